"""Modes of a train followed from the closed valve to full lift: from one lift to the next each mode
continues in the one whose shape overlaps it most, whatever their frequencies do in between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from valvetrain.arrays import Array, Ints
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.solution.modes import TrainModes
from valvetrain.system.train_modes import eigen_at, modes_from
from valvetrain.system.train_system import TrainSystem

#: Lifts over the full one at which modes are looked at on the way; springs whose rest takes long are
#: followed in one step.
LIFTS = (0.01, 0.05, 0.2, 0.5, 0.8)


def continued(before: Array, after: Array) -> tuple[Ints, Array]:
    """For each mode ``after`` the mode ``before`` (both (unknown, mode), of unit length) that it continues
    from, each once, and their overlap: squared cosine between the shapes, weighted by mass.
    """
    overlap = (before.T @ after) ** 2
    first, second = linear_sum_assignment(-overlap)
    from_mode = np.empty(len(first), dtype=np.int64)
    from_mode[second] = first
    return from_mode, overlap[from_mode, np.arange(len(first))]


def modes_to_full_lift(
    system: TrainSystem,
    installed: Sequence[InstalledSpring],
    closed: float,
    full_lift: float,
    label: str = "",
) -> tuple[TrainModes, TrainModes]:
    """Modes at cam angles (rad) of the closed valve and of full lift; those at full lift say which
    mode of the closed valve each continues, and the least overlap on the way.

    Raises :class:`InputError` for a train that comes to no rest.
    """
    first = eigen_at(system, installed, closed)
    here, from_mode = first, np.arange(len(first.values))
    least = np.ones(len(first.values))
    for cam_angle in (*_on_the_way(system, closed, full_lift), full_lift):
        following = eigen_at(system, installed, cam_angle)
        step, overlap = continued(here.vectors, following.vectors)
        from_mode, least = from_mode[step], np.minimum(least[step], overlap)
        here = following
    lifted = modes_from(system, here, full_lift, "full_lift", label)
    return modes_from(system, first, closed, "closed", label), replace(
        lifted, closed_mode=tuple(from_mode.tolist()), overlap=tuple(least.tolist())
    )


def _on_the_way(system: TrainSystem, closed: float, full_lift: float) -> list[float]:
    """Cam angles (rad) at :data:`LIFTS` on the side that opens; none for springs whose rest takes long."""
    if system.has_large_springs:
        return []
    opening = np.linspace(closed, closed + (full_lift - closed) % (2 * np.pi), 721)
    lift = np.maximum.accumulate(system.mechanism.kinematics.valve_lift(opening))
    if not lift[-1] > 0:
        return []
    return [float(opening[np.searchsorted(lift, share * lift[-1])]) for share in LIFTS]
