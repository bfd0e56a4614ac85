"""Evaluation of one point, bit-identical to a run of the same case."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cam.cached import RememberedLift
from valvetrain.cam.contract import build_lift_law
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.explore.case_paths import vary
from valvetrain.explore.outputs import DRIVE_FORCE, Outcome, Run
from valvetrain.explore.space import ENGINE_SPEED, Varied
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.quantities.request import PointRequest
from valvetrain.quantities.statics import (
    buckling_quantities,
    design_quantities,
    rest_quantities,
    size_quantities,
)
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    integrate_point,
    prepare,
    provenance_of,
    with_quantities,
)
from valvetrain.runs.refusals import refuse_implausible, refuse_speeds
from valvetrain.runs.requests import Run as RunOfCase
from valvetrain.runs.run import run_study
from valvetrain.runs.statics import reach_of, spring_statics, statics_by_model
from valvetrain.runs.train_runs import prepare_trains, rigid_numbers, train_point
from valvetrain.solution.definition import ADDED, NESTED, PAIR
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import COMPLETED, PartialFailures, Status, reason
from valvetrain.solution.uncertainty import Uncertainty
from valvetrain.springs.contract import SpringModel
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem, Rest

#: Steps of a static curve by a spring model; named numbers come from a path of their own and do not
#: depend on it.
CURVE_STEPS, MODES = 24, 12
#: Points whose cases are made again to count what is doubtful.
MAX_POINTS = 300


def at_values(case: Case, values: Mapping[Varied, float], run: Run) -> tuple[Case, Run]:
    """The case with varied quantities at ``values`` (SI), and the run at the engine speed among them. Raises as :func:`vary`.

    >>> import valvetrain as vt
    >>> at_values(vt.load_case("job-t"), {Varied(ENGINE_SPEED, "rpm"): 300.0}, Run())[1].engine_speed
    300.0
    """
    speeds = (value for one, value in values.items() if one.key == ENGINE_SPEED)
    # what is doubtful of points is counted once, by :func:`doubts`, not reported by each
    with warnings.catch_warnings(action="ignore", category=UnusualValueWarning):
        return vary(case, values), run._replace(engine_speed=next(speeds, run.engine_speed))


def evaluate(
    case: Case, values: Mapping[Varied, float], run: Run, request: PointRequest
) -> Outcome:
    """The numbers of a point: a case with varied quantities at ``values`` (SI) in a run; what cannot be built or run is a
    status with its sentence, never an exception.

    >>> import valvetrain as vt
    >>> evaluate(vt.load_case("job-c"), {}, Run(400.0, "massless"), PointRequest(("peak_spring_force",))).status.code
    'completed'
    """
    try:
        return evaluate_case(*at_values(case, values, run), request)
    except FAILURES as error:
        return Outcome(Status("refused", reason(error)))


def evaluate_case(case: Case, run: Run, request: PointRequest) -> Outcome:
    """The numbers of ``case`` in a run. Raises what building and running raises."""
    problem = build(case, spring_models=run.models, spring_set=run.spring_sets)
    if problem.kind != TRAIN and case.lift_law is not None:
        lift = _remembered(case.lift_law)
        members = tuple(replace(member, valve_lift=lift) for member in problem.members)
        problem = replace(problem, valve_lift=lift, members=members)
    if run.engine_speed is not None and request.motion:
        by_case = problem.members[0].instead
        problem = problem.settled()
        if (
            instead := problem.members[0].instead
        ) != by_case:  # no point by another model than its neighbours
            raise InputError(f"{instead}; name spring_models, such as multi-mass", "spring_models")
    member = problem.members[0]
    if member.refusal:
        raise InputError(member.refusal)
    engine_speed = run.engine_speed if request.motion and problem.moves else None
    if engine_speed is not None:
        refuse_speeds(problem, (engine_speed,))
        refuse_implausible(problem, (engine_speed,))
    compute = _train if problem.kind == TRAIN else _spring
    status, values = compute(problem, member, engine_speed, request)
    names = request.outputs or values
    return Outcome(status, {name: float(values[name]) for name in names if name in values})


@lru_cache(maxsize=4)
def _remembered(law: LiftLawParameters) -> RememberedLift:
    """The cached lift that other points of the same law have made."""
    return RememberedLift(build_lift_law(law))


def _spring(
    problem: Problem, member: Member, engine_speed: float | None, request: PointRequest
) -> tuple[Status, dict[str, float]]:
    """Prescribed motion, as :func:`valvetrain.runs.run.run_study` runs it."""
    lift = float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))
    by_rod = (engine_speed is not None and (member.model.needs_rest or not request.light)) or (
        request.rest and not request.rest_model and not request.sizes_alone
    )
    rest: Rest = (
        {spring: spring_statics(problem, spring, lift) for spring in member.springs}
        if by_rod
        else {}
    )
    status, values = COMPLETED, dict[str, float]()
    if engine_speed is not None:
        ready = prepare(
            problem,
            member,
            rest if member.model.needs_rest else {},
            "" if request.light else problem.record.study,
        )
        samples = round(2 * np.pi / problem.output_step)
        plan = Plan("ends" if request.light else "all", samples, not request.light, problem.cycles)
        solution = integrate_point(
            ready, engine_speed, plan, provenance_of(problem, member, engine_speed, "")
        )
        judged = with_quantities(ready, solution, plan, rest)
        status, values = judged.status, dict(judged.quantities)
    return status, values | (_still(problem, member, rest, lift, request) if request.rest else {})


def _still(
    problem: Problem, member: Member, rest: Rest, lift: float, request: PointRequest
) -> dict[str, float]:
    """Numbers of the springs at rest, those of a nested pair with the name of each in front."""
    numbers: dict[str, float] = {}
    names = ("",) if len(member.springs) == 1 else ("outer_", "inner_")
    published = [value.quantity for value in problem.record.published]
    for name, spring in zip(names, member.springs, strict=True):
        of_spring = size_quantities(spring) if not request.outputs else design_quantities(spring)
        at_rest = rest.get(spring)
        if request.rest_model and not request.sizes_alone:
            at_rest = _by_model(problem, spring, request.rest_model, lift)
        if at_rest is not None and not request.sizes_alone:
            of_spring |= rest_quantities(at_rest, published)
            of_spring |= buckling_quantities(spring, at_rest, lift)
        numbers |= {name + key: value for key, value in of_spring.items()}
    both = [(key, [f"{spring}_{key}" for spring in NESTED]) for key in ADDED]
    return numbers | {
        f"{PAIR}_{key}": sum(numbers[name] for name in pair)
        for key, pair in both
        if all(name in numbers for name in pair)
    }


def _by_model(problem: Problem, spring: InstalledSpring, word: str, lift: float) -> SpringAtRest:
    reach = (
        reach_of(spring, lift)
        if spring.wire is not None
        else spring.precompression + max(1.06 * lift, 0.2 * spring.precompression)
    )
    model: SpringModel = problem.model_of(word, spring)
    return statics_by_model(spring, word, model, np.linspace(0.0, reach, CURVE_STEPS + 1), MODES)


def _train(
    problem: Problem, member: Member, engine_speed: float | None, request: PointRequest
) -> tuple[Status, dict[str, float]]:
    """A train to its periodic state, as a run does it, with what rigid theory says and its springs
    at rest where they are requested.
    """
    values: dict[str, float] = {}
    status = COMPLETED
    gaps = PartialFailures()
    speeds = (engine_speed,) if engine_speed is not None else problem.engine_speeds
    if engine_speed is not None or request.rigid:
        ready, _ = prepare_trains(problem, speeds, gaps)
    if engine_speed is not None:
        plan = Plan("all", None, True, problem.cycles, problem.cycles_to_settle)
        solution: Solution = train_point((problem, ready, plan), (0, engine_speed))
        status, values = solution.status, dict(solution.quantities)
        least = re.compile("minimum_.+_contact_force")  # which contacts of the drive alone have
        forces = [value for name, value in values.items() if least.fullmatch(name)]
        if DRIVE_FORCE in request.outputs and forces:
            values[DRIVE_FORCE] = min(forces)
    if request.rigid or (request.rest and engine_speed is not None):
        values |= rigid_numbers(ready, speeds).get(member.spring_set, {})
    by_rod = not (request.rest_model or request.sizes_alone)
    lacks = bool(request.outputs) and not all(name in values for name in request.outputs)
    if request.rest and (lacks or not by_rod):
        assert member.gear is not None
        lift = float(member.gear.mechanism.kinematics.maximum_lift)
        springs = member.springs if by_rod else ()
        rest = {spring: spring_statics(problem, spring, lift) for spring in springs}
        values |= _still(problem, member, rest, lift, request)
    return status, values


def bars_of(
    case: Case, values: Mapping[Varied, float], run: Run, request: PointRequest
) -> tuple[Uncertainty, ...]:
    """Error bars of the numbers of a point; none of a spring at rest and of what cannot run."""
    try:
        case, run = at_values(case, values, run)
        if run.engine_speed is None or not request.motion:
            return ()
        study = run_study(RunOfCase(
            case=case, engine_speeds=(run.engine_speed,), models=run.models, spring_sets=run.spring_sets, workers=1, compute=("error_bars",),
        ))  # fmt: skip
    except FAILURES:
        return ()
    return study.error_bars.rows


def doubts(
    case: Case | None,
    varied: Sequence[Varied],
    draws: Array | Sequence[Sequence[float]],
) -> dict[int, str]:
    """Those of the first :data:`MAX_POINTS` ``draws`` (n, d; SI) that have doubtful values which the case itself has not:
    place -> its first warning. A function has none.

    >>> import valvetrain as vt
    >>> case, height = vt.load_case("vaz-ohc"), Varied("train.springs.nested-cards.0.rate", "N/mm")
    >>> doubts(case, (height,), [[17e3]])
    {}
    """
    own = list(draws)[:MAX_POINTS]
    found: dict[int, str] = {}
    for point, draw in enumerate(own if case is not None else ()):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                assert case is not None
                vary(case, dict(zip(varied, map(float, draw), strict=True)))
            except InputError:
                continue  # a point that cannot be built is reported as that
        texts = [str(one.message) for one in caught if one.category is UnusualValueWarning]
        if new := [text for text in texts if text.startswith("at ")]:
            found[point] = new[0]
    return found
