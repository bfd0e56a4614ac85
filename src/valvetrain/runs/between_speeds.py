"""What lies between the speeds of a sweep of a train: runs where a cam order meets the first surge
frequency of a spring.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from valvetrain.quantities.forces import surge_engine_speeds
from valvetrain.runs.prepared import Plan, PreparedRun
from valvetrain.runs.train_runs import train_point
from valvetrain.runs.workers import map_points
from valvetrain.solution.definition import label_of, shown
from valvetrain.solution.result import Solution
from valvetrain.springs.contract import LargeSpring
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem

#: Distance from a swept speed, over the speed, within which an order speed is no other speed: a
#: tenth of the half-width of a resonance at 5 % damping.
SAME = 0.005
#: Quantities that surge makes worse -> the sign of what is worse.
WORSE = {
    "minimum_spring_force": -1,
    "surge_amplitude_force": 1,
    "minimum_cam_contact_force": -1,
}
#: Change, over the value at the swept speeds, from which a value between them is reported.
REPORTED = 0.02
RPM = math.pi / 30


def order_speeds(one: PreparedRun, engine_speeds: Sequence[float]) -> tuple[float, ...]:
    """Engine speeds (rad/s) between the swept ones at which a cam order meets a first surge
    frequency; at most as many as were swept, the highest, where orders are low and surge is strong.

    None for springs without surge (massless), or whose runs take minutes.
    """
    if not isinstance(one.system, TrainSystem) or one.member.model.word == "massless":
        return ()
    if any(isinstance(spring, LargeSpring) for spring in one.system.springs):
        return ()
    first, last = min(engine_speeds), max(engine_speeds)
    found = {
        speed
        for frequency in one.frame.surge_frequencies
        for speed in surge_engine_speeds(frequency, first, last).values()
        if all(abs(speed - swept) > SAME * swept for swept in engine_speeds)
    }
    return tuple(sorted(found)[-len(engine_speeds) :])


def run_between(
    problem: Problem,
    ready: Sequence[PreparedRun],
    plan: Plan,
    engine_speeds: Sequence[float],
    workers: int,
) -> tuple[Solution, ...]:
    """Reduced solutions at the order speeds of every member."""
    points = [
        (index, speed)
        for index, one in enumerate(ready)
        for speed in order_speeds(one, engine_speeds)
    ]
    shared = problem, tuple(ready), replace(plan, whole=False)
    return tuple(map_points(train_point, shared, points, workers, processes=True)) if points else ()


def between_notes(swept: Sequence[Solution], between: Sequence[Solution]) -> tuple[str, ...]:
    """A sentence per label: what is worse between the speeds of a sweep than at them."""
    notes = []
    for label in dict.fromkeys(run.label for run in between):
        mine = [run for run in between if run.label == label]
        worse = []
        for name, sign in WORSE.items():
            own = [run.quantities[name] for run in swept if _has(run, label, name)]
            others = [run for run in mine if _has(run, label, name)]
            if not own or not others:
                continue
            known = max(own, key=lambda value, sign=sign: sign * value)
            worst = max(others, key=lambda run, sign=sign, name=name: sign * run.quantities[name])
            value = worst.quantities[name]
            if sign * (value - known) > REPORTED * abs(known):
                unit = shown(name, value)[1]
                at = f"{worst.engine_speed / RPM:.0f} rpm"
                swept_value = f"{float(shown(name, known)[0]):.4g} {unit} at the swept speeds"
                worse.append(
                    f"{label_of(name)} {float(shown(name, value)[0]):.4g} {unit} at {at} ({swept_value})"
                )
        speeds = ", ".join(f"{run.engine_speed / RPM:.0f}" for run in mine)
        told = ", ".join(worse) or "nothing worse than at the swept speeds"
        notes.append(
            f"{label}, between the speeds of the sweep, where a cam order meets the first surge frequency of the spring "
            f"({speeds} rpm): {told}."
        )
    return tuple(notes)


def _has(run: Solution, label: str, name: str) -> bool:
    return run.label == label and run.status.completed and name in run.quantities
