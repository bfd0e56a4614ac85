"""Springs in the words of the trade: cylindrical, conical, barrel, hourglass, beehive, variable pitch."""

from __future__ import annotations

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.curve_forms import Parabola
from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.material import OTEVA_90_SC, Material
from valvetrain.parameters.spring import EndCoil, SpringDefinition

CLOSED_GROUND = EndCoil()


def pitch_with_closed_ends(
    total_coils: float, wire_diameter: float, pitch: float, closed_lower: float = 1.0, closed_upper: float = 1.0, ramp: float = 0.5
) -> PiecewiseLinear:
    """Pitch law (m per turn): wire diameter over the closed turns, ``pitch`` between, ramps of ``ramp`` turns."""
    knots = [0.0, closed_lower, closed_lower + ramp, total_coils - closed_upper - ramp, total_coils - closed_upper, total_coils]
    values = [wire_diameter, wire_diameter, pitch, pitch, wire_diameter, wire_diameter]
    if closed_lower == 0:
        knots, values = knots[2:], values[2:]
        knots[0] = 0.0
    if closed_upper == 0:
        knots, values = knots[:-2], values[:-2]
        knots[-1] = total_coils
    if np.any(np.diff(knots) <= 0):
        raise InputError(f"{total_coils:g} turns leave no room between the closed ends; add turns or shorten the ramps")
    return PiecewiseLinear(tuple(knots), tuple(values))


def cylindrical(
    wire_diameter: float, mean_diameter: float, pitch: float, total_coils: float, *, material: Material = OTEVA_90_SC,
    closed_coils: float = 1.0, lower_end: EndCoil = CLOSED_GROUND, upper_end: EndCoil = CLOSED_GROUND, name: str = "cylindrical",
) -> SpringDefinition:  # fmt: skip
    """Cylindrical spring of constant pitch with ``closed_coils`` closed turns at either end (0 for open ends); lengths in m."""
    law = _even_pitch(total_coils, wire_diameter, pitch, closed_coils)
    return _spring(wire_diameter, Constant(mean_diameter), law, total_coils, material, lower_end, upper_end, name)


def conical(
    wire_diameter: float, lower_mean_diameter: float, upper_mean_diameter: float, pitch: float, total_coils: float, *,
    material: Material = OTEVA_90_SC, closed_coils: float = 1.0, lower_end: EndCoil = CLOSED_GROUND,
    upper_end: EndCoil = CLOSED_GROUND, name: str = "conical",
) -> SpringDefinition:  # fmt: skip
    """Conical spring: mean diameter linear from lower to upper end; lengths in m."""
    diameter = PiecewiseLinear((0.0, total_coils), (lower_mean_diameter, upper_mean_diameter))
    law = _even_pitch(total_coils, wire_diameter, pitch, closed_coils)
    return _spring(wire_diameter, diameter, law, total_coils, material, lower_end, upper_end, name)


def barrel(
    wire_diameter: float, end_mean_diameter: float, middle_mean_diameter: float, pitch: float, total_coils: float, *,
    material: Material = OTEVA_90_SC, closed_coils: float = 1.0, lower_end: EndCoil = CLOSED_GROUND,
    upper_end: EndCoil = CLOSED_GROUND, name: str = "barrel",
) -> SpringDefinition:  # fmt: skip
    """Barrel (or, with a slimmer middle, hourglass) spring: mean diameter parabolic over the turns; lengths in m."""
    law = _even_pitch(total_coils, wire_diameter, pitch, closed_coils)
    diameter = Parabola(end_mean_diameter, middle_mean_diameter, total_coils)
    return _spring(wire_diameter, diameter, law, total_coils, material, lower_end, upper_end, name)


def hourglass(
    wire_diameter: float, end_mean_diameter: float, middle_mean_diameter: float, pitch: float, total_coils: float, *,
    material: Material = OTEVA_90_SC, closed_coils: float = 1.0, lower_end: EndCoil = CLOSED_GROUND,
    upper_end: EndCoil = CLOSED_GROUND, name: str = "hourglass",
) -> SpringDefinition:  # fmt: skip
    """Hourglass spring: as :func:`barrel`, with a middle slimmer than the ends."""
    if middle_mean_diameter >= end_mean_diameter:
        raise InputError("an hourglass spring is slimmer in the middle than at its ends; use barrel for the other way round")
    return barrel(
        wire_diameter, end_mean_diameter, middle_mean_diameter, pitch, total_coils, material=material,
        closed_coils=closed_coils, lower_end=lower_end, upper_end=upper_end, name=name,
    )  # fmt: skip


def beehive(
    wire_diameter: float, mean_diameter: float, top_mean_diameter: float, taper_from_coil: float, pitch: Curve, total_coils: float, *,
    material: Material = OTEVA_90_SC, lower_end: EndCoil = CLOSED_GROUND, upper_end: EndCoil = CLOSED_GROUND, name: str = "beehive",
) -> SpringDefinition:  # fmt: skip
    """Beehive spring: cylindrical up to ``taper_from_coil``, then tapering linearly to ``top_mean_diameter``; lengths in m."""
    diameter = PiecewiseLinear((0.0, taper_from_coil, total_coils), (mean_diameter, mean_diameter, top_mean_diameter))
    return _spring(wire_diameter, diameter, pitch, total_coils, material, lower_end, upper_end, name)


def variable_pitch(
    wire_diameter: float, mean_diameter: float, pitch: Curve, total_coils: float, *, material: Material = OTEVA_90_SC,
    lower_end: EndCoil = CLOSED_GROUND, upper_end: EndCoil = CLOSED_GROUND, name: str = "variable pitch",
) -> SpringDefinition:  # fmt: skip
    """Cylindrical spring whose pitch follows any curve over the coil number; lengths in m."""
    return _spring(wire_diameter, Constant(mean_diameter), pitch, total_coils, material, lower_end, upper_end, name)


def _even_pitch(total_coils: float, wire_diameter: float, pitch: float, closed_coils: float) -> Curve:
    if closed_coils <= 0:
        return Constant(pitch)
    return pitch_with_closed_ends(total_coils, wire_diameter, pitch, closed_coils, closed_coils)


def _spring(
    wire_diameter: float, diameter: Curve, pitch: Curve, total_coils: float, material: Material,
    lower_end: EndCoil, upper_end: EndCoil, name: str,
) -> SpringDefinition:  # fmt: skip
    return SpringDefinition(
        wire_diameter=Constant(wire_diameter), mean_diameter=diameter, pitch=pitch, total_coils=total_coils,
        material=material, lower_end=lower_end, upper_end=upper_end, name=name,
    )  # fmt: skip
