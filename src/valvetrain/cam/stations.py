"""Quintic pieces between stations that give lift, velocity and acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array, LiftSpec
from valvetrain.cam.pieces import PeriodicPieces, quintic_pieces, with_base_circle
from valvetrain.errors import InputError
from valvetrain.parameters.schema_lift import LiftModel, check_angles
from valvetrain.parameters.schema_types import Angles, Lengths, problem, quantities


@dataclass(frozen=True, kw_only=True)
class Stations:
    """Piecewise quintic through stations (cam rad): lifts (m), velocities (m/rad) and accelerations (m/rad2), all zero at both ends."""

    continuity: ClassVar[int] = 2

    cam_angles: tuple[float, ...]
    lifts: tuple[float, ...]
    velocities: tuple[float, ...]
    accelerations: tuple[float, ...]

    def __post_init__(self) -> None:
        states = np.array([self.lifts, self.velocities, self.accelerations])
        if np.any(states[:, [0, -1]] != 0):
            raise InputError("the first and last station must rest on the base circle (lift, velocity, acceleration zero); add them")
        angles = np.asarray(self.cam_angles)
        if np.any(np.diff(angles) <= 0) or angles[-1] - angles[0] > TURN * (1 + 1e-12):
            raise InputError("the stations must rise in angle within one cam revolution; sort them")

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        angles = np.asarray(self.cam_angles)
        states = np.stack([self.lifts, self.velocities, self.accelerations], axis=1)
        return with_base_circle(angles, quintic_pieces(angles, states[:-1], states[1:]), self.continuity)

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(self.cam_angles)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return self._pieces.lift(cam_angle, derivative)

    def polynomial_pieces(self) -> PeriodicPieces:
        """The exact flat form."""
        return self._pieces


CamVelocities = Annotated[tuple[float, ...], quantities("cam velocity")]
CamAccelerations = Annotated[tuple[float, ...], quantities("cam acceleration")]


class StationsModel(LiftModel):
    """Quintic pieces between stations at which lift, velocity and acceleration (per cam angle) are all given."""

    cam_angles: Angles
    lifts: Lengths
    velocities: CamVelocities
    accelerations: CamAccelerations

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses stations of unequal number or out of order."""
        own = super().values(folder)
        for name in ("lifts", "velocities", "accelerations"):
            if len(own[name]) != len(self.cam_angles):
                raise problem(f"{name} has {len(own[name])} entries but cam_angles {len(self.cam_angles)}; give one each", (name,))
        check_angles(self.cam_angles, ("cam_angles",))
        return own


SPEC = LiftSpec(Stations, StationsModel)
