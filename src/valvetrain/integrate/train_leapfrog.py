"""Explicit leapfrog of a whole train, springs and all, to its periodic state, for a number of
turns, or through a run-up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.integrate.clash import RECORDED, PairSeries, find_clashes
from valvetrain.integrate.contract import Cycles, Orbit, Periodic, RunOptions, RunUp, Until
from valvetrain.integrate.run_up import run_up
from valvetrain.integrate.train_channels import least_forces, train_channels, train_statistics
from valvetrain.integrate.train_record import TURN, CycleRecord, TrainOptions
from valvetrain.integrate.train_run import TrainRunner, runner
from valvetrain.integrate.train_steady import TOLERANCE, SteadyTrain, steady_train
from valvetrain.solution.force_peak import bandwidth_of
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event
from valvetrain.springs.contract import contact_watch_of
from valvetrain.system.contract import System
from valvetrain.system.train_rest import TrainRest, rest_of
from valvetrain.system.train_system import TrainSystem

#: Samples per cam revolution; fewer of springs whose inner state is large.
SAMPLES, LARGE_SAMPLES = 1440, 720
#: Maximum of cam revolutions of the search for the periodic state; the finite-element rod's state (frames among
#: it) does not mix: few plain turns more than those in which its springs settle.
MAX_CYCLES, FEW_CYCLES, FEW_TOLERANCE = 60, 3, 1e-3
#: Change per cycle from which the numbers of the cycles after those few are compared as well.
FEW_RATTLING = 1e-4
#: How often the step is cut to a third when a contact hardens beyond what it resolves.
FINER_STEPS = 2


@dataclass(frozen=True)
class TrainLeapfrog:
    """Second order; damping of all contacts of a step solved together (``integrate.train_kernel``)."""

    word: str = "train-leapfrog"
    order: int = 2

    def serves(self, system: System, until: Until) -> bool:
        return isinstance(system, TrainSystem)

    def run(
        self,
        system: System,
        cam_speed: float,
        until: Until,
        options: RunOptions,
        provenance: Provenance,
    ) -> Solution:
        """See :class:`valvetrain.integrate.contract.Integrator`."""
        return self.run_to_orbit(system, cam_speed, until, options, provenance)[0]

    def run_to_orbit(
        self,
        system: System,
        cam_speed: float,
        until: Until,
        options: RunOptions,
        provenance: Provenance,
    ) -> tuple[Solution, Orbit | None]:
        """The run, and its motion as a start for another; of a run-up there is none."""
        assert isinstance(system, TrainSystem)
        rest = options.rest or rest_of(system)
        large = system.has_large_springs
        samples = options.samples or (LARGE_SAMPLES if large else SAMPLES)
        chosen = TrainOptions(
            samples,
            time_step=options.time_step,
            record_springs=options.keep != "ends",
            record_contacts=options.coil_contacts and not isinstance(until, RunUp),
            window=options.window or (0.0, TURN),
            nose=options.nose or 0.0,
            force_bandwidth=bandwidth_of(provenance),
        )
        if isinstance(until, RunUp):
            records = run_up(
                system, cam_speed, until.last_cam_speed, until.cam_acceleration, chosen, rest=rest
            )
            if not records:
                raise InputError(
                    "the run-up holds no whole stretch; lower the acceleration or move the last speed"
                )
            return Solution(
                train_channels(system, rest, records),
                (),
                records[-1].status,
                {"integrator": self.word},
                provenance,
            ), None
        if isinstance(until, Cycles):
            ready = runner(system, cam_speed, chosen, rest=rest)
            state = ready.initial_state() if options.start is None else options.start.at(ready)
            for _ in range(until.count - 1):
                state, _ = ready.after(state)
            _, record = ready.cycle(state)
            statistics = train_statistics(ready.system, record) | {
                "steady_cycles_count": float(until.count),
                "integrator": self.word,
            }
            events, spacing = _events(ready, record)
            statistics |= spacing | least_forces(ready.system, record, options)
            channels = train_channels(ready.system, rest, (record,), state)
            return Solution(channels, events, record.status, statistics, provenance), Orbit(
                state, ready.springs, cam_speed
            )
        found = self._settled(system, cam_speed, until, chosen, large, rest, options.start)
        statistics = train_statistics(found.runner.system, found.record) | {
            "steady_cycles_count": float(found.search.cycles),
            "steady_residual_ratio": float(found.search.residuals[-1]),
            "steady_tolerance_ratio": found.tolerance,
            "motion_period_count": float(found.search.period),
            "time_step_duration": found.record.time_step,
            "steps_per_cycle_count": float(found.runner.steps),
            "wall_time_per_cycle_duration": found.wall_time_per_cycle,
            "integrator": self.word,
        }
        statistics |= found.scatter.statistics if found.scatter is not None else {}
        channels = train_channels(found.runner.system, rest, (found.record,), found.start)
        events, spacing = _events(found.runner, found.record)
        statistics |= spacing | least_forces(found.runner.system, found.record, options)
        return Solution(channels, events, found.status, statistics, provenance), found.orbit

    def _settled(
        self,
        system: TrainSystem,
        cam_speed: float,
        until: Periodic,
        chosen: TrainOptions,
        large: bool,
        rest: TrainRest,
        start: Orbit | None = None,
    ) -> SteadyTrain:
        """Periodic state; a contact harder than the step resolves is run again with a finer one."""
        least = _settling(system, cam_speed) if large else 1
        most = until.cycles or (least + FEW_CYCLES - 1 if large else MAX_CYCLES)
        tolerance = until.tolerance or (FEW_TOLERANCE if large else TOLERANCE)
        for _ in range(FINER_STEPS + 1):
            ready = runner(system, cam_speed, chosen, rest=rest)
            found = steady_train(
                ready,
                "repeat" if large else until.method,
                tolerance,
                most,
                start,
                compared=until.compared and not large,
                least=min(least, most),
                probed=until.probed,
                rattling=FEW_RATTLING if large and until.probed else math.inf,
            )
            if found.record.status.code != "diverged" or chosen.time_step is not None:
                break
            chosen = replace(chosen, step_fraction=chosen.step_fraction / 3)
        return found


def _settling(system: TrainSystem, cam_speed: float) -> int:
    """Cam revolutions after which the rods of a train have forgotten their start; the state of a rod,
    which is not compared, is then no longer that of the first revolution.
    """
    from valvetrain.integrate.rod_leapfrog import settling_revolutions
    from valvetrain.springs.finite_element import FiniteElementRod

    rods = (spring for spring in system.springs if isinstance(spring, FiniteElementRod))
    return max((settling_revolutions(rod, cam_speed) for rod in rods), default=1)


def _events(
    ready: TrainRunner, record: CycleRecord
) -> tuple[tuple[Event, ...], dict[str, float | int | str | bool]]:
    """Touches of the train's contacts and clashes of the springs' coils in one cycle, and the
    spacing of the record of the latter.
    """
    touches = record.transitions.touches(ready.system.interaction_names, record.cam_speed)
    clashes: tuple[Event, ...] = ()
    watched = False
    for place, (spring, name) in enumerate(
        zip(ready.springs, ready.system.spring_names, strict=True)
    ):
        watch = contact_watch_of(spring)
        if watch is None or not any(map(len, record.pressed)):
            continue
        watched, pressed = True, record.pressed[place]
        time = np.asarray(record.pressed_interval * np.arange(len(pressed)), dtype=float)
        series = PairSeries(
            time,
            record.cam_speed * time,
            *watch.read(pressed, record.pressed_interval, record.time_step),
            watch.first_period,
        )
        clashes += find_clashes(series, name if len(ready.springs) > 1 else "", closed=True)
    return (*touches, *clashes), {RECORDED: record.pressed_interval} if watched else {}


SPEC = TrainLeapfrog()
