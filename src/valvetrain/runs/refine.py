"""Error bars of any case (:func:`refine`): meshes and steps refined, contact constants varied; here
of springs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.quantities.clash import ClashWindow, find_clash_window, main_clash_quantities
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.statics import modal_quantities
from valvetrain.runs.cost import FEWER_REFINED, Limits, limits_of, refine_cost, refuse_cost
from valvetrain.runs.error_bars import (
    OWN,
    SPRING_HEADLINES,
    STIFFNESS_FACTORS,
    TRUSTED,
    Numbers,
    Stages,
    UncertaintyStudy,
    contact_ranges,
    convergence,
    damped,
    stiffened,
)
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    integrate_point,
    prepare,
    provenance_of,
    with_quantities,
)
from valvetrain.runs.refine_trains import refine_trains
from valvetrain.runs.refusals import checked_speeds
from valvetrain.runs.statics import MODES
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.stored_error_bars import ROD
from valvetrain.runs.workers import Progress, worker_count
from valvetrain.solution.critical import DAMPING_FACTORS
from valvetrain.solution.definition import pattern_of, tables
from valvetrain.solution.result import Solution
from valvetrain.solution.status import reason
from valvetrain.solution.uncertainty import Uncertainty
from valvetrain.springs.finite_element import FiniteElementRod, modal_result
from valvetrain.system.build import build
from valvetrain.system.prescribed import names_of
from valvetrain.system.problem import Problem
from valvetrain.units import Given, known_arguments, si_speeds


@known_arguments
@shows_progress("refine")
def refine(
    case: AnyCase,
    engine_speeds: Given | Sequence[Given] | None = None,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
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
    workers : runs at a time; results do not depend on it
    progress : called with the share done and a text
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    implausible : let values pass that no valvetrain can have (docs/plausible.md)

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
    limits, case, count = limits_of(limit), case_of(case), worker_count(workers)
    speeds = None if engine_speeds is None else si_speeds(engine_speeds)
    refuse_cost(refine_cost(case, speeds, count), limits, "limit=", FEWER_REFINED)
    return refined(
        case, speeds, workers=count, progress=progress, limits=limits, implausible=implausible
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
    case's own), whatever they cost.

    ``limits`` of one run; ``implausible`` values pass. A variant that fails is one of the
    ``failures``. Raises :class:`InputError` for a case that cannot be refined and what
    :func:`valvetrain.runs.run.run_study` refuses, :class:`RefinementStopped` with what is finished
    when it is stopped.
    """
    if case.train is not None:
        return refine_trains(
            case, engine_speeds, workers=workers, progress=progress, implausible=implausible
        )
    return refine_springs(
        case,
        engine_speeds,
        workers=workers,
        progress=progress,
        limits=limits,
        implausible=implausible,
    )


#: Elements per coil over those of the case.
REFINEMENTS = (1.0, 1.5, 2.25)


