"""Curves made from other curves or from named formulas; picklable, with exact derivative and integral."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.parameters.curves import Array, Constant, Curve, PiecewiseLinear, Table


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
        return self.middle + (self.ends - self.middle) * (2 * np.asarray(coil, dtype=float) / self.total_coils - 1) ** 2

    def derivative(self, coil: ArrayLike) -> Array:
        return (self.ends - self.middle) * 4 / self.total_coils * (2 * np.asarray(coil, dtype=float) / self.total_coils - 1)

    def integral(self, coil: ArrayLike) -> Array:
        coil = np.asarray(coil, dtype=float)
        across = 2 * coil / self.total_coils - 1
        return self.middle * coil + (self.ends - self.middle) * self.total_coils / 6 * (across**3 + 1)


def add_curves(first: Curve, second: Curve, weight: float = 1.0) -> Curve:
    """``first + weight * second`` in the simplest class that is exact."""
    if isinstance(first, Constant) and isinstance(second, Constant):
        return Constant(first.level + weight * second.level)
    if isinstance(first, (Constant, PiecewiseLinear)) and isinstance(second, (Constant, PiecewiseLinear)):
        knots = sorted({coil for curve in (first, second) if isinstance(curve, PiecewiseLinear) for coil in curve.coils})
        values = first.value(knots) + weight * second.value(knots)
        return PiecewiseLinear(tuple(knots), tuple(float(value) for value in values))
    return WeightedSum(first, second, weight)
