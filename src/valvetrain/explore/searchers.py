"""How a search chooses its next designs: in rounds of a fixed size, from nothing but its seed and
what it was told.

Sources: J. Bergstra et al. (2011), Algorithms for hyper-parameter optimization (TPE); K. Deb et
al., IEEE Trans. Evol. Comput. 6 (2002)
182 (NSGA-II, and that of two designs the one that misses its bounds by less goes first); N. Hansen
and A. Ostermeier, Evol. Comput. 9
(2001) 159 (CMA-ES). The libraries optuna and cmaes.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import MissingExtraError
from valvetrain.explore.measure import BELOW, Measured
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.optimum_file import SearchModel
from valvetrain.explore.space import Uniform, Values

if TYPE_CHECKING:
    from collections.abc import Iterator


Array = NDArray[np.float64]
#: What is told of a bound where there is no number, as a share of the bound: beyond any that is
#: computed.
UNKNOWN = 1e6
#: Stands for the seed of the case, which no search asked for.
CASE_SEED = -1


@dataclass(frozen=True, eq=False)
class Trial:
    """``number`` counts from 0, the case itself; ``values`` (d, SI) of the varied quantities;
    ``measured``: its numbers; ``seed`` of the
    search that asked for it. ``plan`` tells bounds and directions.
    """

    number: int
    seed: int
    values: Array
    measured: Measured
    plan: OptimumPlan

    @property
    def failure(self) -> str:
        """Why it could not be computed, empty where it was."""
        return self.measured.failure

    @cached_property
    def objectives(self) -> Array:
        """Objectives (m,) in SI, nan where they were not computed."""
        return np.array(
            [self.measured.values.get(one.measure, np.nan) for one in self.plan.objectives]
        )

    @cached_property
    def constraints(self) -> Array:
        """Values (c,) in SI of what is bounded."""
        return np.array(
            [self.measured.values.get(one.measure, np.nan) for one in self.plan.constraints]
        )

    @cached_property
    def missed(self) -> Array:
        """By how much (c + m,) each bound is missed, in shares of it, negative inside; then 0 for
        each objective, more where a limit speed
        lies below the lowest one searched."""
        bounds = [
            one.missed(value)
            for one, value in zip(self.plan.constraints, self.constraints, strict=True)
        ]
        begins = [
            max(
                (
                    1e-9 + bracket.missed
                    for bracket in self.measured.limits.get(one.measure, ())
                    if bracket.kind == BELOW
                ),
                default=0.0,
            )
            for one in self.plan.objectives
        ]
        return np.array([*bounds, *begins])

    @property
    def feasible(self) -> bool:
        """Whether it was computed, all bounds are kept and all objectives are there."""
        return (
            not self.failure
            and bool(np.all(self.missed <= 0.0))
            and bool(np.all(np.isfinite(self.objectives)))
        )

    @property
    def told_missed(self) -> list[float]:
        """What a search is told of the bounds: no number of a design that could not be computed."""
        if self.failure:
            return [UNKNOWN] * max(1, len(self.missed))
        known = [float(one) if np.isfinite(one) else UNKNOWN for one in self.missed]
        return known or [0.0]

    @property
    def state(self) -> str:
        """Its end in a word."""
        if self.failure:
            return self.measured.code
        return "feasible" if self.feasible else "infeasible"

    @property
    def total_missed(self) -> float:
        """Sum of what is missed, in shares of the bounds."""
        return float(sum(max(0.0, one) for one in self.told_missed))


def beats(one: Trial, other: Trial) -> bool:
    """Whether a feasible trial is no worse in any objective, and better in one (both feasible)."""
    signs = np.array([goal.sign for goal in one.plan.objectives])
    apart = signs * (one.objectives - other.objectives)
    return bool(np.all(apart <= 0.0) and np.any(apart < 0.0))


def best_of(trials: list[Trial]) -> Trial | None:
    """The feasible trial with the best first objective, the first of equals; None where there is
    none.
    """
    feasible = [one for one in trials if one.feasible]
    return min(
        feasible,
        key=lambda one: (one.plan.objectives[0].sign * one.objectives[0], one.number),
        default=None,
    )


def front_of(trials: list[Trial]) -> list[Trial]:
    """Feasible trials that no other beats, each set of objectives once, by the first objective."""
    feasible = [one for one in trials if one.feasible]
    if not feasible:
        return []
    signs = np.array([goal.sign for goal in feasible[0].plan.objectives])
    costs = np.array([signs * one.objectives for one in feasible])
    kept: list[Trial] = []
    seen: set[bytes] = set()
    for place, one in enumerate(feasible):
        beaten = np.any(
            np.all(costs <= costs[place], axis=1) & np.any(costs < costs[place], axis=1)
        )
        key = costs[place].tobytes()
        if not beaten and key not in seen:
            seen.add(key)
            kept.append(one)
    return sorted(kept, key=lambda one: (*(signs * one.objectives), one.number))


HINT = "a search needs the library {}, which is not installed; install the extra: pip install 'valvetrain[studies]'"
#: First spread of CMA-ES and change of its population after which it has come to rest, as shares of
#: the ranges.
FIRST_SPREAD = 0.25


class Searcher(Protocol):
    """Chooses points (d,) of the unit cube and learns what came of them."""

    def ask(self, count: int, fixed: Sequence[Array] = ()) -> list[Array]:
        """The next ``count`` points; those of ``fixed`` are taken instead of its own. Fewer, or
        none, where it has come to rest.
        """
        ...

    def tell(self, trials: Sequence[Trial]) -> None:
        """What came of the points of the last round, in their order."""
        ...


def searcher_of(
    search: SearchModel, dimensions: int, signs: Sequence[float], seed: int
) -> Searcher:
    """The searcher of a method. Raises :class:`MissingExtraError` where its library is not
    installed.
    """
    if search.method == "cma-es":
        return EvolutionSearch(dimensions, signs[0], seed, search.per_round)
    return OptunaSearch(search.method, dimensions, signs, seed, search.per_round)


def optuna_library() -> Any:
    """The library, quiet. Raises :class:`MissingExtraError` where it is not installed."""
    try:
        import optuna
    except ImportError as error:
        raise MissingExtraError(HINT.format("optuna")) from error
    return optuna


@contextmanager
def quiet_optuna() -> Iterator[Any]:
    """The library with its warnings and its log held back while the block runs."""
    optuna = optuna_library()
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield optuna
    finally:
        optuna.logging.set_verbosity(before)


class OptunaSearch:
    """TPE or NSGA-II, its sampler made anew for every round from the seed and the number of the
    round.
    """

    def __init__(
        self, method: str, dimensions: int, signs: Sequence[float], seed: int, per_round: int
    ) -> None:
        self.method, self.signs, self.seed, self.per_round, self.round = (
            method,
            tuple(signs),
            seed,
            per_round,
            0,
        )
        with quiet_optuna() as optuna:
            self._study = optuna.create_study(directions=["minimize"] * len(self.signs))
            self._axes = {
                f"{place:03d}": optuna.distributions.FloatDistribution(0.0, 1.0)
                for place in range(dimensions)
            }
        self._asked: list[Any] = []

    def ask(self, count: int, fixed: Sequence[Array] = ()) -> list[Array]:
        """Points (d,) of the next round."""
        with quiet_optuna() as optuna:
            self._study.sampler = self._sampler(
                optuna, int(np.random.SeedSequence([self.seed, self.round]).generate_state(1)[0])
            )
            for point in fixed:
                self._study.enqueue_trial(dict(zip(self._axes, map(float, point), strict=True)))
            self._asked = [self._study.ask(self._axes) for _ in range(len(fixed) or count)]
        self.round += 1
        return [np.array([one.params[name] for name in self._axes]) for one in self._asked]

    def tell(self, trials: Sequence[Trial]) -> None:
        """Objectives of what was computed; the rest, and what could not be, counts as infeasible
        without a number.
        """
        with quiet_optuna() as optuna:
            for asked, trial in zip(self._asked, trials, strict=True):
                asked.set_user_attr("missed", trial.told_missed)
                if trial.failure or not np.all(np.isfinite(trial.objectives)):
                    self._study.tell(asked, state=optuna.trial.TrialState.PRUNED)
                else:
                    costs = [
                        float(sign * value)
                        for sign, value in zip(self.signs, trial.objectives, strict=True)
                    ]
                    self._study.tell(asked, costs)

    def _sampler(self, optuna: Any, seed: int) -> Any:
        def missed(trial: Any) -> list[float]:
            return list(trial.user_attrs["missed"])

        if self.method == "nsga2":
            return optuna.samplers.NSGAIISampler(
                population_size=self.per_round, seed=seed, constraints_func=missed
            )
        return optuna.samplers.TPESampler(
            seed=seed,
            multivariate=True,
            constant_liar=True,
            n_startup_trials=2,
            constraints_func=missed,
        )


class EvolutionSearch:
    """CMA-ES over ranks: feasible designs by their objective, then the others by what they miss,
    then those that could not be computed.
    """

    def __init__(self, dimensions: int, sign: float, seed: int, per_round: int) -> None:
        try:
            import cmaes
        except ImportError as error:
            raise MissingExtraError(HINT.format("cmaes")) from error
        self.dimensions, self.sign, self.seed, self.per_round = (
            dimensions,
            sign,
            seed,
            max(4, per_round),
        )
        self._make: Any = cmaes.CMA
        self._strategy: Any = None
        self._asked: list[Array] = []
        self._first: list[Array] = []

    def ask(self, count: int, fixed: Sequence[Array] = ()) -> list[Array]:
        """Points (d,) of the next generation; none once the population has come to rest."""
        if len(fixed):
            self._first = [*self._first, *fixed]
            return list(fixed)
        if self._strategy.should_stop():
            return []
        self._asked = [self._strategy.ask() for _ in range(self.per_round)]
        return [np.clip(one[: self.dimensions], 0.0, 1.0) for one in self._asked[:count]]

    def tell(self, trials: Sequence[Trial]) -> None:
        """The ranks of a generation; of the first designs only the best counts, about which the
        search begins.
        """
        order = sorted(range(len(trials)), key=lambda place: self._key(trials[place]))
        if self._strategy is None:
            self._begin(self._first[order[0]])
            return
        ranks = {place: float(rank) for rank, place in enumerate(order)}
        if len(trials) == len(self._asked):  # a last generation that is cut short teaches nothing
            self._strategy.tell(
                [(self._asked[place], ranks[place]) for place in range(len(trials))]
            )

    def _begin(self, centre: Array) -> None:
        """About ``centre``; the library knows two quantities or more, so a second one without
        effect stands beside one alone.
        """
        count = max(2, self.dimensions)
        mean = np.full(count, 0.5)
        mean[: self.dimensions] = np.clip(centre, 0.02, 0.98)
        box = np.column_stack([np.zeros(count), np.ones(count)])
        self._strategy = self._make(
            mean=mean,
            sigma=FIRST_SPREAD,
            bounds=box,
            seed=self.seed,
            population_size=self.per_round,
        )

    def _key(self, trial: Trial) -> tuple[int, float]:
        if trial.feasible:
            return 0, float(self.sign * trial.objectives[0])
        return (2, 0.0) if trial.failure else (1, trial.total_missed)


def values_of(plan: OptimumPlan, shares: Array) -> Array:
    """Values (d, SI) of a point (d,) of the unit cube; a quantity with a list of values takes them
    in rising order.
    """
    found = []
    for one, share in zip(plan.varied, np.clip(shares, 0.0, 1.0), strict=True):
        levels = one.distribution
        if isinstance(levels, Values):
            order = sorted(set(levels.values))
            found.append(order[min(int(share * len(order)), len(order) - 1)])
        else:
            found.append(float(levels.at(float(share))))
    return np.array(found)


def shares_of(plan: OptimumPlan, values: Array) -> Array | None:
    """The point (d,) of the unit cube of a design (d, SI); None where it lies outside."""
    found = []
    for one, value in zip(plan.varied, values, strict=True):
        levels = one.distribution
        if isinstance(levels, Values):
            order = sorted(set(levels.values))
            if value not in order:
                return None
            found.append((order.index(value) + 0.5) / len(order))
        else:
            assert isinstance(levels, Uniform)
            share = (value - levels.low) / (levels.high - levels.low)
            if not 0.0 <= share <= 1.0:
                return None
            found.append(share)
    return np.array(found)


def neighbours(plan: OptimumPlan, values: Array, place: int, share: float) -> list[Array]:
    """The design with one quantity a ``share`` of its range lower and higher, or at the next of its
    values, those inside the range.
    """
    levels = plan.varied[place].distribution
    if isinstance(levels, Values):
        order = sorted(set(levels.values))
        at = order.index(min(order, key=lambda one: abs(one - values[place])))
        near = [order[one] for one in (at - 1, at + 1) if 0 <= one < len(order)]
    else:
        assert isinstance(levels, Uniform)
        step = share * (levels.high - levels.low)
        near = [
            one
            for one in (values[place] - step, values[place] + step)
            if levels.low <= one <= levels.high
        ]
    found = []
    for value in near:
        row = values.copy()
        row[place] = value
        found.append(row)
    return found
