"""Reads tables of measured values with their scatter or repeats, as papers and test reports print
them instead of curves.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measured.ranges import refuse_beyond
from valvetrain.measured.tables import read_content, text_of
from valvetrain.units import DIMENSIONS, dimension_of, dimension_powers, parse_quantity, unit_factor
from valvetrain.units.text import clipped

Array = NDArray[np.float64]
#: Larger files, and longer tables, are none of values.
MAX_BYTES, MAX_ROWS, MAX_REPEATS = 5_000_000, 2000, 200
_NOUN = "table of measured values"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.]{0,119}")
_HEAD = re.compile(r"(.*?)\s*(?:[\[(]\s*(.*?)\s*[\])])?\s*")
#: Columns of one number whose unit is in the heading -> dimension.
_AMOUNTS = {
    "cam angle": "angle",
    "angle scatter": "angle",
    "engine speed": "angular speed",
    "cam speed": "angular speed",
}


@dataclass(frozen=True, eq=False)
class MeasuredValue:
    """One measured value of ``quantity``, SI; shown in ``unit``.

    ``repeats``: values of the trials, shape (trials,), one for a single value. ``scatter``: stated
    standard deviation of the value, NaN where repeats show it. ``cam_angle`` and ``angle_scatter``
    (rad) of it, NaN where unspecified; ``engine_speed`` (rad/s of the crank), 0 where unspecified.

    >>> MeasuredValue("stage_2_peak_force", "N", np.array([806.0]), scatter=8.0).value
    806.0
    """

    quantity: str
    unit: str
    repeats: Array
    scatter: float = math.nan
    cam_angle: float = math.nan
    angle_scatter: float = math.nan
    engine_speed: float = 0.0

    @property
    def value(self) -> float:
        """The value, or the mean of its repeats."""
        return float(np.mean(self.repeats))


@dataclass(frozen=True, eq=False)
class ValueTable:
    """Measured ``values``; ``source`` of them, whether they are ``synthetic``, and ``notes`` as for
    measured cycles.

    >>> ValueTable((MeasuredValue("peak_valve_lift", "mm", np.array([9.1e-3, 9.2e-3])),), "own rig")
    ValueTable: 1 value with 2 repeats of own rig
    """

    values: tuple[MeasuredValue, ...]
    source: str = ""
    synthetic: bool = False
    notes: tuple[str, ...] = ()

    @property
    def repeats(self) -> int:
        """Repeats of every value; 1 where scatters are stated instead."""
        return len(self.values[0].repeats)

    def __repr__(self) -> str:
        count = f"{len(self.values)} value{'s' * (len(self.values) != 1)}"
        return f"ValueTable: {count} with {f'{self.repeats} repeats' if self.repeats > 1 else 'a scatter for each'} of {self.source or 'a table'}"


def is_value_table(text: str) -> bool:
    """Whether a text is a table of values: its first line that is no comment begins with the
    heading ``quantity``.
    """
    for line in text.splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            return re.split(r"[,;\t]", line, maxsplit=1)[0].strip().strip('"').lower() in (
                "quantity",
                "name",
            )
    return False


def read_value_table(path: str | Path) -> ValueTable:
    """Read a table of values: comments such as ``# source: ...``, a line of headings, a row a
    value.

    Headings: ``quantity``, ``unit``, then either ``value`` and ``scatter`` (one standard deviation,
    an amount in that unit or per cent) or ``repeat 1``, ``repeat 2`` ...; further ``cam angle
    [deg]``, ``angle scatter [deg]``, ``engine speed [rpm]``, any of them empty.

    Parameters
    ----------
    path : the file

    Returns
    -------
    ValueTable

    Raises
    ------
    InputError : a file that cannot be read, a row that lacks its unit or its scatter, a number that
        is none

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp(), "head.csv")
    >>> _ = file.write_text("quantity,unit,value,scatter,cam angle [deg]" + chr(10) + "stage_2_peak_force,N,806,1 %,183")
    >>> read_value_table(file).values[0].scatter
    8.06
    """
    place = Path(path)
    return values_in(text_of(read_content(place, MAX_BYTES, _NOUN), place.name), place.name[:80])


def values_in(text: str, name: str) -> ValueTable:
    """The table in ``text``; as :func:`read_value_table`."""
    said: dict[str, list[str]] = {}
    lines: list[tuple[int, str]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.lstrip().startswith("#"):
            key, _, value = line.strip().lstrip("# ").partition(":")
            said.setdefault(key.strip().lower(), []).append(value.strip())
        elif line.strip():
            lines.append((number, line))
    if len(lines) < 2 or not is_value_table(text):
        raise InputError(
            f"{name} holds no table of values; write a line of headings 'quantity,unit,value,scatter' and a row a value"
        )
    if len(lines) > MAX_ROWS + 1:
        raise InputError(f"{name} holds more than {MAX_ROWS} values; give fewer")
    mark = max(",;\t", key=lines[0][1].count)
    heads = _heads(_cells(lines[0][1], mark, lines[0][0], name), name)
    overall = _speed(said, name)
    values = tuple(
        _value(heads, _cells(line, mark, number, name), overall, f"line {number} of {name}")
        for number, line in lines[1:]
    )
    if len({len(one.repeats) for one in values}) > 1:
        raise InputError(
            f"{name} holds rows with more repeats than others; give every value as many repeats"
        )
    return ValueTable(
        values,
        (said.get("source") or [name])[0],
        (said.get("synthetic") or [""])[0].lower() in ("yes", "true", "1"),
        tuple(said.get("note", ())),
    )


def _cells(line: str, mark: str, number: int, name: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=mark, strict=True), [])]
    except csv.Error as error:
        raise InputError(
            f"line {number} of {name} is no row of a table: '{clipped(line)}'; correct it or mark it with #"
        ) from error


def _heads(cells: list[str], name: str) -> list[tuple[str, str]]:
    """(word, unit) of every column."""
    heads: list[tuple[str, str]] = []
    for cell in cells:
        found = _HEAD.fullmatch(cell)
        word, unit = (found[1].lower().replace("_", " "), found[2] or "") if found else (cell, "")
        word = "quantity" if word == "name" else word
        known = ("quantity", "unit", "value", "scatter", "source", *_AMOUNTS)
        if word not in known and not re.fullmatch(r"repeat \d+", word):
            raise InputError(
                f"{name} has a column '{clipped(cell)}', which is none of {', '.join(known)}, repeat 1, repeat 2; rename it"
            )
        if (word, unit) in heads or word in (one for one, _ in heads):
            raise InputError(f"{name} has two columns '{word}'; leave one out")
        if word in _AMOUNTS:
            parse_quantity(
                f"1 {unit}".strip(), _AMOUNTS[word], f"heading '{clipped(cell)}' of {name}"
            )
        heads.append((word, unit))
    headings = [word for word, _ in heads]
    repeats = sum(word.startswith("repeat ") for word in headings)
    if "unit" not in headings or ("value" in headings) == (repeats > 0):
        raise InputError(
            f"{name} needs a column 'unit', and either 'value' with 'scatter' or 'repeat 1', 'repeat 2' and so on; add them"
        )
    if repeats > MAX_REPEATS:
        raise InputError(f"{name} has {repeats} repeats; {MAX_REPEATS} are the most")
    return heads


def _value(
    heads: list[tuple[str, str]], cells: list[str], overall: float, where: str
) -> MeasuredValue:
    if len(cells) != len(heads):
        raise InputError(
            f"{where} has {len(cells)} cells, the headings {len(heads)}; make them alike"
        )
    row = dict(zip((word for word, _ in heads), cells, strict=True))
    units = dict(heads)
    quantity = row["quantity"]
    if not _NAME.fullmatch(quantity):
        raise InputError(
            f"'{clipped(quantity)}' is no name of a quantity; docs/quantities.md lists them", where
        )
    unit = "" if row["unit"] in ("1", "-") else row["unit"]
    try:
        factor = unit_factor(unit)
        dimension_powers(f"1 {unit}".strip())
    except InputError as error:
        raise InputError(error.reason, where) from None
    cells_of_value = [
        cell for word, cell in row.items() if word == "value" or word.startswith("repeat ")
    ]
    repeats = np.array([_number(cell, where) for cell in cells_of_value]) * factor
    refuse_beyond(
        repeats, DIMENSIONS[dimension_of(unit) or "ratio"].si_unit, f"{quantity} in {where}"
    )
    scatter = math.nan
    if "value" in row:
        scatter = _scatter(row.get("scatter", ""), float(repeats[0]), unit, factor, where)
    elif len(repeats) < 2:
        raise InputError(
            f"{where} has one repeat, which shows no scatter; give two or more, or a column 'scatter'"
        )
    amounts = {
        word: _number(row[word], where) * unit_factor(units[word]) if row.get(word) else math.nan
        for word in _AMOUNTS
    }
    if amounts["angle scatter"] <= 0:
        raise InputError("a standard deviation is positive; correct the angle scatter", where)
    speed = (
        amounts["engine speed"]
        if math.isfinite(amounts["engine speed"])
        else 2 * amounts["cam speed"]
    )
    if speed <= 0:
        raise InputError("a speed is positive; correct it", where)
    return MeasuredValue(
        quantity,
        unit,
        repeats,
        scatter,
        amounts["cam angle"],
        amounts["angle scatter"],
        speed if math.isfinite(speed) else overall,
    )


def _number(cell: str, where: str) -> float:
    try:
        found = float(cell)
    except ValueError:
        found = math.nan
    if not abs(found) < 1e30:
        raise InputError(f"'{clipped(cell)}' is no number; correct it", where)
    return found


def _scatter(cell: str, value: float, unit: str, factor: float, where: str) -> float:
    """Standard deviation (SI): a number in the unit of the value, an amount, or a share of the
    value in per cent.
    """
    if not cell:
        raise InputError(
            "the scatter is missing; give one standard deviation of the value, such as '2' or '1 %'",
            where,
        )
    if cell.endswith("%"):
        found = abs(value) * parse_quantity(cell, "ratio", where)
    else:
        found = _number(cell, where) * factor
    if not found > 0:
        raise InputError(
            f"the scatter is '{clipped(cell)}'; a standard deviation is positive", where
        )
    return found


def _speed(said: dict[str, list[str]], name: str) -> float:
    for key, ratio in (("engine speed", 1.0), ("cam speed", 2.0)):
        if said.get(key):
            found = parse_quantity(said[key][0], "angular speed", f"{key} of {name}")
            if not found > 0:
                raise InputError(f"{key} of {name} is not positive; give it as it turns")
            return ratio * found
    return 0.0
