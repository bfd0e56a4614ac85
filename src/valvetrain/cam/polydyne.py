"""Polydyne: a nose-centred polynomial valve motion, and the cam that makes it at the design speed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.cam.contract import TURN, Array, LiftSpec, after, check_derivative
from valvetrain.cam.flanks import polynomial_value, rise_factors
from valvetrain.errors import InputError
from valvetrain.parameters.schema_lift import Exponents, LiftModel
from valvetrain.parameters.schema_types import Angle, Mass, PositiveLength, Stiffness, problem, quantity


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


DesignSpeed = Annotated[float, quantity("angular speed", low=0.0)]


class PolydyneModel(LiftModel):
    """Polydyne: the valve follows a nose-centred polynomial at the design speed, the cam adds the deflection of the train."""

    maximum_lift: PositiveLength
    opening_start: Angle
    closing_end: Angle
    exponents: Exponents = Field(default=(2, 10, 18, 26, 34), description="powers about the nose")
    effective_mass: Mass | None = Field(default=None, description="of the train; without it no dynamic deflection")
    effective_stiffness: Stiffness | None = Field(default=None, description="of the train; without it no dynamic deflection")
    design_engine_speed: DesignSpeed | None = Field(default=None, description="without it no dynamic deflection")

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses a deflection given in part."""
        own = super().values(folder)
        parts = (own.pop("effective_mass"), own.pop("effective_stiffness"), own.pop("design_engine_speed"))
        if any(part is None for part in parts):
            if any(part is not None for part in parts):
                raise problem("a polydyne law needs effective_mass, effective_stiffness and design_engine_speed together, or none of them")
            return own | {"dynamic_deflection": 0.0}
        mass, stiffness, engine_speed = parts
        return own | {"dynamic_deflection": mass / stiffness * (engine_speed / 2) ** 2}


SPEC = LiftSpec(Polydyne, PolydyneModel)
