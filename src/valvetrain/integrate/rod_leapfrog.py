"""The geometrically exact rod under prescribed motion by its own vectorised leapfrog, which keeps
every section's motion and load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.integrate.clash import RECORDED, PairSeries, find_clashes
from valvetrain.integrate.contract import Cycles, OfOneSpring, Periodic, RunOptions, Until
from valvetrain.solution.channels import SPRING_CHANNELS, Variable
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import COMPLETED, Event, Status
from valvetrain.springs.contract import WATCH_SHARE
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import rod_channels
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

if TYPE_CHECKING:
    from valvetrain.springs.solid.model import SolidModel

TURN = 2 * np.pi
#: Samples per cam revolution; bounds of the revolutions of a run that shall be periodic, and what is
#: left of the start's first surge mode after them.
SAMPLES, PERIODIC_CYCLES, REST_OF_START = 720, (2, 8), 0.01
#: What may help a run that diverges at a stable step.
REMEDY = "give a smaller time_step or a softer coil contact, or check the lift law for jumps"


def settling_revolutions(rod: FiniteElementRod | SolidModel, cam_speed: float) -> int:
    """Cam revolutions after which the first surge mode has forgotten its start, by its damping; at a
    ``cam_speed`` in rad/s. The state of a rod or a solid is too large to search its periodic motion.
    """
    decay = 0.5 * (
        rod.dynamics.mass_damping + rod.dynamics.stiffness_damping * (TURN / rod.first_period) ** 2
    )
    revolutions = -np.log(REST_OF_START) / max(decay, 1e-9) * cam_speed / TURN
    return int(np.clip(np.ceil(revolutions), *PERIODIC_CYCLES))


@dataclass(frozen=True)
class RodLeapfrog(OfOneSpring):
    """Second order. A run that diverges is repeated once with half the step; when that fails too,
    what was computed has a status.
    """

    model = FiniteElementRod
    word: str = "rod-leapfrog"
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
        rod = system.springs[0]
        assert isinstance(rod, FiniteElementRod)
        model: FiniteElementRod = rod
        upper_coil, pair_of = rod.coil_pairs
        samples = options.samples or SAMPLES
        if isinstance(until, Cycles):
            cycles = until.count
        elif isinstance(until, Periodic) and until.cycles:
            cycles = until.cycles
        else:
            cycles = settling_revolutions(rod, cam_speed)

        def simulated() -> tuple[RodTransient, bool]:
            """The motion, and whether it diverged at first and is that of half the step."""
            step = options.time_step or model.time_step or model.stable_time_step()
            halved = False
            while True:
                made = simulate(
                    model.mesh,
                    model.installed.state,
                    lambda time: model.precompression + system.displacement(time, cam_speed),
                    TURN / samples / cam_speed,
                    cycles * samples,
                    model.dynamics,
                    step,
                    discard=(cycles - 1) * samples,
                    pair_of=pair_of,
                    pair_interval=WATCH_SHARE * model.first_period,
                )
                if made.completed or halved:
                    return made, halved
                step, halved = made.time_step / 2, True

        made, retried = simulated()
        least = min(made.seat_force.min(), made.retainer_force.min())
        if not (rod.pulls or rod.lifting) and least < 0.0:  # an end that is not bonded pulled
            model = replace(rod, lifting=True)
            made, retried = simulated()
        if retried:
            model = replace(model, time_step=made.time_step)
        channels = rod_channels(model, made, cam_speed, options.keep == "all")
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
                model.first_period,
            )
            events = find_clashes(pairs, closed=cycles > 1)
        status = COMPLETED
        if not made.completed:
            time = made.steps_done * made.time_step
            turns, part = divmod(cam_speed * time / TURN, 1.0)
            given, remedy = options.time_step or rod.time_step or 0.0, REMEDY
            message = f"the wire's velocity grew without bound at {360 * part:.1f} cam degrees of turn {int(turns) + 1}"
            if given > (stable := rod.stable_time_step()):
                message += f": a time step of {1e6 * given:.3g} µs is above the stable {1e6 * stable:.3g} µs"
                remedy = "leave time_step out and the stable one is taken"
            status = Status("diverged", message, time, "finite-element rod", remedy)
        return Solution(channels, events, status, statistics, provenance)


SPEC = RodLeapfrog()
