"""Reads what a spin rig gives over engine speed: a column of speeds, and a column each of bounce, loft or another quantity."""

from __future__ import annotations

import math
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.measured.tables import (
    UNIT_NAMES,
    name_and_unit,
    read_content,
    rows_of_words,
    text_of,
)
from valvetrain.solution.definition import definition_of, is_defined
from valvetrain.solution.speed_curve import SpeedCurve
from valvetrain.units import parse_quantity

#: Larger files are none of a spin rig.
MAX_BYTES, MAX_ROWS = 5_000_000, 10_000
#: What a sheet calls a column -> the quantity.
NAMES = {
    "bounce": "bounce_height",
    "loft": "loft_gap",
    "lift": "peak_valve_lift",
}
SPEED = ("engine_speed", "speed", "rpm", "engine_rpm")
EXAMPLE = "'engine speed [rpm], bounce [in], loft [in]'"


def read_speed_table(path: str | Path) -> SpeedCurve:
    """Read a table over engine speed: a line of headings with units, such as ``engine speed [rpm], bounce [mm]``, and a row
    for each speed.

    Parameters
    ----------
    path : the file (CSV, tabs or semicolons); an empty cell is a speed at which nothing was measured

    Returns
    -------
    SpeedCurve, in SI and sorted by speed

    Raises
    ------
    InputError : no such file, a column of no known quantity or without its unit, a cell that is no number
    """
    place = Path(path)
    rows = rows_of_words(text_of(read_content(place, MAX_BYTES, "table of a spin rig"), place.name))
    if not 3 <= len(rows) <= MAX_ROWS:
        raise InputError(f"needs a line of headings and 2 to {MAX_ROWS} speeds; begin it with {EXAMPLE}", place.name)  # fmt: skip
    (_, headings), *body = rows
    columns = [_column(heading, place.name) for heading in headings]
    names = [name for name, _, _ in columns]
    if names.count("engine_speed") != 1 or len(set(names)) != len(names) or len(names) < 2:
        raise InputError(f"needs one column of engine speeds and one for each quantity; begin it with {EXAMPLE}", place.name)  # fmt: skip
    numbers = []
    for line, cells in body:
        if len(cells) != len(columns):
            raise InputError(f"line {line} has {len(cells)} cells, but {len(columns)} headings stand above; correct it", place.name)  # fmt: skip
        where = f"{place.name}, line {line}"
        numbers.append([
            parse_quantity(f"{cell} {unit}", dimension, where) if cell else math.nan
            for cell, (_, unit, dimension) in zip(cells, columns, strict=True)
        ])  # fmt: skip
    by_name = dict(zip(names, zip(*sorted(numbers, key=lambda row: row[names.index("engine_speed")]), strict=True), strict=True))  # fmt: skip
    speeds = by_name.pop("engine_speed")
    if not all(speed > 0 for speed in speeds):
        raise InputError("an engine speed is missing or not positive; correct it", place.name)
    return SpeedCurve(speeds, by_name, place.name)


def _column(heading: str, where: str) -> tuple[str, str, str]:
    """Quantity, unit and dimension of a column."""
    name, unit = name_and_unit(heading.strip())
    word = name.lower().replace(" ", "_")
    unit = UNIT_NAMES.get(unit.lower(), unit)
    if word in SPEED:
        return "engine_speed", unit or "rpm", "angular speed"
    word = NAMES.get(word, word)
    if not is_defined(word):
        raise InputError(f"no quantity is called '{name[:40]}'; name bounce, loft or one of 'valvetrain quantities'", where)  # fmt: skip
    if not unit and definition_of(word).si_unit != "1":
        raise InputError(f"the column '{name[:40]}' has no unit; write it behind, as in {EXAMPLE}", where)  # fmt: skip
    return word, unit, definition_of(word).dimension or "ratio"
