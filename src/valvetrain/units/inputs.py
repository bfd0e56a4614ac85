"""What public functions take for a number: SI, text with a unit or a pint quantity. A bare number that can only be a slip of units is
refused with the likely meaning; a unit that was written is believed, with a warning.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any, SupportsFloat

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.units.dimensions import DIMENSIONS
from valvetrain.units.text import (
    PLAIN_NUMBER,
    clipped,
    dimension_of,
    finite,
    format_quantity,
    parse_quantities,
    parse_quantity,
    split_quantity,
    to_si,
    unit_factor,
)

if TYPE_CHECKING:
    from valvetrain.arrays import Array

#: What a public function takes for a number with a dimension: an SI number (of Python or numpy),
#: text with a unit, a pint quantity.
Given = str | SupportsFloat


@dataclass(frozen=True, slots=True)
class Window:
    """What a named quantity can be: its dimension, the least and largest value (SI) and the unit it
    is usually given in.

    ``bare_high``: largest value (SI) that is taken without a unit, where an SI number and one in
    the default unit are alike.
    """

    dimension: str
    low: float
    high: float
    default_unit: str
    bare_high: float = math.inf


_RPM = math.pi / 30
#: Name of a quantity -> its window, wide enough for any valve spring and valvetrain; beyond it a
#: bare number is a slip of units, and one with its unit unusual.
PLAUSIBLE: dict[str, Window] = {
    "wire_diameter": Window("length", 0.2e-3, 20e-3, "mm"),
    "mean_diameter": Window("length", 3e-3, 200e-3, "mm"),
    "pitch": Window("length", 0.2e-3, 100e-3, "mm"),
    "spring_length": Window("length", 3e-3, 1.0, "mm"),
    "compression": Window("length", 0.0, 0.5, "mm"),
    "valve_lift": Window("length", 1e-9, 0.1, "mm"),
    "engine_speed": Window("angular speed", 10 * _RPM, 30_000 * _RPM, "rpm", 15_000 * _RPM),
    "cam_speed": Window("angular speed", 5 * _RPM, 15_000 * _RPM, "rpm", 7_500 * _RPM),
    "cam_angle": Window("angle", 1e-9, 8 * math.pi, "deg"),
    "spring_rate": Window("stiffness", 100.0, 5e6, "N/mm"),
    "modulus": Window("modulus", 1e8, 2e12, "GPa"),
    "density": Window("density", 100, 100_000, "kg/m^3"),
    "mass": Window("mass", 1e-6, 20.0, "g"),
    "moving_mass": Window("mass", 1e-12, 1e12, "g"),  # warn_unusual speaks of it
}
#: Dimension -> units in which a number out of its window may have been meant, the likeliest first.
_MEANT = {
    "length": ("mm", "inch", "um", "cm", "m"), "angular speed": ("rpm",), "angle": ("deg",),
    "stiffness": ("N/mm", "N/m", "lbf/in"), "modulus": ("GPa", "MPa", "Pa", "psi"), "mass": ("g", "kg", "lb"),
    "density": ("kg/m^3", "g/cm^3", "g/mm^3", "kg/mm^3", "Mg/mm^3"),
}  # fmt: skip
#: More speeds than this in one call are taken for a mistake.
MAX_SPEEDS = 10_000
_RANGE = re.compile(r"\s*([^:\s]+)\s*:\s*([^:\s]+)\s*:\s*([^:\s]+)(\s+[^:]*)?\Z")
#: A range without its step, ``4000-8000 rpm``; and the most steps that it is divided into.
_ENDS = re.compile(rf"\s*({PLAIN_NUMBER})\s*(?:-|to)\s*({PLAIN_NUMBER})\s*([A-Za-z/]+)\s*\Z")
MAX_STEPS = 20


def si(value: Given, quantity: str, where: str = "") -> float:
    """``value`` as an SI float: ``si("22 mm", "mean_diameter") == si(0.022, "mean_diameter") ==
    0.022``.

    Parameters
    ----------
    value : SI number (Python or numpy), text with a unit such as ``"3000 rpm"``, or a pint quantity
        of any registry.
    quantity : name from :data:`PLAUSIBLE`, or of a dimension in :data:`DIMENSIONS`.
    where : place of the value, which leads the message.

    Raises :class:`InputError` for what is no finite number of that dimension and, for a name in
    :data:`PLAUSIBLE`, for a number without a unit that can only be a slip of units; one with its
    unit is believed, with an :class:`UnusualValueWarning`. Zero and negative values pass: whether
    they make sense is for the caller to say.

    >>> si("3000 rpm", "engine_speed")
    314.1592653589793
    """
    window = PLAUSIBLE.get(quantity)
    dimension = window.dimension if window else quantity
    if isinstance(value, str):
        number, unit = split_quantity(value, dimension, where)
        found, bare = to_si(number, unit, dimension, value, where), False
    elif hasattr(value, "to_base_units"):
        number, unit = _base_magnitude(value, where)
        found, bare = to_si(number, unit, dimension, value, where), False
    else:
        due = DIMENSIONS[dimension]
        alone = getattr(value, "shape", ()) == () and not isinstance(value, bool)
        if not alone or not hasattr(value, "__float__"):
            raise InputError(
                f"{clipped(repr(value))} is no single number; {due.phrase} is needed here, such as {due.written()}",
                where,
            )
        try:
            number = found = finite(float(value), value, where)
        except OverflowError:
            number = found = finite(math.inf, value, where)
        unit, bare = due.si_unit, True
    if window and not _BELIEVED.get():
        doubt(found, quantity, f"{number:.6g} {unit}".strip(), bare, where)
    return found


_BELIEVED: ContextVar[bool] = ContextVar("believed", default=False)


@contextmanager
def believed() -> Iterator[None]:
    """Numbers that were read before, with their units, are not doubted again while this is open."""
    before = _BELIEVED.set(True)
    try:
        yield
    finally:
        _BELIEVED.reset(before)


def doubt(value: float, quantity: str, written: str, bare: bool, where: str = "") -> None:
    """Doubt a positive ``value`` (SI) beyond its window: refuse one without a unit, warn of one with its unit.

    Parameters
    ----------
    value : SI number
    quantity : name from :data:`PLAUSIBLE`
    written : the value as it was written
    bare : whether it was written without a unit
    where : place of the value, which leads the message

    Raises
    ------
    InputError : a number without a unit that can only be a slip

    Examples
    --------
    >>> doubt(30e3, "spring_rate", "30 N/mm", False)
    """
    window = PLAUSIBLE[quantity]
    high = min(window.high, window.bare_high if bare else math.inf)
    if value <= 0 or (window.low <= value * (1 + 1e-12) and value <= high * (1 + 1e-12)):
        return
    label, in_default_unit = quantity.replace("_", " "), format_quantity(value, window.default_unit)
    low_text, high_text = (
        format_quantity(end, window.default_unit) for end in (window.low, window.high)
    )
    if not bare:
        sentence = f"{written} of {label} is unusual ({low_text} to {high_text} is typical) and taken as written; check number and unit"
        warnings.warn(
            f"{where}: {sentence}" if where else sentence, UnusualValueWarning, stacklevel=2
        )
        return
    if window.low <= value <= window.high:
        remedy = (
            f"did you mean '{value:g} {window.default_unit}'? If not, write '{in_default_unit}'"
        )
        raise InputError(
            f"{value:g} without a unit is {written}, {label} {in_default_unit}; {remedy}", where
        )
    factors = ((unit, value * unit_factor(unit)) for unit in _MEANT[window.dimension])
    meant = next(
        ((unit, likely) for unit, likely in factors if window.low <= likely <= window.high), None
    )
    if meant is None:
        value_text = written if written == in_default_unit else f"{written} ({in_default_unit})"
        raise InputError(
            f"{value_text} of {label} is outside {low_text} to {high_text}; check the number and its unit",
            where,
        )
    unit, likely = meant
    raise InputError(
        f"{written} of {label} can only be meant as {value:g} {unit}; write {likely:.6g} or '{value:g} {unit}'",
        where,
    )


def si_each(values: str | Iterable[Given], quantity: str, where: str = "") -> tuple[float, ...]:
    """SI floats of several values, each as for :func:`si`, or of text with one unit for all; errors
    as :func:`si`.

    >>> si_each("3.8, 3.8, 7 mm", "pitch") == si_each(["3.8 mm", 3.8e-3, "7 mm"], "pitch")
    True
    """
    if isinstance(values, str):
        known = quantity in PLAUSIBLE
        dimension = PLAUSIBLE[quantity].dimension if known else quantity
        found = parse_quantities(values, dimension, where)
        for value in found if known else ():
            doubt(value, quantity, f"'{clipped(values)}'", False, where)
        return found
    try:
        return tuple(si(value, quantity, where) for value in values)
    except TypeError as error:
        raise InputError(
            f"{clipped(repr(values))} is no row of numbers; give a list, such as '1, 2, 3 mm'",
            where,
        ) from error


def si_array(values: Any, quantity: str, where: str = "") -> Array:
    """SI values of a row of numbers, or of quantities with a unit (a row of them, or a pint array).

    Errors as :func:`si`, which sees the largest plain number, so that degrees are not taken for
    radians.
    """
    import numpy as np

    if hasattr(values, "to_base_units") or any(
        isinstance(one, str) or hasattr(one, "to_base_units") for one in values
    ):
        dimension = PLAUSIBLE[quantity].dimension
        return np.array(si_each(values, dimension, where))
    found = np.asarray(values, dtype=float)
    if found.size and np.isfinite(found).all():
        si(float(np.max(found)), quantity, where)
    return found


def keep_si(part: object, owner: str, /, **quantities: str) -> None:
    """Fields of a frozen dataclass made SI floats as it is made (``__post_init__``): field ->
    quantity as for :func:`si`, None stays None.

    ``owner`` names the part in messages. Errors as :func:`si`.
    """
    for field, quantity in quantities.items():
        if (value := getattr(part, field)) is not None:
            object.__setattr__(part, field, si(value, quantity, f"{field} of {owner}"))


def warn_unusual(part: object, owner: str, /, **typical: tuple[float, float, str]) -> None:
    """Warn (:class:`UnusualValueWarning`) of fields of a part above zero and outside of ``typical``:
    field -> least and largest value (SI) and the unit they are shown in; ``owner`` as for
    :func:`keep_si`.
    """
    for field, (low, high, unit) in typical.items():
        value = getattr(part, field)
        if value is not None and value > 0 and not low <= value <= high:
            shown, least, most = (format_quantity(one, unit) for one in (value, low, high))
            si_unit = DIMENSIONS[dimension_of(unit) or "ratio"].si_unit
            warnings.warn(
                f"{field} of {owner} is {shown}, beyond {least} to {most} of valvetrains; check the number and its unit (a plain number "
                f"is in {si_unit})",
                UnusualValueWarning,
                stacklevel=4,
            )


def si_speeds(
    values: Given | Iterable[Given], quantity: str = "engine_speed", where: str = ""
) -> tuple[float, ...]:
    """Rotational speeds (rad/s) from one, several or a range, in the order given, each once.

    ``values``: as for :func:`si`, or a sequence or array of such; or text: ``"4200, 5600 rpm"``,
    ``"1000:9000:100 rpm"`` with both ends, ``"4000-8000 rpm"`` in round steps; text without a unit is in rpm.
    Raises :class:`InputError` as :func:`si`, and for none, for speeds that are not positive and
    ranges that lead nowhere.

    >>> len(si_speeds("1000:9000:100 rpm")), len(si_speeds("1000:9000:100rpm")), len(si_speeds("4000-8000"))
    (81, 81, 21)
    """
    if isinstance(values, str):
        if values.strip() and not re.search(r"[^\d.,:;+\-eE\s]", values):
            values = f"{values.strip()} rpm"
        speeds = _speeds_of_text(values, quantity, where)
    else:
        try:
            items = list(islice(values, MAX_SPEEDS + 1))  # type: ignore[arg-type]
        except TypeError:  # one value; scalars of numpy and pint have __iter__ too
            return si_speeds([values], quantity, where)  # type: ignore[list-item]
        if len(items) > MAX_SPEEDS:
            raise InputError(f"there are more than {MAX_SPEEDS} speeds; take a larger step", where)
        speeds = tuple(si(value, quantity, where) for value in items)
    if not speeds or min(speeds) <= 0:
        fault = (
            f"'{clipped(str(values))}' holds no speed"
            if not speeds
            else f"a speed in '{clipped(str(values))}' is not positive"
        )
        raise InputError(f"{fault}; write such as '4200, 5600 rpm'", where)
    return tuple(dict.fromkeys(speeds))


def _speeds_of_text(text: str, quantity: str, where: str) -> tuple[float, ...]:
    if ends := _ENDS.match(text):
        text = f"{ends[1]}:{ends[2]}:{_round_step(float(ends[1]), float(ends[2]))} {ends[3]}"
    if match := _RANGE.match(text):
        *parts, unit = match.groups(default="")
        if not unit and parts[0][-1].isdigit():  # "1000:9000:500rpm"
            parts[2], unit = re.fullmatch(r"(.*?)([A-Za-z/]*)", parts[2]).groups()  # type: ignore[union-attr]
        first, last, step = (
            parse_quantity(f"{part}{unit}", "angular speed", where) for part in parts
        )
        if not (first > 0 and last >= first and step > 0):
            why = (
                "the last speed is below the first"
                if last < first
                else "first speed and step must be above zero"
            )
            raise InputError(
                f"range '{clipped(text)}': {why}; write first:last:step as in '1000:9000:500 rpm'",
                where,
            )
        if (last - first) / step > MAX_SPEEDS:
            raise InputError(
                f"range '{clipped(text)}' holds more than {MAX_SPEEDS} speeds; take a larger step",
                where,
            )
        found = [
            first + step * index
            for index in range(int((last - first) / step * (1 + 1e-12) + 1e-9) + 1)
        ]
        if ends and last - found[-1] > 1e-9 * last:
            found.append(last)
    else:
        found = list(parse_quantities(text, "angular speed", where))
    positive = [value for value in found if value > 0]
    for value in {min(positive), max(positive)} if positive else ():
        doubt(value, quantity, format_quantity(value, "rpm"), False, where)
    return tuple(found)


def _round_step(first: float, last: float) -> str:
    """The smallest of 1, 2, 2.5 and 5 times a power of ten that divides a range into at most :data:`MAX_STEPS` steps."""
    least = abs(last - first) / MAX_STEPS or 1.0
    power = 10.0 ** math.floor(math.log10(least))
    step = next(one * power for one in (1, 2, 2.5, 5, 10) if one * power >= least * (1 - 1e-9))
    return f"{step:g}"


def _base_magnitude(value: Any, where: str) -> tuple[float, str]:
    """Number and unit of a quantity of any units library that speaks as pint does, in its base
    units.
    """
    base = value.to_base_units()
    if getattr(base.magnitude, "shape", ()) != ():
        raise InputError(f"'{clipped(str(value))}' is no single number; give one value", where)
    unit = str(base.units).replace("dimensionless", "")
    return float(base.magnitude), " ".join(unit.split())
