"""Motion of two points of the wire, and collisions of coils 1 and 2, as the beehive study (gu2021)
counts them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.clash import runs
from valvetrain.quantities.cycle import Array, Cycle
from valvetrain.quantities.signal import separate_spikes
from valvetrain.solution.study import LiftEvent
from valvetrain.sources.gu2021_reading import SAMPLE
from valvetrain.sources.gu2021_stages import covers_stage, in_stage

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
    ``separation`` (rad) after the touch before it. A model without gaps has none.
    """
    gaps = _where_coils_meet(cycle, "coil_gap")
    if gaps is None:
        return np.zeros(0)
    closing = (gaps < TOUCHING) & (np.roll(gaps, 1, axis=0) >= TOUCHING)
    if not cycle.whole:
        closing[0] = False
    angles = cycle.cam_angle[np.any(closing, axis=1)]
    first = np.ones(len(angles), dtype=bool)
    first[1:] = np.diff(angles) > separation
    return angles[first]


def _where_coils_meet(cycle: Cycle, channel: str) -> Array | None:
    """A channel of coil pairs over the meeting stretch (sample, pair), None where a model has none there."""
    if not cycle.solution.has(channel):
        return None
    places = cycle.solution.arrays.coords["upper_coil"].values
    mine = (places > MEETING[0] + 1e-9) & (places <= MEETING[1] + 1e-9)
    return cycle.channel(channel)[:, mine] if np.any(mine) else None


def _touched(cycle: Cycle) -> NDArray[np.bool_] | None:
    """Whether each pair of the meeting stretch touched at a sample or since the one before (sample,
    pair): contacts may be shorter than a sample. None where a model has no gaps there.
    """
    gaps, forces = (
        _where_coils_meet(cycle, "coil_gap"),
        _where_coils_meet(cycle, "coil_contact_force"),
    )
    if gaps is None:
        return None
    touched = gaps < TOUCHING
    touched[1:] |= touched[:-1]
    return touched if forces is None else touched | (forces > 0)


