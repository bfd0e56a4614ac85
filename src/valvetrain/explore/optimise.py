"""``valvetrain.optimise``: the case, then rounds of trials, the same for any executor and after any
interruption.
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import nominal
from valvetrain.explore.doubts import doubts
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.limit_speed import CLOSER, LimitEvaluation, LimitFound
from valvetrain.explore.measure import (
    INCOMPLETE,
    LIMIT,
    Measure,
    Measured,
    Stop,
    Subject,
    measure_designs,
)
from valvetrain.explore.objective import OptimumPlan, read_optimum
from valvetrain.explore.optimum import Confirmed, Design, Optimum, chosen_designs, steps_of
from valvetrain.explore.optimum_curves import Compared, compare
from valvetrain.explore.optimum_file import OptimumText, read_optimum_file
from valvetrain.explore.outputs import LimitSearch, Outputs, limit_search
from valvetrain.explore.samplers import latin_hypercube
from valvetrain.explore.searchers import local_search, searcher_of, shares_of, values_of
from valvetrain.explore.space import Space
from valvetrain.explore.study import seconds_of
from valvetrain.explore.trial import CASE_SEED, Array, Trial, best_of
from valvetrain.explore.unavailable import refuse_outputs
from valvetrain.explore.valley import valley_of
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost, Limits, limits_of, refuse_cost
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.watch import shows_progress
from valvetrain.runs.workers import Progress, workers_here
from valvetrain.units import known_arguments

#: Trials of the first round or rounds, drawn evenly before the search learns; and for each varied
#: quantity.
FIRST, FIRST_EACH = 10, 2
#: Seconds that a trial takes in addition to its points; bytes of one.
AROUND, TRIAL_BYTES = 0.03, 2e4
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
    after = (
        8 * len(plan.varied) + 1
    ) * each  # steps, and three points towards either end of the valley
    confirmed = sum(2 * _seconds(one.plan) for one in plan.confirmations)
    points = sum(
        len(one.runs) if one.limit is None else len(one.limit.engine_speeds) + CLOSER
        for one in plan.measures
    )
    seconds = trials * AROUND + (trials * each + after * len(plan.objectives) + confirmed) / max(
        1, workers
    )
    return SearchEstimate(
        trials,
        Cost(
            seconds, trials * (TRIAL_BYTES + 500.0 * points) + 1.2e8 * (workers_here(workers) + 1)
        ),
    )


def _seconds(plan: OptimumPlan) -> float:
    """Seconds of one core for a design."""
    total = sum(
        seconds_of(study, run)
        for source, study in plan.plans.items()
        if not isinstance(source, LimitSearch)
        for run in study.runs
    )
    for one in plan.measures:
        if one.limit is not None:
            study, speeds = plan.plans[one.limit], one.limit.engine_speeds
            of_grid = sum(
                seconds_of(study, (speed, *run[1:])) for run in one.runs for speed in speeds
            )
            total += of_grid * (1 + CLOSER / len(speeds))
    return total


def run_search(
    plan: OptimumPlan,
    workers: int,
    folder: Path | None = None,
    limits: Limits = Limits(),
    progress: Progress | None = None,
) -> Optimum:
    """The search of a plan; points that the stores below ``folder`` hold are not computed again.

    Raises :class:`InputError` for a request beyond ``limits``, and :class:`SearchInterrupted` with
    what was finished when it is stopped.
    """
    for one in (plan, *(made.plan for made in plan.confirmations)):
        for source in one.plans.values():
            refuse_outputs(source)
    refuse_cost(estimate_search(plan, workers).cost, limits, fewer=FEWER)
    for seed in _seeds(plan):
        searcher_of(
            plan.search, len(plan.varied), _signs(plan), seed
        )  # a library that is not installed is said before the first run
    return _Search(plan, progress).run(workers, folder)


def _seeds(plan: OptimumPlan) -> tuple[int, ...]:
    return tuple(range(plan.search.seed, plan.search.seed + plan.search.seeds))


def _signs(plan: OptimumPlan) -> list[float]:
    return [one.sign for one in plan.objectives]


def case_of_plan(plan: OptimumPlan) -> Subject:
    """The case itself, in which nothing is varied; of a function the middle of the space."""
    if plan.case is None:
        return plan.plans, tuple(one.distribution.middle for one in plan.varied)
    still = dict[str | LimitSearch, Evaluation]()
    for source, one in plan.plans.items():
        fixed = Evaluation(one.case, Space(()), one.outputs, one.runs)
        still[source] = LimitEvaluation(fixed, source) if isinstance(source, LimitSearch) else fixed
    return still, ()


class _Search:
    """A running search, or several of different seeds."""

    def __init__(self, plan: OptimumPlan, progress: Progress | None) -> None:
        self.plan, self.progress, self.begun = plan, progress, time.perf_counter()
        self.trials: list[Trial] = []
        self.case: Trial | None = None
        self.seeds = _seeds(plan)
        self.computed = 0

    def run(self, workers: int, folder: Path | None) -> Optimum:
        own = case_of_plan(self.plan)
        others = [(one.plan, case_of_plan(one.plan)) for one in self.plan.confirmations]
        every = [own[0], self.plan.plans]
        every += [part for varied, still in others for part in (still[0], varied.plans)]
        experiments = [one for part in every for one in part.values()]
        with Engine(experiments, workers, folder) as points:
            try:
                self.case = self._case(points, self.plan, own)
                self.plan = self.case.plan
                self.trials = [self.case]
                for seed in self.seeds:
                    self._search(points, seed)
                made = self._optimum(points.computed, True)
                designs = [
                    self._looked_at(points, one, index) for index, one in enumerate(made.designs)
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
                beside = self._beside_the_case(points, made, own)
                return replace(
                    made,
                    contact_loss=self._contact_loss(points, made),
                    error_bars=() if beside is None else beside.error_bars,
                    curves=() if beside is None else beside.curves,
                    doubt=self._doubt(best),
                    designs=tuple(designs),
                    computed=points.computed,
                    seconds=time.perf_counter() - self.begun,
                )
            except KeyboardInterrupt:
                if self.case is None:
                    raise
                raise SearchInterrupted(self._optimum(points.computed, False)) from None

    def _case(self, points: Engine, plan: OptimumPlan, own: Subject) -> Trial:
        """The case as given, trial 0, with the bounds that are shares of its numbers."""
        (measured,) = measure_designs(points, [own], plan.measures)
        shares = [one.share for one in plan.constraints]
        shares += [one.limit.share for one in plan.measures if one.limit is not None]
        if measured.failure and any(share is not None for share in shares):
            raise InputError(
                f"the case itself cannot be computed, and a bound is a share of its numbers: {measured.failure}"
            )
        if measured.code == INCOMPLETE:
            raise InputError(f"{measured.failure}; no design can be judged without it")
        values = self._nominal()
        still = {
            one.measure: float(values[tuple(plan.varied).index(one.measure.varied)])
            for one in plan.constraints
            if one.measure.varied is not None
        }
        return Trial(0, CASE_SEED, values, measured, plan.of_case({**measured.values, **still}))

    def _nominal(self) -> Array:
        """Values of the case (d,), nan where it has none; of a function the middle of the space."""
        if self.plan.case is None:
            return np.array(case_of_plan(self.plan)[1])
        found = []
        for one in self.plan.varied:
            try:
                found.append(nominal(self.plan.case, one))
            except InputError:
                found.append(np.nan)
        return np.array(found)

    def _search(self, points: Engine, seed: int) -> None:
        """All rounds of one seed."""
        plan, search = self.plan, self.plan.search
        assert self.case is not None
        searcher = searcher_of(search, len(plan.varied), _signs(plan), seed)
        size = max(FIRST, FIRST_EACH * len(plan.varied))
        size = min(search.trials, -(-size // search.per_round) * search.per_round)
        first = list(latin_hypercube(size, len(plan.varied), [seed, len(plan.varied)]))
        begin = shares_of(plan, self.case.values)
        known = [] if begin is None else [begin]
        requested = searcher.ask(0, [*known, *first])[len(known) :]
        searcher.tell([*([self.case] if known else []), *self._round(points, requested, seed)])
        done, last = len(first), self._local_share()
        while done < search.trials - last:
            requested = searcher.ask(min(search.per_round, search.trials - last - done))
            if not requested:
                break
            searcher.tell(self._round(points, requested, seed))
            done += len(requested)
        if last:
            self._local(points, seed, search.trials - done)

    def _local_share(self) -> int:
        """Trials that the local search has, none for several objectives and where nothing can move
        a little.
        """
        free = any(one.distribution.kind != "values" for one in self.plan.varied)
        return (
            int(self.plan.search.local * self.plan.search.trials)
            if len(self.plan.objectives) == 1 and free
            else 0
        )

    def _local(self, points: Engine, seed: int, budget: int) -> None:
        """About the best design of a seed, or the one that misses its bounds by least."""
        own = [one for one in self.trials if one.seed in (seed, CASE_SEED) and not one.failure]
        starts = [one for one in own if shares_of(self.plan, one.values) is not None]
        if not starts:
            return
        best = best_of(starts) or min(starts, key=lambda one: one.rank)
        begin = shares_of(self.plan, best.values)
        assert begin is not None
        free = [
            index for index, one in enumerate(self.plan.varied) if one.distribution.kind != "values"
        ]
        local_search(
            begin,
            best,
            free,
            lambda shares: self._round(points, [shares], seed, spare=False)[0],
            budget,
        )

    def _round(
        self, points: Engine, shares: Sequence[Array], seed: int, spare: bool = True
    ) -> list[Trial]:
        """The trials of one round, a few batches of points at a time."""
        plan = self.plan
        # the generations of NSGA-II hold infeasible designs too, with their objectives
        stop = _spared(plan) if spare and plan.search.method != "nsga2" else None
        values = [values_of(plan, one) for one in shares]
        made = []
        for begin in range(0, len(values), plan.search.per_round):
            part = values[begin : begin + plan.search.per_round]
            subjects = [(plan.plans, tuple(one.tolist())) for one in part]
            measured = measure_designs(points, subjects, plan.measures, stop)
            for one, found in zip(part, measured, strict=True):
                made.append(Trial(len(self.trials), seed, one, found, plan))
                self.trials.append(made[-1])
            self._tell()
        return made

    def _tell(self) -> None:
        if self.progress is not None:
            total = self.plan.search.trials * len(self.seeds) + 1
            one, best = self.plan.objectives[0].measure, best_of(self.trials)
            phrase = (
                "none feasible yet"
                if best is None
                else f"best {one.shown(float(best.objectives[0])):.5g} {one.unit}".rstrip()
            )
            self.progress(
                min(0.97, len(self.trials) / total),
                f"{len(self.trials) - 1} of {total - 1} trials, {phrase}",
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

    def _looked_at(self, points: Engine, one: Design, index: int) -> Design:
        """A chosen design with what small steps do to it; of several designs the first one alone."""
        if index or (one.trial.number == 0 and shares_of(self.plan, one.trial.values) is None):
            return one

        def measure(values: Sequence[Array]) -> list[Measured]:
            subjects = [(self.plan.plans, tuple(row.tolist())) for row in values]
            return measure_designs(points, subjects, self.plan.measures)

        steps = steps_of(self.plan, one.trial, measure)
        valley = (
            valley_of(self.plan, one.trial, steps, self.trials, measure)
            if len(self.plan.objectives) == 1
            else None
        )
        return replace(one, steps=steps, valley=valley)

    def _beside_the_case(self, points: Engine, made: Optimum, own: Subject) -> Compared | None:
        """The best design, or the one that comes nearest, next to the case: curves and error bars."""
        nearest, case = made.nearest, self.plan.case
        if nearest is None or case is None:
            return None
        if self.progress is not None:
            self.progress(0.99, "error bars")
        name = "best" if made.best is not None else "nearest"
        design = Design(nearest, name) if made.best is None else made.best
        subjects = {"case": own}
        if design.trial is not self.case:
            subjects[name] = self.plan.plans, tuple(design.trial.values.tolist())
        return compare(points, self.plan, subjects, (case, made.case_of(design)))

    def _doubt(self, best: Trial | None) -> str:
        """What is unusual about the values of the best design and not about the case."""
        values = [] if best is None or best is self.case else [best.values.tolist()]
        texts = doubts(self.plan.case, self.plan.varied, values).values()
        return next((text.partition(": ")[2] for text in texts), "")

    def _contact_loss(self, points: Engine, made: Optimum) -> LimitFound | None:
        """The speed at which the nearest design loses contact, where no design retains it."""
        plan, trial = self.plan, made.nearest
        force = None if made.designs or trial is None else trial.floating
        if force is None or trial is None:
            return None
        run = max(force.runs, key=lambda one: one[0] or 0.0)
        speeds = [share * (run[0] or 0.0) for share in np.linspace(0.4, 1.0, 7).tolist()]
        limit = limit_search(
            force.quantity, f"{str(speeds)[1:-1]} rad/s", at_least="1e-9 N", resolution="25 rpm"
        )
        one = Measure(LIMIT, limit.quantity, ((None, *run[1:]),), "", limit=limit)
        own = self.case is trial
        space = Space(()) if own else plan.varied
        bare = Evaluation(plan.case, space, Outputs((limit.quantity,)), one.runs)
        study = LimitEvaluation(bare, limit)
        points.include(study)
        values = () if own else tuple(trial.values.tolist())
        (found,) = measure_designs(points, [({limit: study}, values)], [one])
        return found.limits[one][0] if one in found.limits else None

    def _confirm(
        self,
        points: Engine,
        label: str,
        plan: OptimumPlan,
        still: Subject,
        best: Trial,
    ) -> Confirmed:
        """The best design and the case by another model."""
        if self.progress is not None:
            self.progress(0.98, f"confirming by {label}")
        case = self._case(points, plan, still)
        if best.number == 0:
            return Confirmed(label, case.plan, case, case)
        design = (plan.plans, tuple(best.values.tolist()))
        (measured,) = measure_designs(points, [design], case.plan.measures)
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


@known_arguments
@shows_progress("optimise")
def optimise(
    file: str | os.PathLike[str],
    *,
    workers: int | None = None,
    dask: str = "",
    output: str | os.PathLike[str] | None = None,
    limit: str = "",
    progress: Progress | None = None,
) -> Optimum:
    """Search springs and lift laws for the best values of any quantities within bounds on any
    others.

    Parameters
    ----------
    file : path of an optimisation file (docs/optimisation.md), or its text
    workers : points at a time; results do not depend on it
    dask : "local", the address of a Dask scheduler or the name of a queue ("slurm", "pbs"); empty
        for processes of this machine
    output : folder of the finished points, where a search that was stopped or killed continues;
        none by default
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    progress : called with the share done and a text

    Returns
    -------
    Optimum with every trial in SI, the case itself as trial 0, the best design or the front of
    several objectives, sensitivities at the best, and its numbers by other models

    Raises
    ------
    InputError : one sentence on what is wrong in the file and where, or on a request that is too
        large
    MissingExtraError : the library of the search is not installed

    Examples
    --------
    The smallest preload with 20 mm of lift left until the coils are solid:

    >>> import valvetrain as vt
    >>> found = vt.optimise('''
    ... case = "job-c"
    ... vary = [{ key = "spring.precompression", low = "5 mm", high = "9 mm" }]
    ... objective = [{ quantity = "preload", direction = "minimise" }]
    ... constraint = [{ quantity = "installed_compression", at_least = "6 mm" }]
    ... rest_model = "massless"
    ... search = { trials = 12 }
    ... ''', workers=1)
    >>> round(1e3 * float(found.best.trial.values[0]), 1)
    6.0
    """
    if isinstance(file, str) and "=" in file and "\n" in file:
        text = OptimumText(file, "optimisation", Path())
    else:
        text = read_optimum_file(Path(file))
    return search_plan(read_optimum(text), workers, dask, output, limit, progress)


@known_arguments
@shows_progress("optimise")
def search_plan(
    plan: OptimumPlan,
    workers: int | None = None,
    dask: str = "",
    output: str | os.PathLike[str] | None = None,
    limit: str = "",
    progress: Progress | None = None,
) -> Optimum:
    """The search of a plan, with the arguments of :func:`optimise`."""
    folder = None if output is None else Path(output)
    with on_cluster(dask, workers) as count:
        return run_search(plan, count, folder, limits_of(limit), progress)
