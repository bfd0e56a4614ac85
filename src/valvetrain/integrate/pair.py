"""Nested springs under prescribed motion: each runs alone, for they do not feel each other, and their forces add."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution

#: Channels of the motion, which is one for all springs, and those that add.
SHARED = ("valve_lift", "retainer_velocity", "retainer_acceleration")
ADDED = ("seat_force", "retainer_force", "work_done", "energy_dissipated", "kinetic_energy", "elastic_energy", "contact_energy")


def joined(parts: tuple[Solution, ...], names: tuple[str, ...], provenance: Provenance) -> Solution:
    """One solution of the springs ``names``: common channels once, added ones as the sum, the rest with the spring's name in front.

    The time of the first spring counts; the others are put on it (all run with the same samples). The worst status counts.
    """
    import xarray

    first = parts[0].channels
    count = min(len(part.time) for part in parts)
    if any(not np.allclose(part.time[:count], parts[0].time[:count], rtol=1e-9, atol=1e-12) for part in parts):
        raise InputError("the springs of a nested pair were sampled at different times; run them with one number of samples")
    data = {name: first[name][:count] for name in SHARED if name in first}
    for name in ADDED:
        if all(name in part.channels for part in parts):
            total = first[name][:count].copy()
            total.values = np.sum([part.channels[name].values[:count] for part in parts], axis=0)
            data[name] = total
    coords = {name: first[name][:count] for name in ("time", "cam_angle")}
    for part, spring in zip(parts, names, strict=True):
        renamed: dict[str, str] = {
            dim: f"{spring}_{dim}" for dim in ("wire_point", "coil_pair", "mode", "subsample") if dim in part.channels.dims
        }
        renamed |= {str(name): f"{spring}_{name}" for name in part.channels.coords if name not in ("time", "cam_angle")}
        own = part.channels.isel(sample=slice(0, count)).rename(renamed)
        data |= {f"{spring}_{name}": own[name].drop_vars(["time", "cam_angle"]) for name in own.data_vars if name not in SHARED}
    statistics = {f"{spring}_{key}": value for part, spring in zip(parts, names, strict=True) for key, value in part.statistics.items()}
    worst = next((part.status for part in parts if not part.status.completed), parts[0].status)
    named = [replace(event, where=f"{spring} {event.where}") for part, spring in zip(parts, names, strict=True) for event in part.events]
    events = tuple(sorted(named, key=lambda event: event.time))
    return Solution(xarray.Dataset(data, coords=coords), events, worst, statistics, provenance)
