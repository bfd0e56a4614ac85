"""The geometrically exact rod under prescribed motion by its own vectorised leapfrog, which keeps
every section's motion and load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.integrate.clash import RECORDED, PairSeries, find_clashes
from valvetrain.integrate.contract import Cycles, Periodic, RunOptions, RunUp, Until
from valvetrain.solution.channels import SPRING_CHANNELS, Variable
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import COMPLETED, Event, Status
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import end_channels, rod_channels
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

TURN = 2 * np.pi
#: Samples per cam revolution, and revolutions of a run that shall be periodic (the rod settles within a
#: few; its state is too large to accelerate).
SAMPLES, PERIODIC_CYCLES = 720, 4


@dataclass(frozen=True)
class RodLeapfrog:
    """Second order. A run that diverges is repeated once with half the step; when that fails too,
    what was computed has a status.
    """

    word: str = "rod-leapfrog"
    order: int = 2

    def serves(self, system: System, until: Until) -> bool:
        alone = isinstance(system, PrescribedSpring) and len(system.springs) == 1
        return (
            alone
            and isinstance(system.springs[0], FiniteElementRod)
            and not isinstance(until, RunUp)
        )

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
        rod = system.springs[0]
        assert isinstance(rod, FiniteElementRod)
        model: FiniteElementRod = rod
        upper_coil, pair_of = rod.coil_pairs
        samples, cycles = options.samples or SAMPLES, PERIODIC_CYCLES
        if isinstance(until, Cycles):
            cycles = until.count
        elif isinstance(until, Periodic) and until.cycles:
            cycles = until.cycles

        def turn(step: float | None) -> RodTransient:
            return simulate(
                rod.mesh,
                rod.installed.state,
                lambda time: rod.precompression + system.displacement(time, cam_speed),
                TURN / samples / cam_speed,
                cycles * samples,
                rod.dynamics,
                step,
                discard=(cycles - 1) * samples,
                pair_of=pair_of,
            )

        made = turn(options.time_step or model.time_step or model.stable_time_step())
        retried = not made.completed
        if retried:
            made = turn(made.time_step / 2)
            model = replace(model, time_step=made.time_step)
        channels = (rod_channels if options.keep == "all" else end_channels)(model, made, cam_speed)
        _, unit, label = SPRING_CHANNELS["retainer_acceleration"]
        acceleration = system.displacement(made.time, cam_speed, 2)
        channels = channels.assign(
            {
                "retainer_acceleration": Variable(
                    ("sample",), acceleration, {"units": unit, "long_name": label}
                )
            }
        )
        statistics: dict[str, float | int | str | bool] = {
            "time_step_duration": made.time_step, "steps": made.steps, "elements": model.mesh.elements, "largest_velocity": made.fastest,
            "step_was_halved": retried, "integrator": self.word,
        }  # fmt: skip
        events: tuple[Event, ...] = ()
        if len(upper_coil) and len(made.pair_time) > 1:
            statistics[RECORDED] = float(made.pair_time[1] - made.pair_time[0])
            pairs = PairSeries(
                made.pair_time,
                cam_speed * made.pair_time,
                np.arange(len(upper_coil)),
                upper_coil,
                made.pair_force.T,
                made.pair_energy.T,
            )
            events = find_clashes(pairs)
        status = COMPLETED
        if not made.completed:
            time = made.steps_done * made.time_step
            turns, part = divmod(cam_speed * time / TURN, 1.0)
            status = Status(
                "diverged",
                f"the wire's velocity grew without bound at {360 * part:.1f} cam degrees of turn {int(turns) + 1}",
                time,
                "finite-element rod",
                "give a smaller time_step or a softer coil contact, or check the lift law for jumps",
            )
        return Solution(channels, events, status, statistics, provenance)


SPEC = RodLeapfrog()
