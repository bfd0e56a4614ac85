"""What happens in one cam cycle of a train: loft, float, loss of contact, seating, bounce, clash, each with its cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.solution.event import Detail, Event

Array = NDArray[np.float64]
TURN = 2 * np.pi

SMALLEST_GAP = 2e-6
"""Gaps below this (m) are vibration of a contact, not an event."""

PLACES = {"cam": "loft", "tappet": "loss-of-contact", "rocker": "loss-of-contact", "valve tip": "loss-of-contact"}
CAUSE_INERTIA = "inertia exceeds the spring force (rigid theory loses contact here too)"
CAUSE_SURGE = "surge lowers the spring force below its static value"
CAUSE_VIBRATION = "vibration of the train unloads the contact"
CAUSE_LASH = "lash is open on the base circle"


@dataclass(frozen=True)
class CycleData:
    """One periodic cycle on S samples: what the event search reads. SI units.

    ``cam_angle`` (S,) rad from 0; ``valve_lift``, ``valve_velocity``, ``rigid_lift`` (S,); ``gaps``, ``forces`` place -> (S,) (gap open
    positive); ``rigid_force`` (S,): contact force of rigid theory at the cam; ``spring_force``, ``static_spring_force`` (S,).
    """

    cam_angle: Array
    cam_speed: float
    valve_lift: Array
    valve_velocity: Array
    rigid_lift: Array
    rigid_acceleration: Array
    gaps: dict[str, Array]
    forces: dict[str, Array]
    rigid_force: Array
    spring_force: Array
    static_spring_force: Array


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


def find_events(data: CycleData) -> tuple[Event, ...]:
    """All events of one cycle in order of cam angle."""
    found = [*contact_losses(data), *floats(data), *seatings_and_bounces(data)]
    return tuple(sorted(found, key=lambda event: event.cam_angle))


def contact_losses(data: CycleData) -> list[Event]:
    """Loft at the cam and losses of contact elsewhere while the rigid valve is open; size is the largest gap (m)."""
    found = []
    opened = data.rigid_lift > 0
    for place, kind in PLACES.items():
        if place not in data.gaps:
            continue
        apart = (data.gaps[place] > SMALLEST_GAP) & opened
        for start, length in intervals(apart):
            window = _window(start, length, len(apart))
            size = float(np.max(data.gaps[place][window]))
            landing = window[-1]
            details: dict[str, Detail] = {
                "cause": _cause(data, window), "landing_cam_angle": float(data.cam_angle[landing]),
                "landing_force": float(np.max(data.forces[place][_window(landing, 8, len(apart))])),
            }  # fmt: skip
            found.append(_event(data, kind, start, length, size, "m", place, details))
    return found


def floats(data: CycleData) -> list[Event]:
    """Loss of control over the nose: the valve runs above its rigid lift with the train open; size is the excess lift (m)."""
    apart = np.zeros(len(data.cam_angle), dtype=bool)
    for place in PLACES:
        if place in data.gaps:
            apart |= data.gaps[place] > SMALLEST_GAP
    nose = (data.rigid_lift > 0.3 * np.max(data.rigid_lift)) & (data.rigid_acceleration < 0)
    excess = data.valve_lift - data.rigid_lift
    found = []
    for start, length in intervals(apart & nose & (excess > 10 * SMALLEST_GAP)):
        window = _window(start, length, len(apart))
        details: dict[str, Detail] = {"cause": _cause(data, window)}
        found.append(_event(data, "float", start, length, float(np.max(excess[window])), "m", "valve", details))
    return found


def seatings_and_bounces(data: CycleData) -> list[Event]:
    """Every touch of the seat with its velocity (m/s) and which one it is, and every bounce with its height (m)."""
    lifted = data.valve_lift > SMALLEST_GAP
    runs = intervals(lifted)
    if not runs or (len(runs) == 1 and runs[0][1] == len(lifted)):
        return []
    main = max(range(len(runs)), key=lambda place: runs[place][1])
    found = []
    for turn in range(len(runs)):
        start, length = runs[(main + turn) % len(runs)]
        window = _window(start, length, len(lifted))
        touch = (start + length) % len(lifted)
        velocity = float(np.min(data.valve_velocity[_window(touch - 3, 4, len(lifted))]))
        rebound: dict[str, Detail] = {"touch": turn + 1, "cause": "end of the closing flank" if turn == 0 else "end of a bounce"}
        found.append(_event(data, "seating", touch, 0, -velocity, "m/s", "seat", rebound))
        if turn > 0:
            height = float(np.max(data.valve_lift[window]))
            slack = float(np.mean(data.spring_force[window]) / max(float(np.mean(data.static_spring_force[window])), 1e-9))
            reason = "rebound from the seat" if slack > 0.8 else f"rebound with the spring force down to {slack:.0%} by surge"
            found.append(_event(data, "bounce", start, length, height, "m", "seat", {"bounce": turn, "cause": reason}))
    return found


def clash_events(
    cam_angle: Array, cam_speed: float, upper_coil: Array, contact_force: Array, where: str, resting: Array | None = None
) -> list[Event]:
    """Coil clashes of one spring: ``contact_force`` (S, pairs) in N; pairs that always touch are no clash. Size is the peak force (N).

    Neighbouring pairs that touch together are one event, told by the pair with the largest force.
    """
    touching = contact_force > 0
    moving = ~np.all(touching, axis=0)
    flag = np.any(touching[:, moving], axis=1) if np.any(moving) else np.zeros(len(cam_angle), dtype=bool)
    found, spacing = [], TURN / len(cam_angle) / cam_speed
    for start, length in intervals(flag):
        window = _window(start, length, len(cam_angle))
        block = contact_force[np.ix_(window, np.flatnonzero(moving))]
        total = block.sum(axis=1)
        pair = int(np.flatnonzero(moving)[int(np.argmax(block.max(axis=0)))])
        details: dict[str, Detail] = {
            "impulse": float(total.sum() * spacing), "upper_coil": float(upper_coil[pair]), "lower_coil": float(upper_coil[pair] - 1),
            "cause": "end coils come to rest as the spring closes" if length > len(cam_angle) // 12 else "coils meet under surge",
        }  # fmt: skip
        angle = float(cam_angle[start])
        found.append(Event("clash", angle, angle / cam_speed, length * spacing, float(total.max()), "N", where, details))
    return found


def _cause(data: CycleData, window: NDArray[np.int64]) -> str:
    first = window[: max(1, len(window) // 4)]
    if np.min(data.rigid_force[window]) <= 0:
        return CAUSE_INERTIA
    if np.mean(data.spring_force[first]) < 0.9 * np.mean(data.static_spring_force[first]):
        return CAUSE_SURGE
    return CAUSE_VIBRATION


def _window(start: int, length: int, count: int) -> NDArray[np.int64]:
    return np.arange(start, start + max(length, 1)) % count


def _event(data: CycleData, kind: str, start: int, length: int, size: float, unit: str, where: str, details: dict[str, Detail]) -> Event:
    angle = float(data.cam_angle[start % len(data.cam_angle)])
    duration = length * TURN / len(data.cam_angle) / data.cam_speed
    return Event(kind, angle, angle / data.cam_speed, duration, size, unit, where, details)


def of_kind(events: Sequence[Event], kind: str) -> tuple[Event, ...]:
    """The events of one kind."""
    return tuple(event for event in events if event.kind == kind)
