"""A main event between constant-velocity ramps: quintic flanks, or pulses of acceleration."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from valvetrain.cam.contract import LiftSpec
from valvetrain.cam.flanks import DEFAULT_SHARE, SHARES, HalfLobe, joined
from valvetrain.cam.pieces import PeriodicPieces, ramp_states, solve
from valvetrain.cam.spline import Stations
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength, problem, quantity

Flank = Literal["quintic", "pulses"]


def ramped(
    *,
    maximum_lift: float,
    ramp_lift: float,
    ramp_start: float,
    event_start: float,
    event_end: float,
    ramp_end: float,
    ramp_blend: float = 0.3,
    nose_acceleration: float | None = None,
    flank: Flank = "quintic",
) -> Stations | PeriodicPieces:
    """Ramp of constant velocity to ``ramp_lift`` (m) at ``event_start``, flanks to the nose
    half-way through the event, and back.

    ``ramp_blend``: share of the ramp over which its velocity is built up. ``nose_acceleration``
    (m/rad2, negative). ``flank``: one ``quintic``, whose largest deceleration is before the nose
    and barely follows ``nose_acceleration`` (None makes the jerk vanish at the nose, for equal
    ramps); or two ``pulses``, whose largest deceleration is that of the nose (None: that of the
    default pulse). Angles in cam rad. Raises :class:`InputError` for events out of order and for a
    nose that pulses cannot have.
    """
    if (
        not ramp_start < event_start < event_end < ramp_end
        or not 0 < ramp_lift < maximum_lift
        or not 0 < ramp_blend <= 1
    ):
        raise InputError(
            "ramp_start, event_start, event_end, ramp_end must rise and ramp_lift be below maximum_lift; correct them"
        )
    if flank == "pulses":
        nose = (event_start + event_end) / 2
        lengths = (event_start - ramp_start, ramp_end - event_end)
        starts = tuple(
            (ramp_states(ramp_lift, length, ramp_blend)[0], length) for length in lengths
        )
        halves = tuple(
            HalfLobe(maximum_lift, (ramp_lift, velocity), nose - event_start, DEFAULT_SHARE)
            for velocity, _ in starts
        )
        slowing = halves[0].sizes[1] if nose_acceleration is None else -nose_acceleration
        flanks = (
            _with_nose(half, slowing).after_ramp(length, ramp_blend)
            for half, (_, length) in zip(halves, starts, strict=True)
        )
        return joined(nose, *flanks)
    half, rise = (event_end - event_start) / 2, maximum_lift - ramp_lift
    opening, opened = ramp_states(ramp_lift, event_start - ramp_start, ramp_blend)
    closing, closed = ramp_states(ramp_lift, ramp_end - event_end, ramp_blend)
    if nose_acceleration is None:
        nose_acceleration = -(60 * rise - 24 * (opening + closing) / 2 * half) / (9 * half**2)
    angles = [
        ramp_start,
        ramp_start + ramp_blend * (event_start - ramp_start),
        event_start,
        event_start + half,
    ]
    angles += [event_end, ramp_end - ramp_blend * (ramp_end - event_end), ramp_end]
    rows = list(
        zip(
            angles,
            (0.0, opened, ramp_lift, maximum_lift, ramp_lift, closed, 0.0),
            (0.0, opening, opening, 0.0, -closing, -closing, 0.0),
            (0.0, 0.0, 0.0, nose_acceleration, 0.0, 0.0, 0.0),
            strict=True,
        )
    )
    if ramp_blend == 1.0:
        rows = [row for index, row in enumerate(rows) if index not in (1, 5)]
    stations, lifts, velocities, accelerations = (
        tuple(map(float, column)) for column in zip(*rows, strict=True)
    )
    return Stations(
        cam_angles=stations, lifts=lifts, velocities=velocities, accelerations=accelerations
    )


def _with_nose(half: HalfLobe, deceleration: float) -> HalfLobe:
    """The flank that comes to rest at the nose with ``deceleration`` (m/rad2): it grows with the
    share of positive acceleration.
    """
    share = solve(lambda value: replace(half, share=value).sizes[1] - deceleration, SHARES)
    if share is None:
        least, most = (replace(half, share=bound).sizes[1] for bound in SHARES)
        raise InputError(
            f"a nose_acceleration of {-deceleration * 1e3:.4g} mm/rad^2 does not go with this lift, ramp and event: pulses reach "
            f"{-least * 1e3:.4g} to {-most * 1e3:.4g} mm/rad^2; change it, or lengthen the event"
        )
    return replace(half, share=share)


RampBlend = Annotated[float, quantity("ratio", low=0.01, high=1.0)]
NegativeAcceleration = Annotated[float, quantity("cam acceleration", high=0.0)]


class RampedModel(LiftModel):
    """Constant-velocity ramps on both sides of a quintic main event."""

    maximum_lift: PositiveLength
    ramp_lift: PositiveLength
    ramp_start: Angle
    event_start: Angle
    event_end: Angle
    ramp_end: Angle
    ramp_blend: RampBlend = Field(
        default=0.3, description="share of the ramp over which its velocity is built up"
    )
    flank: Flank = Field(
        default="quintic",
        description="one quintic, or two pulses whose largest deceleration is at the nose",
    )
    nose_acceleration: NegativeAcceleration | None = Field(
        default=None, description="without it that of no jerk at the nose, or of the default pulse"
    )

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses ramps above the lift and events out of
        order.
        """
        own = super().values(folder)
        if self.ramp_lift >= self.maximum_lift:
            raise problem("ramp_lift is not below maximum_lift; lower it", ("ramp_lift",))
        return own


SPEC = LiftSpec(ramped, RampedModel)
