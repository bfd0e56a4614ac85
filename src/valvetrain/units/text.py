"""Quantities as text, such as "4.0 mm", to SI floats and back."""

from __future__ import annotations

import difflib
import math
import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeVar

from valvetrain.errors import InputError
from valvetrain.units.dimensions import DEFAULT, DEFINITIONS, DIMENSIONS

if TYPE_CHECKING:
    import pint

    from valvetrain.arrays import Array

Number = TypeVar("Number", float, "Array")
#: Bare lengths below this are more likely inches: wires, lifts and heights of springs are, but for
#: lashes and thin wires in mm.
MAX_INCHES = 2.6
_SHOWN_UNITS = (
    "m mm cm um µm in inch thou mil ft N kN lbf kgf N/mm N/m lbf/in kg g lb oz Pa kPa MPa GPa bar psi ksi rad deg "
    "rpm rad/s s ms us min Hz kHz 1/s kg/m^3 g/cm^3 N/mm^2 mm/s m/s mm/s^2 m/s^2 N*s/m N*s/mm J mJ W %"
).split()
# no two neighbours of these patterns take the same characters: a text that fails is then read once,
# not once per way to share it out
PLAIN_NUMBER = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,4})?"
_NUMBER = rf"[+-]?{PLAIN_NUMBER}"
#: ``3/8 in`` and ``1 3/8 in``, as sizes in inches are written.
_FRACTION = re.compile(
    r"\A([+-]?)(?:(\d{1,4})\s+)?(\d{1,4})/([1-9]\d{0,3})(?=\s*[A-Za-z\u00b5\u03bc])"
)
_QUANTITY = re.compile(rf"({_NUMBER})\s*(.*)\Z", re.DOTALL)
_SPAN = re.compile(rf"({_NUMBER})\s*(?:-|to)\s*({_NUMBER})\s*([A-Za-z/]+)\Z")
_FACTOR = r"(?:1|[A-Za-zµμ_]+)(?:\s*(?:\^|\*\*)\s*-?\d(?:\.\d{1,3})?)?"
_UNIT = re.compile(rf"{_FACTOR}(?:\s*[*/·]\s*{_FACTOR}|\s+{_FACTOR})*\Z")


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Any]:
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(None)
    registry.load_definitions(DEFINITIONS.strip().splitlines())
    return registry


def _better(unit: str) -> str:
    """What to write for a unit that is none: often a range by a dash or a comma in a number."""
    if re.match(r"-\s*\d", unit):
        return "a range is written first:last:step, as in '1000:9000:500 rpm'"
    if re.match(r",\d", unit):
        return "write the number with a point, as in '0.5 mm'"
    if unit in ('"', "''", "\u2033"):
        return "inches are written 'in'"
    if unit == "#":
        return "pounds of force are written 'lbf'"
    if re.match(r":\s*1\Z", unit):
        return "write a ratio as a plain number"
    return "write it as in 'N/mm' or 'kg/m^3'"


@lru_cache(maxsize=512)
def _resolve(unit: str) -> tuple[float, tuple[tuple[str, float], ...]]:
    """SI value of one ``unit`` and its dimension; raises :class:`InputError` when it is unknown."""
    text = unit.strip().replace("°", "deg").replace("·", "*").replace("²", "^2").replace("³", "^3")
    if text == "":
        return 1.0, ()
    if text == "%":
        return 0.01, ()
    if text in DEFAULT:
        return DEFAULT[text]
    if len(text) > 40 or not _UNIT.match(text):
        raise InputError(f"unit '{clipped(unit)}' cannot be read; {_better(text)}")
    try:
        quantity: Any = _registry().Quantity(1.0, _registry().parse_units(text)).to_base_units()
    except Exception as error:  # pint raises many kinds for a text it cannot read
        close = difflib.get_close_matches(unit, _SHOWN_UNITS, n=3, cutoff=0.5)
        hint = (
            "did you mean " + " or ".join(close) + "?"
            if close
            else "use one such as mm, N, N/mm, MPa, g, rpm, Hz, deg"
        )
        raise InputError(f"unit '{clipped(unit)}' is unknown; {hint}") from error
    # Base units are metre, second, gram, radian: a power of 1000 per mass leads to kilograms.
    powers = tuple(
        sorted((name, float(power)) for name, power in quantity.dimensionality.items() if power)
    )
    mass_power = dict(powers).get("[mass]", 0.0)
    return float(quantity.magnitude) * 1e-3**mass_power, powers


def unit_factor(unit: str) -> float:
    """SI value of one ``unit``: ``unit_factor("mm") == 1e-3``. Raises :class:`InputError` for an
    unknown unit.
    """
    return _resolve(unit)[0]


def dimension_of(unit: str) -> str | None:
    """Name of the (first) dimension in :data:`DIMENSIONS` that ``unit`` measures; None when it is
    not among them.
    """
    powers = _resolve(unit)[1]
    return next(
        (
            name
            for name, dimension in DIMENSIONS.items()
            if _resolve(dimension.si_unit)[1] == powers
        ),
        None,
    )


