"""Solids in a train: its periodic motion with rods, then each solid alone under the motion of the
retainer, and both as one solution.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from valvetrain.compiled import program_digest
from valvetrain.contact.kernels import OWN_LAW
from valvetrain.integrate.contract import Periodic, RunOptions, RunUp, Until
from valvetrain.integrate.run import SHARED, run
from valvetrain.integrate.solid_store import read_run, write_run
from valvetrain.integrate.train_channels import PREFIX as SCATTER
from valvetrain.integrate.train_channels import position_name
from valvetrain.integrate.train_leapfrog import SPEC as TRAIN_LEAPFROG
from valvetrain.solution.channels import ChannelArrays, Variable, empty_channels
from valvetrain.solution.force_peak import bandwidth_of, force_peak
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.springs.finite_element_model import RodModel
from valvetrain.system.contract import System
from valvetrain.system.driven import DrivenSprings, RecordedMotion
from valvetrain.system.prescribed import PrescribedSpring

TURN = 2 * np.pi
#: Statistic and quantity: root mean square (N) of the force on the retainer less that of the springs
#: that the train ran with.
DIFFERENCE = "driver_difference_force"
#: Statistic: model of the springs that the train ran with.
DRIVER = "driver"
#: Energies of a spring alone; a train has them by cycle.
ENERGIES = ("kinetic_energy", "elastic_energy", "contact_energy", "work_done", "energy_dissipated")


@dataclass(frozen=True)
class SolidInTrain:
    """Second order. A train that does not complete is the result as it is."""

    word: str = "solid-in-train"
    order: int = 2

    def serves(self, system: System, until: Until) -> bool:
        return isinstance(system, DrivenSprings) and not isinstance(until, RunUp)

    def run(
        self,
        system: System,
        cam_speed: float,
        until: Until,
        options: RunOptions,
        provenance: Provenance,
    ) -> Solution:
        """See :class:`valvetrain.integrate.contract.Integrator`."""
        assert isinstance(system, DrivenSprings)
        train = _train_run(system, cam_speed, until, options, provenance)
        if not train.status.completed:
            return train
        alone = PrescribedSpring(system.springs, motion_of(system, train), system.name)
        chosen = RunOptions(len(train.time), keep=options.keep, watch=options.watch)
        return with_driven(train, run(alone, cam_speed, Periodic(), chosen, provenance), system)


def motion_of(system: DrivenSprings, train: Solution) -> RecordedMotion:
    """The motion of the retainer in the turn of a train's run."""
    mechanism = system.mechanism
    retainer = mechanism.coordinates[system.train.arrays.retainer]
    speed = train.engine_speed / 2
    return RecordedMotion(
        train.channel(position_name(retainer, mechanism.valve)),
        train.channel("retainer_velocity") / speed,
        train.channel("retainer_acceleration") / speed**2,
    )


def _train_run(
    system: DrivenSprings,
    cam_speed: float,
    until: Until,
    options: RunOptions,
    provenance: Provenance,
) -> Solution:
    """The train with its own springs, read where it ran before."""
    key = _key(system, cam_speed, until, options, bandwidth_of(provenance))
    if (stored := read_run(key, provenance)) is not None:
        return stored
    ends = replace(options, keep="ends", time_step=None, start=None, watch=None)
    found = TRAIN_LEAPFROG.run(system.train, cam_speed, until, ends, provenance)
    if found.status.completed:
        write_run(key, found)
    return found


