"""Error bars of any case (:func:`refine`): springs divided more finely, steps halved, contact constants varied."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from valvetrain.errors import InputError
from valvetrain.integrate.train_leapfrog import LARGE_SAMPLES
from valvetrain.integrate.train_leapfrog import SAMPLES as TRAIN_SAMPLES
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import AnyCase
from valvetrain.quantities.clash import ClashWindow, find_clash_window, main_clash_quantities
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.runs.api import Speeds
from valvetrain.runs.cost import FEWER_REFINED, Limits, refuse_cost
from valvetrain.runs.error_bars import (
    OWN,
    ROUNDING,
    SPRING_HEADLINES,
    TRAIN_HEADLINES,
    TRUSTED,
    Numbers,
    Stages,
    UncertaintyStudy,
    contact_ranges,
    convergence,
)
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    integrate_from,
    provenance_of,
    with_quantities,
)
from valvetrain.runs.refine_variants import (
    DIVISION,
    is_large,
    place_of,
    prepare_refined,
    prepare_variant,
    rods_of,
    variants_of,
)
from valvetrain.runs.refusals import checked_speeds
from valvetrain.runs.requests import Refine
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.stored_error_bars import ROD
from valvetrain.runs.workers import LOST, LOST_REMEDY, Progress
from valvetrain.solution.definition import pattern_of, tables
from valvetrain.solution.result import Solution
from valvetrain.solution.status import reason
from valvetrain.solution.uncertainty import Uncertainty
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Problem
from valvetrain.system.train_system import TrainSystem


@shows_progress("refine")
def refine(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    *,
    progress: Progress | None = None,
    **options: Any,
) -> UncertaintyStudy:
    """Error bars of the headline numbers: finer meshes and steps, other contact constants.

    Numerical uncertainty by the grid convergence index (Roache 1994; Celik et al. 2008), of a
    spring from three meshes and a halved step, of a train from three steps and finer springs.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file; a spring with its wire and a lift
        law, or a train
    engine_speeds : speeds of the crank, "4200 rpm", rad/s or pint quantities; the case's own by
        default
    progress : called with the share done and a text
    options : ``workers``, ``limit`` and ``implausible`` as for :func:`valvetrain.simulate`

    Returns
    -------
    UncertaintyStudy whose ``rows`` hold value and uncertainty (SI) by quantity and speed; a variant
    that fails is one of its ``failures``

    Raises
    ------
    InputError : what cannot be built or refined, is too large or implausible
    RefinementStopped : a KeyboardInterrupt whose ``study`` holds what was finished

    Examples
    --------
    >>> import valvetrain as vt
    >>> case = vt.load_case("tdi-pushrod")
    >>> stock = case.replace(train=case.train.replace(variants=case.train.variants[:1]))
    >>> row = next(row for row in vt.refine(stock, "2000 rpm").rows if row.quantity == "peak_spring_force")
    >>> row.numerical < 0.01 * row.value
    True
    """
    request = Refine.read({"case": case, "engine_speeds": engine_speeds, **options})
    refuse_cost(request.cost(), request.limit, "limit=", FEWER_REFINED)
    return refined(
        request.case,
        request.engine_speeds,
        workers=request.worker_count,
        progress=progress,
        limits=request.limit,
        implausible=request.implausible,
    )


def refined(
    case: Case,
    engine_speeds: Sequence[float] | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> UncertaintyStudy:
    """Error bars of a case's headline numbers at ``engine_speeds`` (rad/s of the crank; None: the
    case's own), whatever they cost: springs alone over ``workers`` threads, trains over processes.

    ``limits`` of one run; ``implausible`` values pass. A variant that fails is one of the
    ``failures``. A train on finite-element springs gets two grids of each kind instead of three
    (:func:`two_grids`), since a finer run takes many times as long. Raises :class:`InputError` for a
    case that cannot be refined and what :func:`valvetrain.runs.run.run_study` refuses,
    :class:`RefinementStopped` with what is finished when it is stopped.
    """
    train = case.train is not None
    wires = bool(case.springs) and all(spring.wire is not None for spring in case.springs)
    if not train and (case.lift_law is None or not wires):
        raise InputError(
            f"case '{case.name}' needs a [spring] with its wire and a [lift_law] to be refined; give it both"
        )
    problem = build(case).settled() if train else build(case, spring_models=(ROD,))
    speeds = checked_speeds(problem, engine_speeds, implausible)
    plan = Plan(
        samples=None if train else round(2 * np.pi / problem.output_step),
        cycles=problem.cycles,
        cycles_to_settle=problem.cycles_to_settle,
        max_seconds=limits.seconds,
        implausible=implausible,
    )
    # The own mesh comes first: its surge frequencies and clash windows define the numbers of every variant.
    ready: dict[str, dict[int, PreparedRun]] = {OWN: {}}
    at_rest: dict[str, Numbers] = {}
    failures, stages = list[str](), Stages()
    for index, member in enumerate(problem.members):
        try:
            ready[OWN][index], numbers = prepare_refined(problem, member)
        except FAILURES as error:
            if not train:
                raise
            failures.append(f"{place_of(member, OWN)}: {reason(error)}")
        else:
            at_rest |= {OWN: numbers} if numbers else {}
    variants = variants_of(case, problem, ready[OWN], failures)
    prepared = stages.map(
        prepare_variant,
        ready[OWN],
        variants,
        workers,
        tell=_stage(progress, 0.0, 0.05, "statics and modes"),
    )
    for number, (one, numbers, failure) in sorted(prepared.items()):
        variant = variants[number]
        failures += [failure] if failure else []
        at_rest |= {variant.name: numbers} if numbers else {}
        if one is not None:
            ready.setdefault(variant.name, {})[variant.member] = one

    def lost(job: _Job) -> _Result:
        place = place_of(problem.members[job.member], job.variant)
        return _Result({}, None, f"{place}: {LOST}; {LOST_REMEDY}")

    results: dict[_Job, _Result] = {}
    windows: dict[float, ClashWindow | None] = {}
    jobs = [_Job(OWN, index, speed) for speed in speeds for index in ready[OWN]]
    further = [one for job in jobs for one in _further(job, ready)]
    for batch, begin, end, name in ((jobs, 0.05, 0.1, OWN), (further, 0.1, 1.0, "variants")):
        shared = problem, ready, plan, dict(windows)
        found = stages.map(
            _run, shared, batch, workers, processes=train, tell=_stage(progress, begin, end, name), lost=lost,
        )  # fmt: skip
        results |= {batch[number]: result for number, result in sorted(found.items())}
        windows |= {job.engine_speed: result.window for job, result in results.items()}
    values: dict[str, dict[float | None, Numbers]] = {}
    for name, numbers in at_rest.items():
        values[name] = {None: numbers}
    by_run: dict[tuple[float, int], dict[str, Numbers]] = {}
    for job, result in results.items():
        place = place_of(problem.members[job.member], job.variant)
        values.setdefault(place, {})[job.engine_speed] = result.numbers
        by_run.setdefault((job.engine_speed, job.member), {})[job.variant] = result.numbers
        failures += [result.failure] if result.failure else []
    missing = {(one.engine_speed, one.member) for one in (*jobs, *further) if one not in results}
    elements: tuple[int, ...] = ()
    if not train:
        of_case = rods_of(ready[OWN][0])[0].elements_per_coil
        elements = (of_case, *(round(of_case * factor) for factor in DIVISION))
    rows = list(_rows(at_rest, None, "", elements)) if len(prepared) == len(variants) else []
    for (speed, index), numbers_of in by_run.items():
        if (speed, index) not in missing:
            rows += _rows(numbers_of, speed, problem.members[index].label, elements)
    unprepared = len(speeds) * (len(variants) - len(prepared))
    study = UncertaintyStudy(
        problem.record,
        elements,
        tuple(rows),
        values,
        tuple(failures),
        runs=len(jobs) + len(further) + unprepared,
        finished=len(results),
    )
    return stages.closed(study)


#: Steps of a train over its default one; its samples per cam revolution, half the default.
STEPS, SAMPLES = (0.5, 0.25), 720


class _Job(NamedTuple):
    """One run: variant of the study, index of the member, engine speed (rad/s), step of a train over the
    default, its samples per revolution.
    """

    variant: str
    member: int
    engine_speed: float
    step: float = 1.0
    samples: int | None = None


class _Result(NamedTuple):
    """Headline numbers of a run, the window of its main clash, and why it failed."""

    numbers: Numbers
    window: ClashWindow | None = None
    failure: str = ""


#: Problem, prepared members by variant, plan, and windows of the main clash by engine speed (rad/s).
_Shared = tuple[
    Problem, Mapping[str, Mapping[int, PreparedRun]], Plan, Mapping[float, ClashWindow | None]
]


def _stage(
    progress: Progress | None, begin: float, end: float, name: str
) -> Callable[[int, int], None]:
    """Reports a stage of the study as its share of the whole."""

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress(begin + (end - begin) * done / total, f"{name}, {done} of {total}")

    return tell


def _further(job: _Job, ready: Mapping[str, Mapping[int, PreparedRun]]) -> Iterator[_Job]:
    """The runs that judge one with the mesh and step of the case."""
    member = ready[OWN][job.member].member
    if member.gear is not None:
        yield job._replace(variant="step 2", step=STEPS[0])
        if not is_large(member):
            yield job._replace(variant="step 3", step=STEPS[1])
            yield job._replace(variant="samples", samples=SAMPLES)
    for name, members in ready.items():
        if name != OWN and job.member in members:
            yield job._replace(variant=name)


def _run(shared: _Shared, job: _Job) -> _Result:
    """Headline numbers of one run and, where it failed, why."""
    problem, ready, plan, windows = shared
    prepared = ready.get(job.variant, ready[OWN])[job.member]
    place = f"{place_of(prepared.member, job.variant)} at {job.engine_speed * 30 / np.pi:.0f} rpm"
    try:
        solution = _solution(problem, plan, prepared, job)
        window = windows.get(job.engine_speed)
        if job.variant == OWN and problem.kind != TRAIN:
            window = _window(prepared, solution)
        if not solution.status.completed:
            return _Result({}, window, f"{place}: {solution.status.sentence()}")
        return _Result(_moving(solution, window, problem), window)
    except FAILURES as error:
        return _Result({}, None, f"{place}: {reason(error)}")


def _solution(problem: Problem, plan: Plan, prepared: PreparedRun, job: _Job) -> Solution:
    system, step = prepared.system, None
    if isinstance(system, TrainSystem) and (job.step != 1.0 or job.samples is not None):
        chosen = TrainOptions(LARGE_SAMPLES if system.has_large_springs else TRAIN_SAMPLES)
        default = runner(system, job.engine_speed / 2, chosen, rest=prepared.rest).time_step
        step = default * job.step * (1 + 1e-9)
    plan = plan if job.samples is None else replace(plan, samples=job.samples)
    provenance = provenance_of(problem, prepared.member, job.engine_speed, "")
    found, _ = integrate_from(prepared, job.engine_speed, plan, provenance, time_step=step)
    return with_quantities(prepared, found, plan, {})


def _window(base: PreparedRun, solution: Solution) -> ClashWindow | None:
    """The window of the main clash on the case's own mesh, in which all variants are read."""
    surge, event = base.frame.surge_frequency, base.frame.lift_event
    if surge is None or event is None or len(solution.time) < 3:
        return None
    return find_clash_window(reported_cycle(solution), surge, event)


