"""How a search chooses its next designs: in rounds of a fixed size, from its seed and the trials of
the rounds before; and the local search at its end.

Sources: J. Bergstra et al. (2011), Algorithms for hyper-parameter optimization (TPE); K. Deb et
al., IEEE Trans. Evol. Comput. 6 (2002) 182 (NSGA-II, and that of two designs the one that misses
its bounds by less goes first); N. Hansen and A. Ostermeier, Evol. Comput. 9 (2001) 159 (CMA-ES).
The libraries optuna and cmaes; COBYLA of scipy.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from valvetrain.errors import MissingExtraError
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.optimum_file import SearchModel
from valvetrain.explore.space import Values
from valvetrain.explore.trial import Array, Trial

if TYPE_CHECKING:
    from collections.abc import Iterator

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
    """The library with its warnings and its log suppressed while the block runs."""
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
    """TPE or NSGA-II, its sampler new for every round from the seed and the number of the
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
        self._requested: list[Any] = []

    def ask(self, count: int, fixed: Sequence[Array] = ()) -> list[Array]:
        """Points (d,) of the next round."""
        with quiet_optuna() as optuna:
            self._study.sampler = self._sampler(
                optuna, int(np.random.SeedSequence([self.seed, self.round]).generate_state(1)[0])
            )
            for point in fixed:
                self._study.enqueue_trial(dict(zip(self._axes, map(float, point), strict=True)))
            self._requested = [self._study.ask(self._axes) for _ in range(len(fixed) or count)]
        self.round += 1
        return [np.array([one.params[name] for name in self._axes]) for one in self._requested]

    def tell(self, trials: Sequence[Trial]) -> None:
        """Objectives of what was computed; the rest, and what could not be, counts as infeasible
        without a number.
        """
        with quiet_optuna() as optuna:
            for requested, trial in zip(self._requested, trials, strict=True):
                requested.set_user_attr("missed", trial.penalties)
                if trial.failure or not np.all(np.isfinite(trial.objectives)):
                    self._study.tell(requested, state=optuna.trial.TrialState.PRUNED)
                else:
                    costs = [
                        float(sign * value)
                        for sign, value in zip(self.signs, trial.objectives, strict=True)
                    ]
                    self._study.tell(requested, costs)

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
        self._requested: list[Array] = []
        self._first: list[Array] = []

    def ask(self, count: int, fixed: Sequence[Array] = ()) -> list[Array]:
        """Points (d,) of the next generation; none once the population has come to rest."""
        if len(fixed):
            self._first = [*self._first, *fixed]
            return list(fixed)
        if self._strategy.should_stop():
            return []
        self._requested = [self._strategy.ask() for _ in range(self.per_round)]
        return [np.clip(one[: self.dimensions], 0.0, 1.0) for one in self._requested[:count]]

    def tell(self, trials: Sequence[Trial]) -> None:
        """The ranks of a generation; of the first designs only the best counts, about which the
        search begins.
        """
        order = sorted(range(len(trials)), key=lambda place: self._key(trials[place]))
        if self._strategy is None:
            self._begin(self._first[order[0]])
            return
        ranks = {place: float(rank) for rank, place in enumerate(order)}
        if len(trials) == len(
            self._requested
        ):  # a last generation that is cut short teaches nothing
            self._strategy.tell(
                [(self._requested[place], ranks[place]) for place in range(len(trials))]
            )

    def _begin(self, centre: Array) -> None:
        """About ``centre``; the library knows two quantities or more, so a second one without
        effect is added to a single one.
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
    """The point (d,) of the unit cube of a design (d, SI); None outside it."""
    found = []
    for one, value in zip(plan.varied, values, strict=True):
        levels = one.distribution
        if isinstance(levels, Values):
            order = sorted(set(levels.values))
            if value not in order:
                return None
            found.append((order.index(value) + 0.5) / len(order))
        else:
            if not levels.low <= value <= levels.high:
                return None
            found.append(float(levels.share(levels.work(value))))
    return np.array(found)


ComputeTrial = Callable[[Array], Trial]
#: First radius of the neighbourhood in shares of the ranges, what it shrinks by, and the radius at
#: which the search ends.
RADIUS, SHRINK, SMALLEST = 0.1, 0.3, 0.003
#: Bounds are met with this much to spare, in shares of them, so that what ends on one does not end
#: beyond it.
TO_SPARE = 1e-4


class _Spent(Exception):
    """All trials are used."""


def local_search(
    start: Array, best: Trial, free: Sequence[int], look: ComputeTrial, budget: int
) -> None:
    """Look at up to ``budget`` designs about ``start`` (d, shares of the ranges), whose trial is
    ``best``; ``free``: places that may move.

    ``look(shares)`` computes a trial, all of its objectives included.
    """
    moving, centre, used = np.array(free, dtype=int), np.array(start, dtype=float), 0
    known: dict[bytes, Trial] = {centre[moving].tobytes(): best}
    sign = best.plan.objectives[0].sign
    scale = abs(float(best.objectives[0])) if np.isfinite(best.objectives[0]) else 1.0
    radius = RADIUS

    def trial_at(point: Array) -> Trial:
        nonlocal used
        inside = np.clip(point, 0.0, 1.0)
        key = inside.tobytes()
        if key not in known:
            if used >= budget:
                raise _Spent
            used += 1
            shares = centre.copy()
            shares[moving] = inside
            known[key] = look(shares)
        return known[key]

    def objective(point: Array) -> float:
        one = trial_at(point)
        value = (
            one.objectives[0]
            if not one.failure and np.isfinite(one.objectives[0])
            else best.objectives[0]
        )
        return float(sign * value / (scale or 1.0)) if np.isfinite(value) else 0.0

    def retained(point: Array) -> Array:
        one = trial_at(point)
        missed = (
            np.full(len(one.missed), 1.0) if one.failure else np.nan_to_num(one.missed, nan=1.0)
        )
        return np.concatenate(
            [
                -missed[: len(one.plan.constraints)] - TO_SPARE,
                -missed[len(one.plan.constraints) :],
                point,
                1.0 - point,
            ]
        )

    while used < budget and radius >= SMALLEST:
        before = best
        best, centre = _around(
            best, centre, moving, objective, retained, known, radius, budget - used
        )
        if best is before:
            radius *= SHRINK


def _around(
    best: Trial,
    centre: Array,
    moving: Array,
    objective: Callable[[Array], float],
    retained: Callable[[Array], Array],
    known: dict[bytes, Trial],
    radius: float,
    budget: int,
) -> tuple[Trial, Array]:
    """One search from the best design; the best of all evaluated, and its position."""
    from scipy.optimize import minimize

    options = {"rhobeg": radius, "tol": radius / 20, "maxiter": max(budget, len(moving) + 3)}
    try:
        minimize(
            objective,
            centre[moving],
            method="COBYLA",
            constraints=[{"type": "ineq", "fun": retained}],
            options=options,
        )
    except _Spent:
        pass
    found = best
    place = centre
    for key, one in known.items():
        if one is not found and _before(one, found):
            found, place = one, centre.copy()
            place[moving] = np.frombuffer(key)
    return found, place


def _before(one: Trial, other: Trial) -> bool:
    """Whether a trial is better: feasible before infeasible, then by the objective, or by what is
    missed.
    """
    if one.failure or one.feasible != other.feasible:
        return bool(not one.failure and one.feasible)
    if one.feasible:
        sign = one.plan.objectives[0].sign
        return bool(sign * one.objectives[0] < sign * other.objectives[0])
    return one.total_missed < other.total_missed
