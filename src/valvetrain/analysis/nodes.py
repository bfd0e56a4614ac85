"""Motion of the wire at the ends of coils 1 and 2, and the collisions seen in it."""

from __future__ import annotations

import numpy as np

from valvetrain.analysis.cycle import Array, Cycle
from valvetrain.analysis.peaks import separate_spikes
from valvetrain.analysis.stages import Stages

#: A collision shows as an acceleration of at least this share of the largest in the cycle.
SPIKE_SHARE = 0.10
#: Spikes closer than this share of the period of the first mode belong to one collision.
SEPARATION_SHARE = 0.35
#: The same as a cam angle (rad) where no natural frequency is known.
DEFAULT_SEPARATION = np.radians(8.0)


def separation_angle(cycle: Cycle, surge_frequency: float | None) -> float:
    """Least distance (cam rad) of two collisions; ``surge_frequency`` in Hz."""
    if not surge_frequency:
        return float(DEFAULT_SEPARATION)
    cam_speed = cycle.solution.engine_speed / 2
    return SEPARATION_SHARE * cam_speed / surge_frequency


def displacement_quantities(cycle: Cycle, stages: Stages = Stages()) -> dict[str, float]:
    """Displacement of node 2, zero where coil 2 touches coil 1 (m), and the closing of these coils in Stage II."""
    found: dict[str, float] = {}
    lift_off = cycle.at_coil("coil_gap", 2.0)
    if lift_off is not None and np.all(np.isfinite(lift_off)):
        top = int(np.argmax(lift_off))
        found["node_2_maximum_displacement"] = float(lift_off[top])
        found["node_2_maximum_displacement_cam_angle"] = float(cycle.cam_angle[top])
        if cycle.covers(*stages.bounds(1)):
            early = lift_off[cycle.window(*stages.bounds(1))]
            found["node_2_stage_1_maximum_displacement"] = float(np.max(early))
            found["node_2_stage_1_displacement_range"] = float(np.ptp(early))
    moved, force = cycle.at_coil("axial_displacement", 2.0), cycle.at_coil("coil_contact_force", 2.0)
    if moved is not None and force is not None:
        closing = np.flatnonzero(cycle.window(*stages.bounds(2)) & (force > 0))
        if len(closing):
            found["node_2_contact_displacement"] = float(-moved[closing[0]])
    return found


def velocity_quantities(cycle: Cycle, stages: Stages = Stages()) -> dict[str, float]:
    """Extremes of the velocity of node 2 (m/s) by stage, its rebound after the main collision and what follows."""
    velocity = cycle.at_coil("axial_velocity", 2.0)
    if velocity is None:
        return {}
    found: dict[str, float] = {}
    for stage in (1, 2, 3):
        if not cycle.covers(*stages.bounds(stage)):
            continue
        inside = np.flatnonzero(cycle.window(*stages.bounds(stage)))
        for word, pick in (("minimum", np.argmin), ("maximum", np.argmax)):
            index = inside[int(pick(velocity[inside]))]
            found[f"node_2_stage_{stage}_{word}_velocity"] = float(velocity[index])
            found[f"node_2_stage_{stage}_{word}_velocity_cam_angle"] = float(cycle.cam_angle[index])
    if "node_2_stage_1_maximum_velocity" in found:
        found["node_2_stage_1_velocity_range"] = found["node_2_stage_1_maximum_velocity"] - found["node_2_stage_1_minimum_velocity"]
    if "node_2_stage_3_minimum_velocity" in found:
        found |= _rebound(cycle, velocity, stages)
    return found


def _rebound(cycle: Cycle, velocity: Array, stages: Stages) -> dict[str, float]:
    inside = np.flatnonzero(cycle.window(*stages.bounds(3)))
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


def acceleration_quantities(cycle: Cycle, separation: float) -> dict[str, float]:
    """Largest accelerations of nodes 1 and 2 (m/s2), signed, of separate collisions, with their angles."""
    found: dict[str, float] = {}
    for node in (1, 2):
        values = cycle.at_coil("axial_acceleration", float(node))
        if values is None:
            continue
        spikes = separate_spikes(cycle.cam_angle, np.abs(values), separation, 0.0)
        for word, index in zip(("peak", "second_peak", "third_peak"), spikes, strict=False):
            found[f"node_{node}_{word}_acceleration"] = float(values[index])
            found[f"node_{node}_{word}_acceleration_cam_angle"] = float(cycle.cam_angle[index])
    return found


def collision_angles(cycle: Cycle, separation: float) -> Array:
    """Cam angles (rad, ascending) of the collisions of coils 1 and 2, seen as spikes of the acceleration of node 2."""
    values = cycle.at_coil("axial_acceleration", 2.0)
    if values is None or not np.any(values):
        return np.zeros(0)
    size = np.abs(values)
    return np.sort(cycle.cam_angle[separate_spikes(cycle.cam_angle, size, separation, SPIKE_SHARE * float(np.max(size)))])


def collision_quantities(cycle: Cycle, separation: float, surge_frequency: float | None, stages: Stages = Stages()) -> dict[str, float]:
    """Angles of the collisions, their mean distance outside Stage II, and that distance over the first mode's period."""
    angles = collision_angles(cycle, separation)
    found = {f"clash_{number}_cam_angle": float(angle) for number, angle in enumerate(angles, start=1)}
    interval = mean_interval(angles, stages)
    if interval is None:
        return found
    found["clash_interval_cam_angle"] = interval
    if surge_frequency:
        period = cycle.solution.engine_speed / 2 / surge_frequency  # cam rad per period of the first mode
        found["clash_interval_to_mode_1_period_ratio"] = interval / period
    return found


def mean_interval(angles: Array, stages: Stages = Stages()) -> float | None:
    """Mean distance (rad) of successive collisions within Stage I and within Stage III; a missed one is left out."""
    first, second = angles[angles < stages.first_end], angles[angles >= stages.second_end]
    steps = np.concatenate((np.diff(first), np.diff(second)))
    if len(steps) == 0:
        return None
    return float(np.mean(steps[steps <= 1.5 * np.median(steps)]))
