"""Run a case's train to its steady state, all the variants it asks for, and name what came out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from valvetrain.citations import cite
from valvetrain.errors import InputError
from valvetrain.integrate.train_run import TrainOptions, runner
from valvetrain.integrate.train_steady import SteadyTrain, steady_train
from valvetrain.parameters.case import Case, SpringCard
from valvetrain.parameters.train import TrainParameters, TrainVariant
from valvetrain.quantities.compare import compare
from valvetrain.quantities.kinematics import RigidTable, contact_loss_cam_speed, rigid_table
from valvetrain.quantities.valvetrain_quantities import cycle_data, cycle_events, cycle_quantities
from valvetrain.quantities.valvetrain_study import TrainRun, TrainStudy
from valvetrain.quantities.valvetrain_traces import cycle_traces
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.quantity import Quantity, named
from valvetrain.studies.batch import map_cases
from valvetrain.studies.train_findings import derived_quantities, findings
from valvetrain.system.build_train import build_train
from valvetrain.system.train_system import TrainSystem

#: The finite-element spring costs seconds per cycle and its state (frames among it) does not mix; few plain cycles serve.
FEW_CYCLES = {"finite-element": 3}
#: Change per cycle at which they count as settled; every other spring meets `valvetrain.integrate.train_steady.TOLERANCE`.
FEW_CYCLES_TOLERANCE = 1e-3
CARD_WIRE_NOTE = (
    "The finite-element spring of a card is a wire made up for it: rate, preload and mass are the card's, five active coils are "
    "assumed, and its coils "
    "never touch. Its clashes and stresses are not those of the real spring."
)
#: Samples per cycle of springs whose inner state is large.
LARGE_SAMPLES = 720
#: How often the step is cut to a third when a contact hardens beyond what it resolves.
FINER_STEPS = 2


@dataclass(frozen=True)
class RunJob:
    """One run of a batch: what :func:`run_job` needs, all of it picklable."""

    case: Case
    engine_speed: float
    variant: TrainVariant
    options: TrainOptions | None = None
    method: str = "anderson"
    cycles: int = 60
    keep_traces: bool = True
    spring_options: Mapping[str, Any] = field(default_factory=dict)


def train_of(case: Case) -> TrainParameters:
    """The case's train. Raises :class:`InputError` when it has none."""
    if case.train is None:
        raise InputError(f"case '{case.name}' holds no valvetrain; add a [train] table or choose another case, such as vaz-ohc")
    train: TrainParameters = case.train
    return train


def run_job(job: RunJob) -> TrainRun:
    """Steady state of one variant at one speed, with numbers, events and (where kept) traces."""
    train, chosen_set, system = _assembled(job)
    steady = settle(system, job.engine_speed, train.spring_model, job.options, job.method, job.cycles, train.cycles)
    table = rigid_table(system, train, job.engine_speed / 2, samples=720 if job.keep_traces else 360)
    return _named(job, steady, table, train, chosen_set)


#: The last train assembled, with what it was assembled from: a sweep asks for the same one at every speed.
_LAST: list[tuple[RunJob, tuple[TrainParameters, str, TrainSystem]]] = []


def _assembled(job: RunJob) -> tuple[TrainParameters, str, TrainSystem]:
    """The job's train, the name of its spring set and the system."""
    if _LAST:
        last, found = _LAST[0]
        if last.case is job.case and last.variant == job.variant and last.spring_options == job.spring_options:
            return found
    train = job.variant.apply(train_of(job.case))
    chosen_set = train.spring_set or next(iter(train.springs), "")
    found = train, chosen_set, build_train(job.case, train=train, spring_set=chosen_set, **job.spring_options)
    _LAST[:] = [(job, found)]
    return found


def run_train(
    case: Case, engine_speed: float | None = None, *, spring_model: str = "", spring_set: str = "", lash: float | None = None,
    options: TrainOptions | None = None, method: str = "anderson", cycles: int = 60, **spring_options: Any,
) -> TrainRun:  # fmt: skip
    """One run of the case's train at ``engine_speed`` (rad/s of the crank; the case's first by default)."""
    train = train_of(case)
    variant = TrainVariant(spring_model or train.spring_model, spring_set, spring_model, lash)
    return run_job(RunJob(case, engine_speed or first_engine_speed(case), variant, options, method, cycles, True, spring_options))


def settle(
    system: TrainSystem,
    engine_speed: float,
    spring_model: str,
    options: TrainOptions | None = None,
    method: str = "anderson",
    cycles: int = 60,
    most: int | None = None,
) -> SteadyTrain:
    """Steady state of an assembled train (rad/s of the crank); a contact harder than the step resolves is run again with a finer one.

    ``cycles`` bounds the search, for springs of :data:`FEW_CYCLES` no further than theirs; ``most`` (a case's wish) replaces both.
    """
    few, chosen = FEW_CYCLES.get(spring_model), options or TrainOptions(record_springs=True)
    for _ in range(FINER_STEPS + 1):
        if few is not None:
            ready = runner(system, engine_speed / 2, replace(chosen, samples=min(chosen.samples, LARGE_SAMPLES)))
            found = steady_train(ready, "repeat", FEW_CYCLES_TOLERANCE, most or min(few, cycles))
        else:
            found = steady_train(runner(system, engine_speed / 2, chosen), method, cycles=most or cycles)
        if found.record.status.completed or chosen.time_step is not None:
            break
        chosen = replace(chosen, step_fraction=chosen.step_fraction / 3)
    return found


