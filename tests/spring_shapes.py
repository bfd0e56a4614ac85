"""Springs of a library steel, also those whose mean diameter follows a curve, for tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.parameters.curves import Parabola, PiecewiseLinear
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.units import Given, si


def cylindrical(
    wire: Given, mean: Any, pitch: Any = None, total_coils: float = 7.0, **more: Any
) -> SpringDefinition:
    """A spring of OTEVA 90 SC where ``more`` names no other material."""
    usual: dict[str, Any] = {
        "total_coils": total_coils,
        "material": "OTEVA 90 SC",
        "name": "cylindrical",
    }
    return SpringDefinition(wire, mean_diameter=mean, pitch=pitch, **usual | more)


def conical(
    wire: Given,
    lower: Given,
    upper: Given,
    pitch: Any = None,
    total_coils: float = 7.0,
    **more: Any,
) -> SpringDefinition:
    """Mean diameter linear from the ``lower`` to the ``upper`` end."""
    law = PiecewiseLinear((0.0, total_coils), (lower, upper))
    return cylindrical(wire, law, pitch, total_coils, **more)


def barrel(
    wire: Given,
    end: Given,
    middle: Given,
    pitch: Any = None,
    total_coils: float = 7.0,
    **more: Any,
) -> SpringDefinition:
    """Mean diameter parabolic from the ``end`` to the ``middle``."""
    law = Parabola(si(end, "length"), si(middle, "length"), total_coils)
    return cylindrical(wire, law, pitch, total_coils, **more)


def beehive(
    wire: Given,
    mean: Given,
    top: Given,
    taper_from_coil: float,
    pitch: Any = None,
    total_coils: float = 7.0,
    **more: Any,
) -> SpringDefinition:
    """Cylindrical up to a coil number, then tapering linearly."""
    law = PiecewiseLinear((0.0, taper_from_coil, total_coils), (mean, mean, top))
    return cylindrical(wire, law, pitch, total_coils, **more)


@dataclass(frozen=True, slots=True)
class FunctionCurve:
    """A curve of one's own: any callable of the coil number, derivative and integral taken numerically."""

    function: Callable[[Array], ArrayLike]

    def value(self, coil: ArrayLike) -> Array:
        coil = np.asarray(coil, dtype=float)
        return np.broadcast_to(np.asarray(self.function(coil), dtype=float), coil.shape).copy()

    def derivative(self, coil: ArrayLike) -> Array:
        coil, step = np.asarray(coil, dtype=float), 1e-5
        return (self.value(coil + step) - self.value(coil - step)) / (2 * step)

    def integral(self, coil: ArrayLike) -> Array:
        coil = np.asarray(coil, dtype=float)
        # Gauss-Legendre in panels of at most a quarter turn resolves any smooth pitch law.
        nodes, weights = np.polynomial.legendre.leggauss(8)
        panels = max(4, int(np.ceil(4 * np.max(np.abs(coil), initial=1.0))))
        edges = np.linspace(0.0, 1.0, panels + 1)
        points = (edges[:-1, None] + np.diff(edges)[:, None] * (nodes + 1) / 2).ravel()
        scale = (np.diff(edges)[:, None] * weights / 2).ravel()
        return coil * (self.value(np.multiply.outer(coil, points)) @ scale)
