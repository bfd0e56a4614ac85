"""The plan of a search: case, varied quantities, objectives, constraints, and the evaluations that give their numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.explore.distributions import Prior, Values
from valvetrain.explore.engine import Evaluation, Plan
from valvetrain.explore.files import FileText
from valvetrain.explore.measure import (
    Constraint,
    ConstraintModel,
    GoalsModel,
    Measure,
    MeasureModel,
    Objective,
    OptimumModel,
    SearchModel,
    tasks_of,
)
from valvetrain.explore.outputs import (
    Outputs,
    Task,
    refuse_sets,
    share_of_case,
)
from valvetrain.explore.space import ENGINE_SPEED, Space, Varied
from valvetrain.explore.study import seconds_of
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.request import is_at_rest
from valvetrain.registry import OWN, find
from valvetrain.runs.cost import planned
from valvetrain.solution.definition import definition_of
from valvetrain.units import parse_quantity

#: Quantities that rank designs that lose contact, and whether the largest is the worst.
LOSSES = {"loss_of_contact_duration": True, "loft_gap": True, "minimum_spring_margin_force": False}
#: The finest spring models of springs with a wire, and of those that are known by card alone; the
#: first one gives springs at rest too.
FINEST, OF_CARDS = "finite-element", "wave-rod"
#: Models that need no check by a finer one.
FULL = frozenset({FINEST, "solid"})
#: Place of a table in a file.
Place = tuple[str | int, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class OptimumPlan(Plan):
    """What a search does. ``rest_model``: spring model of static quantities, empty for the finite-element rod.
    ``confirmations``: another model that the best design is computed by -> the plan of that. ``unchecked``: the finest
    model that the case allows, where nothing is computed by it.
    """

    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    search: SearchModel
    rest_model: str = ""
    confirmations: Mapping[str, OptimumPlan] = field(default_factory=dict)
    unchecked: str = ""

    @property
    def measures(self) -> tuple[Measure, ...]:
        """Every measure once, objectives first."""
        return tuple(dict.fromkeys([*self._judged, *self.losses]))

    @property
    def _judged(self) -> list[Measure]:
        """Measures of objectives and constraints."""
        bounded = [one.measure for one in self.constraints]
        return [*(one.measure for one in self.objectives), *bounded]

    @property
    def losses(self) -> tuple[Measure, ...]:
        """How much contact is lost, the shortest loss first, for designs whose least contact force is zero
        alike; empty where no such force is an objective or bound.
        """
        runs = next((one.runs for one in self._judged if one.is_contact_force), ())
        return tuple(
            Measure(name, runs, name, more, optional=True)
            for name, more in (LOSSES if runs and self.case is not None else {}).items()
        )

    @property
    def tasks(self) -> tuple[Task, ...]:
        """All that is computed of a design."""
        return tuple(tasks_of(self.measures, self.rest_model).values())

    @property
    def seconds(self) -> float:
        """Estimated seconds of one core for a design whose limit speeds are searched to the end."""
        return sum(seconds_of(self.experiment, task) for task in self.tasks)

    def values(self, shares: Array) -> Array:
        """Values (d, SI) of a point (d,) of the unit cube."""
        pairs = zip(self.varied, np.clip(shares, 0.0, 1.0), strict=True)
        return np.array([float(one.distribution.at(float(share))) for one, share in pairs])

    def shares(self, values: Array) -> Array | None:
        """The point (d,) of the unit cube of a design (d, SI); None outside it."""
        pairs = zip(self.varied, values.tolist(), strict=True)
        shares = np.array([one.distribution.share_of(value) for one, value in pairs])
        return shares if np.all(np.isfinite(shares)) else None

    def of_case(self, values: Mapping[Measure, float]) -> OptimumPlan:
        """The plan with bounds that are shares of what the case has. Raises :class:`InputError`
        where the case has no such number.
        """
        made = []
        for one in self.constraints:
            if one.share is not None:
                value = values.get(one.measure, np.nan)
                if np.isnan(value):
                    raise InputError(
                        f"the case itself gives no {one.measure.label}, which a bound is a share of; give a number"
                    )
                one = replace(one, bound=one.share * value, scale=abs(value) or 1.0)
            made.append(one)
        return replace(self, constraints=tuple(made))

    def by_another(self, model: str) -> OptimumPlan:
        """The same measures by another spring model, which gives springs at rest too where it is the finest."""

        def moved(goal: Any) -> Any:
            runs = (run._replace(spring_model=model) for run in goal.measure.runs)
            return replace(goal, measure=replace(goal.measure, runs=tuple(dict.fromkeys(runs))))

        return replace(
            self,
            objectives=tuple(map(moved, self.objectives)),
            constraints=tuple(map(moved, self.constraints)),
            rest_model="" if model == FINEST else self.rest_model,
        )


def read_optimum(text: FileText[OptimumModel]) -> OptimumPlan:
    """The plan of an optimisation file. Raises :class:`InputError`, one sentence with file, line
    and key.
    """
    model, case, space = text.model, text.case, text.space
    for place, one in enumerate(space):
        if one.key == ENGINE_SPEED:
            reason = "is no part of a design; give engine_speeds, or a limit_speed as an objective"
            raise text.located(("vary", place, "key"), reason)
    if model.spring_sets:
        text.guarded(("spring_sets",), lambda: refuse_sets(case, model.spring_sets))
    plan = _plan(text, case, space)
    confirmations = {
        one: text.guarded(("confirm", place), lambda one=one: plan.by_another(one))
        for place, one in enumerate(model.confirm)
    }
    return with_finest(replace(plan, confirmations=confirmations))


def plan_of_experiment(
    experiment: Evaluation,
    objective: Sequence[Mapping[str, Any]],
    constraint: Sequence[Mapping[str, Any]],
    search: Mapping[str, Any],
) -> OptimumPlan:
    """The search over an experiment; tables as in an optimisation file."""
    outputs = experiment.outputs
    tables: dict[str, Any] = {
        "objective": list(objective), "constraint": list(constraint), "search": dict(search),
        "spring_models": list(outputs.spring_models), "spring_sets": list(outputs.spring_sets), "rest_model": outputs.rest_model,
    }  # fmt: skip
    if outputs.engine_speeds is not None:
        tables["engine_speeds"] = list(outputs.engine_speeds)
    text = FileText(tables, "optimise", Path(), GoalsModel)
    return with_finest(_plan(text, experiment.case, experiment.space, outputs.function))


def with_finest(plan: OptimumPlan) -> OptimumPlan:
    """The plan with a check of its best design by the finest spring model that the case allows.

    The plan stays as it is where a model as fine computes it already. It names the finest model as ``unchecked`` where a
    spring model was made in Python, and where the check would cost more than the search.
    """
    if plan.case is None:
        return plan
    models, springs = set[str](), list[InstalledSpring]()
    for every in (plan, *plan.confirmations.values()):
        for task in every.tasks:
            words, several = planned(task.run._replace(engine_speed=None).request(plan.case))[0]
            springs += several
            if task.limit is not None or task.request.motion:
                models.update(words)
            elif not task.request.sizes_alone:
                models.add(task.request.rest_model or FINEST)
    finest = FINEST if all(one.wire is not None for one in springs) else OF_CARDS
    fine = models & {finest, *FULL}
    if not models or fine or any(find("springs", finest).why_not(one) for one in springs):
        return plan
    made = plan.by_another(finest)
    if models & OWN.keys() or 2 * made.seconds > plan.search.trials * plan.seconds:
        return replace(plan, unchecked=finest)
    return replace(plan, confirmations={**plan.confirmations, finest: made})


def _in_order(one: Varied) -> Varied:
    """A quantity whose list of values rises. Raises :class:`InputError` for a distribution without ends."""
    levels = one.distribution
    if isinstance(levels, Prior) and not levels.flat:
        reason = "a search goes between low and high or through values; give one of them"
        raise InputError(reason, one.name)
    if isinstance(levels, Values):
        return replace(one, distribution=replace(levels, values=tuple(sorted(set(levels.values)))))
    return one


def _plan(
    text: FileText[Any],
    case: Case | None,
    space: Space,
    function: Callable[..., Any] | None = None,
) -> OptimumPlan:
    """The plan of the objectives and constraints in the tables of a ``text``, without confirmations."""
    model = text.model

    def measure(path: Place, one: MeasureModel, largest_is_worst: bool) -> Measure:
        """The measure of a table: of a run, of springs at rest, a limit speed, or what is varied."""
        limit = one.limit_speed
        if case is None and limit is not None:
            raise text.located(path, "a function has no limit speed; give a quantity")
        if case is not None and one.engine_speeds is not None and is_at_rest(one.quantity):
            reason = (
                f"'{one.quantity}' belongs to springs at rest, at no engine speed; leave it out"
            )
            raise text.located((*path, "engine_speeds"), reason)
        outputs = text.guarded((*path, "quantity"), lambda: Outputs(
            one.quantity or (), engine_speeds=one.engine_speeds or model.engine_speeds, spring_models=model.spring_models,
            spring_set=model.spring_sets, limit_speeds=filter(None, [limit]), function=function,
        ))  # fmt: skip
        runs = text.guarded(path, lambda: outputs.runs(case, False))
        name = one.quantity if limit is None else limit.quantity
        label = name.replace("_", " ") if case is None else definition_of(name).label
        if limit is not None:
            label = f"speed up to which the {label} stays within its bound"
        return Measure(name, runs, one.label or label, largest_is_worst, one.over, limit)

    def constraint(path: Place, one: ConstraintModel, key: str) -> Constraint:
        """The constraint of one bound of a table."""
        upper, raw = key == "at_most", getattr(one, key)
        bounded, share = measure(path, one, upper), share_of_case(raw)
        if share is not None:
            return Constraint(bounded, upper, np.nan, share)
        due = definition_of(bounded.quantity).dimension or "ratio"
        if bounded.limit is not None:
            due = "angular speed"
        bound = text.guarded((*path, key), lambda: parse_quantity(raw, due))
        return Constraint(bounded, upper, bound, None, abs(bound) or 1.0)

    objectives = tuple(
        Objective(measure(("objective", place), one, one.direction == "minimise"), one.direction == "maximise")
        for place, one in enumerate(model.objective)
    )  # fmt: skip
    if len({one.measure for one in objectives}) < len(objectives):
        raise text.located(("objective",), "the same objective is there twice; give it once")
    constraints = tuple(
        constraint(("constraint", place), one, key)
        for place, one in enumerate(model.constraint)
        for key in ("at_most", "at_least")
        if getattr(one, key) is not None
    )
    goals: list[Any] = [*objectives, *constraints]
    outputs = Outputs([one.measure.quantity for one in goals], function=function)
    varied = [
        text.guarded(("vary", place), lambda one=one: _in_order(one))
        for place, one in enumerate(space)
    ]
    experiment = Evaluation(case, Space(varied), outputs)
    return OptimumPlan(
        experiment=experiment, title=model.title or f"{experiment.name}: {objectives[0].measure.label}", description=model.description,
        objectives=objectives, constraints=constraints, search=model.search, rest_model=model.rest_model,
    )  # fmt: skip
