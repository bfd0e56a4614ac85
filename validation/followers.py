"""Lobes and followers by textbook formulas: a three-arc lobe, gas between its angles, a dwell after
a rise, a follower that bounces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from validation.laws import hunt_crossley_restitution
from validation.row import Row, book_case
from valvetrain.cam.arcs import ThreeArc
from valvetrain.cam.closed_form import Cycloidal, Harmonic
from valvetrain.cam.contract import LiftLaw
from valvetrain.contact.dissipative import HuntCrossley
from valvetrain.integrate.train_record import CycleRecord, TrainOptions, TrainState
from valvetrain.integrate.train_run import runner
from valvetrain.mechanism.contour import lift_table, monotone_table
from valvetrain.mechanism.gap_kinds import CAM_LIFT
from valvetrain.mechanism.gaps import table_value
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, ElasticLink, Interaction, Law
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]
MASS = 0.1


@book_case()
def three_arc_lobe() -> list[Row]:
    """A lobe of three circles: the flank that is tangent to base and nose, lift as the highest
    point of the outline, accelerations.
    """
    base, nose_radius, top, half = 18e-3, 4e-3, 8e-3, math.radians(65)
    law = ThreeArc(
        base_radius=base,
        nose_radius=nose_radius,
        maximum_lift=top,
        nose=math.pi,
        opening_start=math.pi - half,
    )
    away = (
        base + top - nose_radius
    )  # the nose's centre is on the x axis, the flank's beyond the cam's centre

    def centre(flank: float) -> Array:
        return -(flank - base) * np.array([math.cos(half), math.sin(half)])

    def apart(flank: float) -> float:
        return float(np.hypot(*(centre(flank) - [away, 0.0]))) - (flank - nose_radius)

    flank = float(brentq(apart, 1.01 * (base + top), 1.0))
    direction = np.linspace(0, half, 200_001)
    joint = math.atan2(-centre(flank)[1], away - centre(flank)[0])
    on_nose, other = direction <= joint, centre(flank)
    radius = np.where(on_nose, nose_radius, flank)
    x = np.where(on_nose, away, other[0]) + radius * np.cos(direction)
    y = np.where(on_nose, 0.0, other[1]) + radius * np.sin(direction)
    about, source = "base 18, nose 4, lift 8 mm, half event 65 deg, flat face", "norton2009"
    rows = [
        Row(
            "cam laws",
            "three arcs, radius of the flank",
            source,
            about,
            1e3 * flank,
            1e3 * law.flank_radius,
            "mm",
            1e-6,
            "closed form",
        )
    ]
    for degrees in (60.0, 45.0, 30.0, 10.0):
        turn = math.radians(degrees)
        highest = float(np.max(x * math.cos(turn) + y * math.sin(turn))) - base
        found = float(law.lift(math.pi + turn))
        what = f"three arcs, lift {degrees:g} degrees from the nose"
        rows.append(
            Row(
                "cam laws",
                what,
                source,
                about,
                1e3 * highest,
                1e3 * found,
                "mm",
                1e-6,
                "points of the outline",
                "independent computation",
            )
        )
    for what, turn, expected in (
        ("at the first lift", half - 1e-9, flank - base),
        ("at the end of the flank", joint + 1e-9, (flank - base) * math.cos(half - joint)),
        ("at the nose", 0.0, -away),
    ):
        found = float(law.lift(math.pi - turn, 2))
        rows.append(
            Row(
                "cam laws",
                f"three arcs, acceleration {what}",
                source,
                about,
                expected,
                found,
                "m",
                1e-9,
                "closed form",
            )
        )
    return rows


@book_case()
def gas_between_its_angles() -> list[Row]:
    """Cylinder gas on a valve between the angles given: monotone cubics, slopes by the weighted
    harmonic means of their authors.
    """
    degrees = np.array([0.0, 90.0, 130.0, 160.0, 178.0, 184.0, 196.0, 220.0, 270.0, 320.0])
    force = np.array([30.0, 30.0, 90.0, 420.0, 2100.0, 2600.0, 1700.0, 600.0, 150.0, 40.0])
    table = monotone_table(np.radians(degrees), force)[None]
    steps, rises = np.diff(np.append(degrees, 360.0)), np.diff(np.append(force, force[0]))
    slopes = np.zeros(len(degrees))
    for k in range(len(degrees)):
        (h0, h1), (d0, d1) = (
            (steps[k - 1], steps[k]),
            (rises[k - 1] / steps[k - 1], rises[k] / steps[k]),
        )
        if d0 * d1 > 0:
            slopes[k] = 3 * (h0 + h1) / ((2 * h1 + h0) / d0 + (h1 + 2 * h0) / d1)
    rows = []
    for k in (2, 3, 4, 5, 6):
        middle, after = degrees[k] + steps[k] / 2, (k + 1) % len(degrees)
        expected = (force[k] + force[after]) / 2 + steps[k] / 8 * (slopes[k] - slopes[after])
        found = float(table_value(table, 0, math.radians(middle))[0])
        what, about = (
            f"gas force at {middle:g} degrees",
            "10 angles from 0 to 320 degrees, 30 to 2600 N",
        )
        rows.append(
            Row(
                "followers",
                what,
                "fritsch1984",
                about,
                expected,
                found,
                "N",
                1e-6 * expected,
                "rounding",
            )
        )
    return rows


def follower(law: Law, lift_law: LiftLaw, force: float = 0.0) -> TrainSystem:
    """One mass on a cam whose lift it feels through ``law``; ``force`` (N) pulls it away from the
    cam.
    """
    contact = Interaction(
        "cam", CAM_LIFT, ("valve",), (0.0, 1.0, 0.0, 0.0, 0.0, 1.0), law, "cam lift"
    )
    tables = {"cam lift": lift_table(lift_law)}
    return TrainSystem(
        AssembledMechanism(
            "follower",
            (Coordinate("valve", MASS, force=force),),
            (contact,),
            tables,
            "valve",
            "valve",
        )
    )


def turns(
    built: TrainSystem, cam_speed: float, start: tuple[float, float], steps: int, cycles: int
) -> CycleRecord:
    """Record of the last of ``cycles`` cam revolutions from a height (m) and velocity (m/s) at cam
    angle zero.
    """
    options = TrainOptions(samples=1440, time_step=2 * math.pi / cam_speed / steps)
    ready = runner(built, cam_speed, options)
    memory = np.zeros(built.arrays.memory_of[-1])
    state = TrainState(np.array([start[0]]), np.array([start[1]]), (), memory, np.zeros(5))
    for _ in range(cycles):
        state, record = ready.cycle(state)
    return record


def cycloidal_ringing(periods: float) -> float:
    """Amplitude over lift after a cycloidal rise of this many periods of the follower."""
    return abs(math.sin(math.pi * periods) / (math.pi * periods * (periods**2 - 1)))


def harmonic_ringing(periods: float) -> float:
    """The same after a harmonic rise."""
    return abs(math.cos(math.pi * periods) / (4 * periods**2 - 1))


@book_case()
def dwell_after_a_rise() -> list[Row]:
    """An elastic follower without damping rings in the dwell: amplitude over lift by the number of
    its periods in the rise.
    """
    lift, begin, end, stiffness = 8e-3, 1.0, 2.2, 1e6
    omega, rows = math.sqrt(stiffness / MASS), []
    flanks = {
        "maximum_lift": lift,
        "opening_start": begin,
        "opening_end": end,
        "closing_start": 4.4,
        "closing_end": 5.6,
    }
    for word, law, closed in (
        ("cycloidal", Cycloidal(**flanks), cycloidal_ringing),
        ("harmonic", Harmonic(**flanks), harmonic_ringing),
    ):
        for periods in (1.5, 2.25, 3.3) if word == "cycloidal" else (1.0, 2.2, 3.0):
            cam_speed = (end - begin) * omega / (2 * math.pi * periods)
            record = turns(
                follower(ElasticLink(stiffness), law), cam_speed, (0.0, 0.0), 1440 * 16, 1
            )
            dwell = (record.cam_angle > end + 0.05) & (record.cam_angle < 4.35)
            phase = omega * record.cam_angle[dwell] / cam_speed
            waves = np.column_stack([np.cos(phase), np.sin(phase), np.ones_like(phase)])
            cosine, sine, _ = np.linalg.lstsq(waves, record.q[dwell, 0], rcond=None)[0]
            expected, found = closed(periods), math.hypot(cosine, sine) / lift
            rows.append(
                Row(
                    "followers",
                    f"ringing after a {word} rise of {periods:g} periods",
                    "norton2009",
                    "one mass on a spring, no damping, amplitude over lift",
                    expected,
                    found,
                    "-",
                    3e-5 * expected,
                    "step of the integration, 16 per quarter degree",
                )
            )
    return rows


@dataclass(frozen=True, slots=True)
class Shaker:
    """A table that swings by ``amplitude`` (m) once per cam revolution."""

    amplitude: float

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Height (m) or a derivative by the cam angle."""
        return np.asarray(
            self.amplitude * np.sin(np.asarray(cam_angle, dtype=float) + derivative * math.pi / 2)
        )


