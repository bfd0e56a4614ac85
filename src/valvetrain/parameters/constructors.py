"""Springs in the words of the trade: cylindrical, conical, barrel, hourglass, beehive, variable pitch.

Every length is taken as :func:`valvetrain.units.si` takes it: in m, as text with a unit ("22 mm") or as a pint quantity.
"""

from __future__ import annotations

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.curve_forms import Parabola
from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.material import OTEVA_90_SC, Material
from valvetrain.parameters.spring import OPEN_END, EndCoil, SpringDefinition
from valvetrain.units import Given, si

CLOSED_GROUND = EndCoil()


def pitch_with_closed_ends(
    total_coils: float, wire_diameter: Given, pitch: Given, closed_lower: float = 1.0, closed_upper: float = 1.0, ramp: float = 0.5
) -> PiecewiseLinear:
    """Pitch law (m per turn): wire diameter over the closed turns, ``pitch`` between, ramps of ``ramp`` turns.

    >>> pitch_with_closed_ends(7, "3.8 mm", "7 mm").value(3.5)
    np.float64(0.007)
    """
    wire, free = si(wire_diameter, "wire_diameter", "wire_diameter"), si(pitch, "pitch", "pitch")
    knots = [0.0, closed_lower, closed_lower + ramp, total_coils - closed_upper - ramp, total_coils - closed_upper, total_coils]
    values = [wire, wire, free, free, wire, wire]
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
    wire_diameter: Given, mean_diameter: Given, pitch: Given, total_coils: float, *, material: Material = OTEVA_90_SC,
    closed_coils: float = 1.0, lower_end: EndCoil | None = None, upper_end: EndCoil | None = None, name: str = "cylindrical",
) -> SpringDefinition:  # fmt: skip
    """Cylindrical spring of constant pitch.

    Parameters
    ----------
    wire_diameter, mean_diameter : lengths (m, "4 mm" or a pint quantity); the mean diameter is that of the wire's axis
    pitch : rise of the wire's axis per turn, a length, between the closed turns
    total_coils : all turns, tip to tip
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end; 0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and ground, or open where ``closed_coils`` is 0
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> spring = cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
    >>> round(spring.free_length, 6)
    0.0391
    """
    law = _pitch_law(total_coils, wire_diameter, pitch, closed_coils)
    return _spring(wire_diameter, Constant(_coil(mean_diameter)), law, total_coils, material, lower_end, upper_end, name, closed_coils)


def conical(
    wire_diameter: Given, lower_mean_diameter: Given, upper_mean_diameter: Given, pitch: Given, total_coils: float, *,
    material: Material = OTEVA_90_SC, closed_coils: float = 1.0, lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None, name: str = "conical",
) -> SpringDefinition:  # fmt: skip
    """Conical spring: mean diameter linear from the lower to the upper end.

    Parameters
    ----------
    wire_diameter, lower_mean_diameter, upper_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : rise of the wire's axis per turn, a length, between the closed turns
    total_coils : all turns, tip to tip
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end; 0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and ground, or open where ``closed_coils`` is 0
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> conical("3 mm", "26 mm", "18 mm", "6 mm", 6).mean_diameter.value(3.0).round(6)
    np.float64(0.022)
    """
    diameter = PiecewiseLinear((0.0, total_coils), (_coil(lower_mean_diameter), _coil(upper_mean_diameter)))
    law = _pitch_law(total_coils, wire_diameter, pitch, closed_coils)
    return _spring(wire_diameter, diameter, law, total_coils, material, lower_end, upper_end, name, closed_coils)


def barrel(
    wire_diameter: Given, end_mean_diameter: Given, middle_mean_diameter: Given, pitch: Given, total_coils: float, *,
    material: Material = OTEVA_90_SC, closed_coils: float = 1.0, lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None, name: str = "barrel",
) -> SpringDefinition:  # fmt: skip
    """Barrel (or, with a slimmer middle, hourglass) spring: mean diameter parabolic from the ends to the middle.

    Parameters
    ----------
    wire_diameter, end_mean_diameter, middle_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : rise of the wire's axis per turn, a length, between the closed turns
    total_coils : all turns, tip to tip
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end; 0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and ground, or open where ``closed_coils`` is 0
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> barrel("4 mm", "20 mm", "26 mm", "8 mm", 7).mean_diameter.value(3.5).round(6)
    np.float64(0.026)
    """
    law = _pitch_law(total_coils, wire_diameter, pitch, closed_coils)
    diameter = Parabola(_coil(end_mean_diameter), _coil(middle_mean_diameter), total_coils)
    return _spring(wire_diameter, diameter, law, total_coils, material, lower_end, upper_end, name, closed_coils)


