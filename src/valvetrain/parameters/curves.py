"""Curves over the coil number: the laws of wire diameter, coil diameter and pitch along a spring.

A curve answers three questions at any coil number ``u`` (turns from the lower wire tip): its value,
its derivative per turn and its integral from zero. One class per kind; a new kind is one more small
class.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from pydantic import PlainValidator, ValidationInfo

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.schema_types import (
    Lengths,
    Number,
    Numbers,
    PositiveLength,
    StrictModel,
    quantity,
    validate_as,
)
from valvetrain.units import Given, si, si_each

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator


@runtime_checkable
class Curve(Protocol):
    """A scalar law over the coil number, in SI units of its quantity."""

    def value(self, coil: ArrayLike) -> Array: ...

    def derivative(self, coil: ArrayLike) -> Array: ...

    def integral(self, coil: ArrayLike) -> Array: ...


@dataclass(frozen=True, slots=True)
class Constant:
    """The same length at every coil number: ``level`` in m, as text with a unit ("7 mm") or as a
    pint quantity.

    Raises :class:`InputError` for what is no length.

    >>> Constant("7 mm").level
    0.007
    """

    level: float

    if TYPE_CHECKING:  # accepted types are wider than the stored one

        def __init__(self, level: Given) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "level", si(self.level, "length", "level of a constant curve"))

    def value(self, coil: ArrayLike) -> Array:
        return np.full_like(np.asarray(coil, dtype=float), self.level)

    def derivative(self, coil: ArrayLike) -> Array:
        return np.zeros_like(np.asarray(coil, dtype=float))

    def integral(self, coil: ArrayLike) -> Array:
        return self.level * np.asarray(coil, dtype=float)


@dataclass(frozen=True, slots=True)
class _Knots:
    """Rising coil numbers and as many lengths (m)."""

    coils: tuple[float, ...]
    values: tuple[float, ...]

    if TYPE_CHECKING:

        def __init__(self, coils: Iterable[float], values: str | Iterable[Given]) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "coils", si_each(self.coils, "ratio", "coils of a curve"))
        object.__setattr__(self, "values", si_each(self.values, "length", "values of a curve"))
        coils, values = self.coils, self.values
        if len(coils) != len(values):
            raise InputError(
                f"a curve has {len(coils)} coil numbers but {len(values)} values; give one value per coil number"
            )
        if len(coils) < 2:
            raise InputError("a curve needs at least two knots; give a constant for one value")
        if not (np.all(np.isfinite(coils)) and np.all(np.isfinite(values))):
            raise InputError("a curve holds a value that is not a finite number; replace it")
        if np.any(np.diff(coils) <= 0):
            raise InputError(
                "the coil numbers of a curve must increase; sort them and remove repeats"
            )


@dataclass(frozen=True, slots=True, init=False)
class PiecewiseLinear(_Knots):
    """Straight lines between (coil, value) knots, held constant beyond the first and last knot.

    ``coils``: rising coil numbers; ``values``: as many lengths (m, text with a unit, pint
    quantities), or text such as "4, 7, 4 mm". Raises :class:`InputError` when fewer than two knots
    are given, the coils do not increase or a value is no length.

    >>> PiecewiseLinear((0, 3, 6), "4, 7, 4 mm").values
    (0.004, 0.007, 0.004)
    """

    def value(self, coil: ArrayLike) -> Array:
        found: Array = np.interp(np.asarray(coil, dtype=float), self.coils, self.values)
        return found

    def derivative(self, coil: ArrayLike) -> Array:
        knots, values = np.asarray(self.coils), np.asarray(self.values)
        slopes = np.concatenate(([0.0], np.diff(values) / np.diff(knots), [0.0]))
        return slopes[np.searchsorted(knots, np.asarray(coil, dtype=float), side="right")]

    def integral(self, coil: ArrayLike) -> Array:
        places = np.append(coil, 0.0)
        knots, values = np.asarray(self.coils), np.asarray(self.values)
        areas = np.concatenate(([0.0], np.cumsum(np.diff(knots) * (values[1:] + values[:-1]) / 2)))
        inside = np.clip(places, knots[0], knots[-1])
        segment = np.clip(np.searchsorted(knots, inside, side="right") - 1, 0, len(knots) - 2)
        step = inside - knots[segment]
        slope = (np.diff(values) / np.diff(knots))[segment]
        area = areas[segment] + values[segment] * step + slope * step**2 / 2
        area += np.minimum(places - knots[0], 0) * values[0]
        area += np.maximum(places - knots[-1], 0) * values[-1]
        found: Array = (area[:-1] - area[-1]).reshape(np.shape(coil))
        return found


@dataclass(frozen=True, slots=True, init=False)
class Table(_Knots):
    """A measured or drawn table, interpolated by a shape-preserving cubic (PCHIP): C1, no
    overshoot.

    ``coils``: rising coil numbers; ``values``: as many lengths (m, text with a unit, pint
    quantities), or text such as "4, 7, 4 mm". Raises :class:`InputError` when fewer than two knots
    are given, the coils do not increase or a value is no length.

    >>> Table((0, 3, 6), "4, 7, 4 mm").values
    (0.004, 0.007, 0.004)
    """

    def _interpolant(self) -> PchipInterpolator:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.coils, self.values, extrapolate=False)

    def value(self, coil: ArrayLike) -> Array:
        found: Array = self._interpolant()(np.clip(coil, self.coils[0], self.coils[-1]))
        return found

    def derivative(self, coil: ArrayLike) -> Array:
        found: Array = np.nan_to_num(
            self._interpolant().derivative()(np.asarray(coil, dtype=float))
        )
        return found

    def integral(self, coil: ArrayLike) -> Array:
        coil = np.asarray(coil, dtype=float)
        first, last = self.coils[0], self.coils[-1]
        primitive = self._interpolant().antiderivative()

        def area(point: Array) -> Array:
            beyond = (
                np.minimum(point - first, 0) * self.values[0]
                + np.maximum(point - last, 0) * self.values[-1]
            )
            found: Array = primitive(np.clip(point, first, last)) + beyond
            return found

        return area(coil) - area(np.asarray(0.0))


@dataclass(frozen=True, slots=True)
class WeightedSum:
    """``first + weight * second``: such as a mean diameter from an outer one less the wire."""

    first: Curve
    second: Curve
    weight: float = 1.0

    def value(self, coil: ArrayLike) -> Array:
        return self.first.value(coil) + self.weight * self.second.value(coil)

    def derivative(self, coil: ArrayLike) -> Array:
        return self.first.derivative(coil) + self.weight * self.second.derivative(coil)

    def integral(self, coil: ArrayLike) -> Array:
        return self.first.integral(coil) + self.weight * self.second.integral(coil)


@dataclass(frozen=True, slots=True)
class SlopeOf:
    """Derivative of a table: the pitch that belongs to a measured height over the coil number."""

    table: Table

    def value(self, coil: ArrayLike) -> Array:
        return self.table.derivative(coil)

    def derivative(self, coil: ArrayLike) -> Array:
        coil = np.asarray(coil, dtype=float)
        inside = (coil >= self.table.coils[0]) & (coil <= self.table.coils[-1])
        return np.where(inside, np.nan_to_num(self.table._interpolant().derivative(2)(coil)), 0.0)

    def integral(self, coil: ArrayLike) -> Array:
        return self.table.value(coil) - self.table.value(0.0)


@dataclass(frozen=True, slots=True)
class Parabola:
    """``ends`` at coil 0 and ``total_coils``, ``middle`` half-way: the barrel and hourglass law."""

    ends: float
    middle: float
    total_coils: float

    def value(self, coil: ArrayLike) -> Array:
        return (
            self.middle
            + (self.ends - self.middle)
            * (2 * np.asarray(coil, dtype=float) / self.total_coils - 1) ** 2
        )

    def derivative(self, coil: ArrayLike) -> Array:
        return (
            (self.ends - self.middle)
            * 4
            / self.total_coils
            * (2 * np.asarray(coil, dtype=float) / self.total_coils - 1)
        )

    def integral(self, coil: ArrayLike) -> Array:
        coil = np.asarray(coil, dtype=float)
        across = 2 * coil / self.total_coils - 1
        return self.middle * coil + (self.ends - self.middle) * self.total_coils / 6 * (
            across**3 + 1
        )


def add_curves(first: Curve, second: Curve, weight: float = 1.0) -> Curve:
    """``first + weight * second`` in the simplest class that is exact."""
    if isinstance(first, Constant) and isinstance(second, Constant):
        return Constant(first.level + weight * second.level)
    if isinstance(first, (Constant, PiecewiseLinear)) and isinstance(
        second, (Constant, PiecewiseLinear)
    ):
        knots = sorted(
            {
                coil
                for curve in (first, second)
                if isinstance(curve, PiecewiseLinear)
                for coil in curve.coils
            }
        )
        values = first.value(knots) + weight * second.value(knots)
        return PiecewiseLinear(tuple(knots), tuple(float(value) for value in values))
    return WeightedSum(first, second, weight)


#: The pitch rises from the wire diameter to its full value over this stretch, half of it before and
#: half after the first turn.
RAMP = 0.5


def pitch_with_closed_turns(
    total_coils: float,
    wire: float,
    pitch: float,
    closed_lower: float = 1.0,
    closed_upper: float = 1.0,
    ramp: float = RAMP,
) -> PiecewiseLinear:
    """Pitch law (m per turn): the ``wire`` diameter (m) over the closed turns, ``pitch`` (m)
    between, ramps of ``ramp`` turns.

    Raises :class:`InputError` where the closed turns and their ramps leave no turn between them.
    """
    knots = [
        0.0,
        closed_lower,
        closed_lower + ramp,
        total_coils - closed_upper - ramp,
        total_coils - closed_upper,
        total_coils,
    ]
    values = [wire, wire, pitch, pitch, wire, wire]
    if closed_lower == 0:
        knots, values = knots[2:], values[2:]
        knots[0] = 0.0
    if closed_upper == 0:
        knots, values = knots[:-2], values[:-2]
        knots[-1] = total_coils
    if np.any(np.diff(knots) <= 0):
        raise InputError(
            f"{total_coils:g} turns leave no space between the closed ends; add turns or shorten the ramps"
        )
    return PiecewiseLinear(tuple(knots), tuple(values))


class KnotsForm(StrictModel):
    """``{ coils = [0, 4, 7], values = "22, 22, 17 mm" }``, straight between knots, or smooth with
    ``kind = "table"``.

    ``clearances`` in place of ``values`` gives a pitch less the wire diameter.
    """

    kind: Literal["piecewise-linear", "table"] = "piecewise-linear"
    coils: Numbers
    values: Lengths | None = None
    clearances: Lengths | None = None

    def build(self, total_coils: float, wire: Curve | None = None) -> Curve:
        """The curve; raises :class:`InputError` when this form lacks or repeats something."""
        if (self.values is None) == (self.clearances is None):
            raise InputError(
                "a curve over coils has either values or clearances (pitch less wire diameter); give one of them"
            )
        numbers = self.values if self.values is not None else self.clearances
        assert numbers is not None
        curve: Curve = (
            Table(self.coils, numbers)
            if self.kind == "table"
            else PiecewiseLinear(self.coils, numbers)
        )
        if self.clearances is None:
            return curve
        if wire is None:
            raise InputError("clearances belong to a pitch; give values here")
        return add_curves(curve, wire)


class FormulaForm(StrictModel):
    """A named law: linear (conical), parabolic (barrel, hourglass), beehive, closed-ends (a pitch)."""

    formula: Literal["linear", "conical", "barrel", "hourglass", "beehive", "closed-ends"]
    lower: PositiveLength | None = None
    upper: PositiveLength | None = None
    ends: PositiveLength | None = None
    middle: PositiveLength | None = None
    taper_from_coil: Number | None = None
    pitch: PositiveLength | None = None
    closed_lower: Number = 1.0
    closed_upper: Number = 1.0
    ramp: Number = 0.5

    def build(self, total_coils: float, wire: Curve | None = None) -> Curve:
        """The curve; raises :class:`InputError` when this form lacks or repeats something."""
        if self.formula in ("linear", "conical"):
            lower, upper = self._need("lower", "upper")
            return PiecewiseLinear((0.0, total_coils), (lower, upper))
        if self.formula in ("barrel", "hourglass"):
            ends, middle = self._need("ends", "middle")
            if (middle > ends) != (self.formula == "barrel"):
                raise InputError(
                    f"formula {self.formula} has middle {middle:g} m and ends {ends:g} m, the wrong way round; swap them"
                )
            return Parabola(ends, middle, total_coils)
        if self.formula == "beehive":
            lower, upper, start = self._need("lower", "upper", "taper_from_coil")
            return PiecewiseLinear((0.0, start, total_coils), (lower, lower, upper))
        (pitch,) = self._need("pitch")
        if not isinstance(wire, Constant):
            raise InputError(
                "formula closed-ends is a pitch for a wire of constant diameter; write the pitch over coils instead"
            )
        return pitch_with_closed_turns(
            total_coils, wire.level, pitch, self.closed_lower, self.closed_upper, self.ramp
        )

    def _need(self, *names: str) -> tuple[float, ...]:
        for name in names:
            if getattr(self, name) is None:
                raise InputError(f"formula {self.formula} needs {' and '.join(names)}; add {name}")
        return tuple(getattr(self, name) for name in names)


class HeightForm(StrictModel):
    """Height of the wire axis over the coil number, interpolated smoothly: another way to give the
    pitch.
    """

    kind: Literal["table"] = "table"
    coils: Numbers
    values: Lengths

    def build(self, total_coils: float, wire: Curve | None = None) -> Curve:
        """The pitch; raises :class:`InputError` for knots that make no curve."""
        return SlopeOf(Table(self.coils, self.values))


def curve_of(form: Any, total_coils: float, wire: Curve | None = None) -> Curve:
    """The curve of what is given, a number (m), a curve or a form of a file, over ``total_coils`` turns of a ``wire``;
    raises :class:`InputError`.
    """
    if isinstance(form, (KnotsForm, FormulaForm, HeightForm)):
        return form.build(total_coils, wire)
    curve: Curve = Constant(form) if isinstance(form, float) else form
    return curve


_read_length: Any = quantity("length").func


def _read_curve(raw: Any, info: ValidationInfo) -> Any:
    if isinstance(raw, dict):
        return validate_as(FormulaForm if "formula" in raw else KnotsForm, raw)
    return raw if isinstance(raw, Curve) else _read_length(raw, info)


#: A curve in a file or in Python; a form of a file becomes one where the turns of the wire are known.
CurveField = Annotated[Curve, PlainValidator(_read_curve)]
