"""Run a case's train to its steady state and name what came out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from valvetrain.analysis.kinematics import RigidTable, rigid_table
from valvetrain.analysis.valvetrain_quantities import cycle_data, cycle_events, cycle_quantities
from valvetrain.errors import InputError
from valvetrain.integrate.train_run import TrainOptions, runner
from valvetrain.integrate.train_steady import SteadyTrain, steady_train
from valvetrain.parameters.case import Case
from valvetrain.parameters.train import TrainParameters
from valvetrain.solution.event import Event
from valvetrain.solution.status import Status
from valvetrain.system.build_train import build_train
from valvetrain.system.train_system import TrainSystem

#: The finite-element spring costs seconds per cycle and its state (frames among it) does not mix; few plain cycles serve.
FEW_CYCLES = {"finite-element": 3}


@dataclass(frozen=True)
class TrainRun:
    """One steady cycle of a train: numbers, events, status; ``steady`` and ``table`` hold the traces.

    ``engine_speed`` in rad/s of the crank. ``quantities``: name -> SI value.
    """

    label: str
    spring_model: str
    spring_set: str
    engine_speed: float
    quantities: Mapping[str, float]
    events: tuple[Event, ...]
    status: Status
    steady: SteadyTrain | None = None
    table: RigidTable | None = None
    notes: tuple[str, ...] = field(default=())


def train_of(case: Case) -> TrainParameters:
    """The case's train. Raises :class:`InputError` when it has none."""
    if case.train is None:
        raise InputError(f"case '{case.name}' holds no valvetrain; add a [train] table or choose another case, such as vaz-ohc")
    train: TrainParameters = case.train
    return train


def run_train(
    case: Case, engine_speed: float | None = None, *, spring_model: str | None = None, spring_set: str | None = None,
    train: TrainParameters | None = None, options: TrainOptions | None = None, method: str = "anderson", cycles: int = 60,
    label: str = "", spring_options: Mapping[str, Any] | None = None,
) -> TrainRun:  # fmt: skip
    """Steady state of the case's train at ``engine_speed`` (rad/s of the crank; the case's first by default)."""
    parameters = train or train_of(case)
    speed = engine_speed if engine_speed is not None else _first_speed(case)
    model, chosen_set = spring_model or parameters.spring_model, spring_set or parameters.spring_set or next(iter(parameters.springs), "")
    system = build_train(case, spring_model=model, spring_set=chosen_set, train=parameters, **(spring_options or {}))
    steady = settle(system, speed, model, options, method, cycles)
    table = rigid_table(system, parameters, speed / 2)
    return _named(steady, table, label or model, model, chosen_set, speed)


def settle(
    system: TrainSystem, engine_speed: float, spring_model: str, options: TrainOptions | None = None, method: str = "anderson", cycles: int = 60
) -> SteadyTrain:
    """Steady state of an assembled train (rad/s of the crank)."""
    few = FEW_CYCLES.get(spring_model)
    chosen = options or TrainOptions(record_springs=few is None)
    ready = runner(system, engine_speed / 2, chosen)
    if few is not None:
        return steady_train(ready, "repeat", cycles=min(few, cycles), tolerance=1e-3)
    return steady_train(ready, method, cycles=cycles)


def _named(steady: SteadyTrain, table: RigidTable, label: str, model: str, spring_set: str, engine_speed: float) -> TrainRun:
    data = cycle_data(steady, table)
    finite = bool(np.all(np.isfinite(data.valve_lift)))
    events = cycle_events(steady, data) if finite else ()
    numbers = cycle_quantities(steady, data, table, events) if finite else {}
    return TrainRun(label, model, spring_set, engine_speed, numbers, events, steady.status, steady, table)


def _first_speed(case: Case) -> float:
    if not case.operation.engine_speeds:
        raise InputError(f"case '{case.name}' names no engine speed; add engine_speeds or cam_speeds to [operation]")
    return case.operation.engine_speeds[0]
