"""Masses that a moving surface strikes once a turn, and their orbits in closed form: a published cam with its follower, the
impact oscillator, and two masses in line. It knows nothing of the package.

An orbit is a free flight of one turn that begins and ends on the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

Array = NDArray[np.float64]
TURN = 2 * math.pi


class Surface(Protocol):
    """Height (m) of a surface over an angle, or a derivative by it."""

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array: ...


@dataclass(frozen=True, slots=True)
class ArcCam:
    """The published cam: a base circle, flanks and nose of circular arcs, and a top dwell; a point follower feels its
    radius. Angle zero is where the rise begins; lengths in m.
    """

    base: float = 0.40
    #: Radius and distance of the centre from the axis, of the flank and of the nose.
    flank: tuple[float, float] = (0.85, 0.45)
    nose: tuple[float, float] = (0.15, 0.40393320723821)
    corner: float = 1.050328174371336
    top: float = math.radians(70)
    continuity: int = 1

    @property
    def joints(self) -> Array:
        """Angles at which the acceleration jumps."""
        rise = np.array([0.0, self.corner, self.top])
        return np.concatenate((rise, math.pi - rise[::-1]))

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Lift (m) or a derivative by the cam angle."""
        angle = np.mod(np.asarray(cam_angle, dtype=float), TURN)
        falls = angle > math.pi / 2
        rise = np.where(falls, math.pi - angle, angle)
        level = sum(self.nose) - self.base if derivative == 0 else 0.0
        side = np.select(
            [rise < 0, rise <= self.corner, rise <= self.top],
            [0.0, self._arc(rise + math.pi, self.flank, derivative), self._arc(rise - self.top, self.nose, derivative)],
            level,
        )  # fmt: skip
        return np.asarray(np.where(falls, (-1.0) ** derivative, 1.0) * side)

    def _arc(self, turned: Array, arc: tuple[float, float], derivative: int) -> Array:
        radius, away = arc
        turned = np.clip(
            turned, *((math.pi, 1.5 * math.pi) if arc is self.flank else (-math.pi / 2, 0.0))
        )
        sine, cosine = np.sin(turned), np.cos(turned)
        root = np.sqrt(np.maximum(radius**2 - (away * sine) ** 2, 1e-12))
        if derivative == 0:
            return np.asarray(away * cosine + root - self.base)
        if derivative == 1:
            return np.asarray(-away * sine - away**2 * sine * cosine / root)
        bend = (cosine**2 - sine**2) / root + (away * sine * cosine) ** 2 / root**3
        return np.asarray(-away * cosine - away**2 * bend)


@dataclass(frozen=True, slots=True)
class Stop:
    """The stop of the impact oscillator as it moves beside the free oscillation; ``drive`` over the natural frequency."""

    drive: float
    damping: float
    size: float = 1e-3

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Height (m) or a derivative by the angle of the drive."""
        answer = self.size / (1 - self.drive**2 + 2j * self.damping * self.drive)
        turned = np.exp(1j * np.asarray(cam_angle, dtype=float)) * 1j**derivative
        return np.asarray((answer * turned).real)


def largest_first(slopes: Array) -> NDArray[np.complex128]:
    """Eigenvalues of a cycle map's derivative."""
    values = np.linalg.eigvals(slopes).astype(np.complex128)
    return values[np.argsort(-np.abs(values), kind="stable")]


@dataclass(frozen=True)
class Bouncer:
    """A mass (kg) on a spring (N/m) and a damper (share of critical), struck by a moving surface; ``raised`` (m): the
    surface's zero over the rest of the spring.
    """

    surface: Surface
    mass: float
    rate: float
    damping: float
    raised: float
    restitution: float
    stiffness: float = 1e12

    @property
    def natural(self) -> float:
        return math.sqrt(self.rate / self.mass)

    def height(self, time: float, cam_speed: float, derivative: int = 0) -> float:
        """Of the surface over the rest of the spring (m), or a derivative by time."""
        lift = float(self.surface.lift(cam_speed * time, derivative)) * cam_speed**derivative
        return lift + (self.raised if derivative == 0 else 0.0)

    def flight(self, start: Array, time: float) -> Array:
        """Height over rest and velocity, a ``time`` (s) after ``start`` of both."""
        slow = self.damping * self.natural
        ring = self.natural * math.sqrt(1 - self.damping**2)
        other = (start[1] + slow * start[0]) / ring
        sine, cosine, left = math.sin(ring * time), math.cos(ring * time), math.exp(-slow * time)
        place = left * (start[0] * cosine + other * sine)
        return np.array([place, -slow * place + left * ring * (other * cosine - start[0] * sine)])

    def leaving(self, time: float, arrival: float, cam_speed: float) -> Array:
        """Height and velocity after an impact with the velocity ``arrival``."""
        moves = self.height(time, cam_speed, 1)
        return np.array(
            [self.height(time, cam_speed), moves - self.restitution * (arrival - moves)]
        )

    def next_impact(self, impact: Array, cam_speed: float) -> Array:
        """Time and velocity of arrival from those of the impact one turn before, its time less the turn."""
        start, turn = self.leaving(impact[0], impact[1], cam_speed), TURN / cam_speed

        def apart(time: float) -> float:
            return float(self.flight(start, time)[0]) - self.height(impact[0] + time, cam_speed)

        time = float(brentq(apart, 0.97 * turn, 1.03 * turn, xtol=1e-15))
        return np.array([impact[0] + time - turn, self.flight(start, time)[1]])

    def impacts(self, cam_speed: float, first: float, last: float) -> list[Array]:
        """Times in a turn, and velocities of arrival, of the orbits of one impact a turn between two angles (rad)."""
        turn = TURN / cam_speed

        def leaves(time: float) -> float:
            """Velocity with which a flight of one turn comes back to its height."""
            height = self.height(time, cam_speed)
            still, moving = (
                self.flight(np.array([height, 0.0]), turn)[0],
                self.flight(np.array([0.0, 1.0]), turn)[0],
            )
            return float((height - still) / moving)

        def arrives(time: float) -> float:
            return float(
                self.flight(np.array([self.height(time, cam_speed), leaves(time)]), turn)[1]
            )

        def excess(time: float) -> float:
            return float(self.leaving(time, arrives(time), cam_speed)[1]) - leaves(time)

        times = np.linspace(first, last, 401) / cam_speed
        values = [excess(time) for time in times]
        roots = [
            float(brentq(excess, times[k], times[k + 1], xtol=1e-15))
            for k in np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
            if abs(values[k]) + abs(values[k + 1]) < 1e2 * abs(arrives(times[k]))
        ]
        return [
            np.array([time, arrives(time)])
            for time in roots
            if arrives(time) < self.height(time, cam_speed, 1)
        ]

    def known_multipliers(self, impact: Array, cam_speed: float) -> NDArray[np.complex128]:
        """Of the orbit through an impact, by differences of the flights."""
        steps = np.diag([1e-6 / cam_speed, 1e-6 * abs(impact[1])])
        columns = [
            (self.next_impact(impact + step, cam_speed) - self.next_impact(impact - step, cam_speed)) / (2 * np.sum(step))
            for step in steps
        ]  # fmt: skip
        return largest_first(np.array(columns).T)


