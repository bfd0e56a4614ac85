"""Springs of round wire made in Python, and how closed ends and a free length make a pitch.

Every length is taken as :func:`valvetrain.units.si` takes it: in m, as text with a unit ("22 mm")
or as a pint quantity.
"""

from __future__ import annotations

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.material import OTEVA_90_SC, Material
from valvetrain.parameters.spring import EndCoil, EndKind, SpringDefinition, is_closed
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
    mean_diameter: Curve | Given,
    pitch: Curve | Given | None = None,
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
    """Cylindrical spring of constant pitch, or one whose mean diameter and pitch follow curves.

    Parameters
    ----------
    wire_diameter : length (m, "4 mm" or a pint quantity)
    mean_diameter : of the wire's axis: a length, or a curve over the coil number (conical, beehive)
    pitch : rise of the wire's axis per turn: a length, which holds between the closed turns, or a
        curve over the coil number; or give the free length
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
    >>> beehive = cylindrical("3.8 mm", PiecewiseLinear((0, 4, 7), "22, 22, 18 mm"), "7 mm", 7)
    >>> beehive.mean_diameter.value(7.0).round(6)
    np.float64(0.018)
    """
    if total_coils is None:
        raise InputError("total_coils is missing; give all turns of the wire, tip to tip")
    if closed_coils is not None and not (np.isfinite(closed_coils) and closed_coils >= 0):
        raise InputError(
            f"closed_coils is {closed_coils:g}; give the turns that are closed at either end, 0 for open ends"
        )
    lower, upper = lower_end, upper_end
    if ends is not None and (closed_coils is not None or lower is not None or upper is not None):
        raise InputError(
            "ends speaks for both ends, so closed_coils, lower_end and upper_end may contradict it; leave one or the other out"
        )
    wire = Constant(si(wire_diameter, "wire_diameter", "wire_diameter"))
    law: Curve
    if free_length is not None and pitch is None:
        if closed_coils:
            raise InputError(
                "closed_coils goes with a pitch; with a free length say how the ends are made by ends, lower_end or upper_end"
            )
        both: EndKind = ends or ("open" if closed_coils == 0 else "closed-ground")
        length = si(free_length, "spring_length", "free_length")
        law, lower, upper = wind(total_coils, wire, length, lower or both, upper or both)
    elif pitch is not None and free_length is None:
        closed = 1.0 if closed_coils is None else closed_coils
        if ends is not None:
            closed = 1.0 if is_closed(ends) else 0.0
        default_end = EndCoil(ends or ("closed-ground" if closed > 0 else "open"))
        lower, upper = lower or default_end, upper or default_end
        if isinstance(pitch, Curve):
            law = pitch
        elif closed == 0:
            law = Constant(si(pitch, "pitch", "pitch"))
        else:
            law = pitch_with_closed_ends(total_coils, wire.level, pitch, closed, closed)
    else:
        raise InputError(
            "a spring is wound to a pitch or to a free length; give pitch or free_length, one of them"
        )
    if not isinstance(mean_diameter, Curve):
        mean_diameter = Constant(si(mean_diameter, "mean_diameter", "mean diameter"))
    return SpringDefinition(
        wire, mean_diameter, law, total_coils, material, lower, upper, name=name
    )
