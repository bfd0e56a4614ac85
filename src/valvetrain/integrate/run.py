"""One call for every system: integrate in time and hand back a solution."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles, Integrator, Periodic, RunOptions, Until
from valvetrain.registry import find
from valvetrain.registry import names as registered_names
from valvetrain.solution.channels import FINE
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

if TYPE_CHECKING:
    from valvetrain.integrate.contract import Orbit


def run(
    system: System,
    cam_speed: float,
    until: Until = Periodic(),
    options: RunOptions = RunOptions(),
    provenance: Provenance | None = None,
) -> Solution:
    """Integrate ``system`` at ``cam_speed`` (rad/s) for so long as ``until`` says.

    The solution holds the channels of docs/architecture.md over the last cam revolution, a status and
    statistics; events and named quantities are found by ``quantities.evaluate``. Raises
    :class:`InputError` for a cam speed that is not positive, an unknown integrator or one that does
    not serve the system; whatever happens in the run itself is its status.
    """
    return run_to_orbit(system, cam_speed, until, options, provenance)[0]


def run_to_orbit(
    system: System,
    cam_speed: float,
    until: Until = Periodic(),
    options: RunOptions = RunOptions(),
    provenance: Provenance | None = None,
) -> tuple[Solution, Orbit | None]:
    """As :func:`run`, and of a train the motion it ended on, which ``RunOptions.start`` takes at
    another speed; None of what has none.
    """
    from valvetrain.integrate.train_leapfrog import TrainLeapfrog

    if not (math.isfinite(cam_speed) and cam_speed > 0):
        raise InputError(f"the cam speed must be positive; it is {cam_speed:g} rad/s")
    origin = provenance or _origin(system, cam_speed)
    if isinstance(system, PrescribedSpring) and len(system.springs) > 1:
        members = system.members()
        parts = tuple(run(member, cam_speed, until, options, origin) for member in members)
        if isinstance(until, Periodic):  # of springs that settle at different times, the latest
            longest = max(round(cam_speed * part.time[-1] / (2 * np.pi)) for part in parts)
            parts = tuple(
                part
                if cam_speed * part.time[-1] > 2 * np.pi * (longest - 0.5)
                else run(member, cam_speed, Cycles(longest), options, origin)
                for part, member in zip(parts, members, strict=True)
            )
        return joined(parts, system.spring_names, origin), None
    integrator = integrator_for(system, until, options.integrator)
    if isinstance(integrator, TrainLeapfrog):
        return integrator.run_to_orbit(system, cam_speed, until, options, origin)
    return integrator.run(system, cam_speed, until, options, origin), None


def integrator_for(system: System, until: Until, word: str | None = None) -> Integrator:
    """The integrator called ``word``, or the first of the registry that serves. Raises
    :class:`InputError` where none does.
    """
    for name in (word,) if word else registered_names("integrators"):
        found = find("integrators", name)
        assert isinstance(found, Integrator)
        if found.serves(system, until):
            return found
    raise InputError(
        f"no integrator {f'{word!r} ' if word else ''}runs a {system.kind} for {type(until).__name__}; choose another"
    )


def _origin(system: System, cam_speed: float) -> Provenance:
    name = system.springs[0].name if system.springs else ""
    return Provenance(
        system.name, name, 2 * cam_speed, system=system.kind, springs=system.spring_names
    )


def _summed(parts: list[Array]) -> Array:
    """Sum of records (sample, substep) of several springs on the finest substeps among them."""
    most = max(part.shape[1] for part in parts)
    if all(part.shape[1] == most for part in parts):
        return np.asarray(np.sum(parts, axis=0))
    rows = np.arange(len(parts[0]))
    at = (rows[:, None] + np.arange(most) / most).ravel()
    series = [
        np.interp(at, (rows[:, None] + np.arange(n := part.shape[1]) / n).ravel(), part.ravel())
        for part in parts
    ]
    return np.asarray(np.sum(series, axis=0)).reshape(len(rows), most)


#: Channels of the motion, which is one for all springs, and those that add.
SHARED = ("valve_lift", "retainer_velocity", "retainer_acceleration")


ADDED = (
    "seat_force",
    "retainer_force",
    "work_done",
    "energy_dissipated",
    "kinetic_energy",
    "elastic_energy",
    "contact_energy",
)


def joined(parts: tuple[Solution, ...], names: tuple[str, ...], provenance: Provenance) -> Solution:
    """One solution of the springs ``names``: common channels once, added ones as the sum, the rest
    with the spring's name in front.

    The time of the first spring counts; the others are put on it (all run with the same samples).
    The worst status counts.
    """
    import xarray

    labelled = [part.arrays.stored for part in parts]
    first = labelled[0]
    count = min(len(part.time) for part in parts)
    if any(
        not np.allclose(part.time[:count], parts[0].time[:count], rtol=1e-9, atol=1e-12)
        for part in parts
    ):
        raise InputError(
            "the springs of a nested pair were sampled at different times; run them with one number of samples"
        )
    data = {name: first[name][:count] for name in SHARED if name in first}
    for name in ADDED:
        if all(name in one for one in labelled):
            total = first[name][:count].copy()
            total.values = np.sum([one[name].values[:count] for one in labelled], axis=0)
            data[name] = total
    data |= {
        name: xarray.DataArray(
            _summed([one[name].values[:count] for one in labelled]),
            dims=("sample", "subsample"),
            attrs=first[name].attrs,
        )
        for name in FINE
        if name.endswith("_fine") and all(name in one for one in labelled)
    }
    coords = {name: first[name][:count] for name in ("time", "cam_angle")}
    for one, spring in zip(labelled, names, strict=True):
        renamed: dict[str, str] = {
            str(dim): f"{spring}_{dim}" for dim in one.dims if dim != "sample"
        }
        renamed |= {
            str(name): f"{spring}_{name}"
            for name in one.coords
            if name not in ("time", "cam_angle")
        }
        own = one.isel(sample=slice(0, count)).rename(renamed)
        data |= {
            f"{spring}_{name}": own[name].drop_vars(["time", "cam_angle"])
            for name in own.data_vars
            if name not in SHARED
        }
    statistics = {
        f"{spring}_{key}": value
        for part, spring in zip(parts, names, strict=True)
        for key, value in part.statistics.items()
    }
    worst = next((part.status for part in parts if not part.status.completed), parts[0].status)
    named = [
        replace(event, where=f"{spring} {event.where}")
        for part, spring in zip(parts, names, strict=True)
        for event in part.events
    ]
    events = tuple(sorted(named, key=lambda event: event.time))
    return Solution(xarray.Dataset(data, coords=coords), events, worst, statistics, provenance)