@dataclass(frozen=True)
class TwoMasses:
    """Two equal masses in line on equal springs, the first of them tied to the ground and driven; it strikes a stop that stands
    where the masses rest. Lengths in ``size`` (m), times over the natural frequency ``natural`` (rad/s) of a mass on a spring.

    The unknowns are those of the free masses, beside the driven motion: places and velocities of both (4,).
    """

    drive: float
    damping: float
    restitution: float
    size: float = 1e-3
    natural: float = 100.0

    #: Stiffness of the springs over that of the first.
    springs = np.array([[2.0, -1.0], [-1.0, 1.0]])

    @property
    def turn(self) -> float:
        return TURN / self.drive

    @property
    def rates(self) -> Array:
        """Of the unknowns (4, 4)."""
        low = np.hstack((-self.springs, -2 * self.damping * self.springs))
        return np.vstack((np.eye(2, 4, 2), low))

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Height (m) of the stop beside the driven motion, or a derivative by the angle of the drive."""
        yields = (1 + 2j * self.damping * self.drive) * self.springs - self.drive**2 * np.eye(2)
        driven = np.linalg.solve(yields, [1.0, 0.0])[0]
        turned = np.exp(1j * np.asarray(cam_angle, dtype=float)) * 1j**derivative
        return np.asarray(-self.size * (driven * turned).real)

    def stop(self, time: float, derivative: int) -> float:
        """Derivative by time of the stop's height, in sizes."""
        return float(self.lift(self.drive * time, derivative)) * self.drive**derivative / self.size

    @property
    def blow(self) -> Array:
        """What an impact on a stop at rest makes of the unknowns (4, 4)."""
        return np.diag([1.0, 1.0, -self.restitution, 1.0])

    def before(self, time: float) -> Array:
        """Unknowns before an impact that comes once a turn."""
        pushed = (1 + self.restitution) * self.stop(time, 1) * np.eye(4)[2]
        free = expm(self.turn * self.rates)
        return np.asarray(np.linalg.solve(np.eye(4) - free @ self.blow, free @ pushed))

    def after(self, time: float) -> Array:
        """Unknowns after it."""
        pushed = (1 + self.restitution) * self.stop(time, 1) * np.eye(4)[2]
        return np.asarray(self.blow @ self.before(time) + pushed)

    def impact(self) -> float:
        """Time of the only impact in a turn, from which the mass stays above the stop till the next."""

        def apart(time: float) -> float:
            return float(self.before(time)[0]) - self.stop(time, 0)

        times, found = np.linspace(0.0, self.turn, 361), list[float]()
        values = [apart(time) for time in times]
        for k in np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:])):
            time = float(brentq(apart, times[k], times[k + 1], xtol=1e-14))
            later = self.turn * np.arange(1, 400) / 400
            heights = [(expm(t * self.rates) @ self.after(time))[0] - self.stop(time + t, 0) for t in later]  # fmt: skip
            if self.before(time)[2] < self.stop(time, 1) and min(heights) > 0:
                found.append(time)
        (only,) = found
        return only

    def at_zero(self) -> Array:
        """Places (m) and velocities (m/s) at angle zero."""
        time = self.impact()
        scale = self.size * np.array([1.0, 1.0, self.natural, self.natural])
        return np.asarray(scale * (expm((self.turn - time) * self.rates) @ self.after(time)))

    def known_multipliers(self) -> NDArray[np.complex128]:
        """Of the orbit: the free turn, then the impact, which comes earlier or later for a disturbed motion
        (saltation matrix).
        """
        time = self.impact()
        before, after, blow = self.before(time), self.after(time), self.blow
        pushed = (1 + self.restitution) * self.stop(time, 2) * np.eye(4)[2]
        late = self.rates @ after - blow @ self.rates @ before - pushed
        slope = blow + np.outer(late, np.eye(4)[0]) / (before[2] - self.stop(time, 1))
        return largest_first(slope @ expm(self.turn * self.rates))