@book_case()
def bouncing_follower() -> list[Row]:
    """A follower thrown once per turn by a swinging table: arrival speed, restitution and phase of
    the periodic motion.

    With g the constant pull over the mass and T a turn, it leaves at u = g T / 2 and comes back as
    fast; the table then moves at w = u (1 - e) / (1 + e), so it is struck at 2 u / (1 + e).
    """
    cam_speed, pull, amplitude, stiffness, damping = 2000.0, 200.0, 0.35e-3, 3e12, 0.12
    leave = pull / MASS * math.pi / cam_speed
    restitution = float(
        brentq(lambda e: e - hunt_crossley_restitution(damping * 2 * leave / (1 + e)), 0.05, 0.999)
    )
    table_speed = leave * (1 - restitution) / (1 + restitution)
    phase = math.acos(table_speed / (amplitude * cam_speed))
    built = follower(HuntCrossley(stiffness, damping), Shaker(amplitude), -pull)  # type: ignore[arg-type]
    flown = (2 * math.pi - phase) / cam_speed
    start = (
        amplitude * math.sin(phase) + leave * flown - pull / MASS * flown**2 / 2,
        leave - pull / MASS * flown,
    )
    record = turns(built, cam_speed, (0.9 * start[0], start[1]), 1440 * 24, 40)
    free = record.forces[:, 0] == 0.0
    time = record.cam_angle % (2 * math.pi) / cam_speed
    # The flight crosses the end of the turn: a parabola through its samples before and after the
    # impact, each its own.
    impact = int(np.argmin(record.q[:, 0]))
    after = free & (np.arange(len(time)) > impact + 3)
    speed = float(
        np.polyval(np.polyder(np.polyfit(time[after], record.q[after, 0], 2)), phase / cam_speed)
    )
    about = "0.1 kg pulled by 200 N, table 0.35 mm at 2000 rad/s, one bounce per turn"
    found_phase = float(record.cam_angle[impact] % (2 * math.pi))
    return [
        Row(
            "followers",
            "bouncing follower, speed of leaving",
            "guckenheimer1983",
            about,
            leave,
            speed,
            "m/s",
            0.0015 * leave,
            "time of contact, 10 us of 3.1 ms",
        ),
        Row(
            "followers",
            "bouncing follower, phase of the impact",
            "guckenheimer1983",
            about,
            math.degrees(phase),
            math.degrees(found_phase),
            "deg",
            0.25,
            "samples of a quarter degree",
        ),
    ]
