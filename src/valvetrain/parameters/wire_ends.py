"""Ends of a coil spring by the words of the textbook, and the pitch that a free length leaves between them.

Of a wire of diameter d with n active turns of pitch p (shigley2015, table 10-1; EN 13906-1 has the same closed and ground ends):

    ends            total turns   free length   solid length
    open            n             p n + d       d (turns + 1)
    open-ground     n + 1         p (n + 1)     d turns
    closed          n + 2         p n + 3 d     d (turns + 1)
    closed-ground   n + 2         p n + 2 d     d turns
"""

from __future__ import annotations

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.spring import EndCoil, EndKind

#: Kind -> inactive and ground turns of the table: half a ground turn of closed wire brings the seat onto the axis of the tip.
TEXTBOOK_TURNS: dict[str, tuple[float, float]] = {
    "closed-ground": (1.0, 0.5), "closed": (1.0, 0.0), "open": (0.0, 0.0), "open-ground": (0.5, float("nan")),
}  # fmt: skip
#: The pitch rises from the wire diameter to its full value over this stretch, half of it before and half after the first turn.
RAMP = 0.5


def pitch_with_closed_turns(
    total_coils: float, wire: float, pitch: float, closed_lower: float, closed_upper: float, ramp: float
) -> PiecewiseLinear:
    """Pitch law (m per turn): the ``wire`` diameter (m) over the closed turns, ``pitch`` (m) between, ramps of ``ramp`` turns.

    Raises :class:`InputError` where the closed turns and their ramps leave no turn between them.
    """
    knots = [0.0, closed_lower, closed_lower + ramp, total_coils - closed_upper - ramp, total_coils - closed_upper, total_coils]
    values = [wire, wire, pitch, pitch, wire, wire]
    if closed_lower == 0:
        knots, values = knots[2:], values[2:]
        knots[0] = 0.0
    if closed_upper == 0:
        knots, values = knots[:-2], values[:-2]
        knots[-1] = total_coils
    if np.any(np.diff(knots) <= 0):
        raise InputError(f"{total_coils:g} turns leave no room between the closed ends; add turns or shorten the ramps")
    return PiecewiseLinear(tuple(knots), tuple(values))


def is_closed(end: EndCoil | EndKind) -> bool:
    """Whether the last turn lies on its neighbour."""
    return (end.kind if isinstance(end, EndCoil) else end).startswith("closed")


def wind(
    total_coils: float, wire_diameter: Curve, free_length: float, lower: EndCoil | EndKind, upper: EndCoil | EndKind
) -> tuple[Curve, EndCoil, EndCoil]:
    """Pitch law (m per turn) and both ends of a spring of a ``free_length`` (m) with ``total_coils`` turns tip to tip.

    An end given as a word gets the turns of the table; an :class:`EndCoil` is taken as it is. Closed ends are wound at the wire diameter.
    Raises :class:`InputError` for a wire of no constant diameter and for a free length at which the coils would be solid.
    """
    if not isinstance(wire_diameter, Constant):
        raise InputError(
            "a free length makes the pitch of a wire of constant diameter; give the pitch over the coils instead", "free_length"
        )
    wire = wire_diameter.level
    if not (np.isfinite(total_coils) and total_coils > 0 and np.isfinite(wire) and wire > 0):
        raise InputError("a free length makes a pitch for positive wire_diameter and total_coils; check both", "free_length")
    closed = (_closed_turns(lower), _closed_turns(upper))

    def law(pitch: float) -> Curve:
        return Constant(pitch) if not any(closed) else pitch_with_closed_turns(total_coils, wire, pitch, *closed, RAMP)

    def length(pitch: float) -> float:
        curve, low, high = law(pitch), _end(lower, wire, pitch), _end(upper, wire, pitch)
        return float(curve.integral(total_coils - high.ground_coils) - curve.integral(low.ground_coils)) + wire

    # the length is a straight line over the pitch, whatever the ends
    solid, slope = length(wire), (length(3 * wire) - length(wire)) / (2 * wire)
    if not slope > 1e-9:
        raise InputError(f"the ground turns of both ends leave nothing of {total_coils:g} turns; grind fewer or wind more", "total_coils")
    pitch = wire + (free_length - solid) / slope
    if not pitch > wire * (1 + 1e-9):
        raise InputError(
            f"a free length of {free_length * 1e3:.4g} mm leaves no gap between {total_coils:g} turns of {wire * 1e3:.4g} mm wire, "
            f"which are solid at {solid * 1e3:.4g} mm; lengthen the spring or take out turns", "free_length",
        )  # fmt: skip
    return law(pitch), _end(lower, wire, pitch), _end(upper, wire, pitch)


def _closed_turns(end: EndCoil | EndKind) -> float:
    return 1.0 - RAMP / 2 if is_closed(end) else 0.0


def _end(end: EndCoil | EndKind, wire: float, pitch: float) -> EndCoil:
    """The end coil; ground at its pitch, an open one loses half the wire at its tip over d / (2 p) turns."""
    if isinstance(end, EndCoil):
        return end
    if end not in TEXTBOOK_TURNS:
        raise InputError(f"ends '{end}' are unknown; use {', '.join(TEXTBOOK_TURNS)}", "ends")
    inactive, ground = TEXTBOOK_TURNS[end]
    return EndCoil(end, inactive, 0.5 * wire / pitch if end == "open-ground" else ground)