def dimension_powers(text: str) -> dict[str, float]:
    """Powers of the base dimensions of a quantity: ``"2 N/mm"`` gives ``{"[mass]": 1.0, "[time]":
    -2.0}``; as :func:`parse_quantity`.
    """
    return dict(_resolve(split_quantity(text, None, "")[1])[1])


class PlainNumber(float):
    """A number from Python in the tree of a case: SI of the dimension that is due where
    it is read. ``unit`` is set there, so that the tree can be written with units.

    >>> number = PlainNumber(0.004)
    >>> parse_quantity(number, "length"), number.unit
    (0.004, 'm')
    """

    unit: str = ""


class PlainInteger(int):
    """A whole number from Python, as :class:`PlainNumber`."""

    unit: str = ""


def plain_value(value: Any) -> Any:
    """A value of Python as the tree of a case holds it: numbers alone as :class:`PlainNumber`, quantities of a
    units library as text, arrays and rows of these likewise; others as they are.

    >>> plain_value((0.004, 2)), plain_value("4 mm")
    ((0.004, 2), '4 mm')
    """
    if hasattr(value, "to_base_units"):  # pint and what speaks as it does
        if getattr(value.magnitude, "shape", ()) != ():
            return [plain_value(item) for item in value]
        return f"{float(value.magnitude)!r} {value.units:~C}".strip()
    if hasattr(value, "tolist"):  # of numpy
        value = value.tolist()
    if isinstance(value, (list, tuple)) and not hasattr(value, "_fields"):
        return type(value)(plain_value(item) for item in value)
    if isinstance(value, bool):
        return value
    if isinstance(value, int):
        return PlainInteger(value)
    return PlainNumber(value) if isinstance(value, float) else value


def parse_quantity(text: object, dimension: str | None, where: str = "") -> float:
    """Turn ``text`` ("4.0 mm") into an SI float.

    ``dimension``: a name from :data:`DIMENSIONS`, a unit whose dimension is due ("N/m^1.5"), or
    None for any. ``where`` leads the message. Raises :class:`InputError` for a bare number where a
    unit is due, a wrong dimension, an unknown unit and what is no finite number.
    """
    value, unit = split_quantity(text, dimension, where)
    return to_si(value, unit, dimension, text, where)


def parse_quantities(text: object, dimension: str | None, where: str = "") -> tuple[float, ...]:
    """Turn ``"0, 1.5, 3 mm"`` (one unit for all) or a list of quantities into SI floats; as
    :func:`parse_quantity`.
    """
    if isinstance(text, (list, tuple)):
        return tuple(
            parse_quantity(item, dimension, f"{where}[{index}]") for index, item in enumerate(text)
        )
    if not isinstance(text, str) or "," not in text:
        return (parse_quantity(text, dimension, where),)
    *heads, last = (part.strip() for part in text.split(","))
    value, unit = split_quantity(last, dimension, where)
    for head in heads:
        if not re.fullmatch(_NUMBER, head):
            raise InputError(
                f"'{clipped(head)}' is no plain number; write the numbers, then one unit, as in '0, 1.5, 3 mm'",
                where,
            )
    return tuple(
        to_si(number, unit, dimension, text, where) for number in [*map(float, heads), value]
    )


def numbers_of(*values: Any, dimension: str | None = None) -> tuple[tuple[float, ...], str | None]:
    """SI numbers of plain ones, of text with a unit and of quantities of a units library, and their
    dimension, None where all are plain. Raises :class:`InputError` where dimensions disagree, or
    are not the ``dimension`` that is due.

    >>> numbers_of("7 mm", 0.008)
    ((0.007, 0.008), 'length')
    """
    found: list[float] = []
    for value in values:
        if hasattr(value, "to_base_units"):
            value = f"{float(value.magnitude)!r} {value.units:~C}"
        if isinstance(value, str):
            number, unit = split_quantity(value, dimension, "")
            dimension = dimension or dimension_of(unit)
            found.append(to_si(number, unit, dimension, value, ""))
        else:
            try:
                found.append(float(value))
            except (TypeError, ValueError):
                raise InputError(f"{clipped(repr(value))} is no number; give one") from None
    return tuple(found), dimension


