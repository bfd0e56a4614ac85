"""Runs between the speeds of a sweep of a train: runs where a cam order meets the first surge
frequency of a spring.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from valvetrain.quantities.forces import surge_engine_speeds
from valvetrain.runs.prepared import Plan, PreparedRun
from valvetrain.runs.train_runs import train_point
from valvetrain.runs.workers import map_points
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Fact
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


def order_speeds(one: PreparedRun, engine_speeds: Sequence[float]) -> tuple[float, ...]:
    """Engine speeds (rad/s) between the swept ones at which a cam order meets a first surge
    frequency; at most as many as were swept, the highest, where orders are low and surge is strong.

    None for springs without surge (massless), or whose runs take minutes.
    """
    if not isinstance(one.system, TrainSystem) or one.member.model.word == "massless":
        return ()
    if one.system.has_large_springs:
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


def between_facts(swept: Sequence[Solution], between: Sequence[Solution]) -> Iterator[Fact]:
    """The speeds of the runs between the swept ones, and where a quantity there is worse than at both
    swept speeds next to it.
    """
    for run in between:
        yield Fact("between-speeds", {"label": run.label, "engine_speed": run.engine_speed})
    for label in dict.fromkeys(run.label for run in between):
        mine = [run for run in between if run.label == label]
        own = sorted((run for run in swept if run.label == label), key=lambda run: run.engine_speed)
        for name, sign in WORSE.items():
            yield from _worst(own, mine, name, sign)


def _worst(
    swept: Sequence[Solution], between: Sequence[Solution], name: str, sign: int
) -> tuple[Fact, ...]:
    """The worst of the values that are worse than at both swept speeds next to them; empty for none."""
    most, found = -math.inf, tuple[Fact, ...]()
    for run in between:
        speed = run.engine_speed
        sides = (
            [one for one in swept if one.engine_speed < speed][-1:],
            [one for one in swept if one.engine_speed > speed][:1],
        )
        next_to = [*sides[0], *sides[1]]
        if not all(one.status.completed and name in one.quantities for one in (run, *next_to)):
            continue
        worst = max(next_to, key=lambda one: sign * one.quantities[name])
        value, known = run.quantities[name], worst.quantities[name]
        if sign * (value - known) > REPORTED * abs(known) and sign * value > most:
            most = sign * value
            numbers = {
                "engine_speed": speed,
                "value": value,
                "next_engine_speed": worst.engine_speed,
                "next_value": known,
            }
            found = (Fact("worse-between", {"label": run.label, "quantity": name, **numbers}),)
    return found
