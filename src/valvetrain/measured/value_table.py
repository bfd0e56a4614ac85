"""Reads tables of measured values with their scatter or repeats, as papers and test reports print
them instead of curves.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.cycles import stated_speed
from valvetrain.measured.door import refuse_beyond
from valvetrain.measured.tables import (
    comments_in,
    name_and_unit,
    number_of,
    read_content,
    rows_of_words,
    text_of,
)
from valvetrain.units import DIMENSIONS, dimension_of, dimension_powers, parse_quantity, unit_factor
from valvetrain.units.text import clipped

#: Larger files, and longer tables, are none of values.
MAX_BYTES, MAX_ROWS, MAX_REPEATS = 5_000_000, 2000, 200
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.]{0,119}")
#: Columns of one number whose unit is in the heading -> dimension.
_AMOUNTS = {
    "cam angle": "angle",
    "angle scatter": "angle",
    "engine speed": "angular speed",
    "cam speed": "angular speed",
}
#: What a column may be, but for repeats.
_COLUMNS = ("quantity", "unit", "value", "scatter", "source", *_AMOUNTS)


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
    return any(cells[0].lower() in ("quantity", "name") for _, cells in rows_of_words(text)[:1])


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
    content = read_content(place, MAX_BYTES, "table of measured values")
    return values_in(text_of(content, place.name), place.name[:80])


def values_in(text: str, name: str) -> ValueTable:
    """The table in ``text``; as :func:`read_value_table`."""
    said, rows = comments_in(text), rows_of_words(text)
    if len(rows) < 2 or not is_value_table(text):
        raise InputError(
            f"{name} holds no table of values; write a line of headings 'quantity,unit,value,scatter' and a row a value"
        )
    if len(rows) > MAX_ROWS + 1:
        raise InputError(f"{name} holds more than {MAX_ROWS} values; give fewer")
    heads, speed = _heads(rows[0][1], name), stated_speed(said, name)
    values = tuple(
        _value(heads, cells, speed, f"line {number} of {name}") for number, cells in rows[1:]
    )
    if len({len(value.repeats) for value in values}) > 1:
        raise InputError(
            f"{name} holds rows with more repeats than others; give every value as many repeats"
        )
    return ValueTable(
        values,
        said.get("source", [name])[0],
        said.get("synthetic", [""])[0].lower() in ("yes", "true", "1"),
        tuple(said.get("note", ())),
    )


def _heads(cells: list[str], name: str) -> dict[str, str]:
    """Word -> unit of every column."""
    heads: dict[str, str] = {}
    for cell in cells:
        word, unit = name_and_unit(cell)
        word = word.lower().replace("_", " ").replace("name", "quantity")
        if word not in _COLUMNS and not re.fullmatch(r"repeat \d+", word):
            raise InputError(
                f"{name} has a column '{clipped(cell)}', which is none of {', '.join(_COLUMNS)}, repeat 1, repeat 2; rename it"
            )
        if word in heads:
            raise InputError(f"{name} has two columns '{word}'; leave one out")
        if word in _AMOUNTS:
            parse_quantity(
                f"1 {unit}".strip(), _AMOUNTS[word], f"heading '{clipped(cell)}' of {name}"
            )
        heads[word] = unit
    repeats = sum(word.startswith("repeat ") for word in heads)
    if "unit" not in heads or ("value" in heads) == (repeats > 0):
        raise InputError(
            f"{name} needs a column 'unit', and either 'value' with 'scatter' or 'repeat 1', 'repeat 2' and so on; add them"
        )
    if repeats > MAX_REPEATS:
        raise InputError(f"{name} has {repeats} repeats; {MAX_REPEATS} are the most")
    return heads


def _value(heads: dict[str, str], cells: list[str], overall: float, where: str) -> MeasuredValue:
    if len(cells) != len(heads):
        raise InputError(
            f"{where} has {len(cells)} cells, the headings {len(heads)}; make them alike"
        )
    row = dict(zip(heads, cells, strict=True))
    quantity = row["quantity"]
    if not _NAME.fullmatch(quantity):
        raise InputError(
            f"'{clipped(quantity)}' is no name of a quantity; `valvetrain quantities` lists them",
            where,
        )
    unit = "" if row["unit"] in ("1", "-") else row["unit"]
    try:
        factor = unit_factor(unit)
        dimension_powers(f"1 {unit}".strip())
    except InputError as error:
        raise InputError(error.reason, where) from None
    repeats = factor * np.array(
        [_number(row[word], where) for word in row if word == "value" or word.startswith("repeat ")]
    )
    refuse_beyond(
        repeats, DIMENSIONS[dimension_of(unit) or "ratio"].si_unit, f"{quantity} in {where}"
    )
    scatter = math.nan
    if "value" in row:
        scatter = _scatter(row.get("scatter", ""), float(repeats[0]), factor, where)
    elif len(repeats) < 2:
        raise InputError(
            f"{where} has one repeat, which shows no scatter; give two or more, or a column 'scatter'"
        )
    amounts = {
        word: _number(row[word], where) * unit_factor(heads[word]) if row.get(word) else math.nan
        for word in _AMOUNTS
    }
    if amounts["angle scatter"] <= 0:
        raise InputError("a standard deviation is positive; correct the angle scatter", where)
    engine_speed = amounts["engine speed"]
    speed = engine_speed if math.isfinite(engine_speed) else 2 * amounts["cam speed"]
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
        number = number_of(cell)
    except ValueError:
        number = math.nan
    if not abs(number) < 1e30:
        raise InputError(f"'{clipped(cell)}' is no number; correct it", where)
    return number


def _scatter(cell: str, value: float, factor: float, where: str) -> float:
    """Standard deviation (SI): a number in the unit of the value, or a share of the value in per cent."""
    if not cell:
        raise InputError(
            "the scatter is missing; give one standard deviation of the value, such as '2' or '1 %'",
            where,
        )
    share = cell.endswith("%")
    scatter = (
        abs(value) * parse_quantity(cell, "ratio", where)
        if share
        else _number(cell, where) * factor
    )
    if not scatter > 0:
        raise InputError(
            f"the scatter is '{clipped(cell)}'; a standard deviation is positive", where
        )
    return scatter
