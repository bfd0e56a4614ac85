"""Springs in the words of the trade: cylindrical, conical, barrel, hourglass, beehive, variable
pitch.

Every length is taken as :func:`valvetrain.units.si` takes it: in m, as text with a unit ("22 mm")
or as a pint quantity.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant, Curve, Parabola, PiecewiseLinear
from valvetrain.parameters.material import OTEVA_90_SC, Material
from valvetrain.parameters.spring import OPEN_END, EndCoil, EndKind, SpringDefinition
from valvetrain.units import Given, si

#: Kind -> inactive and ground turns of the table: half a ground turn of closed wire brings the seat
#: onto the axis of the tip.
TEXTBOOK_TURNS: dict[str, tuple[float, float]] = {
    "closed-ground": (1.0, 0.5), "closed": (1.0, 0.0), "open": (0.0, 0.0), "open-ground": (0.5, float("nan")),
}  # fmt: skip
#: The pitch rises from the wire diameter to its full value over this stretch, half of it before and
#: half after the first turn.
RAMP = 0.5


def pitch_with_closed_turns(
    total_coils: float,
    wire: float,
    pitch: float,
    closed_lower: float,
    closed_upper: float,
    ramp: float,
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


def is_closed(end: EndCoil | EndKind) -> bool:
    """Whether the last turn touches its neighbour."""
    return (end.kind if isinstance(end, EndCoil) else end).startswith("closed")


def wind(
    total_coils: float,
    wire_diameter: Curve,
    free_length: float,
    lower: EndCoil | EndKind,
    upper: EndCoil | EndKind,
) -> tuple[Curve, EndCoil, EndCoil]:
    """Pitch law (m per turn) and both ends of a spring of a ``free_length`` (m) with
    ``total_coils`` turns tip to tip.

    An end given as a word gets the turns of the table; an :class:`EndCoil` is taken as it is.
    Closed ends are wound at the wire diameter. Raises :class:`InputError` for a wire of no constant
    diameter and for a free length at which the coils would be solid.
    """
    if not isinstance(wire_diameter, Constant):
        raise InputError(
            "a free length makes the pitch of a wire of constant diameter; give the pitch over the coils instead",
            "free_length",
        )
    wire = wire_diameter.level
    if not (np.isfinite(total_coils) and total_coils > 0 and np.isfinite(wire) and wire > 0):
        raise InputError(
            "a free length makes a pitch for positive wire_diameter and total_coils; check both",
            "free_length",
        )
    closed = (_closed_turns(lower), _closed_turns(upper))

    def law(pitch: float) -> Curve:
        return (
            Constant(pitch)
            if not any(closed)
            else pitch_with_closed_turns(total_coils, wire, pitch, *closed, RAMP)
        )

    def length(pitch: float) -> float:
        curve, low, high = law(pitch), _end(lower, wire, pitch), _end(upper, wire, pitch)
        return (
            float(
                curve.integral(total_coils - high.ground_coils) - curve.integral(low.ground_coils)
            )
            + wire
        )

    # the length is a straight line over the pitch, whatever the ends
    solid, slope = length(wire), (length(3 * wire) - length(wire)) / (2 * wire)
    if not slope > 1e-9:
        raise InputError(
            f"the ground turns of both ends use up all of {total_coils:g} turns; grind fewer or wind more",
            "total_coils",
        )
    pitch = wire + (free_length - solid) / slope
    if not pitch > wire * (1 + 1e-9):
        raise InputError(
            f"a free length of {free_length * 1e3:.4g} mm leaves no gap between {total_coils:g} turns of {wire * 1e3:.4g} mm wire, "
            f"which are solid at {solid * 1e3:.4g} mm; lengthen the spring or take out turns",
            "free_length",
        )
    return law(pitch), _end(lower, wire, pitch), _end(upper, wire, pitch)


def _closed_turns(end: EndCoil | EndKind) -> float:
    return 1.0 - RAMP / 2 if is_closed(end) else 0.0


def _end(end: EndCoil | EndKind, wire: float, pitch: float) -> EndCoil:
    """The end coil; ground at its pitch, an open one loses half the wire at its tip over d / (2 p)
    turns.
    """
    if isinstance(end, EndCoil):
        return end
    if end not in TEXTBOOK_TURNS:
        raise InputError(f"ends '{end}' are unknown; use {', '.join(TEXTBOOK_TURNS)}", "ends")
    inactive, ground = TEXTBOOK_TURNS[end]
    return EndCoil(end, inactive, 0.5 * wire / pitch if end == "open-ground" else ground)


CLOSED_GROUND = EndCoil()


def pitch_with_closed_ends(
    total_coils: float,
    wire_diameter: Given,
    pitch: Given,
    closed_lower: float = 1.0,
    closed_upper: float = 1.0,
    ramp: float = 0.5,
) -> PiecewiseLinear:
    """Pitch law (m per turn): wire diameter over the closed turns, ``pitch`` between, ramps of
    ``ramp`` turns.

    >>> pitch_with_closed_ends(7, "3.8 mm", "7 mm").value(3.5)
    np.float64(0.007)
    """
    wire, free = si(wire_diameter, "wire_diameter", "wire_diameter"), si(pitch, "pitch", "pitch")
    return pitch_with_closed_turns(total_coils, wire, free, closed_lower, closed_upper, ramp)


def cylindrical(
    wire_diameter: Given,
    mean_diameter: Given,
    pitch: Given | None = None,
    total_coils: float | None = None,
    *,
    free_length: Given | None = None,
    ends: EndKind | None = None,
    material: Material = OTEVA_90_SC,
    closed_coils: float | None = None,
    lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None,
    name: str = "cylindrical",
) -> SpringDefinition:
    """Cylindrical spring of constant pitch.

    Parameters
    ----------
    wire_diameter, mean_diameter : lengths (m, "4 mm" or a pint quantity); the mean diameter is that
        of the wire's axis
    pitch : rise of the wire's axis per turn, a length, between the closed turns; or give the free
        length
    total_coils : all turns, tip to tip
    free_length : length of the unloaded spring, in place of the pitch, which then follows
    ends : "closed-ground" (the default), "closed", "open" or "open-ground", both ends; made as in
        textbooks where the free length is given
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end, 1 where a pitch is given and nothing else said;
        0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and
        ground, or open where ``closed_coils`` is 0
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> spring = cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
    >>> round(spring.free_length, 6)
    0.0391
    >>> spring = cylindrical("4 mm", "24 mm", total_coils=8, free_length="52 mm", ends="closed-ground")
    >>> float(spring.pitch.value(4.0).round(6)), round(spring.solid_height, 6)
    (0.007333, 0.032639)
    """
    wound = _wound(
        total_coils, wire_diameter, pitch, free_length, ends, closed_coils, lower_end, upper_end
    )
    return _spring(wound, Constant(_coil(mean_diameter)), material, name)


def conical(
    wire_diameter: Given,
    lower_mean_diameter: Given,
    upper_mean_diameter: Given,
    pitch: Given | None = None,
    total_coils: float | None = None,
    *,
    free_length: Given | None = None,
    ends: EndKind | None = None,
    material: Material = OTEVA_90_SC,
    closed_coils: float | None = None,
    lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None,
    name: str = "conical",
) -> SpringDefinition:
    """Conical spring: mean diameter linear from the lower to the upper end.

    Parameters
    ----------
    wire_diameter, lower_mean_diameter, upper_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : rise of the wire's axis per turn, a length, between the closed turns; or give the free
        length
    total_coils : all turns, tip to tip
    free_length : length of the unloaded spring, in place of the pitch, which then follows
    ends : "closed-ground" (the default), "closed", "open" or "open-ground", both ends; made as in
        textbooks where the free length is given
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end, 1 where a pitch is given and nothing else said;
        0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and
        ground, or open where ``closed_coils`` is 0
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> conical("3 mm", "26 mm", "18 mm", "6 mm", 6).mean_diameter.value(3.0).round(6)
    np.float64(0.022)
    """
    wound = _wound(
        total_coils, wire_diameter, pitch, free_length, ends, closed_coils, lower_end, upper_end
    )
    diameter = PiecewiseLinear(
        (0.0, wound.total_coils), (_coil(lower_mean_diameter), _coil(upper_mean_diameter))
    )
    return _spring(wound, diameter, material, name)


def barrel(
    wire_diameter: Given,
    end_mean_diameter: Given,
    middle_mean_diameter: Given,
    pitch: Given | None = None,
    total_coils: float | None = None,
    *,
    free_length: Given | None = None,
    ends: EndKind | None = None,
    material: Material = OTEVA_90_SC,
    closed_coils: float | None = None,
    lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None,
    name: str = "barrel",
) -> SpringDefinition:
    """Barrel (or, with a slimmer middle, hourglass) spring: mean diameter parabolic from the ends
    to the middle.

    Parameters
    ----------
    wire_diameter, end_mean_diameter, middle_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : rise of the wire's axis per turn, a length, between the closed turns; or give the free
        length
    total_coils : all turns, tip to tip
    free_length : length of the unloaded spring, in place of the pitch, which then follows
    ends : "closed-ground" (the default), "closed", "open" or "open-ground", both ends; made as in
        textbooks where the free length is given
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end, 1 where a pitch is given and nothing else said;
        0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and
        ground, or open where ``closed_coils`` is 0
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> barrel("4 mm", "20 mm", "26 mm", "8 mm", 7).mean_diameter.value(3.5).round(6)
    np.float64(0.026)
    """
    wound = _wound(
        total_coils, wire_diameter, pitch, free_length, ends, closed_coils, lower_end, upper_end
    )
    diameter = Parabola(_coil(end_mean_diameter), _coil(middle_mean_diameter), wound.total_coils)
    return _spring(wound, diameter, material, name)


def hourglass(
    wire_diameter: Given,
    end_mean_diameter: Given,
    middle_mean_diameter: Given,
    pitch: Given | None = None,
    total_coils: float | None = None,
    *,
    free_length: Given | None = None,
    ends: EndKind | None = None,
    material: Material = OTEVA_90_SC,
    closed_coils: float | None = None,
    lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None,
    name: str = "hourglass",
) -> SpringDefinition:
    """Hourglass spring: mean diameter parabolic from the ends to a slimmer middle.

    Parameters
    ----------
    wire_diameter, end_mean_diameter, middle_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : rise of the wire's axis per turn, a length, between the closed turns; or give the free
        length
    total_coils : all turns, tip to tip
    free_length : length of the unloaded spring, in place of the pitch, which then follows
    ends : "closed-ground" (the default), "closed", "open" or "open-ground", both ends; made as in
        textbooks where the free length is given
    material : of the wire, :class:`Material`
    closed_coils : turns lying closed at either end, 1 where a pitch is given and nothing else said;
        0 for open ends
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and
        ground, or open where ``closed_coils`` is 0
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
        raise InputError(
            "an hourglass spring is slimmer in the middle than at its ends; use barrel for the other way round"
        )
    return barrel(
        wire_diameter,
        end_mean_diameter,
        middle_mean_diameter,
        pitch,
        total_coils,
        free_length=free_length,
        ends=ends,
        material=material,
        closed_coils=closed_coils,
        lower_end=lower_end,
        upper_end=upper_end,
        name=name,
    )


