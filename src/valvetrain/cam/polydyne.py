"""Polydyne: a nose-centred polynomial valve motion, and the cam that makes it at the design speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array, after, check_derivative
from valvetrain.cam.flanks import polynomial_value, rise_factors
from valvetrain.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Polydyne:
    """Valve motion ``y = maximum_lift (1 - sum of C_p x**p)``, x = 0 at the nose and 1 at either end; the law is
    ``y + dynamic_deflection * y''`` (rad^2: effective mass / stiffness * cam_speed^2), what the cam must do for an elastic train.

    After Thoren, Engemann and Stoddart, "Cam design as related to valve train dynamics" (1952). Events in cam rad.
    """

    maximum_lift: float
    opening_start: float
    closing_end: float
    exponents: tuple[int, ...] = (2, 10, 18, 26, 34)
    dynamic_deflection: float = 0.0

    def __post_init__(self) -> None:
        if not 0 < self.closing_end - self.opening_start <= TURN * (1 + 1e-12):
            raise InputError("closing_end must follow opening_start within one cam revolution; correct them")
        if any(power % 2 for power in self.exponents):
            raise InputError("the exponents of a polydyne law must be even, so that both flanks meet smoothly at the nose; change them")
        if self.continuity < 1:
            raise InputError("a polydyne law needs at least two exponents, four with a dynamic deflection; add some")

    @property
    def continuity(self) -> int:
        return len(self.exponents) - 1 - (2 if self.dynamic_deflection else 0)

    @property
    def joints(self) -> tuple[float, ...]:
        return (self.opening_start, self.closing_end)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        value = self._valve(cam_angle, derivative)
        return value + self.dynamic_deflection * self._valve(cam_angle, derivative + 2) if self.dynamic_deflection else value

    def _valve(self, cam_angle: ArrayLike, derivative: int) -> Array:
        half = (self.closing_end - self.opening_start) / 2
        since = after(self.opening_start, cam_angle)
        x = np.clip(since / half - 1, -1.0, 1.0)
        polynomial = -polynomial_value(self.exponents, rise_factors(self.exponents), x, derivative) / half**derivative
        if derivative == 0:
            polynomial = 1 + polynomial
        return np.where(since < 2 * half, self.maximum_lift * polynomial, 0.0)
