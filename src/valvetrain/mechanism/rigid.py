"""Rigid kinematics of a train: valve lift over cam angle with derivatives up to jerk, motion ratio,
zero elasticity.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

#: Share of the largest rigid lift above which the valve counts as open.
OPEN_SHARE = 0.1


@dataclass(frozen=True)
class RatioCurve:
    """Valve lift (m, without lash) as a function of the drive coordinate ``s`` (m or rad): an exact
    quintic spline through the geometry.
    """

    drive: Array
    valve_lift: Array

    @cached_property
    def splines(self) -> tuple[BSpline, ...]:
        """The interpolating spline lift(s) and its first three derivatives."""
        from scipy.interpolate import make_interp_spline

        spline = make_interp_spline(self.drive, self.valve_lift, k=5)
        return spline, *(spline.derivative(order) for order in (1, 2, 3))

    def inverse(self, valve_lift: ArrayLike) -> Array:
        """Drive coordinate of a valve lift (m), by Newton on the spline."""
        spline, slope, *_ = self.splines
        target_lift = np.asarray(valve_lift, dtype=float)
        drive: Array = np.interp(target_lift, self.valve_lift, self.drive)
        for _ in range(20):
            change = (spline(drive) - target_lift) / slope(drive)
            drive = drive - change
            if np.max(np.abs(change), initial=0.0) < 1e-14:
                break
        return drive


@dataclass(frozen=True)
class RigidKinematics:
    """Chain of lift law -> drive coordinate -> valve, every part rigid and every contact closed but
    the ``lash`` (m, at the valve).

    ``law``: lift law. ``law_of``: ``drive`` when the law prescribes the drive coordinate times
    ``drive_scale`` (m per unit), ``valve`` when it prescribes the valve lift at zero lash.
    ``ratio``: geometry of the chain.
    """

    law: LiftLaw
    law_of: str
    ratio: RatioCurve
    drive_scale: float = 1.0
    lash: float = 0.0

    def drive(self, cam_angle: ArrayLike) -> Array:
        """Drive coordinate (tappet lift in m, or lever angle in rad) over the cam angle."""
        lift = np.asarray(self.law.lift(cam_angle, 0), dtype=float)
        return lift / self.drive_scale if self.law_of == "drive" else self.ratio.inverse(lift)

    def _tight(self, cam_angle: ArrayLike, derivative: int) -> Array:
        """Derivative (m/rad**n) of the valve lift without lash: the law itself, or Faà di Bruno
        through the ratio curve.
        """
        law = [np.asarray(self.law.lift(cam_angle, n), dtype=float) for n in range(derivative + 1)]
        if self.law_of == "valve":
            return law[derivative]
        s = [value / self.drive_scale for value in law]
        f = [spline(s[0]) for spline in self.ratio.splines[: derivative + 1]]
        if derivative == 0:
            return np.asarray(f[0])
        if derivative == 1:
            return np.asarray(f[1] * s[1])
        if derivative == 2:
            return np.asarray(f[2] * s[1] ** 2 + f[1] * s[2])
        return np.asarray(f[3] * s[1] ** 3 + 3 * f[2] * s[1] * s[2] + f[1] * s[3])

    def valve_lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Rigid valve lift (m) or its derivative (m/rad**n, n up to 3); zero while the lash is
        open.
        """
        if derivative not in (0, 1, 2, 3):
            raise InputError(f"rigid kinematics give derivatives 0 to 3, not {derivative}")
        tight = self._tight(cam_angle, 0)
        value = tight - self.lash if derivative == 0 else self._tight(cam_angle, derivative)
        return np.where(tight > self.lash, value, 0.0)

    def law_lift(self, valve_lift: ArrayLike) -> Array:
        """What the law lifts (m) when the rigid valve is at ``valve_lift`` (m), the lash taken
        up; in the same shape.
        """
        tight = np.asarray(valve_lift, dtype=float) + self.lash
        return tight if self.law_of == "valve" else self.ratio.inverse(tight) * self.drive_scale

    def motion_ratio(self, cam_angle: ArrayLike) -> Array:
        """Valve travel per drive travel d(valve)/d(drive length) (1), from geometry."""
        return np.asarray(self.ratio.splines[1](self.drive(cam_angle)) / self.drive_scale)

    @cached_property
    def maximum_lift(self) -> float:
        """Largest rigid valve lift (m)."""
        return float(np.max(self.valve_lift(np.linspace(0, 2 * np.pi, 1441))))

    @cached_property
    def turn(self) -> Array:
        """Rigid valve lift (m) and its derivative (m/rad) at 720 even cam angles of a turn, (2, 720)."""
        angle = np.arange(720) * np.pi / 360
        return np.array([self.valve_lift(angle, derivative) for derivative in (0, 1)])


def check_lash(kinematics: RigidKinematics) -> None:
    """Raise :class:`InputError` when the lash swallows the whole lift."""
    tight = float(np.max(kinematics._tight(np.linspace(0, 2 * np.pi, 1441), 0)))
    if kinematics.lash >= tight:
        raise InputError(
            f"the lash ({kinematics.lash * 1e3:.3f} mm) is not smaller than the valve lift ({tight * 1e3:.3f} mm), so the valve never "
            f"opens; "
            "reduce the lash or check its unit"
        )