def refine_springs(
    case: Case,
    engine_speeds: Sequence[float] | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> UncertaintyStudy:
    """Error bars of springs under prescribed motion: see :func:`refined`; runs over ``workers``
    threads.
    """
    if (
        case.lift_law is None
        or not case.springs
        or any(spring.wire is None for spring in case.springs)
    ):
        raise InputError(
            f"case '{case.name}' needs a [spring] with its wire and a [lift_law] to be refined; give it both"
        )
    problem = build(case, spring_models=("finite-element",))
    speeds = checked_speeds(problem, engine_speeds, implausible)
    samples = round(2 * np.pi / problem.output_step)
    plan = Plan(
        samples=samples, cycles=problem.cycles, max_seconds=limits.seconds, implausible=implausible
    )
    # The own mesh comes first: its surge frequencies and clash windows define the numbers of every variant.
    base, base_numbers = _prepare((problem, ()), problem.members[0].springs)
    changed, failures, stages = _variants(base), list[str](), Stages()
    names = tuple(changed)
    prepared = stages.map(
        _prepare_variant,
        (problem, base.frame.surge_frequencies),
        tuple(changed.items()),
        workers,
        tell=_stage(progress, 0.0, 0.05, "statics and modes"),
    )
    runs = {OWN: base}
    values: dict[str, dict[float | None, Numbers]] = {OWN: {None: base_numbers}}
    for index, (variant, numbers, failure) in sorted(prepared.items()):
        failures += [failure] if failure else []
        if variant is not None:
            runs[names[index]], values[names[index]] = variant, {None: numbers}
    own = {
        speeds[index]: solution
        for index, solution in stages.map(
            _run,
            (problem, plan),
            [(base, speed) for speed in speeds],
            workers,
            tell=_stage(progress, 0.05, 0.1, "own mesh"),
        ).items()
    }
    windows = {speed: _window(base, solution) for speed, solution in own.items()}

    def run_variant(shared: tuple[Problem, Plan], job: tuple[float, str]) -> tuple[Numbers, str]:
        speed, name = job
        position = f"{name} at {speed * 30 / np.pi:.0f} rpm"
        try:
            solution = own[speed] if name == OWN else _run(shared, (runs[name], speed))
            failure = (
                "" if solution.status.completed else f"{position}: {solution.status.sentence()}"
            )
            return _moving(solution, windows[speed], problem.record.study), failure
        except FAILURES as error:
            return {}, f"{position}: {reason(error)}"

    jobs = [(speed, name) for speed in speeds for name in runs]
    moving = stages.map(
        run_variant, (problem, plan), jobs, workers, tell=_stage(progress, 0.1, 1.0, "variants")
    )
    for index, (numbers, failure) in moving.items():
        speed, name = jobs[index]
        values[name][speed] = numbers
        failures += [failure] if failure else []
    if not moving:  # stopped before: the numbers of the own mesh are there
        values[OWN] |= {
            speed: _moving(solution, windows[speed], problem.record.study)
            for speed, solution in own.items()
        }
    missing = {speed for index, (speed, _) in enumerate(jobs) if index not in moving}
    complete: list[float | None] = [None] if len(prepared) == len(changed) else []
    if own:
        complete += [speed for speed in speeds if speed not in missing]
    own_elements = _rods(base)[0].elements_per_coil
    elements = (own_elements, *(round(own_elements * ratio) for ratio in REFINEMENTS[1:]))
    study = UncertaintyStudy(
        problem.record,
        elements,
        tuple(_rows(values, elements, complete)),
        values,
        tuple(failures),
        runs=len(speeds) * (1 + len(changed)),
        finished=len(moving) or len(own),
    )
    return stages.closed(study)


def _stage(
    progress: Progress | None, begin: float, end: float, name: str
) -> Callable[[int, int], None]:
    """Reports a stage of the study as its share of the whole."""

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress(begin + (end - begin) * done / total, f"{name}, {done} of {total}")

    return tell


def _prepare(
    shared: tuple[Problem, tuple[float, ...]], springs: tuple[InstalledSpring, ...]
) -> tuple[PreparedRun, Numbers]:
    """The run with other springs, and their static numbers; ``shared``: problem, surge frequencies
    (none: its own).
    """
    problem, surge = shared
    one = prepare(problem, replace(problem.members[0], springs=springs), {}, problem.record.study)
    rods = _rods(one)
    if one.refusal or len(rods) != len(springs):
        raise InputError(
            one.refusal
            or "springs that rub on each other cannot be refined; leave the rubbing out of the case"
        )
    numbers: dict[str, float] = {}
    first: list[float] = []
    for rod, name in zip(rods, names_of(rods), strict=True):
        found = {"preload": float(rod.installed.retainer_force)}
        found |= modal_quantities(modal_result(rod, MODES))
        prefix = f"{name}_" if len(rods) > 1 else ""
        numbers |= {prefix + key: value for key, value in found.items()}
        first += [found["mode_1_frequency"]] if "mode_1_frequency" in found else []
    return replace(one, frame=replace(one.frame, surge_frequencies=surge or tuple(first))), numbers


def _prepare_variant(
    shared: tuple[Problem, tuple[float, ...]], variant: tuple[str, tuple[InstalledSpring, ...]]
) -> tuple[PreparedRun | None, Numbers, str]:
    """A named variant, prepared with its static numbers, or why it cannot be."""
    try:
        return (*_prepare(shared, variant[1]), "")
    except FAILURES as error:
        return None, {}, f"{variant[0]}: {reason(error)}"


def _rods(prepared: PreparedRun) -> tuple[FiniteElementRod, ...]:
    springs = () if prepared.system is None else prepared.system.springs
    return tuple(spring for spring in springs if isinstance(spring, FiniteElementRod))


def _run(shared: tuple[Problem, Plan], point: tuple[PreparedRun, float]) -> Solution:
    (problem, plan), (prepared, speed) = shared, point
    provenance = provenance_of(problem, prepared.member, speed, "")
    return with_quantities(prepared, integrate_point(prepared, speed, plan, provenance), plan, {})


def _variants(base: PreparedRun) -> dict[str, tuple[InstalledSpring, ...]]:
    """Installed springs of every variant but the case's own mesh."""
    springs, rods = base.member.springs, _rods(base)
    pairs = tuple(zip(springs, rods, strict=True))

    def refined(ratio: float) -> tuple[InstalledSpring, ...]:
        counts = (round(rod.elements_per_coil * ratio) for rod in rods)
        return tuple(
            spring.with_options("finite-element", elements_per_coil=count)
            for spring, count in zip(springs, counts, strict=True)
        )

    variants = {f"mesh {n}": refined(REFINEMENTS[n - 1]) for n in (2, 3)}
    variants["half step"] = tuple(
        spring.with_options(
            "finite-element", time_step=0.5 * (rod.time_step or rod.stable_time_step())
        )
        for spring, rod in pairs
    )
    for n, factor in enumerate(STIFFNESS_FACTORS, start=1):
        variants[f"contact stiffness {n}"] = tuple(stiffened(spring, factor) for spring in springs)
    for n, factor in enumerate(DAMPING_FACTORS, start=1):
        variants[f"damping {n}"] = tuple(damped(spring, factor) for spring in springs)
    return variants


def _window(base: PreparedRun, solution: Solution) -> ClashWindow | None:
    """The window of the main clash on the case's own mesh, in which all variants are read."""
    surge, event = base.frame.surge_frequency, base.frame.lift_event
    if surge is None or event is None or len(solution.time) < 3:
        return None
    return find_clash_window(reported_cycle(solution), surge, event)


def _moving(solution: Solution, window: ClashWindow | None, study: str) -> dict[str, float]:
    """Headline numbers of a run; none of one that failed."""
    if not solution.status.completed:
        return {}
    found = dict(solution.quantities)
    if window is not None:
        found |= main_clash_quantities(reported_cycle(solution), window)
    patterns = [
        pattern_of(row.name) for row in tables().get(study, ()) if row.name.endswith("_force")
    ]
    sourced = (name for name in found if any(pattern.fullmatch(name) for pattern in patterns))
    names = dict.fromkeys((*SPRING_HEADLINES, *sourced))
    return {name: float(found[name]) for name in names if name in found}


def _rows(
    values: Mapping[str, Mapping[float | None, Numbers]],
    elements: tuple[int, ...],
    speeds: Sequence[float | None],
) -> list[Uncertainty]:
    """Rows at ``speeds`` (None: statics and modes) of every number with a finer mesh and the halved
    step.
    """
    rows = []
    for speed in speeds:
        for name, value in values[OWN].get(speed, {}).items():

            def of(variant: str, speed: float | None = speed, name: str = name) -> float | None:
                return values.get(variant, {}).get(speed, {}).get(name)

            halved = of("half step")
            mesh = convergence(value, (of("mesh 2"), of("mesh 3")), elements)
            if mesh is None or (halved is None and speed is not None):
                continue
            # Second order in the step: a quarter of its error is left after halving.
            step = 0.0 if halved is None or speed is None else TRUSTED * 4 / 3 * abs(value - halved)
            numerical = mesh.uncertainty + step
            order, limit = mesh.observed_order, mesh.extrapolated
            ranges = contact_ranges(value, of)
            label = "" if speed is None else ROD
            rows.append(
                Uncertainty(name, speed, value, numerical, order, limit, step, *ranges, label)
            )
    return rows
