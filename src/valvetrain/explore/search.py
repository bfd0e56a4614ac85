"""A search while it goes on: the case, then rounds of trials, the same whoever computes them and
however often it is begun anew.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.designs import Design as PointRequest
from valvetrain.explore.designs import Points, Stop, spread_first
from valvetrain.explore.experiment import seconds_of
from valvetrain.explore.measure import Measure, Measured
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.optimum import Confirmed, Design, Optimum, chosen_designs, steps_of
from valvetrain.explore.plan import StudyPlan, nominal
from valvetrain.explore.searchers import (
    CASE_SEED,
    Trial,
    best_of,
    searcher_of,
    shares_of,
    values_of,
)
from valvetrain.explore.space import Uniform
from valvetrain.runs.cost import Cost, Limits, refuse_cost
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.workers import Progress

Array = np.ndarray[tuple[int], np.dtype[np.float64]]
Look = Callable[[Array], Trial]
#: First radius of the neighbourhood in shares of the ranges, what it shrinks by, and the radius at
#: which the search ends.
RADIUS, SHRINK, SMALLEST = 0.1, 0.3, 0.003
#: Bounds are kept with this much to spare, in shares of them, so that what ends on one does not end
#: beyond it.
TO_SPARE = 1e-4


class _Spent(Exception):
    """All trials are used."""


def local_search(start: Array, best: Trial, free: Sequence[int], look: Look, budget: int) -> None:
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

    def kept(point: Array) -> Array:
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
        best, centre = _around(best, centre, moving, objective, kept, known, radius, budget - used)
        if best is before:
            radius *= SHRINK


def _around(
    best: Trial,
    centre: Array,
    moving: Array,
    objective: Callable[[Array], float],
    kept: Callable[[Array], Array],
    known: dict[bytes, Trial],
    radius: float,
    budget: int,
) -> tuple[Trial, Array]:
    """One search from the best design; the best of all looked at, and where it lies."""
    from scipy.optimize import minimize

    options = {"rhobeg": radius, "tol": radius / 20, "maxiter": max(budget, len(moving) + 3)}
    try:
        minimize(
            objective,
            centre[moving],
            method="COBYLA",
            constraints=[{"type": "ineq", "fun": kept}],
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


#: Trials of the first round or rounds, drawn evenly before the search learns; and for each varied
#: quantity.
FIRST, FIRST_EACH = 10, 2
#: Points of the search for a limit speed beyond those of its grid; seconds that a trial takes
#: besides its points; bytes of one.
CLOSER, AROUND, TRIAL_BYTES = 10, 0.03, 2e4
#: What makes a search large.
FEWER = "trials, speeds or models"


class SearchInterrupted(Stopped):
    """A search was stopped; ``optimum`` holds the trials that were finished."""

    def __init__(self, optimum: Optimum) -> None:
        super().__init__("stopped")
        self.optimum = optimum


@dataclass(frozen=True, slots=True)
class SearchEstimate:
    """What a search will cost before it starts, at most."""

    trials: int
    cost: Cost


def estimate_search(plan: OptimumPlan, workers: int) -> SearchEstimate:
    """Estimated cost of a plan: every trial to the end of its scans, and the confirmations."""
    trials = plan.search.trials * plan.search.seeds + 1
    each = _seconds(plan)
    after = (2 * len(plan.varied) + 1) * each
    confirmed = sum(2 * _seconds(one.plan) for one in plan.confirmations)
    points = sum(
        len(one.runs) if one.limit is None else len(one.limit.engine_speeds) + CLOSER
        for one in plan.measures
    )
    seconds = trials * AROUND + (trials * each + after * len(plan.objectives) + confirmed) / max(
        1, workers
    )
    return SearchEstimate(
        trials, Cost(seconds, trials * (TRIAL_BYTES + 500.0 * points) + 1.2e8 * (workers + 1))
    )


def _seconds(plan: OptimumPlan) -> float:
    """Seconds of one core for a design."""
    total = sum(
        seconds_of(study, run)
        for source, study in plan.plans.items()
        if source != "limit"
        for run in study.runs
    )
    for one in plan.measures:
        if one.limit is not None:
            study, speeds = plan.plans["limit"], one.limit.engine_speeds
            of_grid = sum(
                seconds_of(study, (speed, *run[1:])) for run in one.runs for speed in speeds
            )
            total += of_grid * (1 + CLOSER / len(speeds))
    return total


def run_search(
    plan: OptimumPlan,
    workers: int,
    dask: str = "",
    folder: Path | None = None,
    limits: Limits = Limits(),
    progress: Progress | None = None,
) -> Optimum:
    """The search of a plan; points that the stores below ``folder`` hold are not computed again.

    Raises :class:`InputError` for a request beyond ``limits``, and :class:`SearchInterrupted` with
    what was finished when it is stopped.
    """
    if workers < 1:
        raise InputError(f"workers must be 1 or more; it is {workers}", "--workers")
    refuse_cost(estimate_search(plan, workers).cost, limits, fewer=FEWER)
    for seed in _seeds(plan):
        searcher_of(
            plan.search, len(plan.varied), _signs(plan), seed
        )  # a library that is not installed is said before the first run
    return _Search(plan, progress).run(workers, dask, folder)


def _seeds(plan: OptimumPlan) -> tuple[int, ...]:
    return tuple(range(plan.search.seed, plan.search.seed + plan.search.seeds))


def _signs(plan: OptimumPlan) -> list[float]:
    return [one.sign for one in plan.objectives]


def case_plans(plan: OptimumPlan) -> dict[str, StudyPlan]:
    """The plans of the case itself, in which nothing is varied."""
    return {source: replace(study, varied=()) for source, study in plan.plans.items()}


class _Search:
    """One search, or several of different seeds, while they go on."""

    def __init__(self, plan: OptimumPlan, progress: Progress | None) -> None:
        self.plan, self.progress, self.begun = plan, progress, time.perf_counter()
        self.trials: list[Trial] = []
        self.case: Trial | None = None
        self.seeds = _seeds(plan)
        self.computed = 0

    def run(self, workers: int, dask: str, folder: Path | None) -> Optimum:
        own = case_plans(self.plan)
        others = [(one.plan, case_plans(one.plan)) for one in self.plan.confirmations]
        plans = [*own.items(), *self.plan.plans.items()]
        plans += [
            pair for varied, still in others for pair in (*still.items(), *varied.plans.items())
        ]
        with Points(plans, workers, dask, folder) as points:
            try:
                self.case = self._case(points, self.plan, own)
                self.plan = self.case.plan
                self.trials = [self.case]
                for seed in self.seeds:
                    self._search(points, seed)
                made = self._optimum(points.computed, True)
                designs = [
                    self._looked_at(points, one, place) for place, one in enumerate(made.designs)
                ]
                best = made.designs[0].trial if made.designs else None
                confirmed = (
                    ()
                    if best is None
                    else tuple(
                        self._confirm(points, one.label, varied, still, best)
                        for one, (varied, still) in zip(
                            self.plan.confirmations, others, strict=True
                        )
                    )
                )
                designs[:1] = [replace(one, confirmed=confirmed) for one in designs[:1]]
                return replace(
                    made,
                    designs=tuple(designs),
                    computed=points.computed,
                    seconds=time.perf_counter() - self.begun,
                )
            except KeyboardInterrupt:
                if self.case is None:
                    raise
                raise SearchInterrupted(self._optimum(points.computed, False)) from None

    def _case(self, points: Points, plan: OptimumPlan, own: Mapping[str, StudyPlan]) -> Trial:
        """The case as it stands, trial 0, with the bounds that are shares of its numbers."""
        if plan.begins:
            (begin,) = points.measure(
                [PointRequest(own, ())],
                [one for several in plan.begins.values() for one in several],
            )
            if begin.failure:
                raise InputError(
                    f"the case itself cannot be computed, and a limit speed is a share of its numbers: {begin.failure}"
                )
            plan = plan.with_limits(begin.values)
        (measured,) = points.measure([PointRequest(own, ())], plan.measures)
        if measured.failure and any(one.share is not None for one in plan.constraints):
            raise InputError(
                f"the case itself cannot be computed, and a bound is a share of its numbers: {measured.failure}"
            )
        return Trial(0, CASE_SEED, self._nominal(), measured, plan.of_case(measured.values))

    def _nominal(self) -> Array:
        """What stands in the case (d,), nan where nothing does."""
        found = []
        for one in self.plan.varied:
            try:
                found.append(nominal(self.plan.case, one))
            except InputError:
                found.append(np.nan)
        return np.array(found)

    def _search(self, points: Points, seed: int) -> None:
        """All rounds of one seed."""
        plan, search = self.plan, self.plan.search
        assert self.case is not None
        searcher = searcher_of(search, len(plan.varied), _signs(plan), seed)
        size = max(FIRST, FIRST_EACH * len(plan.varied))
        size = min(search.trials, -(-size // search.per_round) * search.per_round)
        first = list(spread_first(size, len(plan.varied), seed))
        begin = shares_of(plan, self.case.values)
        known = [] if begin is None else [begin]
        asked = searcher.ask(0, [*known, *first])[len(known) :]
        searcher.tell([*([self.case] if known else []), *self._round(points, asked, seed)])
        done, last = len(first), self._local_share()
        while done < search.trials - last:
            asked = searcher.ask(min(search.per_round, search.trials - last - done))
            if not asked:
                break
            searcher.tell(self._round(points, asked, seed))
            done += len(asked)
        if last:
            self._local(points, seed, search.trials - done)

    def _local_share(self) -> int:
        """Trials that the local search has, none for several objectives and where nothing can move
        a little.
        """
        free = any(isinstance(one.distribution, Uniform) for one in self.plan.varied)
        return (
            int(self.plan.search.local * self.plan.search.trials)
            if len(self.plan.objectives) == 1 and free
            else 0
        )

    def _local(self, points: Points, seed: int, budget: int) -> None:
        """About the best design of a seed, or the one that misses its bounds by least."""
        own = [one for one in self.trials if one.seed in (seed, CASE_SEED) and not one.failure]
        starts = [one for one in own if shares_of(self.plan, one.values) is not None]
        if not starts:
            return
        best = best_of(starts) or min(starts, key=lambda one: (one.total_missed, one.number))
        begin = shares_of(self.plan, best.values)
        assert begin is not None
        free = [
            place
            for place, one in enumerate(self.plan.varied)
            if isinstance(one.distribution, Uniform)
        ]
        local_search(
            begin,
            best,
            free,
            lambda shares: self._round(points, [shares], seed, spare=False)[0],
            budget,
        )

    def _round(
        self, points: Points, shares: Sequence[Array], seed: int, spare: bool = True
    ) -> list[Trial]:
        """The trials of one round, a few batches of points at a time."""
        plan = self.plan
        # the generations of NSGA-II hold infeasible designs too, with their objectives
        stop = _spared(plan) if spare and plan.search.method != "nsga2" else None
        values = [values_of(plan, one) for one in shares]
        made = []
        for begin in range(0, len(values), plan.search.per_round):
            part = values[begin : begin + plan.search.per_round]
            measured = points.measure(
                [PointRequest(plan.plans, tuple(map(float, one))) for one in part],
                plan.measures,
                stop,
            )
            for one, found in zip(part, measured, strict=True):
                made.append(Trial(len(self.trials), seed, one, found, plan))
                self.trials.append(made[-1])
            self._tell()
        return made

    def _tell(self) -> None:
        if self.progress is not None:
            total = self.plan.search.trials * len(self.seeds) + 1
            one, best = self.plan.objectives[0].measure, best_of(self.trials)
            words = (
                "none feasible yet"
                if best is None
                else f"best {one.shown(float(best.objectives[0])):.5g} {one.unit}".rstrip()
            )
            self.progress(
                min(0.97, len(self.trials) / total),
                f"{len(self.trials) - 1} of {total - 1} trials, {words}",
            )

    def _optimum(self, computed: int, finished: bool) -> Optimum:
        assert self.case is not None
        seconds = time.perf_counter() - self.begun
        made = Optimum(
            self.plan,
            self.case,
            tuple(self.trials),
            computed=computed,
            seconds=seconds,
            finished=finished,
            seeds=self.seeds,
        )
        by_seed: dict[int, float] = {}
        if len(self.plan.objectives) == 1 and len(self.seeds) > 1:
            by_seed = {
                seed: float(found[-1])
                for seed in self.seeds
                if len(found := made.history(seed)) and np.isfinite(found[-1])
            }
        return replace(made, best_by_seed=by_seed, designs=chosen_designs(made))

    def _looked_at(self, points: Points, one: Design, place: int) -> Design:
        """A chosen design with what small steps do to it; of several designs the first one alone."""
        if place or (one.trial.number == 0 and shares_of(self.plan, one.trial.values) is None):
            return one

        def measure(values: Sequence[Array]) -> list[Measured]:
            return points.measure(
                [PointRequest(self.plan.plans, tuple(map(float, row))) for row in values],
                self.plan.measures,
            )

        return replace(one, steps=steps_of(self.plan, one.trial, measure))

    def _confirm(
        self,
        points: Points,
        label: str,
        plan: OptimumPlan,
        still: Mapping[str, StudyPlan],
        best: Trial,
    ) -> Confirmed:
        """The best design and the case by another model."""
        if self.progress is not None:
            self.progress(0.98, f"confirming by {label}")
        case = self._case(points, plan, still)
        if best.number == 0:
            return Confirmed(label, case.plan, case, case)
        (measured,) = points.measure(
            [PointRequest(plan.plans, tuple(map(float, best.values)))], case.plan.measures
        )
        return Confirmed(
            label, case.plan, case, Trial(best.number, best.seed, best.values, measured, case.plan)
        )


def _spared(plan: OptimumPlan) -> Stop:
    """Says of numbers at hand whether a bound is missed already, so that no limit speed is needed."""

    def stop(values: Mapping[Measure, float]) -> bool:
        return any(
            one.missed(values[one.measure]) > 0 for one in plan.constraints if one.measure in values
        )

    return stop
