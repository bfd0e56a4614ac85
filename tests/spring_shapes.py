"""Springs of a library steel, also those whose mean diameter follows a curve, for tests."""

from __future__ import annotations

from typing import Any

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
