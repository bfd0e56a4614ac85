"""Masses that a moving surface strikes once a turn, and their orbits in closed form: a published cam with its follower, and the
impact oscillator. It knows nothing of the package.

An orbit is a free flight of one turn that begins and ends on the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
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
