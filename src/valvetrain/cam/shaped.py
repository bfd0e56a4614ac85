"""A symmetric event whose flank acceleration is drawn by a few control values, between constant-velocity ramps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.cam.contract import TURN, Array, LiftSpec
from valvetrain.cam.pieces import PeriodicPieces, quintic_pieces, with_base_circle
from valvetrain.cam.ramped import ramp_states
from valvetrain.errors import InputError
from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import Angle, Numbers, PositiveLength, quantity


@dataclass(frozen=True, kw_only=True)
class Shaped:
    """Ramp, event and mirrored return about ``nose`` (angles in cam rad, lifts in m).

    ``flank_shape``: control values of a cubic B-spline, evenly spaced from ``event_start`` to ``nose``, that draw the acceleration
    of the opening flank: first positive ones, then negative ones. Two scales, one for each sign, are found so that the flank takes over
    the velocity of the ramp without acceleration and comes to rest at ``maximum_lift``; only ratios within one sign matter. A
    B-spline turns no more often than its control values, so the acceleration cannot oscillate between them. ``ramp_blend``: share
    of the ramp over which its velocity is built up.
    """

    continuity: ClassVar[int] = 2

    maximum_lift: float
    ramp_lift: float
    ramp_start: float
    event_start: float
    nose: float
    flank_shape: tuple[float, ...]
    ramp_blend: float = 0.3

    def __post_init__(self) -> None:
        if not self.ramp_start < self.event_start < self.nose or self.nose - self.ramp_start > TURN / 2 * (1 + 1e-12):
            raise InputError("ramp_start, event_start and nose must follow each other within half a cam revolution; reorder them")
        if not 0 < self.ramp_lift < self.maximum_lift or not 0 < self.ramp_blend < 1:
            raise InputError("ramp_lift must lie between zero and maximum_lift, and ramp_blend between 0 and 1; correct them")
        shape = np.asarray(self.flank_shape, dtype=float)
        first_falling = int(np.argmax(shape < 0))  # 0 where none is
        if len(shape) < 4 or first_falling < 1 or np.any(shape[first_falling:] > 0) or not np.any(shape[:first_falling] > 0):
            raise InputError("flank_shape needs four values or more, first positive, then negative ones; correct it")
        if not np.all(self._scales > 0):
            raise InputError("this flank_shape cannot reach maximum_lift with rest at the nose; move the change of sign or lower ramp_lift")

    @cached_property
    def _splines(self) -> list[Any]:
        """Lift from the positive and from the negative control values, each with zero lift and velocity at ``event_start``."""
        from scipy.interpolate import BSpline

        controls = np.array([0.0, *self.flank_shape, self.flank_shape[-1]])
        inner = np.linspace(self.event_start, self.nose, len(controls) - 2)
        knots = np.concatenate([np.full(3, inner[0]), inner, np.full(3, inner[-1])])
        return [BSpline(knots, np.where(sign * controls > 0, controls, 0.0), 3).antiderivative(2) for sign in (1, -1)]

    @cached_property
    def _scales(self) -> Array:
        velocity, _ = ramp_states(self.ramp_lift, self.event_start - self.ramp_start, self.ramp_blend)
        ends = np.array([[float(spline(self.nose, nu=order)) for spline in self._splines] for order in (0, 1)])
        rise = self.maximum_lift - self.ramp_lift - velocity * (self.nose - self.event_start)
        solved: Array = np.linalg.solve(ends, [rise, -velocity])
        return solved

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        length = self.event_start - self.ramp_start
        velocity, built = ramp_states(self.ramp_lift, length, self.ramp_blend)
        breaks = np.unique(self._splines[0].t)
        states = np.zeros((len(breaks), 3))
        for scale, spline in zip(self._scales, self._splines, strict=True):
            states += scale * np.stack([spline(breaks), spline(breaks, nu=1), spline(breaks, nu=2)], axis=1)
        states[:, 0] += self.ramp_lift + velocity * (breaks - self.event_start)
        states[:, 1] += velocity
        states[-1, :2] = self.maximum_lift, 0.0
        ramp = [self.ramp_start, self.ramp_start + self.ramp_blend * length]
        breaks = np.concatenate([ramp, breaks])
        states = np.vstack([[0.0, 0.0, 0.0], [built, velocity, 0.0], states])
        mirrored = (states * [1, -1, 1])[-2::-1]
        breaks, states = np.concatenate([breaks, 2 * self.nose - breaks[-2::-1]]), np.vstack([states, mirrored])
        return with_base_circle(breaks, quintic_pieces(breaks, states[:-1], states[1:]), self.continuity)

    @property
    def joints(self) -> tuple[float, ...]:
        return self._pieces.joints

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return self._pieces.lift(cam_angle, derivative)

    def polynomial_pieces(self) -> PeriodicPieces:
        """The exact flat form."""
        return self._pieces


OpenRampBlend = Annotated[float, quantity("ratio", low=0.01, high=0.99)]


class ShapedModel(LiftModel):
    """Ramps and an event, symmetric about the nose, whose flank acceleration a few control values draw."""

    maximum_lift: PositiveLength
    ramp_lift: PositiveLength
    ramp_start: Angle
    event_start: Angle
    nose: Angle
    flank_shape: Numbers
    ramp_blend: OpenRampBlend = Field(default=0.3, description="share of the ramp over which its velocity is built up")

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses events out of order."""
        self.in_order("ramp_start", "event_start", "nose")
        return {name: getattr(self, name) for name in type(self).model_fields if name not in LiftModel.model_fields}


SPEC = LiftSpec(Shaped, ShapedModel)
