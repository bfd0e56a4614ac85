"""What happens in one closed cycle of a train: loft, float, loss of contact, seating, bounce, each with its cause."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.clash import runs
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.solution.event import Detail, Event
from valvetrain.solution.result import Solution

Array = NDArray[np.float64]
TURN = 2 * np.pi

SMALLEST_GAP = 2e-6
"""Gaps below this (m) are vibration of a contact, not an event."""

#: Place whose gap can open while the valve should be driven -> kind of that event.
PLACES = {"cam": "loft", "tappet": "loss-of-contact", "rocker": "loss-of-contact", "valve_tip": "loss-of-contact"}
CAUSE_INERTIA = "inertia exceeds the spring force (rigid theory loses contact here too)"
CAUSE_SURGE = "surge lowers the spring force below its static value"
CAUSE_VIBRATION = "vibration of the train unloads the contact"
#: Closings of contacts that the integrator logged are read and not kept.
LOGGED = ("touch",)


@dataclass(frozen=True, eq=False)
class RigidCycle:
    """Rigid motion at the samples of a run (S,): lift (m), acceleration (m/s2), contact force at the cam (N)."""

    valve_lift: Array
    valve_acceleration: Array
    contact_force: Array


def rigid_cycle(solution: Solution, rigid: RigidTable) -> RigidCycle:
    """The rigid table, which may have any number of samples, at the cam angles of a run."""
    names = ("valve_lift", "valve_acceleration", "contact_force")
    return RigidCycle(*(np.interp(solution.cam_angle, rigid.cam_angle, rigid[name], period=TURN) for name in names))


def train_events(solution: Solution, rigid: RigidCycle) -> tuple[Event, ...]:
    """All events of one closed cycle but clashes, in order of cam angle."""
    found = [*_contact_losses(solution, rigid), *_floats(solution, rigid), *_seatings_and_bounces(solution)]
    return tuple(sorted(found, key=lambda event: event.cam_angle))


def _contact_losses(solution: Solution, rigid: RigidCycle) -> list[Event]:
    """Loft at the cam and losses of contact elsewhere while the rigid valve is open; size is the largest gap (m)."""
    found = []
    for place, kind in PLACES.items():
        if not solution.has(f"{place}_gap"):
            continue
        gap, force = solution.channel(f"{place}_gap"), solution.channel(f"{place}_contact_force")
        for start, last_open in runs((gap > SMALLEST_GAP) & (rigid.valve_lift > 0), ring=True):
            length = last_open - start + 1
            window = _window(start, length, len(gap))
            details: dict[str, Detail] = {
                "cause": _cause(solution, rigid, window), "landing_cam_angle": float(solution.cam_angle[window[-1]]),
                "landing_force": float(np.max(force[_window(int(window[-1]), 8, len(gap))])),
            }  # fmt: skip
            found.append(_event(solution, kind, start, length, float(np.max(gap[window])), "m", place.replace("_", " "), details))
    return found


def _floats(solution: Solution, rigid: RigidCycle) -> list[Event]:
    """Loss of control over the nose: the valve runs above its rigid lift with the train open; size is the excess lift (m)."""
    gaps = [solution.channel(f"{place}_gap") > SMALLEST_GAP for place in PLACES if solution.has(f"{place}_gap")]
    if not gaps:
        return []
    nose = (rigid.valve_lift > 0.3 * np.max(rigid.valve_lift)) & (rigid.valve_acceleration < 0)
    excess = solution.channel("valve_lift") - rigid.valve_lift
    found = []
    for start, last_open in runs(np.any(gaps, axis=0) & nose & (excess > 10 * SMALLEST_GAP), ring=True):
        length = last_open - start + 1
        window = _window(start, length, len(excess))
        details: dict[str, Detail] = {"cause": _cause(solution, rigid, window)}
        found.append(_event(solution, "float", start, length, float(np.max(excess[window])), "m", "valve", details))
    return found


@dataclass(frozen=True)
class _Opening:
    """The valve off its seat once: release and touch (cam rad), closing velocity (m/s), height (m)."""

    release: float
    touch: float
    velocity: float
    height: float


def _seatings_and_bounces(solution: Solution) -> list[Event]:
    """Every touch of the seat with its velocity (m/s) and which one it is, and every bounce with its height (m)."""
    kept = [event for event in solution.events if event.kind in ("seating", "bounce")]
    if kept:  # found by an evaluation before this one, from what the integrator saw
        return kept
    openings = _logged_openings(solution) or _sampled_openings(solution)
    main, found = max(range(len(openings)), key=lambda k: openings[k].height, default=0), []
    for turn in range(len(openings)):
        one = openings[(main + turn) % len(openings)]
        touch: dict[str, Detail] = {"touch": turn + 1, "cause": "end of the closing flank" if turn == 0 else "end of a bounce"}
        touch["release_cam_angle"] = one.release
        found.append(Event("seating", one.touch, _time_at(solution, one.touch), 0.0, one.velocity, "m/s", "seat", touch))
        if turn > 0:
            length = (one.touch - one.release) % TURN
            window = _between(solution, one.release, length)
            force, static = (float(np.mean(solution.channel(name)[window])) for name in ("retainer_force", "static_retainer_force"))
            slack = force / max(static, 1e-9)
            reason = "rebound from the seat" if slack > 0.8 else f"rebound with the spring force down to {slack:.0%} by surge"
            details: dict[str, Detail] = {"bounce": turn, "cause": reason}
            start, lasts = _time_at(solution, one.release), length / TURN * _period(solution)
            found.append(Event("bounce", one.release, start, lasts, one.height, "m", "seat", details))
    return found


def _logged_openings(solution: Solution) -> list[_Opening]:
    """As the integrator saw them on every step: the same for any number of samples."""
    return [
        _Opening(float(event.details["release_cam_angle"]), event.cam_angle, event.size, height)
        for event in solution.events
        if event.kind == "touch" and event.where == "seat" and (height := float(event.details["largest_gap"])) > SMALLEST_GAP
    ]


def _sampled_openings(solution: Solution) -> list[_Opening]:
    """From the samples, of a run without such a log: from the last two before the touch the valve goes on, straight in velocity.

    Second order, and free of what the blow did to the velocity after it.
    """
    lift = solution.channel("valve_lift")
    gap = solution.channel("seat_gap" if solution.has("seat_gap") else "valve_lift")
    angle, rate, count = solution.cam_angle, solution.channel("valve_velocity"), len(lift)
    step, seconds, found = float(angle[1] - angle[0]), float(solution.time[1] - solution.time[0]), []
    for start, last_open in runs(lift > SMALLEST_GAP, ring=True):
        length = last_open - start + 1
        if length == count:
            return []
        last, before = (start + length - 1) % count, (start + length - 2) % count
        speed = float(-rate[last])
        ahead = float(np.clip(gap[last] / speed, 0.0, 2 * seconds)) if speed > 0 else seconds
        velocity = speed + float(rate[before] - rate[last]) * ahead / seconds
        height = float(np.max(lift[_window(start, length, count)]))
        found.append(_Opening(float(angle[start]), float(angle[last]) + ahead * step / seconds, velocity, height))
    return found


def _between(solution: Solution, release: float, length: float) -> NDArray[np.int64]:
    """Samples of the open stretch; the nearest one where it is shorter than their interval."""
    angle = solution.cam_angle
    inside = np.flatnonzero((angle - release) % TURN <= length)
    return inside if len(inside) else np.array([np.argmin(np.abs((angle - release + np.pi) % TURN - np.pi))])


def _period(solution: Solution) -> float:
    return len(solution.time) * float(solution.time[1] - solution.time[0])


def _time_at(solution: Solution, angle: float) -> float:
    rate = (solution.cam_angle[1] - solution.cam_angle[0]) / (solution.time[1] - solution.time[0])
    return float(solution.time[0] + (angle - solution.cam_angle[0]) / rate)


def _cause(solution: Solution, rigid: RigidCycle, window: NDArray[np.int64]) -> str:
    first = window[: max(1, len(window) // 4)]
    if np.min(rigid.contact_force[window]) <= 0:
        return CAUSE_INERTIA
    if np.mean(solution.channel("retainer_force")[first]) < 0.9 * np.mean(solution.channel("static_retainer_force")[first]):
        return CAUSE_SURGE
    return CAUSE_VIBRATION


def _window(start: int, length: int, count: int) -> NDArray[np.int64]:
    return np.arange(start, start + max(length, 1)) % count


def _event(solution: Solution, kind: str, start: int, length: int, size: float, unit: str, where: str, details: dict[str, Detail]) -> Event:
    place, step = start % len(solution.time), float(solution.time[1] - solution.time[0])
    return Event(kind, float(solution.cam_angle[place]), float(solution.time[place]), length * step, size, unit, where, details)
