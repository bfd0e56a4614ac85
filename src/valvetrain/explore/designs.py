"""Points of designs, each computed once: out to the workers, outcomes into stores on disk as they
come.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from valvetrain.explore.evaluate import evaluate
from valvetrain.explore.executors import DaskExecutor
from valvetrain.explore.measure import Ask, Measure, Measured, measuring
from valvetrain.explore.plan import Array, Run, StudyPlan
from valvetrain.explore.point import Outcome
from valvetrain.explore.store import PointStore
from valvetrain.runs.workers import LOST, LOST_REMEDY, Lost, StandingPool
from valvetrain.solution.status import Status

#: (which plan, values, run) of a point for a worker.
Job = tuple[int, tuple[float, ...], Run]
Stop = Callable[[Mapping[Measure, float]], bool]


class Stream(Protocol):
    """Computes a batch of points, each handed back as it is finished."""

    def stream(self, jobs: Sequence[Job]) -> Any:
        """(place, outcome) of each job."""
        ...


@dataclass(frozen=True, eq=False)
class Design:
    """A design to be measured: ``plans`` by source (those of the case itself, or with what is
    varied) and its ``values`` (SI).
    """

    plans: Mapping[str, StudyPlan]
    values: tuple[float, ...]


class Points:
    """Measures designs side by side, batch by batch; use it as a context. ``computed`` counts the
    points of this call.

    ``plans``: source and study of points, all there are; points of a source are kept in its folder
    below ``folder`` (None: in memory).
    """

    def __init__(
        self, plans: Sequence[tuple[str, StudyPlan]], workers: int, dask: str, folder: Path | None
    ) -> None:
        self.plans = tuple(plans)
        self.places = {id(plan): place for place, (_, plan) in enumerate(self.plans)}
        self.workers, self.dask, self.folder = workers, dask, folder
        self.computed = 0
        self.stores: dict[str, PointStore] = {}

    def __enter__(self) -> Points:
        self._left = ExitStack()
        try:
            for source, plan in self.plans:
                if source not in self.stores:
                    store = PointStore(
                        None if self.folder is None else self.folder / source, plan.wanted.outputs
                    )
                    self._left.callback(store.close)
                    self.stores[source] = store
            shared = tuple(plan for _, plan in self.plans)
            self._executor: Stream
            if self.dask:
                self._executor = _Cluster(shared, self.dask, self.workers)
                self._left.callback(self._executor.close)
            else:
                self._executor = self._left.enter_context(
                    StandingPool(evaluate_job, shared, self.workers)
                )
        except BaseException:
            self._left.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._left.close()

    def measure(
        self, designs: Sequence[Design], measures: Sequence[Measure], stop: Stop | None = None
    ) -> list[Measured]:
        """The numbers of every design, in order; ``stop(values)`` may spare it the search for limit
        speeds.
        """
        if not measures:
            return [Measured({}, {}) for _ in designs]
        going = {place: measuring(measures, stop) for place in range(len(designs))}
        asked = {place: next(one, None) for place, one in going.items()}
        done: dict[int, Measured] = {}
        while going:
            outcomes = self._outcomes(
                [(designs[place], ask) for place in going for ask in asked[place] or ()]
            )
            given = iter(outcomes)
            for place in tuple(going):
                answer = [next(given) for _ in asked[place] or ()]
                try:
                    asked[place] = going[place].send(answer)
                except StopIteration as end:
                    done[place] = end.value
                    del going[place], asked[place]
        return [done[place] for place in range(len(designs))]

    def _outcomes(self, wanted: Sequence[tuple[Design, Ask]]) -> list[Outcome]:
        """Outcomes of a batch, in order; what no store holds is computed, each once."""
        keys: list[tuple[str, bytes]] = []
        waiting: dict[tuple[str, bytes], Job] = {}
        for design, (source, run) in wanted:
            plan = design.plans[source]
            key = (source, plan.digest(design.values, run))
            keys.append(key)
            if key[1] not in self.stores[source]:
                waiting.setdefault(key, (self.places[id(plan)], design.values, run))
        order = list(waiting)
        for number, result in self._executor.stream([waiting[key] for key in order]):
            source, digest = order[number]
            lost = Outcome(Status("worker-lost", LOST, remedy=LOST_REMEDY))
            self.stores[source].add(digest, lost if isinstance(result, Lost) else result)
            self.computed += 1
        return [self.stores[source].outcome(digest) for source, digest in keys]


def evaluate_job(plans: tuple[StudyPlan, ...], job: Job) -> Outcome:
    """The outcome of one point, in a worker."""
    place, values, run = job
    return evaluate(plans[place].point(values, run))


class _Cluster:
    """The same by a Dask cluster."""

    def __init__(self, shared: tuple[StudyPlan, ...], where: str, workers: int) -> None:
        self.shared, self.executor = shared, DaskExecutor(where, workers)

    def stream(self, jobs: Sequence[Job]) -> Any:
        """(place, outcome) of each job."""
        if jobs:
            yield from self.executor.run(evaluate_job, self.shared, jobs)

    def close(self) -> None:
        """Leave the cluster."""
        self.executor.close()


def spread_first(count: int, dimensions: int, seed: int) -> Array:
    """``count`` points (n, d) of the unit cube, one in each row and column of a Latin square."""
    from scipy.stats import qmc

    return np.asarray(
        qmc.LatinHypercube(dimensions, seed=np.random.default_rng([seed, dimensions])).random(count)
    )
