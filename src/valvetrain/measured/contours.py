"""From the contour of a cam to the lift of its follower and back, with curvature and pressure angle.

The cam angle is that of the point of the contour which lies under the line of the follower. A contour that is read lifts its
follower to where it first clears every point; a contour that is made is the envelope of the follower in all its places
(Rothbart, Cam Design Handbook 2004, ch. 3). A dome is a roller that does not turn.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.errors import InputError
from valvetrain.units import parse_quantity

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: Points to which a contour is filled up, and stations of its lift.
POINTS, STATIONS = 7200, 720


@dataclass(frozen=True, slots=True)
class Follower:
    """What a cam lifts: a flat face, or a roller or dome of ``radius`` (m).

    ``offset`` (m) of its line from the cam's centre, positive to the side from which the contour comes. ``arm`` (m): length of
    a finger to its roller, whose pivot is ``pivot`` (m): to the side, and along the line, from the cam's centre.

    >>> Follower.of("roller 10 mm").radius
    0.01
    """

    radius: float = 0.0
    offset: float = 0.0
    arm: float = 0.0
    pivot: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, text: str) -> Follower:
        """The follower that ``flat``, ``roller 10 mm``, ``dome 50 mm`` or ``roller 10 mm offset 5 mm`` says."""
        found = re.fullmatch(r"flat|(?:roller|dome)\s+(.+?)(?:\s+offset\s+(.+))?", text.strip())
        if found is None:
            raise InputError(
                f"a follower is 'flat', 'roller 10 mm' or 'dome 50 mm', with 'offset 5 mm' behind it, not '{text[:40]}'",
                "follower",
            )
        radius, offset = (
            parse_quantity(part, "length", "follower") if part else 0.0 for part in found.groups()
        )
        if radius < 0 or (found[1] and not radius):
            raise InputError("the radius of a roller or dome is above zero; correct it", "follower")
        return cls(radius, offset)

    def height(self, x: Array, y: Array) -> Array:
        """Where points at ``x`` to the side and ``y`` along the line hold the follower (m, of a finger rad times its arm);
        minus infinity where they pass it.
        """
        if self.arm:
            across, along = x - self.pivot[0], y - self.pivot[1]
            apart = np.hypot(across, along)
            cosine = (self.arm**2 + apart**2 - self.radius**2) / (2 * self.arm * apart)
            side = -np.sign(self.pivot[0]) or 1.0
            angle = np.arctan2(along, side * across) + np.arccos(np.clip(cosine, -1, 1))
            return np.where(np.abs(cosine) <= 1, self.arm * angle, -np.inf)
        if not self.radius:
            return y
        reach = self.radius**2 - (x + self.offset) ** 2
        return np.where(reach >= 0, y + np.sqrt(np.maximum(reach, 0.0)), -np.inf)


@dataclass(frozen=True, eq=False)
class Contour:
    """A contour: ``polar_angles`` (rad) and ``radii`` (m) at each station of the lift, ``curvature_radii`` (m), negative in a
    hollow, and ``pressure_angles`` (rad), zero under a flat face.

    ``undercut``: the path of a roller bends closer than the roller, or a flat face would need a hollow.

    >>> turn = np.linspace(0, 2 * np.pi, 361)
    >>> lift = 5e-3 * np.array([1 + np.cos(turn), -np.sin(turn), -np.cos(turn)])
    >>> contour_of_lift(lift, turn, 13e-3, Follower()).undercut
    False
    """

    polar_angles: Array
    radii: Array
    curvature_radii: Array
    pressure_angles: Array
    undercut: bool


def lift_of_contour(
    polar_angles: ArrayLike, radii: ArrayLike, follower: Follower
) -> tuple[Array, Array]:
    """Cam angles (rad) over one turn and lifts (m) above the least of them.

    Parameters
    ----------
    polar_angles, radii : (points,) polar angle (rad, rising, within one turn) and radius (m) of the contour, all round
    follower : what the contour lifts

    Raises
    ------
    InputError : a contour that does not go all round

    Examples
    --------
    >>> turn = np.linspace(0, 2 * np.pi, 721)[:-1]
    >>> circle = 5e-3 * np.cos(turn) + np.sqrt(18e-3**2 - (5e-3 * np.sin(turn)) ** 2)
    >>> round(1e3 * float(lift_of_contour(turn, circle, Follower())[1].max()), 6)
    10.0
    """
    from scipy.interpolate import CubicSpline

    theta, radius = np.asarray(polar_angles, dtype=float), np.asarray(radii, dtype=float)
    if theta[-1] - theta[0] > TURN - 1e-9:
        theta, radius = theta[:-1], radius[:-1]
    if len(theta) < 30 or np.max(np.diff(theta, append=theta[0] + TURN)) > np.radians(15):
        raise InputError(
            "a contour goes all round, with a point every 15 degrees at least; add what is missing"
        )
    spline = CubicSpline(
        np.append(theta, theta[0] + TURN), np.append(radius, radius[0]), bc_type="periodic"
    )
    fine = theta[0] + TURN * np.arange(POINTS) / POINTS
    polar = spline(fine)
    cam = TURN * np.arange(STATIONS) / STATIONS
    lifts = np.empty(STATIONS)
    for at, turned in enumerate(cam):
        heights = follower.height(polar * np.sin(turned - fine), polar * np.cos(turned - fine))
        top = int(np.argmax(heights))
        before, high, after = heights[[top - 1, top, (top + 1) % POINTS]]
        bend = before - 2 * high + after
        lifts[at] = (
            high - (after - before) ** 2 / (8 * bend) if np.isfinite(bend) and bend < 0 else high
        )
    return cam, lifts - lifts.min()


def contour_of_lift(
    lifts: ArrayLike, cam_angles: ArrayLike, base_radius: float, follower: Follower
) -> Contour:
    """The contour that gives ``follower`` this lift.

    Parameters
    ----------
    lifts : (3, stations) lift (m), its first and second derivative (m/rad, m/rad2)
    cam_angles : (stations,) rad
    base_radius : of the base circle (m)
    follower : flat, or a roller or dome on a line; no finger

    Raises
    ------
    InputError : a finger, an offset that the base circle does not reach, a base radius that is not positive

    Examples
    --------
    >>> turn = np.linspace(0, 2 * np.pi, 361)
    >>> circle = contour_of_lift(5e-3 * np.array([1 + np.cos(turn), -np.sin(turn), -np.cos(turn)]), turn, 13e-3, Follower())
    >>> bool(np.allclose(circle.curvature_radii, 18e-3))
    True
    """
    rise, slope, bend = np.asarray(lifts, dtype=float)
    theta, reach = np.asarray(cam_angles, dtype=float), base_radius + follower.radius
    if follower.arm or base_radius <= 0 or abs(follower.offset) >= reach:
        raise InputError(
            "a contour is made for a flat face, or a roller or dome whose line passes within its base circle; correct follower or base_radius"
        )
    if not follower.radius:
        polar, curvature = np.hypot(base_radius + rise, slope), base_radius + rise + bend
        angle = theta + np.arctan2(slope, base_radius + rise)
        return Contour(angle, polar, curvature, np.zeros_like(rise), bool(np.min(curvature) < 0))
    # the roller's centre as the cam sees it moves `ahead` along its line and `along` across it, each rad
    along, ahead = np.sqrt(reach**2 - follower.offset**2) + rise, slope - follower.offset
    speed = np.hypot(ahead, along)
    path_radius = speed**3 / (ahead * (ahead + slope) + along * (along - bend))
    share = follower.radius / speed
    upward, aside = along * (1 - share), follower.offset + share * ahead
    undercut = bool(np.any((path_radius > 0) & (path_radius < follower.radius)))
    return Contour(
        theta + np.arctan2(aside, upward),
        np.hypot(upward, aside),
        path_radius - follower.radius,
        np.arctan2(ahead, along),
        undercut,
    )
