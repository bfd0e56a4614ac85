"""Designs of a search, feasible ones first, and how they are chosen: Optuna proposes them in rounds, then scipy's COBYQA searches about
the best one.

A search depends on its request alone. Started again it proposes the same designs, and what the store
holds of them is not computed again.

Sources: J. Bergstra et al. (2011), Algorithms for hyper-parameter optimization (TPE); K. Deb et al., IEEE Trans. Evol.
Comput. 6 (2002) 182 (NSGA-II); T. M. Ragonneau and Z. Zhang (2023), COBYQA, DOI 10.5281/zenodo.10046277.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.explore.limit_speed import BELOW
from valvetrain.explore.measure import Constraint, Measured, Objective
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.samplers import latin_hypercube, needs

#: Designs of the first round or rounds, drawn evenly before the search learns; and for each varied
#: quantity.
FIRST, FIRST_EACH = 10, 2
#: First and last radius of the local search, in shares of the ranges.
RADIUS, SMALLEST = 0.1, 1e-4
#: The local search meets bounds with this much to spare, in shares of them, so that it does not end
#: beyond one by rounding.
RESERVE = 1e-4
#: What a design that failed costs more than the best one, and misses each bound by.
FAILED = 1.0
#: Penalty of a bound without a number, as a share of the bound: beyond any that is
#: computed.
UNKNOWN = 1e6


@dataclass(frozen=True, eq=False)
class Trial:
    """``number`` counts from 0, the case itself; ``values`` (d, SI) of the varied quantities;
    ``measured``: its numbers. ``plan`` holds bounds and directions.
    """

    number: int
    values: Array
    measured: Measured
    plan: OptimumPlan

    def to_dict(self) -> dict[str, Any]:
        """Its numbers (SI), its end in a word, and the brackets of its limit speeds."""
        names = (
            "number",
            "values",
            "objectives",
            "constraints",
            "missed",
            "state",
            "failure",
        )
        limits = [one for every in self.measured.limits.values() for one in every]
        return {name: getattr(self, name) for name in names} | {"limits": limits}

    @property
    def failure(self) -> str:
        """Why it could not be computed, empty where it was."""
        return self.measured.failure

    @cached_property
    def objectives(self) -> Array:
        """Objectives (m,) in SI, nan where they were not computed."""
        return self._values(self.plan.objectives)

    @cached_property
    def costs(self) -> Array:
        """Objectives (m,) with the sign that makes less better."""
        return self.objectives * [one.sign for one in self.plan.objectives]

    @cached_property
    def constraints(self) -> Array:
        """Values (c,) in SI of what is bounded."""
        return self._values(self.plan.constraints)

    def _values(self, bounded: Sequence[Objective | Constraint]) -> Array:
        return np.array([self.measured.values.get(one.measure, np.nan) for one in bounded])

    @cached_property
    def missed(self) -> Array:
        """By how much (c + m,) each bound is missed, in shares of it, negative inside.

        A contact force of zero misses its bound by the share of the cycle without contact in addition. The last
        m are of the objectives: 0, or more where a limit speed is below the lowest one searched.
        """
        missed = [
            one.missed(value) + (self.lost if one.measure.is_contact_force and value <= 0 else 0.0)
            for one, value in zip(self.plan.constraints, self.constraints, strict=True)
        ]
        for goal in self.plan.objectives:
            brackets = self.measured.limits.get(goal.measure, ())
            below = [1e-9 + one.missed for one in brackets if one.kind == BELOW]
            missed.append(max(below, default=0.0))
        return np.array(missed)

    @cached_property
    def losses(self) -> tuple[float, ...]:
        """Time without contact (s), loft (m) and negative rigid margin (N), 0 where they were not computed."""
        values = ((one, self.measured.values.get(one, 0.0)) for one in self.plan.losses)
        return tuple(
            float(np.nan_to_num(value if one.largest_is_worst else -value)) for one, value in values
        )

    @property
    def lost(self) -> float:
        """Share of the cycle without contact, at the highest speed."""
        speeds = [run[0] or 0.0 for one in self.plan.losses for run in one.runs]
        return self.losses[0] * max(speeds) / (4 * np.pi) if speeds else 0.0

    @cached_property
    def feasible(self) -> bool:
        """Whether it was computed, all bounds are met and all objectives are there."""
        met = bool(np.all(self.missed <= 0.0)) and bool(np.all(np.isfinite(self.objectives)))
        return met and not self.failure

    @cached_property
    def rank(self) -> tuple[float, ...]:
        """Order of designs: feasible ones by the first objective, then by what is missed, then those that failed.

        Of equals the one that loses contact least goes first, then the first.
        """
        if self.feasible:
            return (0.0, float(self.costs[0]), *self.losses, self.number)
        if self.failure:
            return (2.0, self.number)
        missed = sum(max(0.0, one) for one in self.penalties)
        return (1.0, missed, *self.losses[1:], self.number)

    @property
    def penalties(self) -> list[float]:
        """Missed shares (c + m) of the bounds, large where there is no number."""
        missed = np.full(len(self.missed), UNKNOWN) if self.failure else self.missed
        return [float(one) for one in np.nan_to_num(missed, nan=UNKNOWN)]

    @property
    def state(self) -> str:
        """Its end in a word."""
        return self.measured.code if self.failure else "feasible" if self.feasible else "infeasible"


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """The first of the feasible trials by their rank; None where there is none."""
    first = min(trials, key=lambda one: one.rank)
    return first if first.feasible else None


def front_of(trials: Sequence[Trial]) -> list[Trial]:
    """Feasible trials that no other beats, each set of objectives once, by the first objective."""
    by_costs = dict[bytes, Trial]()
    for one in trials:
        if one.feasible:
            by_costs.setdefault(one.costs.tobytes(), one)
    costs = np.array([one.costs for one in by_costs.values()])
    front = [
        one
        for one in by_costs.values()
        if not np.any(np.all(costs <= one.costs, axis=1) & np.any(costs < one.costs, axis=1))
    ]
    return sorted(front, key=lambda one: (*one.costs, one.number))


#: Computes designs (shares of the ranges); the second argument spares those that miss a bound their
#: limit speeds.
Compute = Callable[[Sequence[Array], bool], list[Trial]]


@contextmanager
def quiet_optuna() -> Iterator[Any]:
    """The library with its warnings and its log suppressed while the block runs.

    Raises :class:`MissingExtraError` where it is not installed.
    """
    with needs("optuna"):
        import optuna
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield optuna
    finally:
        optuna.logging.set_verbosity(before)


def search_from(plan: OptimumPlan, case: Trial, compute: Compute) -> None:
    """All designs of a search: some drawn evenly, those that Optuna proposes, and for one objective the local
    search about the best.
    """
    search, size = plan.search, len(plan.varied)
    moving = [place for place, one in enumerate(plan.varied) if one.distribution.kind != "values"]
    local = int(search.local * search.trials) if len(plan.objectives) == 1 and moving else 0
    trials, begin = [case], plan.shares(case.values)
    rounds = -(-max(FIRST, FIRST_EACH * size) // search.per_round)
    first = list(
        latin_hypercube(min(search.trials, rounds * search.per_round), size, [search.seed, size])
    )
    with quiet_optuna() as optuna:
        proposals = _Proposals(optuna, plan)
        if begin is not None:
            proposals.computed_round([begin], 1, lambda points: [case])
        while (left := search.trials - local + 1 - len(trials)) > 0 or first:
            # the generations of NSGA-II hold infeasible designs too, with their objectives
            trials += proposals.computed_round(
                first,
                len(first) or min(search.per_round, left),
                lambda points: compute(points, search.method != "nsga2"),
            )
            first = []
    able = [one for one in trials if not one.failure and plan.shares(one.values) is not None]
    budget = search.trials + 1 - len(trials)
    if local and able and budget > 0:
        local_search(
            min(able, key=lambda one: one.rank),
            moving,
            lambda point: compute([point], False)[0],
            budget,
        )


class _Proposals:
    """Points of the unit cube that a sampler of Optuna proposes from what came of those before."""

    def __init__(self, optuna: Any, plan: OptimumPlan) -> None:
        options: dict[str, Any] = {
            "seed": plan.search.seed,
            "constraints_func": lambda trial: trial.user_attrs["missed"],
        }
        if plan.search.method == "nsga2":
            sampler = optuna.samplers.NSGAIISampler(
                population_size=plan.search.per_round, **options
            )
        else:
            sampler = optuna.samplers.TPESampler(
                multivariate=True, constant_liar=True, n_startup_trials=2, **options
            )
        directions = ["minimize"] * len(plan.objectives)
        self.study = optuna.create_study(directions=directions, sampler=sampler)
        axis = optuna.distributions.FloatDistribution(0.0, 1.0)
        self.axes = {f"{place:03d}": axis for place in range(len(plan.varied))}
        self.no_number = optuna.trial.TrialState.PRUNED

    def computed_round(
        self,
        given: Sequence[Array],
        count: int,
        compute: Callable[[Sequence[Array]], list[Trial]],
    ) -> list[Trial]:
        """The next ``count`` points (d,) with their numbers, those that are ``given`` first; a trial without an objective counts as
        infeasible without a number.
        """
        for point in given:
            self.study.enqueue_trial(dict(zip(self.axes, map(float, point), strict=True)))
        requested = [self.study.ask(self.axes) for _ in range(count)]
        trials = compute([np.array([one.params[name] for name in self.axes]) for one in requested])
        for one, trial in zip(requested, trials, strict=True):
            one.set_user_attr("missed", trial.penalties)
            if np.all(np.isfinite(trial.costs)):
                self.study.tell(one, trial.costs.tolist())
            else:
                self.study.tell(one, state=self.no_number)
        return trials


class _Spent(Exception):
    """All trials are used."""


def local_search(
    best: Trial, moving: Sequence[int], compute: Callable[[Array], Trial], budget: int
) -> None:
    """Compute up to ``budget`` designs about the ``best`` one by COBYQA, of the first objective within all bounds.

    Parameters
    ----------
    best : where the search begins
    moving : places of the quantities that may move
    compute : the design at a point (d, shares of the ranges), its objective included
    budget : largest number of designs
    """
    from scipy.optimize import NonlinearConstraint, minimize

    start = best.plan.shares(best.values)
    assert start is not None
    scale = (abs(float(best.costs[0])) if np.isfinite(best.costs[0]) else 0.0) or 1.0
    least = float(np.nan_to_num(best.costs[0])) / scale
    bounds = len(best.plan.constraints)
    there = {start[moving].tobytes(): best}

    def trial_at(point: Array) -> Trial:
        inside = np.clip(point, 0.0, 1.0)
        if inside.tobytes() not in there:
            if len(there) > budget:
                raise _Spent
            shares = start.copy()
            shares[moving] = inside
            there[inside.tobytes()] = compute(shares)
        return there[inside.tobytes()]

    def cost(point: Array) -> float:
        value = float(trial_at(point).costs[0]) / scale
        return value if np.isfinite(value) else least + FAILED

    def missed(point: Array) -> Array:
        trial = trial_at(point)
        if trial.failure:
            return np.full(bounds, FAILED)
        return np.clip(np.nan_to_num(trial.missed[:bounds], nan=FAILED), -1.0, 1.0)

    try:
        minimize(
            cost,
            start[moving],
            method="COBYQA",
            bounds=[(0.0, 1.0)] * len(moving),
            constraints=[NonlinearConstraint(missed, -np.inf, -RESERVE)] if bounds else [],
            options={
                "initial_tr_radius": RADIUS,
                "final_tr_radius": SMALLEST,
                "maxfev": budget + 1,
            },
        )
    except _Spent:
        pass