def collision_quantities(
    cycle: Cycle,
    separation: float,
    surge_frequency: float | None,
    event: LiftEvent | None,
    spike_angle: float | None = None,
) -> dict[str, float]:
    """Angles of the collisions, their mean distance outside Stage II, that distance over the first
    mode's period, and the bounce after the spike at ``spike_angle`` (rad).
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
    if spike_angle is None:
        return found
    return found | bounce_quantities(cycle, spike_angle, separation)


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


def bounce_quantities(cycle: Cycle, spike_angle: float, separation: float) -> dict[str, float]:
    """Contact, separation and contact again in the collision whose spike is at ``spike_angle`` (rad).

    Of the points within half a turn of node 2 that touch within a sample of the source of that
    angle, that meet, leave and meet again within ``separation`` (rad) each, the one that is pressed
    hardest there (where no force is known, the deepest): from the sample at which it meets the coil
    below to the one at which it meets it again after a sample apart. The source counts so: at 8000
    rpm from 253.5 degrees, where coils touch, with the spike at 254.5, to 255.5.
    """
    gaps, touched = _where_coils_meet(cycle, "coil_gap"), _touched(cycle)
    near = np.abs(cycle.cam_angle - spike_angle) <= SAMPLE * (1 + 1e-9)
    if gaps is None or touched is None or not np.any(near):
        return {}
    pressed = _where_coils_meet(cycle, "coil_contact_peak_force")
    hardest = (-gaps if pressed is None else pressed)[near].max(axis=0)
    found: list[tuple[float, int, int]] = []
    for pair in range(touched.shape[1]):
        for (first, last), (again, _) in pairwise(runs(touched[:, pair])):
            meets, leaves, comes = cycle.cam_angle[[first, last, again]] - spike_angle
            if (
                np.any(near[first : last + 1])
                and meets >= -separation
                and leaves <= separation
                and comes - leaves <= separation
            ):
                found.append((float(hardest[pair]), first, again))
    if not found:
        return {}
    _, first, again = max(found)
    return {
        "coil_1_2_bounce_start_cam_angle": float(cycle.cam_angle[first]),
        "coil_1_2_bounce_end_cam_angle": float(cycle.cam_angle[again]),
        "coil_1_2_bounce_duration": float(cycle.time[again] - cycle.time[first]),
    }


def coils_of(points: Sequence[tuple[str, float]]) -> dict[int, float]:
    """Coil numbers of nodes 1 and 2: those of the case's ``points``, by default the ends of coils 1
    and 2.
    """
    given = dict(points)
    return {node: given.get(f"node_{node}", float(node)) for node in (1, 2)}


def displacement_quantities(
    cycle: Cycle, event: LiftEvent | None, coil: float = 2.0
) -> dict[str, float]:
    """Displacement of node 2 (at ``coil``), zero where coil 2 touches coil 1 (m), and the closing
    of these coils in Stage II.
    """
    found: dict[str, float] = {}
    lift_off = cycle.at_coil("coil_gap", coil)
    if lift_off is not None and np.all(np.isfinite(lift_off)):
        top = int(np.argmax(lift_off))
        found["node_2_maximum_displacement"] = float(lift_off[top])
        found["node_2_maximum_displacement_cam_angle"] = float(cycle.cam_angle[top])
        if event is not None and covers_stage(cycle, event, 1):
            early = lift_off[in_stage(cycle, event, 1)]
            found["node_2_stage_1_maximum_displacement"] = float(np.max(early))
            found["node_2_stage_1_displacement_range"] = float(np.ptp(early))
    moved, force = (
        cycle.at_coil("axial_displacement", coil),
        cycle.at_coil("coil_contact_force", coil),
    )
    if event is not None and moved is not None and force is not None:
        closing = np.flatnonzero(in_stage(cycle, event, 2) & (force > 0))
        if len(closing):
            found["node_2_contact_displacement"] = float(-moved[closing[0]])
    return found


def velocity_quantities(
    cycle: Cycle, event: LiftEvent | None, coil: float = 2.0
) -> dict[str, float]:
    """Extremes of the velocity of node 2 (at ``coil``; m/s) by stage, its rebound after the main
    collision and what follows.
    """
    velocity = cycle.at_coil("axial_velocity", coil)
    if velocity is None or event is None:
        return {}
    found: dict[str, float] = {}
    for stage in (1, 2, 3):
        if not covers_stage(cycle, event, stage):
            continue
        inside = np.flatnonzero(in_stage(cycle, event, stage))
        for word, pick in (("minimum", np.argmin), ("maximum", np.argmax)):
            index = inside[int(pick(velocity[inside]))]
            found[f"node_2_stage_{stage}_{word}_velocity"] = float(velocity[index])
            found[f"node_2_stage_{stage}_{word}_velocity_cam_angle"] = float(cycle.cam_angle[index])
    if "node_2_stage_1_maximum_velocity" in found:
        found["node_2_stage_1_velocity_range"] = (
            found["node_2_stage_1_maximum_velocity"] - found["node_2_stage_1_minimum_velocity"]
        )
    if "node_2_stage_3_minimum_velocity" in found:
        found |= _rebound(cycle, velocity, event)
    return found


def _rebound(cycle: Cycle, velocity: Array, event: LiftEvent) -> dict[str, float]:
    inside = np.flatnonzero(in_stage(cycle, event, 3))
    lowest = inside[int(np.argmin(velocity[inside]))]
    after = velocity[lowest:]
    falling = np.flatnonzero(np.diff(after) < 0)
    if len(falling) == 0:
        return {}
    highest = lowest + int(falling[0])
    late = velocity[highest:]
    return {
        "node_2_rebound_velocity": float(velocity[highest]),
        "node_2_rebound_velocity_cam_angle": float(cycle.cam_angle[highest]),
        "node_2_rebound_duration": float(cycle.time[highest] - cycle.time[lowest]),
        "node_2_late_stage_3_minimum_velocity": float(np.min(late)),
        "node_2_late_stage_3_maximum_velocity": float(np.max(late)),
    }


def acceleration_quantities(
    cycle: Cycle, separation: float, coils: Mapping[int, float]
) -> dict[str, float]:
    """Largest accelerations of nodes 1 and 2 (at ``coils``; m/s2), signed, of separate collisions,
    with their angles.
    """
    found: dict[str, float] = {}
    for node, coil in coils.items():
        values = cycle.at_coil("axial_acceleration", coil)
        if values is None:
            continue
        spikes = separate_spikes(cycle.cam_angle, np.abs(values), separation, 0.0)
        for word, index in zip(("peak", "second_peak", "third_peak"), spikes, strict=False):
            found[f"node_{node}_{word}_acceleration"] = float(values[index])
            found[f"node_{node}_{word}_acceleration_cam_angle"] = float(cycle.cam_angle[index])
    return found
