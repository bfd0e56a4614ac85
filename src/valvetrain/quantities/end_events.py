"""Ends of a spring that leave seat or retainer: when, for how long, and how fast they come down.

A model of linear modes, whose ends are fixed whatever happens, shows no force where they
would pull; it cannot lift them, so its run has events of another kind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.clash import runs
from valvetrain.quantities.cycle import is_closed
from valvetrain.quantities.signal import fine_series
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event

Array = NDArray[np.float64]

LIFT_OFF, STRIKE, PULL = "end-lift-off", "end-strike", "end-pull"
END_KINDS = (LIFT_OFF, STRIKE, PULL)
#: Forces (N) below this are none; bonded ends pass it in less than a step.
NOTHING = 1e-9
#: A contact that opens for less than this (s) vibrates; the spring has not left it.
SHORTEST = 2e-5
#: Models of linear modes, which belong to fixed ends.
FIXED_END_MODELS = ("modal-uniform", "modal-varied")


def end_events(solution: Solution) -> tuple[Event, ...]:
    """Events of the ends of every spring of a run by start time: ``end-lift-off`` (size: time off
    the seat, s) and ``end-strike`` (size: closing velocity, m/s); ``end-pull`` where the end of a
    model that cannot lift would pull.
    """
    found: list[Event] = []
    for spring in solution.springs:
        for end in ("seat", "retainer"):
            name = solution.channel_of(spring, f"{end}_force")
            if solution.has(name):
                found += _of_end(solution, spring, end, name)
    return tuple(sorted(found, key=lambda event: event.time))


def _of_end(solution: Solution, spring: str, end: str, channel: str) -> list[Event]:
    time, angle, force = fine_series(solution, channel)
    period, closed = time[-1] - time[0], is_closed(solution)
    where = f"{spring} {end}" if len(solution.springs) > 1 else end
    found: list[Event] = []
    for first, last in runs(np.abs(force) < NOTHING, closed):
        begin, stop = first % len(time), (last + 1) % len(time)
        if closed:
            lasts = float((time[stop] - time[begin]) % period)
        else:
            lasts = float(time[min(last + 1, len(time) - 1)] - time[begin])
        if lasts < SHORTEST:
            continue
        kind = PULL if solution.model in FIXED_END_MODELS else LIFT_OFF
        found.append(Event(kind, float(angle[begin]), float(time[begin]), lasts, lasts, "s", where))
        met = closed or last + 1 < len(time)
        velocity = (
            None
            if kind == PULL or not met
            else _closing(solution, spring, end, float(time[begin]), float(time[stop]))
        )
        if velocity is not None:
            found.append(
                Event(STRIKE, float(angle[stop]), float(time[stop]), 0.0, velocity, "m/s", where, {"time_off": lasts})
            )  # fmt: skip
    return found


def _closing(solution: Solution, spring: str, end: str, begin: float, stop: float) -> float | None:
    """Velocity (m/s) with which an end comes down at ``stop``: straight from the last two samples
    before, of the end coil or of the first moving point of the wire; None without sections.
    """
    name = solution.channel_of(spring, "axial_velocity")
    if not solution.has(name):
        return None
    speed = solution.channel(name)
    towards = -speed if end == "seat" else speed + solution.channel("retainer_velocity")[:, None]
    order = range(speed.shape[1]) if end == "seat" else range(speed.shape[1] - 1, -1, -1)
    scale = float(np.max(np.abs(speed)))
    point = next((k for k in order if np.max(np.abs(towards[:, k])) > 1e-6 * scale), None)
    if point is None:
        return None
    last = int(np.searchsorted(solution.time, stop, side="right")) - 1
    if last < 1 or solution.time[last - 1] < begin or begin > stop:
        return float(max(towards[last, point], 0.0))
    slope = (towards[last, point] - towards[last - 1, point]) / (
        solution.time[last] - solution.time[last - 1]
    )
    return float(max(towards[last, point] + slope * (stop - solution.time[last]), 0.0))
