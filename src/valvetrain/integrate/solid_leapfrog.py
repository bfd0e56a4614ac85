"""The solid spring under prescribed motion by its own explicit leapfrog; finished runs are stored, so
that a request that was stopped continues with the speed it was at.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.continuum.transient import SolidTransient, simulate_solid
from valvetrain.integrate.clash import RECORDED, PairSeries, find_clashes
from valvetrain.integrate.contract import Cycles, OfOneSpring, Periodic, RunOptions, Until
from valvetrain.integrate.rod_leapfrog import REMEDY, SAMPLES, settling_revolutions
from valvetrain.integrate.solid_store import read_run, run_key, write_run
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import COMPLETED, Event, Status
from valvetrain.springs.contract import WATCH_SHARE
from valvetrain.springs.solid.model import SolidModel
from valvetrain.springs.solid.motion_channels import solid_channels
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

TURN = 2 * np.pi


@dataclass(frozen=True)
class SolidLeapfrog(OfOneSpring):
    """Second order. A run that diverges has that status, with what was computed."""

    model = SolidModel
    word: str = "solid-leapfrog"
    order: int = 2

    def run(
        self,
        system: System,
        cam_speed: float,
        until: Until,
        options: RunOptions,
        provenance: Provenance,
    ) -> Solution:
        """See :class:`valvetrain.integrate.contract.Integrator`."""
        assert isinstance(system, PrescribedSpring)
        model = system.springs[0]
        assert isinstance(model, SolidModel)
        samples = options.samples or SAMPLES
        if isinstance(until, Cycles):
            cycles = until.count
        elif isinstance(until, Periodic) and until.cycles:
            cycles = until.cycles
        else:
            cycles = settling_revolutions(model, cam_speed)
        angles = np.linspace(0.0, TURN, 4 * samples + 1)
        key = run_key(
            model,
            system.valve_lift.lift(angles),
            (cam_speed, cycles, samples, options.time_step or 0.0),
            options.keep,
        )
        if (stored := read_run(key, provenance)) is not None:
            return stored
        made = simulate_solid(
            model.statics,
            model.equilibrium(float(system.displacement(0.0, cam_speed))),
            lambda time: model.precompression + system.displacement(time, cam_speed),
            TURN / samples / cam_speed,
            cycles * samples,
            model.dynamics,
            options.time_step or model.time_step or model.stable_time_step(),
            discard=(cycles - 1) * samples,
            watch=options.watch,
            pair_interval=WATCH_SHARE * model.first_period,
        )
        found = _solution(model, system, made, cam_speed, options, provenance)
        if found.status.completed:
            write_run(key, found)
        return found


def _solution(
    model: SolidModel,
    system: PrescribedSpring,
    made: SolidTransient,
    cam_speed: float,
    options: RunOptions,
    provenance: Provenance,
) -> Solution:
    """Channels, clashes, statistics and status of a run."""
    turned = [system.displacement(made.time, cam_speed, order) for order in (1, 2)]
    motion = (turned[0], turned[1])
    channels = solid_channels(model, made, cam_speed, motion, options.keep == "all")
    span = float(np.ptp(made.energy[:, 5])) if len(made.time) else 0.0
    statistics: dict[str, float | int | str | bool] = {
        "time_step_duration": made.time_step,
        "steps": made.steps,
        "elements": model.wire.bricks.count,
        "largest_velocity": made.fastest,
        "step_was_halved": False,
        "integrator": SPEC.word,
    }
    if span > 0:
        statistics["energy_gap"] = float(np.abs(made.energy_gap).max()) / span
    upper_coil, events = model.wire.pair_coils, tuple[Event, ...]()
    if len(upper_coil) and len(made.pair_time) > 1:
        statistics[RECORDED] = float(made.pair_time[1] - made.pair_time[0])
        pairs = PairSeries(
            made.pair_time,
            cam_speed * made.pair_time,
            np.arange(len(upper_coil)),
            upper_coil,
            made.pair_force.T,
            made.pair_energy.T,
            model.first_period,
        )
        events = find_clashes(pairs, closed=bool(made.pair_time[0] > 0))
    status = COMPLETED
    if made.stopped:
        message = "the run was stopped; runs at other speeds that were finished are stored"
        status = Status("interrupted", message, made.steps_done * made.time_step)
    elif not made.completed:
        time = made.steps_done * made.time_step
        turns, part = divmod(cam_speed * time / TURN, 1.0)
        status = Status(
            "diverged",
            f"the wire's velocity grew without bound at {360 * part:.1f} cam degrees of turn {int(turns) + 1}",
            time,
            "solid finite elements",
            REMEDY,
        )
    return Solution(channels, events, status, statistics, provenance)


SPEC = SolidLeapfrog()
