"""An event whose flank acceleration is drawn by a few control values, between constant-velocity
ramps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.cam.contract import TURN, LiftSpec
from valvetrain.cam.pieces import (
    OfPieces,
    PeriodicPieces,
    quintic_pieces,
    ramp_states,
    with_base_circle,
)
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.schema_types import Angle, Numbers, PositiveLength, quantity


@dataclass(frozen=True, kw_only=True)
class Shaped(OfPieces):
    """Ramp, event and return about ``nose`` (angles in cam rad, lifts in m), mirrored unless a
    closing flank is specified.

    ``flank_shape``: control values of a cubic B-spline, evenly spaced from ``event_start`` to
    ``nose``, that draw the acceleration of the opening flank: first positive ones, then negative
    ones. Two scales, one for each sign, are found so that the flank takes over the velocity of the
    ramp without acceleration and comes to rest at ``maximum_lift``; only ratios within one sign
    matter. A B-spline turns no more often than its control values, so the acceleration cannot
    oscillate between them. ``ramp_blend``: share of the ramp over which its velocity is built up.
    ``event_end``: end of the closing flank, which the same control values draw over its own length:
    it keeps the acceleration at the nose, and two scales are found for the others; its ramp is as
    long as the opening one. ``closing_flank_shape``: control values of the closing flank, from
    ``event_end`` back to ``nose``, where they are others. The last lends only its place, since the
    nose has one acceleration.
    """

    continuity: ClassVar[int] = 2

    maximum_lift: float
    ramp_lift: float
    ramp_start: float
    event_start: float
    nose: float
    flank_shape: tuple[float, ...]
    ramp_blend: float = 0.3
    event_end: float | None = None
    closing_flank_shape: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if (
            not self.ramp_start < self.event_start < self.nose
            or self.nose - self.ramp_start > TURN / 2 * (1 + 1e-12)
        ):
            raise InputError(
                "ramp_start, event_start and nose must follow each other within half a cam revolution; reorder them"
            )
        last = self.closing_end + self.event_start - self.ramp_start
        if not self.nose < self.closing_end or last - self.nose > TURN / 2 * (1 + 1e-12):
            raise InputError(
                "event_end and the ramp after it must follow the nose within half a cam revolution; move event_end"
            )
        if not 0 < self.ramp_lift < self.maximum_lift or not 0 < self.ramp_blend < 1:
            raise InputError(
                "ramp_lift must be between zero and maximum_lift, and ramp_blend between 0 and 1; correct them"
            )
        for name in ("flank_shape", "closing_flank_shape"):
            if getattr(self, name) is not None and not _rises_then_falls(getattr(self, name)):
                raise InputError(
                    f"{name} needs four values or more, first positive, then negative ones; correct it"
                )
        if not np.all(self._opening[2] > 0):
            raise InputError(
                "this flank_shape cannot reach maximum_lift with rest at the nose; move the change of sign or lower ramp_lift"
            )
        if self._mirrored:
            return
        name = "flank_shape" if self.closing_flank_shape is None else "closing_flank_shape"
        if not min(getattr(self, name)[:-1]) < 0:
            raise InputError(
                f"{name} needs a negative value before its last, which a closing flank leaves to the nose; add one"
            )
        if not np.all(self._closing[2] > 0):
            raise InputError(
                f"this {name} cannot close by event_end with the acceleration of the nose; move event_end towards the "
                "mirror of event_start, or its change of sign"
            )

    @property
    def closing_end(self) -> float:
        """End of the event (rad)."""
        return 2 * self.nose - self.event_start if self.event_end is None else self.event_end

    @property
    def _mirrored(self) -> bool:
        return self.event_end is None and self.closing_flank_shape is None

    @cached_property
    def _opening(self) -> tuple[Array, Array, Array]:
        return self._flank(self.event_start, self.nose, self.flank_shape)

    @cached_property
    def _closing(self) -> tuple[Array, Array, Array]:
        """As :attr:`_opening`, run backwards in negative cam angles."""
        shape = self.closing_flank_shape or self.flank_shape
        return self._flank(-self.closing_end, -self.nose, shape, float(self._opening[1][-1, 2]))

    def _flank(
        self,
        start: float,
        nose: float,
        shape: tuple[float, ...],
        nose_acceleration: float | None = None,
    ) -> tuple[Array, Array, Array]:
        """Breaks (rad) from ``start`` to ``nose``, states (n, 3) there, and the scales of both
        signs of the control values.

        ``nose_acceleration`` (m/rad2) is that of the last control values; None leaves it to the
        scale of the negative ones.
        """
        from scipy.interpolate import BSpline

        controls = np.array([0.0, *shape, shape[-1]])
        inner = np.linspace(start, nose, len(controls) - 2)
        knots = np.concatenate([np.full(3, inner[0]), inner, np.full(3, inner[-1])])
        given = np.zeros_like(controls)
        if nose_acceleration is not None:
            given[-2:], controls[-2:] = nose_acceleration, 0.0
        # lifts from control values of one kind, each with zero lift and velocity at the end of the
        # ramp
        parts = (np.maximum(controls, 0.0), np.minimum(controls, 0.0), given)
        splines = [BSpline(knots, part, 3).antiderivative(2) for part in parts]
        velocity, _ = ramp_states(
            self.ramp_lift, self.event_start - self.ramp_start, self.ramp_blend
        )
        ends = np.array([[float(spline(nose, nu=order)) for spline in splines] for order in (0, 1)])
        rise = self.maximum_lift - self.ramp_lift - velocity * (nose - start)
        try:
            scales: Array = np.linalg.solve(ends[:, :2], np.array([rise, -velocity]) - ends[:, 2])
        except np.linalg.LinAlgError:  # no length is left between start and nose
            scales = np.zeros(2)
        breaks = np.unique(splines[0].t)
        states = np.zeros((len(breaks), 3))
        for scale, spline in zip((*scales, 1.0), splines, strict=True):
            states += scale * np.stack(
                [spline(breaks), spline(breaks, nu=1), spline(breaks, nu=2)], axis=1
            )
        states[:, 0] += self.ramp_lift + velocity * (breaks - start)
        states[:, 1] += velocity
        states[-1, :2] = self.maximum_lift, 0.0
        return breaks, states, scales

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        breaks, states = self._with_ramp(self.ramp_start, self._opening)
        if self._mirrored:
            back, mirrored = 2 * self.nose - breaks[-2::-1], states[-2::-1]
        else:
            back, mirrored = self._with_ramp(
                self.ramp_start - self.event_start - self.closing_end, self._closing
            )
            back, mirrored = -back[-2::-1], mirrored[-2::-1]
        breaks, states = np.concatenate([breaks, back]), np.vstack([states, mirrored * [1, -1, 1]])
        return with_base_circle(
            breaks, quintic_pieces(breaks, states[:-1], states[1:]), self.continuity
        )

    def _with_ramp(self, first: float, flank: tuple[Array, Array, Array]) -> tuple[Array, Array]:
        """Breaks and states of a flank, those of the ramp from ``first`` (rad) before them."""
        length = self.event_start - self.ramp_start
        velocity, built = ramp_states(self.ramp_lift, length, self.ramp_blend)
        return np.concatenate([[first, first + self.ramp_blend * length], flank[0]]), np.vstack(
            [[0.0, 0.0, 0.0], [built, velocity, 0.0], flank[1]]
        )


def _rises_then_falls(shape: tuple[float, ...]) -> bool:
    """Whether there are four control values or more, first none below zero, then none above, and
    some of either sign.
    """
    values = np.asarray(shape, dtype=float)
    if len(values) < 4 or not np.all(np.isfinite(values)):
        return False
    falling = int(np.argmax(values < 0))  # 0 where none is
    return falling > 0 and not np.any(values[falling:] > 0) and bool(np.any(values[:falling] > 0))


OpenRampBlend = Annotated[float, quantity("ratio", low=0.01, high=0.99)]


class ShapedModel(LiftModel):
    """Ramps and an event whose flank acceleration a few control values draw, symmetric about the
    nose unless a closing flank is given.
    """

    maximum_lift: PositiveLength
    ramp_lift: PositiveLength
    ramp_start: Angle
    event_start: Angle
    nose: Angle
    flank_shape: Numbers
    ramp_blend: OpenRampBlend = Field(
        default=0.3, description="share of the ramp over which its velocity is built up"
    )
    event_end: Angle | None = Field(
        default=None, description="without it the closing flank is as long as the opening one"
    )
    closing_flank_shape: Numbers | None = Field(
        default=None, description="without it that of the opening flank"
    )

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses events out of order."""
        end = () if self.event_end is None else ("event_end",)
        self.in_order("ramp_start", "event_start", "nose", *end)
        common = LiftModel.model_fields
        return {name: one for name, one in self if name not in common and one is not None}


SPEC = LiftSpec(Shaped, ShapedModel)
