"""How a train that does not repeat differs from cycle to cycle: of its headline numbers, and of the valve at every cam angle."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.integrate.train_run import CycleRecord, TrainRunner, TrainState
from valvetrain.integrate.train_tuples import HIGHEST, LOADS, LOWEST, PEAK_PLACE
from valvetrain.system.train_system import TrainSystem

COMPARED = 8
"""Cycles that are compared."""
STEADY_VALVE = 1e-2
"""Share of the largest lift up to which the valve is taken to repeat."""
LONG_SEARCH = 30
"""Cycles after which what still changes is taken for rattle, not for a motion that has yet to settle."""
SMALLEST_HEIGHT = 2e-6
"""Openings of the seat below this (m) are vibration, no bounce."""
PREFIX = "cycle_scatter_"


@dataclass(frozen=True)
class Scatter:
    """Over :data:`COMPARED` cycles: ``valve`` (m), largest spread of the valve lift at one cam angle; ``peak_valve_lift`` (m), the largest;
    ``numbers``: largest less least value of each number (SI) by the name of its quantity."""

    valve: float
    peak_valve_lift: float
    numbers: dict[str, float]

    @property
    def repeats(self) -> bool:
        """Whether the valve does the same in every cycle, whatever loose parts do."""
        return self.valve <= STEADY_VALVE * self.peak_valve_lift

    @property
    def statistics(self) -> dict[str, float]:
        """The scatter by the names of docs/quantities.md."""
        return {PREFIX + "valve_lift": self.valve} | {PREFIX + name: value for name, value in self.numbers.items()}


def cycle_numbers(system: TrainSystem, record: CycleRecord) -> dict[str, float]:
    """Headline numbers (SI) that one cycle tells by itself, as docs/quantities.md names them."""
    from valvetrain.integrate.train_channels import CONTACTS, force_name

    retainer, seat = (record.loads[LOADS.index(side)].tolist() for side in ("retainer", "seat"))
    found = {
        "peak_spring_force": seat[HIGHEST], "minimum_spring_force": seat[LOWEST], "peak_retainer_force": retainer[HIGHEST],
        "minimum_retainer_force": retainer[LOWEST], "cycle_work_energy": float(record.work[0]),
    }  # fmt: skip
    found["peak_valve_lift"] = float(record.bodies[system.mechanism.index(system.mechanism.valve), PEAK_PLACE])
    names = system.interaction_names
    found |= {f"peak_{force_name(name)}": float(record.peak_forces[place]) for place, name in enumerate(names) if name in CONTACTS}
    if "cam" in names and system.mechanism.kinematics is not None:
        opened = system.mechanism.kinematics.valve_lift(record.cam_angle) > 0
        found["loft_gap"] = float(np.max(record.gaps[opened, names.index("cam")], initial=0.0))
    if "seat" not in names:
        return found
    openings = record.transitions.open_stretches(names.index("seat"))
    heights = np.sort(openings.largest_gap[openings.largest_gap > SMALLEST_HEIGHT])
    found |= {"bounce_count": float(max(len(heights) - 1, 0)), "bounce_height": float(heights[-2]) if len(heights) > 1 else 0.0}
    velocity = record.transitions.seating_velocity(names.index("seat"))
    return found if velocity is None else found | {"seating_velocity": velocity}


def scatter_of(runner: TrainRunner, start: TrainState) -> tuple[Scatter, TrainState]:
    """The spread over :data:`COMPARED` plain cycles from ``start``, and the state at the beginning of the last of them."""
    bare = replace(runner, options=replace(runner.options, record_springs=False, record_contacts=False))
    valve = runner.system.mechanism.index(runner.system.mechanism.valve)
    lifts, numbers, state, first = [], [], start, start
    for _ in range(COMPARED):
        first = state
        end, record = bare.cycle(state, judged=False)
        state = replace(end, cam_angle=0.0)
        lifts.append(record.q[:, valve])
        numbers.append(cycle_numbers(runner.system, record))
    spread = float(np.max(np.ptp(np.array(lifts), axis=0)))
    names = [name for name in numbers[0] if all(name in one for one in numbers)]
    return Scatter(spread, float(np.max(lifts)), {name: _range(one[name] for one in numbers) for name in names}), first


def _range(values: Iterable[float]) -> float:
    return float(np.ptp(list(values)))
