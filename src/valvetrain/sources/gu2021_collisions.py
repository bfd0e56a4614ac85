"""Collisions of coil 2 with coil 1 as the beehive study counts them: when they meet, how regularly,
and how they bounce.
"""

from __future__ import annotations

import numpy as np

from valvetrain.integrate.clash import runs
from valvetrain.quantities.cycle import Array, Cycle
from valvetrain.solution.study import LiftEvent

#: Gap (m) below which coils count as touching; contact stiffness lets them overlap by less than
#: this.
TOUCHING = 1e-6
#: Half a turn of wire (coil numbers) either side of node 2; where in it the coils meet depends on
#: how far coil 2 rests on coil 1.
MEETING = (1.5, 2.5)
#: Contacts closer than this share of the period of the first mode belong to one collision.
SEPARATION_SHARE = 0.35
#: The same as a cam angle (rad) where no natural frequency is known.
DEFAULT_SEPARATION = np.radians(8.0)


def separation_angle(cycle: Cycle, surge_frequency: float | None) -> float:
    """Least distance (cam rad) of two collisions; ``surge_frequency`` in Hz."""
    if not surge_frequency:
        return float(DEFAULT_SEPARATION)
    return SEPARATION_SHARE * cycle.solution.engine_speed / 2 / surge_frequency


def collision_angles(cycle: Cycle, separation: float) -> Array:
    """Cam angles (rad, ascending) at which coil 2 meets coil 1.

    A collision is a touch of any point within half a turn of node 2 that comes more than
    ``separation`` (rad) after the touch
    before it. A model without gaps has none.
    """
    gaps = _meeting_gaps(cycle)
    if gaps is None:
        return np.zeros(0)
    closing = (gaps < TOUCHING) & (np.roll(gaps, 1, axis=0) >= TOUCHING)
    if not cycle.whole:
        closing[0] = False
    angles = cycle.cam_angle[np.any(closing, axis=1)]
    first = np.ones(len(angles), dtype=bool)
    first[1:] = np.diff(angles) > separation
    return angles[first]


def _meeting_gaps(cycle: Cycle) -> Array | None:
    """Gaps (m; sample, pair) over the meeting stretch, or None where a model has none there."""
    if not cycle.solution.has("coil_gap"):
        return None
    places = cycle.solution.arrays.coords["upper_coil"].values
    mine = (places > MEETING[0] + 1e-9) & (places <= MEETING[1] + 1e-9)
    return cycle.channel("coil_gap")[:, mine] if np.any(mine) else None


def collision_quantities(
    cycle: Cycle, separation: float, surge_frequency: float | None, event: LiftEvent | None
) -> dict[str, float]:
    """Angles of the collisions, their mean distance outside Stage II, that distance over the first
    mode's period, the bounce.
    """
    angles = collision_angles(cycle, separation)
    found = {
        f"clash_{number}_cam_angle": float(angle) for number, angle in enumerate(angles, start=1)
    }
    if event is None:
        return found
    interval = mean_interval(angles, event)
    if interval is not None:
        found["clash_interval_cam_angle"] = interval
        if surge_frequency:
            period = (
                cycle.solution.engine_speed / 2 / surge_frequency
            )  # cam rad per period of the first mode
            found["clash_interval_to_mode_1_period_ratio"] = interval / period
    late = angles[angles >= event.end]
    return found | (bounce_quantities(cycle, float(late[0]), separation) if len(late) else {})


def mean_interval(clash_angles: Array, event: LiftEvent) -> float | None:
    """Mean distance (rad) of successive collisions within Stage I and within Stage III; a missed
    one is left out.
    """
    first, second = (
        clash_angles[clash_angles < event.start],
        clash_angles[clash_angles >= event.end],
    )
    steps = np.concatenate((np.diff(first), np.diff(second)))
    if len(steps) == 0:
        return None
    return float(np.mean(steps[steps <= 1.5 * np.median(steps)]))


def bounce_quantities(cycle: Cycle, collision_angle: float, separation: float) -> dict[str, float]:
    """Contact, separation and contact again after the collision at ``collision_angle`` (rad).

    The longest separation of any point within half a turn of node 2 that begins within
    ``separation`` (rad) after it and ends
    within another; nothing where no point leaves again.
    """
    gaps = _meeting_gaps(cycle)
    if gaps is None:
        return {}
    apart: list[tuple[float, int, int]] = []
    for pair in range(gaps.shape[1]):
        for first, last in runs(gaps[:, pair] >= TOUCHING):
            if first == 0 or last == len(gaps) - 1:
                continue
            start, end = cycle.cam_angle[first], cycle.cam_angle[last + 1]
            if (
                collision_angle < start <= collision_angle + separation
                and end <= collision_angle + 2 * separation
            ):
                apart.append((float(end - start), first, last + 1))
    if not apart:
        return {}
    _, first, last = max(apart)
    return {
        "coil_1_2_bounce_start_cam_angle": float(cycle.cam_angle[first]),
        "coil_1_2_bounce_end_cam_angle": float(cycle.cam_angle[last]),
        "coil_1_2_bounce_duration": float(cycle.time[last] - cycle.time[first]),
    }