def hourglass(
    wire_diameter: Given, end_mean_diameter: Given, middle_mean_diameter: Given, pitch: Given, total_coils: float, *,
    material: Material = OTEVA_90_SC, closed_coils: float = 1.0, lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None, name: str = "hourglass",
) -> SpringDefinition:  # fmt: skip
    """Hourglass spring: mean diameter parabolic from the ends to a slimmer middle.

    Parameters
    ----------
    wire_diameter, end_mean_diameter, middle_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : rise of the wire's axis per turn, a length, between the closed turns
    total_coils : all turns, tip to tip
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end; 0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and ground, or open where ``closed_coils`` is 0
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a middle no slimmer than the ends, a spring that cannot exist, a slip of units

    Examples
    --------
    >>> hourglass("4 mm", "26 mm", "20 mm", "8 mm", 7).mean_diameter.value(3.5).round(6)
    np.float64(0.02)
    """
    if _coil(middle_mean_diameter) >= _coil(end_mean_diameter):
        raise InputError("an hourglass spring is slimmer in the middle than at its ends; use barrel for the other way round")
    return barrel(
        wire_diameter, end_mean_diameter, middle_mean_diameter, pitch, total_coils, material=material,
        closed_coils=closed_coils, lower_end=lower_end, upper_end=upper_end, name=name,
    )  # fmt: skip


def beehive(
    wire_diameter: Given, mean_diameter: Given, top_mean_diameter: Given, taper_from_coil: float, pitch: Curve | Given, total_coils: float,
    *, material: Material = OTEVA_90_SC, lower_end: EndCoil | None = None, upper_end: EndCoil | None = None, name: str = "beehive",
) -> SpringDefinition:  # fmt: skip
    """Beehive spring: cylindrical up to a coil number, then tapering linearly.

    Parameters
    ----------
    wire_diameter, mean_diameter, top_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    taper_from_coil : coil number (turns from the lower tip) from which the mean diameter falls to ``top_mean_diameter``
    pitch : curve over the coil number (m per turn), or a length, which holds between one closed turn at either end
    total_coils : all turns, tip to tip
    material : of the wire, :class:`Material`
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and ground
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> beehive("3.8 mm", "22 mm", "18 mm", 4, "7 mm", 7).mean_diameter.value(7.0).round(6)
    np.float64(0.018)
    """
    diameter = PiecewiseLinear((0.0, taper_from_coil, total_coils), (_coil(mean_diameter), _coil(mean_diameter), _coil(top_mean_diameter)))
    law = _pitch_law(total_coils, wire_diameter, pitch, 1.0)
    return _spring(wire_diameter, diameter, law, total_coils, material, lower_end, upper_end, name)


def variable_pitch(
    wire_diameter: Given, mean_diameter: Given, pitch: Curve | Given, total_coils: float, *, material: Material = OTEVA_90_SC,
    lower_end: EndCoil | None = None, upper_end: EndCoil | None = None, name: str = "variable pitch",
) -> SpringDefinition:  # fmt: skip
    """Cylindrical spring whose pitch follows any curve over the coil number.

    Parameters
    ----------
    wire_diameter, mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : curve over the coil number (m per turn), or a length, which holds between one closed turn at either end
    total_coils : all turns, tip to tip
    material : of the wire, :class:`Material`
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and ground
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> law = PiecewiseLinear((0, 1, 2, 5, 6, 7), "3.8, 3.8, 6, 8, 3.8, 3.8 mm")
    >>> variable_pitch("3.8 mm", "22 mm", law, 7).total_coils
    7
    """
    law = _pitch_law(total_coils, wire_diameter, pitch, 1.0)
    return _spring(wire_diameter, Constant(_coil(mean_diameter)), law, total_coils, material, lower_end, upper_end, name)


def _coil(mean_diameter: Given) -> float:
    return si(mean_diameter, "mean_diameter", "mean diameter")


def _pitch_law(total_coils: float, wire_diameter: Given, pitch: Curve | Given, closed_coils: float) -> Curve:
    if not (np.isfinite(closed_coils) and closed_coils >= 0):
        raise InputError(f"closed_coils is {closed_coils:g}; give the turns that lie closed at either end, 0 for open ends")
    if isinstance(pitch, Curve):
        return pitch
    if closed_coils == 0:
        return Constant(si(pitch, "pitch", "pitch"))
    return pitch_with_closed_ends(total_coils, wire_diameter, pitch, closed_coils, closed_coils)


def _spring(
    wire_diameter: Given, diameter: Curve, pitch: Curve, total_coils: float, material: Material,
    lower_end: EndCoil | None, upper_end: EndCoil | None, name: str, closed_coils: float = 1.0,
) -> SpringDefinition:  # fmt: skip
    usual = CLOSED_GROUND if closed_coils > 0 else OPEN_END
    return SpringDefinition(
        wire_diameter=Constant(si(wire_diameter, "wire_diameter", "wire_diameter")), mean_diameter=diameter, pitch=pitch,
        total_coils=total_coils, material=material, lower_end=lower_end or usual, upper_end=upper_end or usual, name=name,
    )  # fmt: skip