def beehive(
    wire_diameter: Given,
    mean_diameter: Given,
    top_mean_diameter: Given,
    taper_from_coil: float,
    pitch: Curve | Given | None = None,
    total_coils: float | None = None,
    *,
    free_length: Given | None = None,
    ends: EndKind | None = None,
    material: Material = OTEVA_90_SC,
    lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None,
    name: str = "beehive",
) -> SpringDefinition:
    """Beehive spring: cylindrical up to a coil number, then tapering linearly.

    Parameters
    ----------
    wire_diameter, mean_diameter, top_mean_diameter : lengths (m, "4 mm" or a pint quantity)
    taper_from_coil : coil number (turns from the lower tip) from which the mean diameter falls to
        ``top_mean_diameter``
    pitch : curve over the coil number (m per turn), or a length, which holds between one closed
        turn at either end; or give the free length
    total_coils : all turns, tip to tip
    free_length : length of the unloaded spring, in place of the pitch, which then follows
    ends : "closed-ground" (the default), "closed", "open" or "open-ground", both ends; made as in
        textbooks where the free length is given
    material : of the wire, :class:`Material`
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and
        ground
    name : word for the spring in messages and results

    Raises
    ------
    InputError : a spring that cannot exist, a slip of units

    Examples
    --------
    >>> beehive("3.8 mm", "22 mm", "18 mm", 4, "7 mm", 7).mean_diameter.value(7.0).round(6)
    np.float64(0.018)
    """
    wound = _wound(total_coils, wire_diameter, pitch, free_length, ends, None, lower_end, upper_end)
    full, top = _coil(mean_diameter), _coil(top_mean_diameter)
    diameter = PiecewiseLinear((0.0, taper_from_coil, wound.total_coils), (full, full, top))
    return _spring(wound, diameter, material, name)