def _moving(solution: Solution, window: ClashWindow | None, problem: Problem) -> Numbers:
    """Headline numbers of a completed run, and of a train how far they scatter over its cycles."""
    found = dict(solution.quantities)
    if window is not None:
        found |= main_clash_quantities(reported_cycle(solution), window)
    names = (*TRAIN_HEADLINES, *(f"cycle_scatter_{name}" for name in TRAIN_HEADLINES))
    if problem.kind != TRAIN:
        rows = tables().get(problem.record.study, ())
        patterns = [pattern_of(row.name) for row in rows if row.name.endswith("_force")]
        sourced = (name for name in found if any(pattern.fullmatch(name) for pattern in patterns))
        names = tuple(dict.fromkeys((*SPRING_HEADLINES, *sourced)))
    return {name: float(found[name]) for name in names if name in found}


def _rows(
    values: Mapping[str, Numbers], speed: float | None, label: str, elements: tuple[int, ...]
) -> Iterator[Uncertainty]:
    """Rows at a speed (rad/s; None: statics and modes) of every number with a halved step, of springs alone also with a finer mesh,
    of as many ``elements`` per coil; of a train there are none, and samples and scatter count too.
    """
    for name, value in values.get(OWN, {}).items():
        if not elements and (name not in TRAIN_HEADLINES or 0 < abs(value) < ROUNDING):
            continue

        def of(variant: str, name: str = name) -> float | None:
            return values.get(variant, {}).get(name)

        halved, sampled = of("step 2"), of("samples")
        mesh = convergence(value, (of("mesh 2"), of("mesh 3")), elements or (1.0, *DIVISION))
        if (halved is None and speed is not None) or (mesh is None and elements):
            continue
        meshes = 0.0 if mesh is None else mesh.uncertainty
        if elements or halved is None:
            assert mesh is not None
            series = mesh
            # Second order in the step: a quarter of its error is left after halving.
            step = 0.0 if halved is None or speed is None else TRUSTED * 4 / 3 * abs(value - halved)
            bar = meshes + step
        else:
            steps = convergence(value, (halved, of("step 3")), (1.0, *(1 / one for one in STEPS)))
            assert steps is not None
            series, step = steps, steps.uncertainty
            scatter = values[OWN].get(f"cycle_scatter_{name}", 0.0)
            bar = step + meshes + ((0.0 if sampled is None else abs(sampled - value)) + scatter)
        order, limit = series.observed_order, series.extrapolated
        yield Uncertainty(
            name, speed, value, bar, order, limit, step, *contact_ranges(value, of), label
        )
