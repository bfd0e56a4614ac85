"""How the ends of a spring meet their seats, and the pitch that closed ends and a free length make."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, ValidatorFunctionWrapHandler, WrapValidator

from valvetrain.errors import InputError
from valvetrain.parameters.curves import RAMP, Constant, Curve, pitch_with_closed_turns
from valvetrain.parameters.schema_types import FOLLOWS, Table, quantity, table

EndKind = Literal["closed-ground", "closed", "open", "open-ground"]
#: Kind -> inactive and ground turns where none are given.
_TYPICAL_TURNS: dict[str, tuple[float, float]] = {
    "closed-ground": (0.75, 0.75), "closed": (0.75, 0.0), "open": (0.0, 0.0), "open-ground": (0.5, 0.25),
}  # fmt: skip
EndTurns = Annotated[float, quantity("ratio", low=0.0, high=3.0)]


@table("the end")
class EndCoil(Table):
    """How one end of the spring meets its seat.

    ``inactive_coils``: turns of wire bonded to the seat (they move with it; the rod starts where
    they end). ``ground_coils``: turns over which the wire is ground flat; the seat plane touches
    the full wire there. Left out, both follow from the kind, as in a case file: 0.75 and 0.75
    closed and ground, 0.75 and 0 closed, none open, 0.5 and 0.25 open and ground. Raises
    :class:`InputError` for an unknown kind and turns outside 0 to 3.

    >>> EndCoil("open").inactive_coils
    0.0
    """

    kind: EndKind = "closed-ground"
    inactive_coils: EndTurns = Field(default=FOLLOWS)
    ground_coils: EndTurns = Field(default=FOLLOWS)

    def __post_init__(self) -> None:
        for name, turns in zip(
            ("inactive_coils", "ground_coils"), _TYPICAL_TURNS[self.kind], strict=True
        ):
            if getattr(self, name) is None:
                object.__setattr__(self, name, turns)


OPEN_END = EndCoil("open")


def is_closed(end: EndCoil | EndKind) -> bool:
    """Whether the last turn touches its neighbour."""
    return (end.kind if isinstance(end, EndCoil) else end).startswith("closed")


def _read_end(raw: Any, read: ValidatorFunctionWrapHandler) -> Any:
    """An end with its turns; its kind alone where no turns are given, since those of a spring given by its
    free length are the textbook's.
    """
    given = {"kind": raw} if isinstance(raw, str) else raw
    end: EndCoil = read(given)
    return end if isinstance(raw, EndCoil) or given.keys() - {"kind"} else end.kind


EndField = Annotated[EndCoil, WrapValidator(_read_end)]


#: Kind -> inactive and ground turns of the table: half a ground turn of closed wire brings the seat
#: onto the axis of the tip.
TEXTBOOK_TURNS: dict[str, tuple[float, float]] = {
    "closed-ground": (1.0, 0.5), "closed": (1.0, 0.0), "open": (0.0, 0.0), "open-ground": (0.5, float("nan")),
}  # fmt: skip


def refuse_lost_tip(name: str, end: EndCoil, pitch: float, wire: float) -> None:
    """Raise :class:`InputError` where grinding at a constant ``pitch`` (m) takes all of the tip's ``wire`` (m)."""
    if end.ground_coils * pitch > wire * (1 + 1e-9):
        raise InputError(
            f"spring '{name}' has a constant pitch of {pitch * 1e3:.4g} mm, so grinding {end.ground_coils:g} turns of its {end.kind} end takes the "
            f"whole tip of the {wire * 1e3:.4g} mm wire; wind the end closed (a length as pitch, or a free length), or grind less"
        )


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
            "a free length makes the pitch of a wire of constant diameter; give the pitch over the coils instead"
        )
    wire = wire_diameter.level
    if not wire > 0:
        raise InputError("a free length makes a pitch for a positive wire_diameter; check it")
    closed = (_closed_turns(lower), _closed_turns(upper))

    def law(pitch: float) -> Curve:
        return (
            Constant(pitch)
            if not any(closed)
            else pitch_with_closed_turns(total_coils, wire, pitch, *closed)
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
            f"the ground turns of both ends use up all of {total_coils:g} turns; grind fewer or wind more"
        )
    pitch = wire + (free_length - solid) / slope
    if not pitch > wire * (1 + 1e-9):
        raise InputError(
            f"a free length of {free_length * 1e3:.4g} mm leaves no gap between {total_coils:g} turns of {wire * 1e3:.4g} mm wire, "
            f"which are solid at {solid * 1e3:.4g} mm; lengthen the spring or take out turns"
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
    inactive, ground = TEXTBOOK_TURNS[end]
    return EndCoil(end, inactive, 0.5 * wire / pitch if end == "open-ground" else ground)
