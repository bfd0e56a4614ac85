"""Orbits with an impact in every turn: a published cam and follower, and the impact oscillator; their multipliers, and the speeds
at which they appear and lose stability.

Both have a closed form: a free flight of one turn that begins and ends on the moving surface. The package's contact has a stiffness,
so that an impact lasts a little; its restitution does not depend on the speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from validation.row import Row, book_case
from valvetrain.contact.dissipative import Flores, damping_number
from valvetrain.errors import InputError
from valvetrain.integrate.steady import repeat_cycles
from valvetrain.integrate.train_run import TrainOptions, runner
from valvetrain.integrate.train_steady import scaled_cycle
from valvetrain.mechanism.contour import Lift, lift_table
from valvetrain.mechanism.gap_kinds import CAM_LIFT, LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, ElasticLink, Interaction
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]
TURN = 2 * math.pi
RESTITUTION = 0.8
#: The published follower (kg, N/m), and the height (m) of its cam over the rest of its spring.
MASS, RATE, RAISED = 1.221, 1430.8, 0.1


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

    surface: Lift
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

    def train(self) -> TrainSystem:
        """The same as a train of the package."""
        number = damping_number(self.restitution)
        law = Flores(self.stiffness, 1.6 / (1.6 + number))
        link = ElasticLink(self.rate, 2 * self.damping * math.sqrt(self.rate * self.mass))
        interactions = (
            Interaction(
                "cam", CAM_LIFT, ("valve",), (0.0, 1.0, 0.0, 0.0, 0.0, 1.0), law, "cam lift"
            ),
            Interaction("spring", LINEAR, ("valve",), (self.raised, 1.0), link),
        )
        tables = {"cam lift": lift_table(self.surface)}
        body = Coordinate("valve", self.mass)
        return TrainSystem(
            AssembledMechanism("follower", (body,), interactions, tables, "valve", "valve")
        )


@dataclass(frozen=True)
class Orbit:
    """An orbit of the package: its state at angle zero (height over the surface's zero, velocity) and its multipliers."""

    state: Array
    multipliers: NDArray[np.complex128]


def known_start(bouncer: Bouncer, impact: Array, cam_speed: float) -> Array:
    """State at angle zero (height over the surface's zero, velocity) of the flight that an impact begins."""
    left = bouncer.leaving(impact[0], impact[1], cam_speed)
    return bouncer.flight(left, TURN / cam_speed - impact[0]) - [bouncer.raised, 0.0]


def orbit(bouncer: Bouncer, cam_speed: float, start: Array, size: float) -> Orbit:
    """The package's orbit near a state at angle zero, by Newton's method on its cycle map.

    ``size`` (m): of the motion; disturbances are a hundredth of it, so that an impact passes over several steps.
    Raises InputError where none is found.
    """
    train = runner(
        bouncer.train(), cam_speed, TrainOptions(samples=1440, step_fraction=0.1, impact_steps=64)
    )
    cycle, _, weights = scaled_cycle(train, train.initial_state())
    scale = float(weights[0]) * size
    state = start * weights
    for _ in range(20):
        left = (cycle(state) - state) / scale
        if not np.all(np.isfinite(left)) or np.max(np.abs(left)) > 10:
            break
        steps = 0.01 * scale * np.eye(2)
        slopes = np.array(
            [(cycle(state + step) - cycle(state - step)) / (0.02 * scale) for step in steps]
        ).T
        if np.max(np.abs(left)) < 2e-5:
            return Orbit(state / weights, largest_first(slopes))
        state = state - np.linalg.solve(slopes - np.eye(2), left * scale)
    raise InputError(f"no orbit near the known one at {cam_speed * 30 / math.pi:g} rpm")


def impact_angle(bouncer: Bouncer, state: Array, cam_speed: float, near: float) -> float:
    """Angle (rad) at which a flight from angle zero meets the surface, near an angle."""
    start = state + np.array([bouncer.raised, 0.0])

    def apart(angle: float) -> float:
        time = angle / cam_speed
        return float(bouncer.flight(start, time)[0]) - bouncer.height(time, cam_speed)

    return float(brentq(apart, near - 0.1, near + 0.1, xtol=1e-12))


def doubling(multipliers: NDArray[np.complex128]) -> float:
    """Zero where one of two multipliers is -1."""
    return float((1 + np.sum(multipliers) + np.prod(multipliers)).real)


CAM = ArcCam()
FOLLOWER = Bouncer(CAM, MASS, RATE, 0.0, RAISED, RESTITUTION)
SIZE = 0.15


def rpm(value: float) -> float:
    return value * math.pi / 30


def followed(which: int, *speeds: float) -> Orbit:
    """The package's orbit of the cam at the last of ``speeds`` (rpm); each but the first starts from the difference that
    the one before has from the known one. ``which`` impact of the rise: 0 on the flank, -1 on the nose.
    """
    offset = np.zeros(2)
    for value in speeds:
        impact = FOLLOWER.impacts(rpm(value), 1e-3, math.pi / 2)[which]
        known = known_start(FOLLOWER, impact, rpm(value))
        found = orbit(FOLLOWER, rpm(value), known + offset, SIZE)
        offset = found.state - known
    return found


@book_case()
def impacting_cam() -> list[Row]:
    """Orbits of one impact a turn of the published cam: a focus on the nose, a saddle on the flank, both born at the corner."""
    about = "1.221 kg, 1430.8 N/m, restitution 0.8, point follower on circular arcs"
    rows: list[Row] = []

    def row(what: str, values: tuple[float, float], unit: str, tolerance: float, why: str) -> None:
        rows.append(
            Row(
                "orbits",
                f"impacting cam, {what}",
                "osorio2008",
                about,
                *values,
                unit,
                tolerance,
                why,
            )
        )

    speed = rpm(700)
    for word, which in (("nose", -1), ("flank", 0)):
        impact = FOLLOWER.impacts(speed, 1e-3, math.pi / 2)[which]
        known = FOLLOWER.known_multipliers(impact, speed)
        found = followed(which, 700)
        angles = impact[0] * speed, impact_angle(FOLLOWER, found.state, speed, impact[0] * speed)
        what = f"impact on the {word} at 700 rpm"
        row(
            f"{what}, angle",
            (math.degrees(angles[0]), math.degrees(angles[1])),
            "deg",
            0.2,
            "time of contact, 0.1 deg",
        )
        values = known[0].real, found.multipliers[0].real
        row(f"{what}, multiplier", values, "-", 0.01 * abs(known[0]), "required: 1 %")
        product = RESTITUTION**2, float(np.prod(found.multipliers).real)
        row(f"{what}, product of multipliers", product, "-", 1e-3, "time of contact")

    def closed(value: float) -> float:
        impact = FOLLOWER.impacts(rpm(value), 1e-3, math.pi / 2)[-1]
        return doubling(FOLLOWER.known_multipliers(impact, rpm(value)))

    flips = (
        float(brentq(closed, 737, 742, xtol=1e-9)),
        float(brentq(lambda value: doubling(followed(-1, 700, 715, 730, value).multipliers), 737, 742, xtol=0.02)),
    )  # fmt: skip
    row("loss of stability by a flip", flips, "rpm", 0.5, "required: 0.1 %")

    def strikes_corner(value: float) -> float:
        """Zero at the speed at which the known orbit strikes the corner of flank and nose."""
        leaves = (1 + RESTITUTION) / (1 - RESTITUTION) * float(CAM.lift(CAM.corner, 1)) * rpm(value)
        height = float(CAM.lift(CAM.corner)) + RAISED
        return leaves - FOLLOWER.natural * height * math.tan(
            FOLLOWER.natural * math.pi / rpm(value)
        )

    born = float(brentq(strikes_corner, 660, 690)), _lowest(followed(0, 700).state, 700.0)
    row("birth of both orbits (fold)", born, "rpm", 0.5, "required: 0.1 %")
    return rows


def _lowest(state: Array, value: float) -> float:
    """Lowest speed (rpm) down to which the package's orbit from a state at ``value`` exists, to 0.05 rpm."""
    step = 4.0
    while step > 0.05:
        try:
            state = orbit(FOLLOWER, rpm(value - step), state, SIZE).state
            value -= step
        except InputError:
            step /= 2
    return value


def oscillator(
    damping: float, drive: float, gap: float, restitution: float
) -> tuple[Bouncer, float, Array]:
    """The impact oscillator of 100 rad/s in millimetres, speed of its drive (rad/s), and its one impact a turn."""
    natural, size = 100.0, 1e-3
    built = Bouncer(
        Stop(drive, damping, size), 1.0, natural**2, damping, -gap * size, restitution, 1e14
    )
    return built, drive * natural, built.impacts(drive * natural, 0.0, TURN)[0]


@book_case()
def impact_oscillator() -> list[Row]:
    """A driven oscillator that strikes a stop once a turn; above a flip, once in every second turn alike."""
    rows: list[Row] = []

    def row(
        what: str, about: str, values: tuple[float, float], unit: str, tolerance: float, why: str
    ) -> None:
        rows.append(
            Row(
                "orbits",
                f"impact oscillator, {what}",
                "shaw1983",
                about,
                *values,
                unit,
                tolerance,
                why,
            )
        )

    def text(damping: float, drive: float, gap: float, restitution: float) -> str:
        return f"damping {damping:g}, drive {drive:g} of the natural frequency, gap {gap:g}, restitution {restitution:g}"

    for numbers in ((0.05, 2.0, 0.1, 0.6), (0.02, 2.6, 0.0, 0.8)):
        built, speed, impact = oscillator(*numbers)
        size = abs(impact[1]) / built.natural / 3
        known = built.known_multipliers(impact, speed)
        found = orbit(built, speed, known_start(built, impact, speed), size)
        angles = impact[0] * speed, impact_angle(built, found.state, speed, impact[0] * speed)
        row(
            f"phase of the impact at drive {numbers[1]:g}",
            text(*numbers),
            angles,
            "rad",
            0.005,
            "time of contact",
        )
        row(
            f"multiplier at drive {numbers[1]:g}",
            text(*numbers),
            (known[0].real, found.multipliers[0].real),
            "-",
            0.01 * abs(known[0]),
            "required: 1 %",
        )
        product = numbers[3] ** 2 * math.exp(-2 * numbers[0] * built.natural * TURN / speed)
        row(
            f"product of multipliers at drive {numbers[1]:g}",
            text(*numbers),
            (product, float(np.prod(found.multipliers).real)),
            "-",
            0.005 * product,
            "0.5 %",
        )

    def closed(drive: float) -> float:
        built, speed, impact = oscillator(0.02, drive, 0.0, 0.8)
        return doubling(built.known_multipliers(impact, speed))

    def computed(drive: float) -> float:
        built, speed, impact = oscillator(0.02, drive, 0.0, 0.8)
        size = abs(impact[1]) / built.natural / 3
        return doubling(orbit(built, speed, known_start(built, impact, speed), size).multipliers)

    about = "damping 0.02, gap 0, restitution 0.8"
    flips = tuple(
        float(brentq(rule, 2.64, 2.7, xtol=tolerance))
        for rule, tolerance in ((closed, 1e-11), (computed, 1e-5))
    )
    row("drive of the flip", about, (flips[0], flips[1]), "-", 0.001 * flips[0], "required: 0.1 %")
    for share, period in ((0.99, 1), (1.01, 2)):
        built, speed, impact = oscillator(0.02, share * flips[0], 0.0, 0.8)
        train = runner(built.train(), speed, TrainOptions(samples=1440))
        cycle, _, weights = scaled_cycle(train, train.initial_state())
        start = 1.02 * known_start(built, impact, speed) * weights
        ends = repeat_cycles(cycle, start, np.ones(2) / (weights[0] * 1e-3), 1e-4, 300)
        row(
            f"period at {share:g} of the drive of the flip",
            about,
            (period, ends.period),
            "-",
            1e-9,
            "a whole number",
        )
    return rows
