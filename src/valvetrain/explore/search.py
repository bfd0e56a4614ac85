"""How a search chooses designs: Optuna proposes them in rounds, then scipy's COBYQA searches about the best one.

A search depends on its request alone. Started again it proposes the same designs, and what the store
holds of them is not computed again.

Sources: J. Bergstra et al. (2011), Algorithms for hyper-parameter optimization (TPE); K. Deb et al., IEEE Trans. Evol.
Comput. 6 (2002) 182 (NSGA-II); T. M. Ragonneau and Z. Zhang (2023), COBYQA, DOI 10.5281/zenodo.10046277.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from valvetrain.errors import MissingExtraError
from valvetrain.explore.measure import Array, Trial
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.samplers import latin_hypercube

HINT = "a search needs the library optuna, which is not installed; install the extra: pip install 'valvetrain[studies]'"
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
#: Computes designs (shares of the ranges); the second argument spares those that miss a bound their
#: limit speeds.
Compute = Callable[[Sequence[Array], bool], list[Trial]]


@contextmanager
def quiet_optuna() -> Iterator[Any]:
    """The library with its warnings and its log suppressed while the block runs.

    Raises :class:`MissingExtraError` where it is not installed.
    """
    try:
        import optuna
    except ImportError as error:
        raise MissingExtraError(HINT) from error
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
    proposals, trials, begin = _Proposals(plan), [case], plan.shares(case.values)
    rounds = -(-max(FIRST, FIRST_EACH * size) // search.per_round)
    first = list(
        latin_hypercube(min(search.trials, rounds * search.per_round), size, [search.seed, size])
    )
    if begin is not None:
        proposals.ask(1, [begin])
        proposals.tell([case])
    while (left := search.trials - local + 1 - len(trials)) > 0 or first:
        points = proposals.ask(len(first) or min(search.per_round, left), first)
        # the generations of NSGA-II hold infeasible designs too, with their objectives
        made = compute(points, search.method != "nsga2")
        proposals.tell(made)
        trials, first = trials + made, []
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

    def __init__(self, plan: OptimumPlan) -> None:
        self.plan, self.requested = plan, list[Any]()
        with quiet_optuna() as optuna:
            options: dict[str, Any] = {"seed": plan.search.seed, "constraints_func": _missed}
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

    def ask(self, count: int, given: Sequence[Array] = ()) -> list[Array]:
        """The next ``count`` points (d,), those that are ``given`` first."""
        with quiet_optuna():
            for point in given:
                self.study.enqueue_trial(dict(zip(self.axes, map(float, point), strict=True)))
            self.requested = [self.study.ask(self.axes) for _ in range(count)]
        return [np.array([one.params[name] for name in self.axes]) for one in self.requested]

    def tell(self, trials: Sequence[Trial]) -> None:
        """What came of the points; one without an objective counts as infeasible without a number."""
        with quiet_optuna() as optuna:
            for requested, trial in zip(self.requested, trials, strict=True):
                requested.set_user_attr("missed", trial.penalties)
                if np.all(np.isfinite(trial.costs)):
                    self.study.tell(requested, trial.costs.tolist())
                else:
                    self.study.tell(requested, state=optuna.trial.TrialState.PRUNED)


class _Spent(Exception):
    """All trials are used."""


def _missed(trial: Any) -> list[float]:
    return list(trial.user_attrs["missed"])


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
