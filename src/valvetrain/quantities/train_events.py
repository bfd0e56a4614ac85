"""What happens in one closed cycle of a train: loft, float, loss of contact, seating, bounce, each with its cause."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
#: Kinds that this module finds; contact transitions that the integrator logged are read and not kept.
FOUND = (*dict.fromkeys(PLACES.values()), "float", "seating", "bounce")
LOGGED = ("touch", "release")


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


def intervals(flag: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Runs of True on a ring as (start, length); one run of the whole length when all are True."""
    count = len(flag)
    if np.all(flag):
        return [(0, count)]
    starts = np.flatnonzero(flag & ~np.roll(flag, 1))
    stops = np.flatnonzero(~flag & np.roll(flag, 1))
    found = []
    for start in starts:
        later = stops[stops > start]
        found.append((int(start), int((later[0] if len(later) else stops[0] + count) - start)))
    return found


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
        for start, length in intervals((gap > SMALLEST_GAP) & (rigid.valve_lift > 0)):
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
    for start, length in intervals(np.any(gaps, axis=0) & nose & (excess > 10 * SMALLEST_GAP)):
        window = _window(start, length, len(excess))
        details: dict[str, Detail] = {"cause": _cause(solution, rigid, window)}
        found.append(_event(solution, "float", start, length, float(np.max(excess[window])), "m", "valve", details))
    return found


def _seatings_and_bounces(solution: Solution) -> list[Event]:
    """Every touch of the seat with its velocity (m/s) and which one it is, and every bounce with its height (m)."""
    lift = solution.channel("valve_lift")
    count, runs = len(lift), intervals(lift > SMALLEST_GAP)
    if not runs or (len(runs) == 1 and runs[0][1] == count):
        return []
    main, found = max(range(len(runs)), key=lambda place: runs[place][1]), []
    for turn in range(len(runs)):
        start, length = runs[(main + turn) % len(runs)]
        window = _window(start, length, count)
        angle, velocity, logged = _landing(solution, start + length)
        touch: dict[str, Detail] = {"touch": turn + 1, "cause": "end of the closing flank" if turn == 0 else "end of a bounce"}
        touch |= {"every_step": True} if logged else {}
        found.append(Event("seating", angle, _time_at(solution, angle), 0.0, velocity, "m/s", "seat", touch))
        if turn > 0:
            force, static = (float(np.mean(solution.channel(name)[window])) for name in ("retainer_force", "static_retainer_force"))
            slack = force / max(static, 1e-9)
            reason = "rebound from the seat" if slack > 0.8 else f"rebound with the spring force down to {slack:.0%} by surge"
            details: dict[str, Detail] = {"bounce": turn, "cause": reason}
            found.append(_event(solution, "bounce", start, length, float(np.max(lift[window])), "m", "seat", details))
    return found


def _logged_touches(solution: Solution) -> list[tuple[float, float]]:
    """Cam angle (rad) and closing velocity (m/s) of the seat's touches that the integrator saw, or an evaluation before this one kept."""
    logged = [event for event in solution.events if event.kind == "touch" and event.details.get("interaction") == "seat"]
    kept = [event for event in solution.events if event.kind == "seating" and event.details.get("every_step")]
    return [(event.cam_angle, -float(event.details["gap_rate"])) for event in logged] + [(event.cam_angle, event.size) for event in kept]


def _landing(solution: Solution, touch: int) -> tuple[float, float, bool]:
    """Cam angle (rad) and closing velocity (m/s) where the valve meets its seat, ``touch`` being the first sample on it; whether logged.

    The truth is the integrator's log of contacts. Without one the valve goes on from the two samples before the touch, straight in
    velocity, to the seat: second order, and free of what the blow did to the velocity after it.
    """
    count, gap = len(solution.time), solution.channel("seat_gap" if solution.has("seat_gap") else "valve_lift")
    angle, rate = solution.cam_angle, solution.channel("valve_velocity")
    step, seconds = float(angle[1] - angle[0]), float(solution.time[1] - solution.time[0])
    at = float(angle[0]) + touch * step
    near = [(abs((place - at + np.pi) % TURN - np.pi), place, velocity) for place, velocity in _logged_touches(solution)]
    distance, place, velocity = min(near, default=(np.inf, 0.0, 0.0))
    if distance < 6 * step:
        return place, velocity, True
    last, before = (touch - 1) % count, (touch - 2) % count
    speed = float(-rate[last])
    ahead = float(np.clip(gap[last] / speed, 0.0, 2 * seconds)) if speed > 0 else seconds
    return float(angle[last]) + ahead * step / seconds, speed + float(rate[before] - rate[last]) * ahead / seconds, False


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
