"""What a search found: its trials, the best designs, what they gain over the case, and how far that
can be trusted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from valvetrain.explore.measure import Measured
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.paths import vary
from valvetrain.explore.searchers import (
    CASE_SEED,
    Array,
    Trial,
    beats,
    best_of,
    front_of,
    neighbours,
)
from valvetrain.parameters.case import Case

#: A varied quantity is at an end of its range, and a bound is active, within these shares of them.
AT_END, ACTIVE = 0.01, 0.01


@dataclass(frozen=True, eq=False)
class Step:
    """What a small step of one varied quantity does to a design: ``size`` (SI, with its sign),
    objectives (m,) and feasibility there.
    """

    place: int
    size: float
    objectives: Array
    feasible: bool
    improves: bool
    failure: str = ""


@dataclass(frozen=True, eq=False)
class Confirmed:
    """A design by another model: what was measured of the case and of the design, against that
    model's own bounds.
    """

    label: str
    plan: OptimumPlan
    case: Trial
    design: Trial


@dataclass(frozen=True, eq=False)
class Design:
    """One of the chosen designs: its ``trial``, why it was ``chosen``, its ``steps`` and
    confirmations.
    """

    trial: Trial
    chosen: str
    steps: tuple[Step, ...] = ()
    confirmed: tuple[Confirmed, ...] = ()


@dataclass(frozen=True, eq=False)
class Optimum:
    """``trials`` of all searches in order, the ``case`` itself first; chosen ``designs``, the best
    first.

    ``best_by_seed``: objectives (m,) of the best trial of the search of each seed, for one
    objective; ``computed``: points that this call
    computed, the others were in its store; ``seconds``: wall time of this call; ``finished``:
    whether it was not stopped before its end.

    >>> import valvetrain as vt
    >>> found = vt.optimise('''
    ... case = "job-c"
    ... vary = [{ key = "spring.precompression", low = "5 mm", high = "9 mm" }]
    ... objective = [{ quantity = "solid_force", direction = "minimise" }]
    ... search = { trials = 4, per_round = 2 }
    ... ''', workers=1)
    >>> isinstance(found, Optimum), len(found.trials)
    (True, 5)
    >>> float(found.case_of(found.best).springs[0].precompression) == float(found.best.trial.values[0])
    True
    """

    plan: OptimumPlan
    case: Trial
    trials: tuple[Trial, ...]
    designs: tuple[Design, ...] = ()
    best_by_seed: Mapping[int, float] = field(default_factory=dict)
    computed: int = 0
    seconds: float = 0.0
    finished: bool = True
    seeds: tuple[int, ...] = ()

    @property
    def best(self) -> Design | None:
        """The best design, of several objectives the balanced one; None where no trial keeps every
        bound.
        """
        return self.designs[0] if self.designs else None

    @cached_property
    def front(self) -> tuple[Trial, ...]:
        """Feasible trials that no other beats in all objectives, by the first of these; for one
        objective the best alone.
        """
        return tuple(front_of(list(self.trials)))

    @property
    def feasible(self) -> int:
        """Trials that keep every bound."""
        return sum(one.feasible for one in self.trials)

    def history(self, seed: int | None = None) -> Array:
        """Best feasible objective (SI) after each trial of the search of ``seed`` (the first), of
        the first objective; nan before any.
        """
        goal = self.plan.objectives[0]
        wanted = self.seeds[0] if seed is None and self.seeds else seed
        best, found = np.nan, []
        for one in self.trials:
            if one.seed not in (wanted, CASE_SEED):
                continue
            if one.feasible and not goal.sign * one.objectives[0] >= goal.sign * best:
                best = float(one.objectives[0])
            found.append(best)
        return np.array(found)

    def case_of(self, design: Design) -> Case:
        """The case with the values of a design."""
        if design.trial is self.case:
            return self.plan.case
        return vary(
            self.plan.case,
            dict(zip(self.plan.varied, map(float, design.trial.values), strict=True)),
        )

    def at_ends(self, trial: Trial) -> tuple[tuple[int, str], ...]:
        """(place, ``low`` or ``high``) of varied quantities that stand at an end of their range in
        a design.
        """
        found = []
        for place, (one, value) in enumerate(zip(self.plan.varied, trial.values, strict=True)):
            low, high = (float(end) for end in one.distribution.at([0.0, 1.0]))
            low, high = min(low, high), max(low, high)
            if value <= low + AT_END * (high - low):
                found.append((place, "low"))
            elif value >= high - AT_END * (high - low):
                found.append((place, "high"))
        return tuple(found)

    def active(self, trial: Trial) -> tuple[int, ...]:
        """Places of the constraints that a design meets with less than a hundredth of the bound to
        spare.
        """
        return tuple(
            place
            for place in range(len(self.plan.constraints))
            if abs(trial.missed[place]) <= ACTIVE
        )

    @property
    def missed_by_least(self) -> tuple[Trial, str] | None:
        """Where no trial is feasible: the one that misses its bounds by least, and the words of the
        bound that it misses most.
        """
        computed = [one for one in self.trials if not one.failure]
        if not computed:
            return None
        nearest = min(computed, key=lambda one: (one.total_missed, one.number))
        place = int(np.argmax(nearest.told_missed))
        return nearest, bound_words(self.plan, place)

    def __repr__(self) -> str:
        cut = "" if self.finished else ", stopped before its end"
        lines = [
            f"search '{self.plan.title}': {len(self.trials)} trials, {self.feasible} feasible{cut}"
        ]
        if self.best is not None:
            for goal, value, before in zip(
                self.plan.objectives, self.best.trial.objectives, self.case.objectives, strict=True
            ):
                one = goal.measure
                lines.append(
                    f"  {one.label}: {one.shown(float(value)):.5g} {one.unit}, the case {one.shown(float(before)):.5g} {one.unit}"
                )
            for varied, value in zip(self.plan.varied, self.best.trial.values, strict=True):
                lines.append(
                    f"  {varied.words}: {varied.shown(float(value)):.5g} {varied.unit}".rstrip()
                )
        return "\n".join(lines)


def bound_words(plan: OptimumPlan, place: int) -> str:
    """A bound in words, by its place in ``Trial.missed``."""
    if place >= len(plan.constraints):
        one = plan.objectives[place - len(plan.constraints)].measure
        lowest = one.shown(one.limit.engine_speeds[0]) if one.limit is not None else 0.0
        return f"{one.label}: above the lowest speed searched, {lowest:.6g} rpm"
    bound = plan.constraints[place]
    measure = bound.measure
    sign = "at most" if bound.upper else "at least"
    of_case = f" ({bound.share:g} x case)" if bound.share is not None else ""
    return (
        f"{measure.label} {sign} {measure.shown(bound.bound):.5g} {measure.unit}".rstrip() + of_case
    )


__all__ = ["ACTIVE", "AT_END", "Confirmed", "Design", "Optimum", "Step", "bound_words"]


#: A small step, as a share of the range of a quantity.
STEP = 0.01


def chosen_designs(found: Optimum) -> tuple[Design, ...]:
    """The best design; of several objectives the balanced one of the front, then the best one by
    each objective.
    """
    if len(found.plan.objectives) == 1:
        best = best_of(list(found.trials))
        return () if best is None else (Design(best, "the best"),)
    front = list(found.front)
    if not front:
        return ()
    signs = np.array([one.sign for one in found.plan.objectives])
    costs = np.array([signs * one.objectives for one in front])
    width = np.ptp(costs, axis=0)
    away = np.sum(((costs - costs.min(axis=0)) / np.where(width > 0, width, 1.0)) ** 2, axis=1)
    designs = [
        Design(
            front[int(np.argmin(away))],
            "balanced: nearest to the best of every objective, each over its span on the front",
        )
    ]
    for place, goal in enumerate(found.plan.objectives):
        one = front[int(np.argmin(costs[:, place]))]
        if all(one is not other.trial for other in designs):
            designs.append(Design(one, f"best {goal.measure.label}"))
    return tuple(designs)


def steps_of(
    plan: OptimumPlan, trial: Trial, measure: Callable[[Sequence[Array]], list[Measured]]
) -> tuple[Step, ...]:
    """What a step of a hundredth of its range, or to the next value, of each varied quantity alone
    does to a design.
    """
    rows = [
        (place, row)
        for place in range(len(plan.varied))
        for row in neighbours(plan, trial.values, place, STEP)
    ]
    if not rows:
        return ()
    found = []
    for (place, row), measured in zip(rows, measure([row for _, row in rows]), strict=True):
        one = Trial(-1, trial.seed, row, measured, plan)
        better = one.feasible and beats(one, trial)
        found.append(
            Step(
                place,
                float(row[place] - trial.values[place]),
                one.objectives,
                one.feasible,
                better,
                one.failure,
            )
        )
    return tuple(found)
