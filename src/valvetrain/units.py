"""Units at the door: text such as "4.0 mm" to SI floats and back. Inside the package every number is plain SI.

Angles carry a dimension of their own here, so "2100 rpm" (an angular speed) is never mistaken for "35 Hz" (a frequency).
"""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from valvetrain.errors import InputError


@dataclass(frozen=True, slots=True)
class Dimension:
    """A kind of quantity: its SI unit, the unit suggested to users and how it is spoken of."""

    si_unit: str
    usual_unit: str
    phrase: str


DIMENSIONS: dict[str, Dimension] = {
    "length": Dimension("m", "mm", "a length"),
    "area": Dimension("m^2", "mm^2", "an area"),
    "force": Dimension("N", "N", "a force"),
    "moment": Dimension("N*m", "N m", "a moment"),
    "stiffness": Dimension("N/m", "N/mm", "a stiffness"),
    "line stiffness": Dimension("N/m^2", "N/mm^2", "a stiffness per length"),
    "rotational stiffness": Dimension("N*m/rad", "N m/rad", "a rotational stiffness"),
    "pressure": Dimension("Pa", "MPa", "a pressure or stress"),
    "modulus": Dimension("Pa", "GPa", "an elastic modulus"),
    "mass": Dimension("kg", "g", "a mass"),
    "moment of inertia": Dimension("kg*m^2", "kg mm^2", "a moment of inertia"),
    "density": Dimension("kg/m^3", "kg/m^3", "a density"),
    "angle": Dimension("rad", "deg", "an angle"),
    "angular speed": Dimension("rad/s", "rpm", "a rotational speed"),
    "time": Dimension("s", "s", "a time"),
    "frequency": Dimension("1/s", "Hz", "a frequency"),
    "damping rate": Dimension("1/s", "1/s", "a damping rate"),
    "damping": Dimension("N*s/m", "N s/mm", "a damping constant"),
    "velocity": Dimension("m/s", "mm/s", "a velocity"),
    "acceleration": Dimension("m/s^2", "mm/s^2", "an acceleration"),
    "impulse": Dimension("N*s", "N s", "an impulse"),
    "energy": Dimension("J", "J", "an energy"),
    "power": Dimension("W", "W", "a power"),
    "cam velocity": Dimension("m/rad", "mm/deg", "a lift per angle"),
    "cam acceleration": Dimension("m/rad^2", "mm/deg^2", "a lift per angle squared"),
    "ratio": Dimension("", "", "a plain number"),
}

_DEFINITIONS = """
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
second = [time] = s = sec
gram = [mass] = g
radian = [angle] = rad
minute = 60 * second = min
hour = 60 * minute = h
degree = 0.017453292519943295 * radian = deg = degrees
turn = 6.283185307179586 * radian = rev = revolution
rpm = turn / minute
hertz = 1 / second = Hz
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
joule = newton * meter = J
watt = joule / second = W
inch = 0.0254 * meter = in
foot = 12 * inch = ft
thou = 0.001 * inch = mil
pound = 0.45359237 * kilogram = lb
ounce = pound / 16 = oz
pound_force = pound * 9.80665 * meter / second ** 2 = lbf
kilogram_force = kilogram * 9.80665 * meter / second ** 2 = kgf
psi = pound_force / inch ** 2
ksi = 1000 * psi
percent = 0.01 = pct
"""

_SHOWN_UNITS = (
    "m mm cm um µm in inch thou mil ft N kN lbf kgf N/mm N/m lbf/in kg g lb oz Pa kPa MPa GPa bar psi ksi rad deg "
    "rpm rad/s s ms us min Hz kHz 1/s kg/m^3 g/cm^3 N/mm^2 mm/s m/s mm/s^2 m/s^2 N*s/m N*s/mm J mJ W %"
).split()
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*\Z", re.DOTALL)
_FACTOR = r"(?:1|[A-Za-zµμ_]+)(?:\s*(?:\^|\*\*)\s*-?\d(?:\.\d{1,3})?)?"
_UNIT = re.compile(rf"{_FACTOR}(?:\s*[*/·]\s*{_FACTOR}|\s+{_FACTOR})*\Z")


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(None)
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


@lru_cache(maxsize=512)
def _resolve(unit: str) -> tuple[float, tuple[tuple[str, float], ...]]:
    """SI value of one ``unit`` and its dimension; raises :class:`InputError` when it is unknown."""
    text = unit.strip().replace("°", "deg").replace("·", "*").replace("²", "^2").replace("³", "^3")
    if text == "":
        return 1.0, ()
    if text == "%":
        return 0.01, ()
    if len(text) > 40 or not _UNIT.match(text):
        raise InputError(f"unit '{_short(unit)}' cannot be read; write it as in 'N/mm' or 'kg/m^3'")
    try:
        quantity = _registry().Quantity(1.0, _registry().parse_units(text)).to_base_units()
    except Exception as error:  # pint raises many kinds for a text it cannot read
        close = difflib.get_close_matches(unit, _SHOWN_UNITS, n=3, cutoff=0.5)
        hint = "did you mean " + " or ".join(close) + "?" if close else "use one such as mm, N, N/mm, MPa, g, rpm, Hz, deg"
        raise InputError(f"unit '{_short(unit)}' is unknown; {hint}") from error
    # Base units are metre, second, gram, radian: a power of 1000 per mass leads to kilograms.
    powers = tuple(sorted((name, float(power)) for name, power in quantity.dimensionality.items() if power))
    mass_power = dict(powers).get("[mass]", 0.0)
    return float(quantity.magnitude) * 1e-3**mass_power, powers