def variable_pitch(
    wire_diameter: Given,
    mean_diameter: Given,
    pitch: Curve | Given,
    total_coils: float,
    *,
    material: Material = OTEVA_90_SC,
    lower_end: EndCoil | None = None,
    upper_end: EndCoil | None = None,
    name: str = "variable pitch",
) -> SpringDefinition:
    """Cylindrical spring whose pitch follows any curve over the coil number.

    Parameters
    ----------
    wire_diameter, mean_diameter : lengths (m, "4 mm" or a pint quantity)
    pitch : curve over the coil number (m per turn), or a length, which holds between one closed
        turn at either end
    total_coils : all turns, tip to tip
    material : of the wire, :class:`Material`
    lower_end, upper_end : :class:`EndCoil`, how the ends meet their seats; left out, closed and
        ground
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
    wound = _wound(total_coils, wire_diameter, pitch, None, None, None, lower_end, upper_end)
    return _spring(wound, Constant(_coil(mean_diameter)), material, name)


def _coil(mean_diameter: Given) -> float:
    return si(mean_diameter, "mean_diameter", "mean diameter")


class _Wound(NamedTuple):
    """What the turns of a spring come to: wire diameter (m), turns, pitch law (m per turn) and both
    ends.
    """

    wire: float
    total_coils: float
    pitch: Curve
    lower: EndCoil
    upper: EndCoil


def _wound(
    total_coils: float | None,
    wire_diameter: Given,
    pitch: Curve | Given | None,
    free_length: Given | None,
    ends: EndKind | None,
    closed_coils: float | None,
    lower: EndCoil | None,
    upper: EndCoil | None,
) -> _Wound:
    if total_coils is None:
        raise InputError("total_coils is missing; give all turns of the wire, tip to tip")
    if (pitch is None) == (free_length is None):
        raise InputError(
            "a spring is wound to a pitch or to a free length; give pitch or free_length, one of them"
        )
    if closed_coils is not None and not (np.isfinite(closed_coils) and closed_coils >= 0):
        raise InputError(
            f"closed_coils is {closed_coils:g}; give the turns that are closed at either end, 0 for open ends"
        )
    if ends is not None and (closed_coils is not None or lower is not None or upper is not None):
        raise InputError(
            "ends speaks for both ends, so closed_coils, lower_end and upper_end may contradict it; leave one or the other out"
        )
    wire = si(wire_diameter, "wire_diameter", "wire_diameter")
    if free_length is not None:
        if closed_coils:
            raise InputError(
                "closed_coils goes with a pitch; with a free length say how the ends are made by ends, lower_end or upper_end"
            )
        both: EndKind = ends or ("open" if closed_coils == 0 else "closed-ground")
        length = si(free_length, "spring_length", "free_length")
        return _Wound(
            wire,
            total_coils,
            *wind(total_coils, Constant(wire), length, lower or both, upper or both),
        )
    assert pitch is not None
    if ends is not None:
        lower = upper = EndCoil(ends)
        closed_coils = 1.0 if is_closed(ends) else 0.0
    closed = 1.0 if closed_coils is None else closed_coils
    default_end = CLOSED_GROUND if closed > 0 else OPEN_END
    if isinstance(pitch, Curve):
        law: Curve = pitch
    elif closed == 0:
        law = Constant(si(pitch, "pitch", "pitch"))
    else:
        law = pitch_with_closed_ends(total_coils, wire, pitch, closed, closed)
    return _Wound(wire, total_coils, law, lower or default_end, upper or default_end)


def _spring(wound: _Wound, diameter: Curve, material: Material, name: str) -> SpringDefinition:
    return SpringDefinition(
        wire_diameter=Constant(wound.wire),
        mean_diameter=diameter,
        pitch=wound.pitch,
        total_coils=wound.total_coils,
        material=material,
        lower_end=wound.lower,
        upper_end=wound.upper,
        name=name,
    )
