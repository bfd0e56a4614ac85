"""Quintic pieces between stations that give lift, velocity and acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array
from valvetrain.cam.pieces import PeriodicPieces, quintic_pieces, with_base_circle
from valvetrain.errors import InputError


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
