"""Orbits with an impact in every turn: a published cam and follower, the impact oscillator, and two masses in line; their
multipliers, and the speeds at which they appear and lose stability.

All have a closed form: a free flight of one turn that begins and ends on the moving surface. The package's contact has a stiffness,
so that an impact lasts a little; its restitution does not depend on the speed.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from validation.impacts import TURN, ArcCam, Bouncer, Stop, TwoMasses, largest_first
from validation.row import Row, book_case
from validation.springs import spring
from validation.struck import Orbit, orbit, train, two_masses
from valvetrain.errors import InputError
from valvetrain.integrate.multipliers import loss_of_stability
from valvetrain.integrate.steady import repeat_cycles
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import scaled_cycle, steady_train
from valvetrain.solution.branches import Branches, BranchPoint
from valvetrain.springs.multi_mass import MultiMassSpring

Array = NDArray[np.float64]
RESTITUTION = 0.8
#: The published follower (kg, N/m), and the height (m) of its cam over the rest of its spring.
MASS, RATE, RAISED = 1.221, 1430.8, 0.1


def known_start(bouncer: Bouncer, impact: Array, cam_speed: float) -> Array:
    """State at angle zero (height over the surface's zero, velocity) of the flight that an impact begins."""
    left = bouncer.leaving(impact[0], impact[1], cam_speed)
    return bouncer.flight(left, TURN / cam_speed - impact[0]) - [bouncer.raised, 0.0]


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
        found = orbit(train(FOLLOWER), rpm(value), known + offset, SIZE)
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
        product = RESTITUTION**2, float(np.linalg.det(found.slopes))
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
            state = orbit(train(FOLLOWER), rpm(value - step), state, SIZE).state
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

    for numbers, share in (((0.05, 2.0, 0.1, 0.6), 0.004), ((0.02, 2.6, 0.0, 0.8), 0.01)):
        built, speed, impact = oscillator(*numbers)
        size = abs(impact[1]) / built.natural / 3
        known = built.known_multipliers(impact, speed)
        found = orbit(train(built), speed, known_start(built, impact, speed), size)
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
            share * abs(known[0]),
            f"{100 * share:g} %; required: 1 %",
        )
        product = numbers[3] ** 2 * math.exp(-2 * numbers[0] * built.natural * TURN / speed)
        row(
            f"product of multipliers at drive {numbers[1]:g}",
            text(*numbers),
            (product, float(np.linalg.det(found.slopes))),
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
        return doubling(
            orbit(train(built), speed, known_start(built, impact, speed), size).multipliers
        )

    about = "damping 0.02, gap 0, restitution 0.8"
    flips = tuple(
        float(brentq(rule, 2.64, 2.7, xtol=tolerance))
        for rule, tolerance in ((closed, 1e-11), (computed, 1e-5))
    )
    row("drive of the flip", about, (flips[0], flips[1]), "-", 0.001 * flips[0], "required: 0.1 %")
    for share, period in ((0.99, 1), (1.01, 2)):
        built, speed, impact = oscillator(0.02, share * flips[0], 0.0, 0.8)
        ready = runner(train(built), speed, TrainOptions(samples=1440))
        cycle, _, weights = scaled_cycle(ready, ready.initial_state())
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


@book_case()
def grazing_oscillator() -> list[Row]:
    """The impact oscillator as its drive falls towards resonance: the motion without impacts ends where it touches the stop."""
    damping, gap, restitution = 0.05, 0.5, 0.6

    def swings(drive: float) -> float:
        return 1 / math.hypot(1 - drive**2, 2 * damping * drive)

    known = float(brentq(lambda drive: swings(drive) - gap, 1.2, 5.0, xtol=1e-12))
    points, before = list[BranchPoint](), None
    for drive in known * np.arange(1.01, 0.99, -0.0004):
        built = Bouncer(Stop(drive, damping), 1.0, 1e4, damping, -gap * 1e-3, restitution, 1e14)
        options = TrainOptions(samples=1440, step_fraction=0.1, impact_steps=64)
        ready = runner(train(built), 100 * drive, options)
        settled = steady_train(ready, start=before, tolerance=1e-6, compared=False, probed=False)
        landings, before = int(np.sum(settled.record.transitions.closes)), settled.orbit
        points.append(
            BranchPoint(
                drive, False, settled.search.period, (settled.start.q[0],), landings=landings
            )
        )
    about = f"damping {damping:g}, gap {gap:g}, restitution {restitution:g}"
    (found,) = Branches("oscillator", "loft_gap", tuple(points), 0).grazing
    middle = (found.lower_engine_speed + found.upper_engine_speed) / 2
    name, why = (
        "impact oscillator, drive at which a motion grazes the stop",
        "half a step of the march",
    )
    return [Row("orbits", name, "budd1995", about, known, middle, "-", 0.0003 * known, why)]


@book_case()
def two_masses_in_line() -> list[Row]:
    """Two masses of which one strikes a stop: the orbit of one impact a turn loses stability to a torus."""
    damping, restitution = 0.02, 0.8
    about = "equal masses and springs, the first driven and struck where it rests, damping 0.02, restitution 0.8"
    rows: list[Row] = []

    def row(what: str, values: tuple[float, float], unit: str, tolerance: float, why: str) -> None:
        name = f"two masses in line, {what}"
        rows.append(Row("orbits", name, "luo1998", about, *values, unit, tolerance, why))

    def computed(drive: float) -> Orbit:
        known = TwoMasses(drive, damping, restitution)
        start = known.at_zero()
        return orbit(two_masses(known), drive * known.natural, start, float(abs(start[0])))

    known, found = TwoMasses(2.5, damping, restitution), computed(2.5)
    first = known.known_multipliers()[0], found.multipliers[0]
    row(
        "size of the pair at drive 2.5",
        (abs(first[0]), abs(first[1])),
        "-",
        0.01 * abs(first[0]),
        "required: 1 %",
    )
    angles = abs(np.angle(first[0])), abs(np.angle(first[1]))
    row(
        "angle of the pair at drive 2.5",
        (float(angles[0]), float(angles[1])),
        "rad",
        0.005 * float(angles[0]),
        "0.5 %",
    )
    product = restitution**2 * math.exp(np.trace(known.rates) * known.turn)
    row(
        "product of multipliers at drive 2.5",
        (product, float(np.linalg.det(found.slopes))),
        "-",
        0.005 * product,
        "0.5 %",
    )

    def begins(rule: Callable[[float], NDArray[np.complex128]]) -> float:
        return float(brentq(lambda drive: abs(rule(drive)[0]) - 1, 2.5, 2.58, xtol=1e-5))

    limits = (
        begins(lambda drive: TwoMasses(drive, damping, restitution).known_multipliers()),
        begins(lambda drive: computed(drive).multipliers),
    )
    row(
        "drive at which the torus begins",
        limits,
        "-",
        0.001 * limits[0],
        "required: 0.1 %",
    )
    for share, named in ((0.995, ""), (1.005, "torus")):
        verdict = loss_of_stability(computed(share * limits[0]).multipliers[0])
        what = f"named '{named or 'stable'}' at {share:g} of that drive"
        row(what, (1.0, float(verdict == named)), "-", 1e-9, "the word of the verdict")
    return rows


@book_case()
def clashing_chain() -> list[Row]:
    """A chain that clashes, damped in proportion to its mass alone: multipliers come in pairs of product exp(-damping T)."""
    damping, speed, amplitude = 200.0, 2 * math.pi * 60, 4.5e-3
    wire = spring(3e-3, 20e-3, 5e-3, 5.0)
    chain = MultiMassSpring.from_definition(
        wire, 4e-3, masses_per_coil=1, contact_stiffness=2e7, mass_damping=damping, contact_damping_time=0.0
    )  # fmt: skip
    steps = math.ceil(TURN / speed / (0.1 * chain.stable_time_step()))
    step, size = TURN / speed / steps, 2 * chain.unknowns
    chain = chain.with_time_step(step)
    angle, state = np.arange(steps) * step * speed, chain.initial_state(0.0)
    places, velocities = amplitude * (1 - np.cos(angle)), amplitude * speed * np.sin(angle)

    kernel, parameters, integers = chain.kernel, chain.parameters(), chain.integers()

    def turn(values: Array) -> Array:
        moved = state.copy()
        moved[:size] = values
        for place, velocity in zip(places, velocities, strict=True):
            kernel(parameters, integers, moved, place, velocity, step)
        return moved[:size]

    motion = state[:size]
    for _ in range(12):
        motion = turn(motion)
    moves = 1e-9 * np.diag(np.repeat([1.0, 1e3], size // 2))
    slopes = [(turn(motion + move) - turn(motion - move)) / (2 * np.sum(move)) for move in moves]
    values = np.abs(largest_first(np.array(slopes).T))
    known = math.exp(-damping * TURN / speed)
    about = f"{chain.unknowns} masses driven by 4.5 mm at 60 Hz, damping 200 1/s of the mass, largest multiplier {values[0]:.3f}"
    return [
        Row(
            "orbits",
            f"clashing chain, product of pair {pair + 1}",
            "mclachlan2001",
            about,
            known,
            float(values[pair] * values[-1 - pair]),
            "-",
            1e-5 * known,
            "differences of cycles",
        )
        for pair in range(size // 2)
    ]