def unit_factor(unit: str) -> float:
    """SI value of one ``unit``: ``unit_factor("mm") == 1e-3``. Raises :class:`InputError` for an unknown unit."""
    return _resolve(unit)[0]


def dimension_of(unit: str) -> str | None:
    """Name of the (first) dimension in :data:`DIMENSIONS` that ``unit`` measures; None when it is not among them."""
    powers = _resolve(unit)[1]
    return next((name for name, dimension in DIMENSIONS.items() if _resolve(dimension.si_unit)[1] == powers), None)


def dimension_powers(text: str) -> dict[str, float]:
    """Powers of the base dimensions of a quantity: ``"2 N/mm"`` gives ``{"[mass]": 1.0, "[time]": -2.0}``; as :func:`parse_quantity`."""
    return dict(_resolve(_split(text, None, "")[1])[1])


def parse_quantity(text: Any, dimension: str | None, where: str = "") -> float:
    """Turn ``text`` ("4.0 mm") into an SI float.

    ``dimension``: a name from :data:`DIMENSIONS`, a unit whose dimension is due ("N/m^1.5"), or None for any.
    ``where`` leads the message. Raises :class:`InputError` for a bare number where a unit is due, a wrong dimension, an unknown unit
    and what is no finite number.
    """
    value, unit = _split(text, dimension, where)
    return _to_si(value, unit, dimension, f"'{_short(str(text))}'", where)


def parse_quantities(text: Any, dimension: str | None, where: str = "") -> tuple[float, ...]:
    """Turn ``"0, 1.5, 3 mm"`` (one unit for all) or a list of quantities into SI floats; as :func:`parse_quantity`."""
    if isinstance(text, (list, tuple)):
        return tuple(parse_quantity(item, dimension, f"{where}[{index}]") for index, item in enumerate(text))
    if not isinstance(text, str) or "," not in text:
        return (parse_quantity(text, dimension, where),)
    *heads, last = (part.strip() for part in text.split(","))
    value, unit = _split(last, dimension, where)
    for head in heads:
        if not re.fullmatch(_NUMBER, head):
            raise InputError(f"'{_short(head)}' is no plain number; write the numbers, then one unit, as in '0, 1.5, 3 mm'", where)
    return tuple(_to_si(number, unit, dimension, f"'{_short(text)}'", where) for number in [*map(float, heads), value])


def _split(text: Any, dimension: str | None, where: str) -> tuple[float, str]:
    due = DIMENSIONS.get(dimension or "ratio", None)
    usual = due.usual_unit if due else str(dimension)
    phrase = due.phrase if due else f"a quantity in {dimension}"
    if isinstance(text, bool) or not isinstance(text, (int, float, str)):
        raise InputError(f"{_short(repr(text))} is no quantity; {phrase} is needed here, such as '1 {usual}'".rstrip(), where)
    if isinstance(text, (int, float)):
        if dimension == "ratio":
            return _finite(float(text) if abs(text) < 1e300 else math.inf, text, where), ""
        remedy = "write it with its unit" if dimension is None else f"{phrase} is needed here: write '{_short(repr(text))} {usual}'"
        raise InputError(f"{_short(repr(text))} has no unit; {remedy}", where)
    match = _QUANTITY.match(text)
    if match is None:
        raise InputError(f"'{_short(text)}' is no quantity; {phrase} is needed here, such as '1 {usual}'".rstrip(), where)
    number, unit = match.groups()
    if unit == "" and dimension not in ("ratio", None, ""):
        raise InputError(f"'{_short(text)}' has no unit; {phrase} is needed here: write '{number} {usual}'", where)
    return _finite(float(number), text, where), unit


def _to_si(value: float, unit: str, dimension: str | None, shown: str, where: str) -> float:
    try:
        factor, powers = _resolve(unit)
    except InputError as error:
        raise InputError(f"{error.reason} (in {shown})", where) from error
    if dimension is not None:
        due = DIMENSIONS.get(dimension)
        if _resolve(due.si_unit if due else dimension)[1] != powers:
            is_what = DIMENSIONS[name].phrase if (name := dimension_of(unit)) else "something else"
            phrase, usual = (due.phrase, due.usual_unit) if due else (f"a quantity in {dimension}", dimension)
            example = f"such as '1 {usual}'" if usual else "without a unit"
            if re.search(r"\blb\b", unit):
                example += " (lb is a mass, lbf the force)"
            raise InputError(f"{shown} is {is_what}, but {phrase} is needed here, {example}", where)
    return _finite(value * factor, shown, where)


def _finite(value: float, shown: Any, where: str) -> float:
    if not math.isfinite(value):
        raise InputError(f"{_short(str(shown))} is not a finite number; replace it", where)
    return value


def _short(text: str, limit: int = 40) -> str:
    clean = "".join(char if char.isprintable() else "?" for char in text)
    return clean if len(clean) <= limit else clean[: limit - 3] + "..."


def to_unit(value: Any, unit: str) -> Any:
    """SI ``value`` (float or array) expressed in ``unit``."""
    return value / unit_factor(unit)


def format_quantity(value: float, unit: str, digits: int | None = 6) -> str:
    """SI ``value`` as text in ``unit``, with ``digits`` significant digits (None: all of them)."""
    number = to_unit(value, unit)
    text = repr(float(number)) if digits is None else f"{number:.{digits}g}"
    return f"{text} {unit}".strip()
