"""Polydyne: a nose-centred polynomial valve motion, and the cam that makes it at the design speed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.cam.contract import HIGHEST_DERIVATIVE, TURN, LiftSpec, after, check_derivative
from valvetrain.cam.flanks import polynomial_value, rise_factors
from valvetrain.cam.pieces import PeriodicPieces, quintic_pieces, ramp_states, with_base_circle
from valvetrain.cam.ramped import RampBlend
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import Exponents, LiftModel
from valvetrain.parameters.schema_types import (
    Angle,
    Mass,
    PositiveLength,
    Stiffness,
    problem,
    quantity,
)


@dataclass(frozen=True, kw_only=True)
class Polydyne:
    """Valve motion ``y = maximum_lift (1 - sum of C_p x**p)``, x = 0 at the nose and 1 at either
    end; the law is ``y + dynamic_deflection * y''`` (rad^2: effective mass / stiffness *
    cam_speed^2), what the cam must do for an elastic train.

    After Thoren, Engemann and Stoddart, "Cam design as related to valve train dynamics" (1952).
    Events in cam rad. With a ``ramp_lift`` (m) the motion begins and ends at that lift with the
    velocity of ramps of ``ramp_length`` (cam rad) before and after it, whose velocity is built up
    over the share ``ramp_blend`` of their length.
    """

    maximum_lift: float
    opening_start: float
    closing_end: float
    exponents: tuple[int, ...] = (2, 10, 18, 26, 34)
    dynamic_deflection: float = 0.0
    ramp_lift: float = 0.0
    ramp_length: float = 0.0
    ramp_blend: float = 0.3

    def __post_init__(self) -> None:
        if (
            not 0
            < self.closing_end - self.opening_start
            <= (TURN - 2 * self.ramp_length) * (1 + 1e-12)
        ):
            raise InputError(
                "closing_end must follow opening_start within one cam revolution, ramps included; correct them"
            )
        if (
            not 0 <= self.ramp_lift < self.maximum_lift
            or not 0 < self.ramp_blend <= 1
            or (self.ramp_lift > 0) != (self.ramp_length > 0)
        ):
            raise InputError(
                "a ramp needs a ramp_length and a ramp_lift below maximum_lift; correct them or leave both out"
            )
        if any(power % 2 for power in self.exponents):
            raise InputError(
                "the exponents of a polydyne law must be even, so that both flanks meet smoothly at the nose; change them"
            )
        if self.continuity < 1:
            raise InputError(
                "a polydyne law needs at least two exponents, four with a dynamic deflection; add some"
            )

    @property
    def continuity(self) -> int:
        whole = len(self.exponents) - 1 - (2 if self.dynamic_deflection else 0)
        return min(whole, 2) if self.ramp_lift else whole

    @property
    def joints(self) -> tuple[float, ...]:
        return (self.opening_start, self.closing_end) if self._ramps is None else self._ramps.joints

    @cached_property
    def _ramps(self) -> PeriodicPieces | None:
        """Both ramps with the base circle; the piece between them is never read."""
        if not self.ramp_lift:
            return None
        velocity, built = ramp_states(self.ramp_lift, self.ramp_length, self.ramp_blend)
        before = [
            (self.ramp_length, 0.0, 0.0),
            (self.ramp_length * (1 - self.ramp_blend), built, velocity),
            (0.0, self.ramp_lift, velocity),
        ]
        if self.ramp_blend == 1:
            del before[1]
        opening = [(self.opening_start - away, height, rate, 0.0) for away, height, rate in before]
        closing = [
            (self.closing_end + away, height, -rate, 0.0) for away, height, rate in before[::-1]
        ]
        rows = np.array(opening + closing)
        return with_base_circle(
            rows[:, 0], quintic_pieces(rows[:, 0], rows[:-1, 1:], rows[1:, 1:]), self.continuity
        )

    @cached_property
    def _factors(self) -> tuple[float, ...]:
        """Factors of the powers: at x = 1 the lift has fallen to the ramp's with the ramp's slope,
        all higher derivatives vanish.

        That requires sum(p^k c_p) to be the fall for k = 0 and the slope for every other k, which
        Lagrange's polynomials at 0 and 1 solve.
        """
        half = (self.closing_end - self.opening_start) / 2
        slope = (
            half * ramp_states(self.ramp_lift, self.ramp_length, self.ramp_blend)[0]
            if self.ramp_lift
            else 0.0
        )
        at_one = (
            float(np.prod([(q - 1) / (q - p) for q in self.exponents if q != p]))
            for p in self.exponents
        )
        fall = self.maximum_lift - self.ramp_lift - slope
        return tuple(
            fall * rise + slope * one
            for rise, one in zip(rise_factors(self.exponents), at_one, strict=True)
        )

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        value = self._valve(cam_angle, derivative)
        if not self.dynamic_deflection:
            return value
        inside = after(self.opening_start, cam_angle) < self.closing_end - self.opening_start
        return value + np.where(
            inside, self.dynamic_deflection * self._valve(cam_angle, derivative + 2), 0.0
        )

    def _valve(self, cam_angle: ArrayLike, derivative: int) -> Array:
        half = (self.closing_end - self.opening_start) / 2
        since = after(self.opening_start, cam_angle)
        x = np.clip(since / half - 1, -1.0, 1.0)
        polynomial = (
            -polynomial_value(self.exponents, self._factors, x, derivative) / half**derivative
        )
        if derivative == 0:
            polynomial = self.maximum_lift + polynomial
        # ramps are straight or short and soft: what the train deflects there is left out
        outside = (
            0.0
            if self._ramps is None or derivative > HIGHEST_DERIVATIVE
            else self._ramps.lift(cam_angle, derivative)
        )
        return np.where(since < 2 * half, polynomial, outside)


DesignSpeed = Annotated[float, quantity("angular speed", low=0.0)]


class PolydyneModel(LiftModel):
    """Polydyne: the valve follows a nose-centred polynomial at the design speed, the cam adds the
    deflection of the train.
    """

    maximum_lift: PositiveLength
    opening_start: Angle
    closing_end: Angle
    exponents: Exponents = Field(default=(2, 10, 18, 26, 34), description="powers about the nose")
    effective_mass: Mass | None = Field(
        default=None, description="of the train; without it no dynamic deflection"
    )
    effective_stiffness: Stiffness | None = Field(
        default=None, description="of the train; without it no dynamic deflection"
    )
    design_engine_speed: DesignSpeed | None = Field(
        default=None, description="without it no dynamic deflection"
    )
    ramp_lift: PositiveLength | None = Field(
        default=None, description="at which ramps end and the event begins; without it no ramps"
    )
    ramp_length: Angle | None = Field(default=None, description="of each ramp; without it no ramps")
    ramp_blend: RampBlend = Field(
        default=0.3, description="share of the ramp over which its velocity is built up"
    )

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses a deflection given in part."""
        own = super().values(folder)
        if (self.ramp_lift is None) != (self.ramp_length is None):
            raise problem("ramps need ramp_lift and ramp_length together, or none of them")
        if self.ramp_lift is None:
            for name in ("ramp_lift", "ramp_length", "ramp_blend"):
                own.pop(name)
        elif self.ramp_lift >= self.maximum_lift:
            raise problem("ramp_lift is not below maximum_lift; lower it", ("ramp_lift",))
        parts = (
            own.pop("effective_mass"),
            own.pop("effective_stiffness"),
            own.pop("design_engine_speed"),
        )
        if any(part is None for part in parts):
            if any(part is not None for part in parts):
                raise problem(
                    "a polydyne law needs effective_mass, effective_stiffness and design_engine_speed together, or none of them"
                )
            return own | {"dynamic_deflection": 0.0}
        mass, stiffness, engine_speed = parts
        return own | {"dynamic_deflection": mass / stiffness * (engine_speed / 2) ** 2}


SPEC = LiftSpec(Polydyne, PolydyneModel)
