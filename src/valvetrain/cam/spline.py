"""A spline through a table of lifts, resting on an exactly zero base circle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array
from valvetrain.cam.pieces import PeriodicPieces, with_base_circle
from valvetrain.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Spline:
    """Spline of ``degree`` 5 or 7 through ``lifts`` (m) at ``cam_angles`` (rad), zero outside them.

    The first (degree - 1) / 2 derivatives vanish at both ends, so the law leaves and meets the base circle with that continuity;
    inside it has degree - 1 continuous derivatives. ``smoothing`` (m): root-mean-square distance from the table that is allowed to
    calm the jerk; 0 interpolates.
    """

    cam_angles: tuple[float, ...]
    lifts: tuple[float, ...]
    degree: int = 5
    smoothing: float = 0.0

    def __post_init__(self) -> None:
        angles = np.asarray(self.cam_angles, dtype=float)
        if self.degree not in (5, 7):
            raise InputError(f"a lift spline has degree 5 or 7, not {self.degree}; choose one of them")
        if len(angles) != len(self.lifts) or len(angles) < 4:
            raise InputError("a lift spline needs four stations or more, each with one lift; complete the table")
        if np.any(np.diff(angles) <= 0) or angles[-1] - angles[0] > TURN * (1 + 1e-12):
            raise InputError("the stations of a lift spline must rise in angle within one cam revolution; sort them")
        if self.lifts[0] != 0 or self.lifts[-1] != 0:
            raise InputError("a lift spline must begin and end on the base circle; add stations of zero lift")

    @property
    def continuity(self) -> int:
        return (self.degree - 1) // 2

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(self.cam_angles)

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        from scipy.interpolate import PPoly, make_interp_spline

        angles, lifts = np.asarray(self.cam_angles, dtype=float), np.asarray(self.lifts, dtype=float)
        if self.smoothing > 0:
            from valvetrain.cam.smoothing import smoothed_spline

            spline = smoothed_spline(angles, lifts, self.degree, self.smoothing)
        else:
            rest = [(order, 0.0) for order in range(1, self.continuity + 1)]
            spline = make_interp_spline(angles, lifts, k=self.degree, bc_type=(rest, rest))
        whole = PPoly.from_spline(spline)
        real = np.diff(whole.x) > 0
        breaks = np.append(whole.x[:-1][real], whole.x[-1])
        return with_base_circle(breaks, whole.c[::-1, real].T.copy(), self.continuity)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return self._pieces.lift(cam_angle, derivative)

    def polynomial_pieces(self) -> PeriodicPieces:
        """The exact flat form."""
        return self._pieces
