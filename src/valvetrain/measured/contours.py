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

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.units import parse_quantity

TURN = 2 * np.pi
#: Points to which a contour is filled up, and stations of its lift and curvature.
POINTS, STATIONS = 7200, 720
#: Stations on either side through which the circle of a curvature goes.
SPAN = 6


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
        """The follower that ``flat``, ``roller 10 mm``, ``dome 50 mm``, ``roller 10 mm offset 5 mm`` or, of a finger,
        ``roller 10 mm arm 40 mm pivot 40 mm, 27 mm`` says.
        """
        found = re.fullmatch(
            r"flat|(?:roller|dome)\s+(.+?)(?:\s+offset\s+(.+)|\s+arm\s+(.+)\s+pivot\s+(.+?)\s*,\s*(.+))?",
            text.strip(),
        )
        if found is None:
            raise InputError(
                "a follower is 'flat', 'roller 10 mm' or 'dome 50 mm', with 'offset 5 mm' or 'arm 40 mm pivot 40 mm, 27 mm' behind it, "
                f"not '{text[:40]}'",
                "follower",
            )
        radius, offset, arm, across, along = (
            parse_quantity(part, "length", "follower") if part else 0.0 for part in found.groups()
        )
        if radius < 0 or (found[1] and not radius) or arm < 0:
            raise InputError("the radius of a roller or dome is above zero; correct it", "follower")
        return cls(radius, offset, arm, (across, along))

    def centre(self, base_radius: float, lifts: Array) -> Array:
        """Place of a roller's centre, along the line and across it as a complex number (m), and its first two derivatives.

        ``lifts`` (3, stations) as of :func:`contour_of_lift`; (3, stations) is returned. Raises :class:`InputError` for a
        follower that does not reach the base circle.
        """
        rise, slope, bend = lifts
        reach = base_radius + self.radius
        if not self.arm:
            if abs(self.offset) >= reach:
                raise InputError(
                    "the line of the roller passes beside the base circle; correct follower or base_radius"
                )
            along = np.sqrt(reach**2 - self.offset**2) - 1j * self.offset
            return np.array([along + rise, slope + 0j, bend + 0j])
        if not abs(self.arm - reach) < np.hypot(*self.pivot) < self.arm + reach:
            raise InputError(
                "the roller of the finger does not reach the base circle; correct follower or base_radius"
            )
        whole = Follower(reach, 0.0, self.arm, self.pivot)
        angle = (float(whole.height(np.zeros(1), np.zeros(1))[0]) + rise) / self.arm
        side = -np.sign(self.pivot[0]) or 1.0
        ray = np.sin(angle) + 1j * side * np.cos(angle)
        across = np.cos(angle) - 1j * side * np.sin(angle)
        place = complex(self.pivot[1], self.pivot[0]) + self.arm * ray
        return np.array([place, slope * across, bend * across - slope**2 / self.arm * ray])

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


def _all_round(polar_angles: ArrayLike, radii: ArrayLike, count: int) -> tuple[Array, Array]:
    """``count`` even points (rad, m) of a contour over one turn."""
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
    fine = theta[0] + TURN * np.arange(count) / count
    return fine, spline(fine)


def curvature_of_contour(polar_angles: ArrayLike, radii: ArrayLike) -> tuple[Array, Array]:
    """Radii of curvature (m) of a contour at :data:`STATIONS` even polar angles from its first, and their standard deviations.

    Circles through all points within three degrees (Kasa 1976); negative in a hollow, infinite where noise hides on which
    side the centre is, and NaN throughout a contour too rough for curvature.

    >>> turn = np.linspace(0, 2 * np.pi, 361)[:-1]
    >>> bool(np.allclose(curvature_of_contour(turn, np.full(360, 15e-3))[0], 15e-3))
    True
    """
    fine, polar = _all_round(polar_angles, radii, STATIONS)
    points = polar * np.exp(1j * fine)
    around = np.arange(-SPAN, SPAN + 1)
    near = points[(np.arange(STATIONS)[:, None] + around) % STATIONS]
    outward = np.exp(1j * fine)[:, None]
    local = (near - points[:, None]) / outward
    rows = np.stack([local.real, local.imag, np.ones_like(local.real)], axis=-1)
    circles = np.einsum("ijk,ik->ij", np.linalg.pinv(rows), np.abs(local) ** 2)
    centre = circles[:, 0] / 2 + 0.5j * circles[:, 1]
    radius = np.sqrt(circles[:, 2] + np.abs(centre) ** 2)
    residual = np.abs(local - centre[:, None]) - radius[:, None]
    # variance of a fitted curvature over a length, of as many points as were given (Karimaki 1991)
    given = max(3.0, len(np.atleast_1d(radii)) * len(around) / STATIONS)
    length = np.abs(near[:, -1] - near[:, 0])
    unsure = np.std(residual) * np.sqrt(720 / given) / length**2
    signed = np.where(centre.real < 0, radius, -radius)
    found = np.where((signed < 0) & (4 * radius * unsure > 1), np.inf, signed)
    rough = 8 * np.median(unsure) * polar.min() > 1
    return np.where(rough, np.nan, found), radius**2 * unsure


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
    fine, polar = _all_round(polar_angles, radii, POINTS)
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
    follower : flat, or a roller or dome on a line or on a finger

    Raises
    ------
    InputError : a follower that does not reach the base circle, a base radius that is not positive

    Examples
    --------
    >>> turn = np.linspace(0, 2 * np.pi, 361)
    >>> circle = contour_of_lift(5e-3 * np.array([1 + np.cos(turn), -np.sin(turn), -np.cos(turn)]), turn, 13e-3, Follower())
    >>> bool(np.allclose(circle.curvature_radii, 18e-3))
    True
    """
    theta, (rise, slope, bend) = np.asarray(cam_angles, dtype=float), np.asarray(lifts, dtype=float)
    if base_radius <= 0:
        raise InputError("the radius of a base circle is above zero; correct base_radius")
    if not follower.radius:
        polar, curvature = np.hypot(base_radius + rise, slope), base_radius + rise + bend
        angle = theta + np.arctan2(slope, base_radius + rise)
        return Contour(angle, polar, curvature, np.zeros_like(rise), bool(np.min(curvature) < 0))
    # the roller's centre as the cam sees it, in the frame that turns with the line
    place, moved, bent = np.conj(follower.centre(base_radius, np.array([rise, slope, bend])))
    path, curved = 1j * place + moved, -place + 2j * moved + bent
    speed = np.abs(path)
    path_radius = speed**3 / np.imag(np.conj(path) * curved)
    outward = -1j * path / speed
    points = np.exp(1j * theta) * (place - follower.radius * outward)
    ahead = np.ones(1) if not follower.arm else np.conj(_direction(follower, place))
    return Contour(
        np.unwrap(np.angle(points)),
        np.abs(points),
        path_radius - follower.radius,
        -np.angle(outward * np.conj(ahead)),
        bool(np.any((path_radius > 0) & (path_radius < follower.radius))),
    )


def _direction(follower: Follower, place: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """In which direction, along the line and across it, a finger's roller at ``place`` (conjugate) moves as it lifts."""
    ray = (np.conj(place) - complex(follower.pivot[1], follower.pivot[0])) / follower.arm
    return np.asarray(ray * 1j * (np.sign(follower.pivot[0]) or -1.0))
