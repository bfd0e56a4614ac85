"""An optimisation file made ready: its case, what is varied, what is asked of a design, and the
plans of its points.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from valvetrain.errors import InputError
from valvetrain.explore.measure import (
    LIMIT,
    REST,
    RUNS,
    Constraint,
    LimitSearch,
    Measure,
    Objective,
)
from valvetrain.explore.optimum_file import (
    ConfirmModel,
    ConstraintModel,
    MeasureModel,
    OptimumText,
    SearchModel,
)
from valvetrain.explore.plan import Run, StudyPlan, case_of_file, varied_of_file
from valvetrain.explore.point import PointRequest, is_at_rest
from valvetrain.explore.samplers import sampler
from valvetrain.explore.space import ENGINE_SPEED, Uniform, Values, Varied
from valvetrain.parameters.case import Case
from valvetrain.registry import find
from valvetrain.solution.definition import definition_of, is_defined, no_quantity
from valvetrain.units import parse_quantity, si_speeds

_OF_CASE = re.compile(r"\s*(?:(\d+(?:\.\d+)?)\s*(?:x|\*|times)\s*(?:the\s+)?)?case\s*\Z")


@dataclass(frozen=True, eq=False)
class Confirmation:
    """Another model or a finer mesh that the best design is computed by: ``label``, and the plans
    of its points.
    """

    label: str
    plan: OptimumPlan


@dataclass(frozen=True, eq=False)
class OptimumPlan:
    """What a search does. ``plans``: the study of points at rest, at the runs, and of limit speeds,
    those that are needed.
    """

    title: str
    description: str
    case: Case
    varied: tuple[Varied, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    search: SearchModel
    plans: Mapping[str, StudyPlan]
    confirmations: tuple[Confirmation, ...] = ()

    @property
    def measures(self) -> tuple[Measure, ...]:
        """Every measure once, objectives first."""
        every = [one.measure for one in self.objectives] + [one.measure for one in self.constraints]
        return tuple(dict.fromkeys(every))

    @property
    def begins(self) -> dict[Measure, tuple[Measure, ...]]:
        """Measures of limit speeds whose bound is a share of the case -> what the case has at the
        lowest speed, for each of their runs.
        """
        found = {}
        for one in self.measures:
            if one.limit is not None and one.limit.share is not None:
                lowest, label = one.limit.engine_speeds[0], definition_of(one.quantity).label
                found[one] = tuple(
                    Measure(LIMIT, one.quantity, ((lowest, *run[1:]),), label) for run in one.runs
                )
        return found

    def with_limits(self, values: Mapping[Measure, float]) -> OptimumPlan:
        """The plan with the bounds of such limit speeds, from ``values`` of what :attr:`begins`
        asks for.
        """
        made: dict[Measure, Measure] = {}
        for one, begins in self.begins.items():
            assert one.limit is not None and one.limit.share is not None
            bounds = tuple(one.limit.share * values[begin] for begin in begins)
            made[one] = replace(one, limit=replace(one.limit, bound=bounds[0]), bounds=bounds)
        objectives = tuple(
            replace(goal, measure=made.get(goal.measure, goal.measure)) for goal in self.objectives
        )
        constraints = tuple(
            replace(bound, measure=made.get(bound.measure, bound.measure))
            for bound in self.constraints
        )
        return replace(self, objectives=objectives, constraints=constraints)

    def of_case(self, values: Mapping[Measure, float]) -> OptimumPlan:
        """The plan with bounds that are shares of what the case has. Raises :class:`InputError`
        where the case has no such number.
        """
        made = []
        for one in self.constraints:
            if one.share is not None:
                value = values.get(one.measure, float("nan"))
                if value != value:
                    raise InputError(
                        f"the case itself gives no {one.measure.label}, which a bound is a share of; give a number"
                    )
                one = replace(one, bound=one.share * value, scale=abs(value) or 1.0)
            made.append(one)
        return replace(self, constraints=tuple(made))


def read_optimum(text: OptimumText) -> OptimumPlan:
    """The plan of an optimisation file. Raises :class:`InputError`, one sentence with file, line
    and key.
    """
    model = text.model
    case = text.guarded(("case",), lambda: case_of_file(model.case, model.changes, text.folder))
    varied = varied_of_file(text, model.vary, case)
    for place, one in enumerate(varied):
        if one.key == ENGINE_SPEED:
            raise text.located(
                ("vary", place, "key"),
                "is no part of a design; give engine_speeds, or a limit_speed as an objective",
            )
        if not isinstance(one.distribution, (Uniform, Values)):
            raise text.located(
                ("vary", place),
                "a search goes between low and high or through values; give one of them",
            )
    for key, word in (
        ("rest_model", model.rest_model),
        *(("spring_models", one) for one in model.spring_models),
    ):
        if word:
            text.guarded((key,), lambda word=word: find("springs", word))
    if model.spring_sets and (
        case.train is None or any(one not in case.train.springs for one in model.spring_sets)
    ):
        raise text.located(
            ("spring_sets",),
            f"case '{case.name}' has no spring set {', '.join(model.spring_sets)[:80]}; correct it",
        )
    objectives = tuple(
        Objective(
            _measure(text, ("objective", place), one, case, one.direction == "minimise"),
            one.direction == "maximise",
        )
        for place, one in enumerate(model.objective)
    )
    if len({one.measure for one in objectives}) < len(objectives):
        raise text.located(("objective",), "the same objective stands there twice; say it once")
    constraints = tuple(
        itertools.chain.from_iterable(
            _constraints(text, ("constraint", place), one, case)
            for place, one in enumerate(model.constraint)
        )
    )
    if model.search.method == "cma-es" and len(objectives) > 1:
        raise text.located(
            ("search", "method"), "cma-es knows one objective; take nsga2 or tpe for several"
        )
    if model.search.method == "nsga2" and model.search.per_round < 4:
        raise text.located(
            ("search", "per_round"),
            "a generation of nsga2 has 4 trials or more; raise per_round, 16 to 40 are usual",
        )
    title = model.title or f"{case.name}: {objectives[0].measure.label}"
    plan = OptimumPlan(
        title, model.description, case, varied, objectives, constraints, model.search, {}
    )
    plan = replace(plan, plans=_plans(plan, model.rest_model))
    confirmations = tuple(
        text.guarded(("confirm", place), lambda one=one: _confirmation(plan, one, text))
        for place, one in enumerate(model.confirm)
    )
    return replace(plan, confirmations=confirmations)


def _plans(plan: OptimumPlan, rest_model: str) -> dict[str, StudyPlan]:
    """A study of points for each source of numbers; it has outputs of its own, so that none costs
    more than it needs.
    """
    spec = sampler("list")
    found: dict[str, StudyPlan] = {}
    for source in (REST, RUNS, LIMIT):
        here = [one for one in plan.measures if one.source == source]
        if here:
            wanted = PointRequest(tuple(dict.fromkeys(one.quantity for one in here)), rest_model)
            runs = tuple(dict.fromkeys(run for one in here for run in one.runs))
            options = spec.read_options({})
            found[source] = StudyPlan(
                plan.title, "points", plan.case, plan.varied, spec, options, runs, wanted
            )
    return found


def _confirmation(plan: OptimumPlan, one: ConfirmModel, text: OptimumText) -> Confirmation:
    """The plan of a confirmation: the same measures by another model, or of the case with a finer
    mesh.
    """
    if not one.spring_model and not one.changes:
        raise InputError("confirms nothing; name a spring_model, or changes such as a finer mesh")
    case = plan.case
    if one.changes:
        case = case_of_file(text.model.case, {**text.model.changes, **one.changes}, text.folder)
    if one.spring_model:
        find("springs", one.spring_model)

    def other(measure: Measure) -> Measure:
        runs = tuple(
            dict.fromkeys((run[0], one.spring_model or run[1], run[2]) for run in measure.runs)
        )
        return replace(measure, runs=runs)

    made = replace(
        plan,
        case=case,
        objectives=tuple(replace(goal, measure=other(goal.measure)) for goal in plan.objectives),
        constraints=tuple(
            replace(bound, measure=other(bound.measure)) for bound in plan.constraints
        ),
    )
    made = replace(made, plans=_plans(made, text.model.rest_model))
    return Confirmation(one.label or one.spring_model or "with its changes", made)


def _measure(
    text: OptimumText,
    path: tuple[str | int, ...],
    one: MeasureModel,
    case: Case,
    largest_is_worst: bool,
) -> Measure:
    if bool(one.quantity) == (one.limit_speed is not None):
        raise text.located(
            path,
            "names "
            + ("both a quantity and a limit_speed" if one.quantity else "nothing")
            + "; give one of the two",
        )
    model = text.model
    words = one.quantity or (one.limit_speed.quantity if one.limit_speed else "")
    if not is_defined(words):
        key = (*path, "quantity") if one.quantity else (*path, "limit_speed", "quantity")
        raise text.located(key, no_quantity(words))
    kinds = itertools.product(
        dict.fromkeys(model.spring_models or ("",)), dict.fromkeys(model.spring_sets or ("",))
    )
    if one.limit_speed is not None:
        if one.engine_speeds is not None:
            raise text.located(
                (*path, "engine_speeds"),
                "a limit_speed has engine_speeds of its own; give them there",
            )
        if is_at_rest(words):
            raise text.located(
                (*path, "limit_speed"),
                f"'{words}' belongs to springs at rest, so it has no limit speed",
            )
        limit = text.guarded((*path, "limit_speed"), lambda: _limit(one))
        runs: tuple[Run, ...] = tuple(
            (None, spring_model, spring_set) for spring_model, spring_set in kinds
        )
        label = (
            one.label
            or f"speed up to which the {definition_of(words).label} stays within its bound"
        )
        return Measure(LIMIT, words, runs, label, largest_is_worst, one.over, limit)
    label = one.label or definition_of(words).label
    if is_at_rest(words):
        if one.engine_speeds is not None:
            raise text.located(
                (*path, "engine_speeds"),
                f"'{words}' belongs to springs at rest, at no engine speed; leave it out",
            )
        runs = tuple((None, spring_model, spring_set) for spring_model, spring_set in kinds)
        return Measure(REST, words, runs, label, largest_is_worst, one.over)
    own = one.engine_speeds is not None
    given, key = (
        (one.engine_speeds, (*path, "engine_speeds"))
        if own
        else (model.engine_speeds, ("engine_speeds",))
    )
    speeds = (
        text.guarded(key, lambda: si_speeds(given))
        if given is not None
        else case.operation.engine_speeds
    )
    if not speeds:
        raise text.located(
            path,
            f"the case names no engine speed, and '{words}' needs one; add engine_speeds = '6000 rpm'",
        )
    return Measure(
        RUNS,
        words,
        tuple((speed, *kind) for speed, kind in itertools.product(speeds, tuple(kinds))),
        label,
        largest_is_worst,
        one.over,
    )


def _limit(one: MeasureModel) -> LimitSearch:
    assert one.limit_speed is not None
    told = one.limit_speed
    if (told.at_most is None) == (told.at_least is None):
        raise InputError("has one bound: give at_most or at_least")
    upper = told.at_most is not None
    raw = told.at_most if upper else told.at_least
    share = _OF_CASE.match(raw) if isinstance(raw, str) else None
    bound = (
        float("nan")
        if share
        else parse_quantity(raw, definition_of(told.quantity).dimension or "ratio")
    )
    speeds = tuple(sorted(si_speeds(told.engine_speeds)))
    if len(speeds) < 2:
        raise InputError("engine_speeds holds one speed; give a range such as '4000:9000:250 rpm'")
    resolution = parse_quantity(told.resolution, "angular speed")
    if not resolution > 0:
        raise InputError("the resolution is not positive; give such as '10 rpm'")
    return LimitSearch(
        told.quantity, upper, bound, speeds, resolution, float(share[1] or 1.0) if share else None
    )


def _constraints(
    text: OptimumText, path: tuple[str | int, ...], one: ConstraintModel, case: Case
) -> list[Constraint]:
    """One constraint for each bound of a table."""
    bounds: Sequence[tuple[str, Any, bool]] = [
        (key, raw, key == "at_most")
        for key, raw in (("at_most", one.at_most), ("at_least", one.at_least))
        if raw is not None
    ]
    if not bounds:
        raise text.located(
            path,
            "has no bound; give at_most, at_least or both, such as at_most = '900 MPa' or '1.0 x case'",
        )
    made = []
    for key, raw, upper in bounds:
        measure = _measure(text, path, one, case, upper)
        share = _OF_CASE.match(raw) if isinstance(raw, str) else None
        if share is not None:
            made.append(Constraint(measure, upper, float("nan"), float(share[1] or 1.0)))
            continue
        dimension = (
            "angular speed"
            if measure.limit is not None
            else definition_of(measure.quantity).dimension or "ratio"
        )
        bound = text.guarded(
            (*path, key), lambda raw=raw, dimension=dimension: parse_quantity(raw, dimension)
        )
        made.append(Constraint(measure, upper, bound, None, abs(bound) or 1.0))
    return made