def _key(
    system: DrivenSprings, cam_speed: float, until: Until, options: RunOptions, bandwidth: float
) -> str:
    """Digest of all that the train's motion follows from; empty where a law of one's own takes part."""
    train = system.train
    rods = [spring for spring in train.springs if isinstance(spring, RodModel)]
    own = any(rod.dynamics.contact_law.kernel is not None for rod in rods)
    if own or len(rods) < len(train.springs) or OWN_LAW in train.arrays.laws:
        return ""
    parts = [[getattr(rod, one.name) for one in fields(rod)] for rod in rods]
    numbers = (train.arrays, train.interaction_names, train.coordinate_names, train.crank)
    how = (cam_speed, until, options.samples, options.window, options.nose, bandwidth)
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
        program = program_digest("integrate/*.py", "cosserat/*.py", "mechanism/*.py", "system/*.py")
        text = repr((parts, numbers, how, program))
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def with_driven(train: Solution, alone: Solution, system: DrivenSprings) -> Solution:
    """The turn of a train with the last turn of its springs alone in place of those it ran with."""
    count, first = len(train.time), len(alone.time) - len(train.time) - 1
    if first < 0 or not alone.status.completed:
        return Solution(empty_channels(), (), alone.status, alone.statistics, train.provenance)
    begin, turns = float(alone.time[first]), float(alone.cam_angle[first])
    variables = {
        name: one
        for name, one in train.arrays.variables.items()
        if name not in ("seat_force", "retainer_force") and one.dims == ("sample",)
    }
    for name, one in alone.arrays.variables.items():
        if name in SHARED or name.endswith(ENERGIES):
            continue
        values = one.values[first : first + count]
        if name.endswith(("highest_time", "lowest_time")):
            values = values - begin
        variables[name] = Variable(one.dims, values, one.attrs)
    coords = {
        name: one for name, one in alone.arrays.coords.items() if name not in ("time", "cam_angle")
    }
    coords |= {name: train.arrays.coords[name] for name in ("time", "cam_angle")}
    events = [event for event in train.events if event.kind != "clash"]
    events += [
        replace(event, cam_angle=event.cam_angle - turns, time=event.time - begin)
        for event in alone.events
        if event.cam_angle >= turns
    ]
    channels = ChannelArrays(variables, coords, train.arrays.attributes)
    statistics = {
        name: value
        for name, value in train.statistics.items()
        if not (
            name.startswith((SCATTER, "raw_peak"))
            and name.endswith(("spring_force", "retainer_force", "force_duration"))
        )
    }
    difference = channels["retainer_force"].values - train.channel("retainer_force")
    statistics |= {
        **alone.statistics,
        **_extremes(channels, system.spring_names, bandwidth_of(train.provenance)),
    }
    statistics |= {
        DIFFERENCE: float(np.sqrt(np.mean(difference**2))),
        DRIVER: system.driver,
        "integrator": SPEC.word,
    }
    statistics.pop("spring_dissipated_energy", None)
    if alone.has(heat := "energy_dissipated"):
        lost = alone.channel(heat)
        statistics["spring_dissipated_energy"] = float(lost[first + count] - lost[first])
    ordered = tuple(sorted(events, key=lambda event: event.cam_angle))
    return Solution(channels, ordered, train.status, statistics, train.provenance)


def _extremes(
    channels: ChannelArrays, names: tuple[str, ...], bandwidth: float
) -> Mapping[str, float]:
    """Peak end forces (N) below the cut-off ``bandwidth`` (Hz) and raw, and the least; the last two of
    one spring on every step, of a pair on the fine samples of its sum.
    """
    prefixes = [f"{name}_" for name in names] if len(names) > 1 else [""]
    angle, found = channels.coords["cam_angle"].values, dict[str, float]()
    time = channels.coords["time"].values
    width, interval = angle[1] - angle[0], time[1] - time[0]
    for end, word in (("seat", "spring"), ("retainer", "retainer")):
        fine = channels[f"{end}_force_fine"].values
        angles = (angle[:, None] + width * np.arange(fine.shape[1]) / fine.shape[1]).ravel()
        ends = {"raw_peak": int(np.argmax(fine)), "minimum": int(np.argmin(fine))}
        found |= {f"{kind}_{word}_force": float(fine.ravel()[at]) for kind, at in ends.items()}
        if not prefixes[0]:
            found[f"raw_peak_{word}_force"] = float(np.max(channels[f"{end}_force_highest"].values))
            found[f"minimum_{word}_force"] = float(np.min(channels[f"{end}_force_lowest"].values))
        place, spacing = ends["raw_peak"] / fine.size, float(interval / fine.shape[1])
        raw = found[f"raw_peak_{word}_force"]
        peak = force_peak(fine.ravel(), spacing, bandwidth, raw, place)
        found |= peak.quantities(f"{word}_force")
        if end == "retainer":
            continue
        found["peak_spring_force_cam_angle"] = TURN * peak.place
        found |= {f"{kind}_spring_force_cam_angle": float(angles[at]) for kind, at in ends.items()}
        for one in filter(None, prefixes):
            own = channels[f"{one}seat_force_fine"].values
            least = float(np.min(channels[f"{one}seat_force_lowest"].values))
            mine = force_peak(own.ravel(), float(interval / own.shape[1]), bandwidth, 0.0, 0.0)
            found |= {f"{one}peak_spring_force": mine.below, f"{one}minimum_spring_force": least}
    return found


SPEC = SolidInTrain()