def first_engine_speed(case: Case) -> float:
    """The case's first engine speed (rad/s). Raises :class:`InputError` when it names none."""
    if not case.operation.engine_speeds:
        raise InputError(f"case '{case.name}' names no engine speed; add engine_speeds or cam_speeds to [operation]")
    return case.operation.engine_speeds[0]


def case_variants(case: Case, spring_models: Sequence[str] = ()) -> tuple[TrainVariant, ...]:
    """The variants of a case, or one per spring model asked for (of every spring set in use)."""
    train = train_of(case)
    if spring_models:
        return tuple(TrainVariant(model, train.spring_set, model) for model in spring_models)
    return train.variants or (TrainVariant(train.spring_model, train.spring_set, train.spring_model),)


def run_train_study(
    case: Case, *, engine_speeds: Sequence[float] | None = None, spring_models: Sequence[str] = (), workers: int = 1,
    progress: Callable[[float, str], None] | None = None, created_at: str = "",
) -> TrainStudy:  # fmt: skip
    """All variants of a case at its engine speeds (or those given, rad/s), compared with what was published."""
    speeds = tuple(engine_speeds or case.operation.engine_speeds or (first_engine_speed(case),))
    jobs = [RunJob(case, speed, variant) for speed in speeds for variant in case_variants(case, spring_models)]
    report = partial(_progress, progress, jobs)
    runs = map_cases(run_job, jobs, workers, report)
    quantities: dict[Quantity, float] = {}
    for run in runs:
        quantities |= named(run.quantities, run.engine_speed, run.label)
    quantities |= static_quantities(case)
    derived = derived_quantities(case, runs)
    quantities |= derived
    provenance = collect_provenance(
        case.name, train_of(case).spring_model, engine_speed=speeds[0], created_at=created_at, citations=cite(case.cite()).splitlines()
    )
    # a comparison of spring models is not the source's study, so its findings and contradictions are not told again
    notes, found = ((), ()) if spring_models else findings(case, runs)
    if any(run.spring_model == "finite-element" and _by_card(case, run) for run in runs):
        notes = (*notes, CARD_WIRE_NOTE)
    return TrainStudy(case, runs, quantities, compare(case.published, derived) if derived else (), found, notes, provenance)


def _by_card(case: Case, run: TrainRun) -> bool:
    return any(isinstance(part, SpringCard) for part in train_of(case).spring_parts(run.spring_set))


def static_quantities(case: Case) -> dict[Quantity, float]:
    """Numbers of rigid theory: largest lift, reduced mass, speed of first loss of contact per spring set."""
    train = train_of(case)
    found: dict[Quantity, float] = {}
    for spring_set in train.springs:
        system = build_train(case, spring_model="massless", spring_set=spring_set)
        cam_speed, angle = contact_loss_cam_speed(system)
        values = {
            "rigid_contact_loss_engine_speed": 2 * cam_speed, "rigid_contact_loss_cam_angle": angle,
            "rigid_maximum_valve_lift": float(system.mechanism.kinematics.maximum_lift),
        }  # fmt: skip
        found |= named({name: value for name, value in values.items() if np.isfinite(value)}, None, spring_set)
    return found


def _progress(progress: Callable[[float, str], None] | None, jobs: Sequence[RunJob], done: int, total: int) -> None:
    if progress is not None:
        progress(done / total, jobs[done - 1].variant.label)


def _named(job: RunJob, steady: SteadyTrain, table: RigidTable, train: TrainParameters, spring_set: str) -> TrainRun:
    data = cycle_data(steady, table)
    finite = bool(np.all(np.isfinite(data.valve_lift))) and steady.record.status.completed
    events = cycle_events(steady, data) if finite else ()
    numbers = cycle_quantities(steady, data, table, events) if finite else {}
    traces = cycle_traces(steady, data, train) if finite and job.keep_traces else None
    if traces is not None:
        numbers |= _trace_numbers(traces)
    return TrainRun(
        job.variant.label, train.spring_model, spring_set, job.engine_speed, numbers, events, steady.status, traces,
        table if job.keep_traces else None, steady.wall_time_per_cycle,
    )  # fmt: skip


def _trace_numbers(traces: Any) -> dict[str, float]:
    """Numbers that need the traces: mean peak motion of the coil sections, least clearance of the piston."""
    values = {}
    for spring in traces.springs:
        peak = spring.peak_section_displacement
        if peak.size:
            values[f"{spring.name}_mean_peak_section_displacement"] = float(np.mean(peak))
    if traces.piston_clearance is not None:
        values["minimum_piston_clearance_gap"] = float(np.min(traces.piston_clearance))
    return values