def split_quantity(text: object, dimension: str | None, where: str) -> tuple[float, str]:
    """Number and unit in ``text``; arguments and errors as :func:`parse_quantity`."""
    due = DIMENSIONS.get(dimension or "ratio", None)
    phrase = due.phrase if due else f"a quantity in {dimension}"
    if isinstance(text, bool) or not isinstance(text, (int, float, str)):
        raise InputError(
            f"{clipped(repr(text))} is not a number with a unit; {phrase} is needed here, such as {_written('1', dimension)}",
            where,
        )
    if isinstance(text, (PlainNumber, PlainInteger)) and dimension is not None:
        text.unit = due.si_unit if due else str(dimension)
        return finite(float(text), text, where), text.unit
    if isinstance(text, (int, float)):
        if dimension == "ratio":
            return finite(float(text) if abs(text) < 1e300 else math.inf, text, where), ""
        remedy = (
            "write it with its unit"
            if dimension is None
            else f"{phrase} is needed here: write {_written(clipped(repr(text)), dimension)}"
        )
        raise InputError(f"{clipped(repr(text))} has no unit; {remedy}", where)
    span = _SPAN.match(text.strip())
    if span and dimension != "angular speed":
        low, high, unit = span.groups()
        raise InputError(
            f"'{clipped(text)}' is a range, but one value is needed here, such as its middle '{(float(low) + float(high)) / 2:.6g} {unit}'",
            where,
        )
    match = _QUANTITY.match(_FRACTION.sub(_as_decimal, text.strip()))
    if match is None:
        raise InputError(
            f"'{clipped(text)}' is not a number with a unit; {phrase} is needed here, such as {_written('1', dimension)}",
            where,
        )
    number, unit = match.groups()
    if unit == "" and dimension not in ("ratio", None, ""):
        raise InputError(
            f"'{clipped(text)}' has no unit; {phrase} is needed here: write {_written(number, dimension)}",
            where,
        )
    return finite(float(number), text, where), unit


def _as_decimal(fraction: re.Match[str]) -> str:
    sign, whole, above, below = fraction.groups(default="")
    return f"{sign}{int(whole or 0) + int(above) / int(below)!r}"


def _as_force(unit: str, due: str) -> str:
    """``unit`` with its pounds (psi too, as spring cards write them), kilograms or grams as forces, where
    that has the dimension of ``due``, else empty.
    """
    force = re.sub(r"\bkg\b", "kgf", re.sub(r"\b(?:lbs?|pounds?|psi)\b", "lbf", unit))
    force = re.sub(r"\bg\b", "gf", force)
    if force == unit:
        return ""
    try:
        return force if _resolve(force)[1] == _resolve(due)[1] else ""
    except InputError:
        return ""


def _written(number: str, dimension: str | None) -> str:
    """``number`` with the units of ``dimension`` that a remedy offers, inches first where the number
    is one of valve gear in inches.
    """
    due = DIMENSIONS.get(dimension or "ratio")
    if due is None:
        return f"'{number} {dimension}'"
    return due.written(number, inches_first=_like_inches(number, dimension))


def _like_inches(number: str, dimension: str | None) -> bool:
    try:
        return dimension == "length" and number != "1" and abs(float(number)) < MAX_INCHES
    except ValueError:
        return False


def to_si(value: float, unit: str, dimension: str | None, text: object, where: str) -> float:
    """``value`` in ``unit`` as SI; ``text`` is how it was written, else as :func:`parse_quantity`."""
    try:
        factor, powers = _resolve(unit)
    except InputError as error:
        raise InputError(f"{error.reason} (in '{clipped(str(text))}')", where) from error
    if dimension is not None:
        due = DIMENSIONS.get(dimension)
        if _resolve(due.si_unit if due else dimension)[1] != powers:
            is_what = DIMENSIONS[name].phrase if (name := dimension_of(unit)) else "something else"
            phrase = due.phrase if due else f"a quantity in {dimension}"
            example = (
                "without a unit" if dimension == "ratio" else f"such as {_written('1', dimension)}"
            )
            force = _as_force(unit, due.si_unit if due else str(dimension))
            if force:
                example = f"write '{value:.12g} {force}' (lb and kg are masses, lbf and kgf forces)"
            if force and "psi" in unit:
                is_what = "by psi, a pressure"
                example = f"write '{value:.12g} {force}' if the card means pounds of force"
            elif force and is_what == "something else":
                is_what = "by pounds or kilograms of mass"
            shown = clipped(str(text))
            raise InputError(
                f"'{shown}' is {is_what}, but {phrase} is needed here, {example}", where
            )
    return finite(value * factor, text, where)


def finite(value: float, written: object, where: str) -> float:
    """``value``, or :class:`InputError` where it is infinite or no number."""
    if not math.isfinite(value):
        raise InputError(f"{clipped(str(written))} is not a finite number; replace it", where)
    return value


def clipped(text: str, limit: int = 40) -> str:
    """Foreign text made safe for a message: printable, at most ``limit`` characters."""
    clean = "".join(char if char.isprintable() else "?" for char in text[: limit + 1])
    return clean if len(clean) <= limit else clean[: limit - 3] + "..."


def to_unit(value: Number, unit: str) -> Number:
    """SI ``value`` (float or array) expressed in ``unit``."""
    return value / unit_factor(unit)


def format_quantity(value: float, unit: str, digits: int | None = 6) -> str:
    """SI ``value`` as text in ``unit``, with ``digits`` significant digits (None: all of them)."""
    number = to_unit(value, unit)
    text = repr(float(number)) if digits is None else f"{number:.{digits}g}"
    return f"{text} {unit}".strip()
