"""Motion of the wire at the ends of coils 1 and 2 in the quantities of the beehive study: its nodes
1 and 2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from valvetrain.quantities.cycle import Array, Cycle
from valvetrain.quantities.signal import separate_spikes
from valvetrain.solution.study import LiftEvent
from valvetrain.sources.gu2021_stages import covers_stage, in_stage


def coils_of(points: Sequence[tuple[str, float]]) -> dict[int, float]:
    """Coil numbers of nodes 1 and 2: the ends of coils 1 and 2, or where the case's ``points`` say."""
    told = dict(points)
    return {node: told.get(f"node_{node}", float(node)) for node in (1, 2)}


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
