"""The plan of an optimisation file: case, varied quantities, objectives, constraints, and the
evaluations of its points.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from valvetrain.errors import InputError
from valvetrain.explore.engine import Evaluation
from valvetrain.explore.files import case_of_file, space_of_file
from valvetrain.explore.limit_speed import LimitEvaluation
from valvetrain.explore.measure import (
    LIMIT,
    REST,
    RUNS,
    VARIED,
    Constraint,
    Evaluations,
    Measure,
    Objective,
)
from valvetrain.explore.optimum_file import (
    ConfirmModel,
    ConstraintModel,
    LimitSpeedModel,
    MeasureModel,
    OptimumText,
    SearchModel,
)
from valvetrain.explore.outputs import (
    LimitSearch,
    Outputs,
    Run,
    limit_search,
    refuse_limit_name,
    share_of_case,
)
from valvetrain.explore.space import ENGINE_SPEED, Space, Varied
from valvetrain.parameters.case import Case
from valvetrain.parameters.overrides import file_key
from valvetrain.quantities.request import is_at_rest
from valvetrain.registry import find
from valvetrain.solution.definition import definition_of, is_defined, no_quantity
from valvetrain.units import parse_quantity, si_speeds

#: Quantities that rank designs that lose contact, and whether the largest is the worst.
LOSSES = {"loss_of_contact_duration": True, "loft_gap": True, "minimum_spring_margin_force": False}


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
    case: Case | None
    varied: Space
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    search: SearchModel
    plans: Evaluations
    confirmations: tuple[Confirmation, ...] = ()

    @property
    def case_name(self) -> str:
        """Name of the case, or of the function."""
        if self.case is not None:
            return self.case.name
        function = next(iter(self.plans.values())).outputs.function
        return getattr(function, "__name__", "function")

    @property
    def measures(self) -> tuple[Measure, ...]:
        """Every measure once, objectives first."""
        every = [one.measure for one in self.objectives] + [one.measure for one in self.constraints]
        return tuple(dict.fromkeys([*every, *self.losses]))

    @property
    def losses(self) -> tuple[Measure, ...]:
        """How much contact is lost, the shortest loss first, for designs whose least contact force is zero
        alike; empty where no such force is an objective or bound.
        """
        bounded = [one.measure for one in self.constraints]
        every = [one.measure for one in self.objectives] + bounded
        runs = next((one.runs for one in every if one.is_contact_force), ())
        return tuple(
            Measure(RUNS, name, runs, name, more, optional=True)
            for name, more in (LOSSES if runs and self.case is not None else {}).items()
        )

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
    varied = space_of_file(text, model.vary, case)
    for place, one in enumerate(varied):
        if one.key == ENGINE_SPEED:
            raise text.located(
                ("vary", place, "key"),
                "is no part of a design; give engine_speeds, or a limit_speed as an objective",
            )
        if one.distribution.kind not in ("uniform", "log-uniform", "values"):
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
            _measure(text, ("objective", place), one, case, varied, one.direction == "minimise"),
            one.direction == "maximise",
        )
        for place, one in enumerate(model.objective)
    )
    if len({one.measure for one in objectives}) < len(objectives):
        raise text.located(("objective",), "the same objective is there twice; give it once")
    constraints = tuple(
        itertools.chain.from_iterable(
            _constraints(text, ("constraint", place), one, case, varied)
            for place, one in enumerate(model.constraint)
        )
    )
    _refuse_method(text, len(objectives))
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


def _refuse_method(text: OptimumText, objectives: int) -> None:
    """Raise for a method that does not fit the number of objectives or its round."""
    search = text.model.search
    if search.method == "cma-es" and objectives > 1:
        raise text.located(
            ("search", "method"), "cma-es knows one objective; take nsga2 or tpe for several"
        )
    if search.method == "nsga2" and search.per_round < 4:
        raise text.located(
            ("search", "per_round"),
            "a generation of nsga2 has 4 trials or more; raise per_round, 16 to 40 are typical",
        )


def _plans(
    plan: OptimumPlan, rest_model: str, function: Callable[..., Any] | None = None
) -> dict[str | LimitSearch, Evaluation]:
    """An experiment for each source of numbers, with outputs of its own, so that none costs more
    than it needs.
    """
    found: dict[str | LimitSearch, Evaluation] = {}
    for source in (REST, RUNS):
        here = [one for one in plan.measures if one.source == source]
        if here:
            names = dict.fromkeys(one.quantity for one in here)
            outputs = Outputs(tuple(names), rest_model=rest_model, function=function)
            runs = tuple(dict.fromkeys(run for one in here for run in one.runs))
            found[source] = Evaluation(plan.case, plan.varied, outputs, runs)
    for one in plan.measures:
        if one.limit is not None:
            outputs = Outputs(one.quantity)
            of_runs = Evaluation(plan.case, plan.varied, outputs, one.runs)
            found[one.limit] = LimitEvaluation(of_runs, one.limit)
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


def _limit(text: OptimumText, path: tuple[str | int, ...], table: LimitSpeedModel) -> LimitSearch:
    found: LimitSearch = text.guarded(
        (*path, "limit_speed"), lambda: limit_search(**table.model_dump())
    )
    return found


def varied_of(name: str, space: Iterable[Varied]) -> Varied | None:
    """The varied quantity that a key of the case means; None for any other name."""
    key = file_key(name)
    return next((one for one in space if name == one.name or key == file_key(one.key)), None)


def _measure(
    text: OptimumText,
    path: tuple[str | int, ...],
    one: MeasureModel,
    case: Case | None,
    space: Space,
    largest_is_worst: bool,
) -> Measure:
    if bool(one.quantity) == (one.limit_speed is not None):
        raise text.located(
            path,
            "names "
            + ("both a quantity and a limit_speed" if one.quantity else "nothing")
            + "; give one of the two",
        )
    varied = varied_of(one.quantity, space) if one.quantity else None
    if varied is not None:
        label = one.label or varied.shown_name
        return Measure(VARIED, varied.name, (), label, largest_is_worst, varied=varied)
    model = text.model
    if case is None:
        if one.limit_speed is not None:
            raise text.located(path, "a function has no limit speed; give a quantity")
        label = one.label or one.quantity.replace("_", " ")
        return Measure(RUNS, one.quantity, ((None, "", ""),), label, largest_is_worst, one.over)
    phrase, limit_table = one.quantity, one.limit_speed
    if limit_table is not None:
        phrase = limit_table.quantity
        if limit_table.kind or not phrase:
            phrase = _limit(text, path, limit_table).quantity
    text.guarded((*path, "quantity"), lambda: refuse_limit_name(phrase))
    if not is_defined(phrase):
        key = (*path, "quantity") if one.quantity else (*path, "limit_speed", "quantity")
        raise text.located(key, no_quantity(phrase))
    kinds = itertools.product(
        dict.fromkeys(model.spring_models or ("",)), dict.fromkeys(model.spring_sets or ("",))
    )
    if limit_table is not None:
        if one.engine_speeds is not None:
            raise text.located(
                (*path, "engine_speeds"),
                "a limit_speed has engine_speeds of its own; give them there",
            )
        if is_at_rest(phrase):
            raise text.located(
                (*path, "limit_speed"),
                f"'{phrase}' belongs to springs at rest, so it has no limit speed",
            )
        runs: tuple[Run, ...] = tuple(
            (None, spring_model, spring_set) for spring_model, spring_set in kinds
        )
        label = (
            one.label
            or f"speed up to which the {definition_of(phrase).label} stays within its bound"
        )
        limit = _limit(text, path, limit_table)
        return Measure(LIMIT, phrase, runs, label, largest_is_worst, one.over, limit)
    label = one.label or definition_of(phrase).label
    if is_at_rest(phrase):
        if one.engine_speeds is not None:
            raise text.located(
                (*path, "engine_speeds"),
                f"'{phrase}' belongs to springs at rest, at no engine speed; leave it out",
            )
        runs = tuple((None, spring_model, spring_set) for spring_model, spring_set in kinds)
        return Measure(REST, phrase, runs, label, largest_is_worst, one.over)
    own = one.engine_speeds is not None
    given, key = (
        (one.engine_speeds, (*path, "engine_speeds"))
        if own
        else (model.engine_speeds, ("engine_speeds",))
    )
    speeds = case.operation.engine_speeds
    if given is not None:
        speeds = given if isinstance(given, tuple) else text.guarded(key, lambda: si_speeds(given))
    if not speeds:
        raise text.located(
            path,
            f"the case names no engine speed, and '{phrase}' needs one; add engine_speeds = '6000 rpm'",
        )
    return Measure(
        RUNS,
        phrase,
        tuple((speed, *kind) for speed, kind in itertools.product(speeds, tuple(kinds))),
        label,
        largest_is_worst,
        one.over,
    )


def _constraints(
    text: OptimumText,
    path: tuple[str | int, ...],
    one: ConstraintModel,
    case: Case | None,
    space: Space,
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
        measure = _measure(text, path, one, case, space, upper)
        share = share_of_case(raw)
        if share is not None:
            made.append(Constraint(measure, upper, float("nan"), share))
            continue
        dimension = (
            "angular speed"
            if measure.limit is not None
            else (measure.varied.dimension or "ratio")
            if measure.varied is not None
            else definition_of(measure.quantity).dimension or "ratio"
        )
        bound = text.guarded(
            (*path, key), lambda raw=raw, dimension=dimension: parse_quantity(raw, dimension)
        )
        made.append(Constraint(measure, upper, bound, None, abs(bound) or 1.0))
    return made


def plan_of_experiment(
    experiment: Evaluation,
    objective: Sequence[Mapping[str, Any]],
    constraint: Sequence[Mapping[str, Any]],
    search: Mapping[str, Any],
) -> OptimumPlan:
    """The search over an experiment; tables as in an optimisation file."""
    outputs, case = experiment.outputs, experiment.case
    tables = {
        "case": "",
        "vary": [{"key": "x", "values": [1]}],
        "objective": list(objective),
        "constraint": list(constraint),
        "search": dict(search),
        "spring_models": list(outputs.spring_models),
        "spring_sets": list(outputs.spring_sets),
    }
    text = OptimumText.of_tables(tables, "optimise")
    model = text.model.model_copy(update={"engine_speeds": outputs.engine_speeds})
    text.model = model
    space = experiment.space
    for one in space:
        if one.distribution.kind not in ("uniform", "log-uniform", "values"):
            raise InputError("a search goes between low and high or through values", one.name)
    objectives = tuple(
        Objective(
            _measure(text, ("objective", index), one, case, space, one.direction == "minimise"),
            one.direction == "maximise",
        )
        for index, one in enumerate(model.objective)
    )
    constraints = tuple(
        made
        for index, one in enumerate(model.constraint)
        for made in _constraints(text, ("constraint", index), one, case, space)
    )
    _refuse_method(text, len(objectives))
    plan = OptimumPlan("", "", case, space, objectives, constraints, model.search, {})
    plan = replace(plan, plans=_plans(plan, outputs.rest_model, outputs.function))
    return replace(plan, title=f"{plan.case_name}: {objectives[0].measure.label}")
