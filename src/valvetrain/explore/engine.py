"""The engine of experiments: what is computed at points, each computed once by processes of this machine or the cluster
in use, and stored as it comes.
"""

from __future__ import annotations

import hashlib
import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import unit_in_case
from valvetrain.explore.evaluate import bars_of, evaluate
from valvetrain.explore.limit_speed import limit_outcome
from valvetrain.explore.outputs import Outcome, Outputs, Run, Task
from valvetrain.explore.space import ENGINE_SPEED, Space, Varied
from valvetrain.explore.store import Store, versions_digest
from valvetrain.parameters.case import Case, content
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.own_parts import part_digest
from valvetrain.quantities.request import PointRequest
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.workers import LOST, LOST_REMEDY, Lost, StandingPool
from valvetrain.solution.status import Status
from valvetrain.solution.uncertainty import Uncertainty

#: Jobs that are submitted at a time, which bounds memory and the wait for any of them.
JOBS = 512
#: Errors of a function of one's own that make its point a refused one; others end the experiment.
_OF_FUNCTION = (InputError, ArithmeticError, ValueError)


class Computation(ABC):
    """What an engine computes at points: of every point each of its ``tasks``."""

    @property
    def tasks(self) -> tuple[Any, ...]:
        """What is computed of a point."""
        return ((),)

    @property
    @abstractmethod
    def subject(self) -> Any:
        """All that an outcome depends on besides values and task, as JSON takes it."""

    @abstractmethod
    def evaluate(self, values: Iterable[float], task: Any) -> Outcome:
        """The outcome of one task at a point, which depends on no other point."""

    def key_of_output(self, name: str, task: Any) -> str:
        """The key of an output for measurements."""
        return name

    @cached_property
    def _base(self) -> bytes:
        text = json.dumps(self.subject, sort_keys=True, default=repr)
        return hashlib.blake2b(text.encode(), digest_size=16).digest()

    def digest(self, values: Iterable[float], task: Any) -> bytes:
        """16 bytes that change with anything that can change the numbers of a point, to the last
        bit of a value.
        """
        text = repr((*map(float, values), task))
        return hashlib.blake2b(self._base + text.encode(), digest_size=16).digest()


class Interrupted(Stopped):
    """A study or a search was stopped; ``result`` holds what was finished."""

    def __init__(self, result: Any) -> None:
        super().__init__("stopped")
        self.result = result


#: A place to be computed, behind its computation; the same for a worker, the computation by its index.
PointJob = tuple[Computation, tuple[float, ...], Any]
Job = tuple[int, tuple[float, ...], Any]


@dataclass(frozen=True, eq=False, init=False)
class Evaluation(Computation):
    """``outputs`` of a ``case``, or of their function where it is None, at every point of a space."""

    case: Case | None
    space: Space
    outputs: Outputs

    def __init__(self, case: Case | str | Path | None, space: Space, outputs: Outputs) -> None:
        if case is not None and not isinstance(case, Case):
            case = load_case(case)
        if (case is None) == (outputs.function is None):
            raise InputError(
                "an experiment evaluates a case or a function; give one of the two", "case"
            )
        if case is not None:
            if any(one.key != ENGINE_SPEED for one in space):
                tables_of(case)  # refuses a case whose values cannot be varied
            parts = (part for one in space for part in one.parts)
            for one in parts:  # runs have speeds of their own, which this would not change
                if one.key.startswith(("operation.engine_speeds", "operation.cam_speeds")):
                    raise InputError(f"is no speed of these runs; vary {ENGINE_SPEED}", one.key)
            space = with_case_units(case, space)
        vars(self).update(case=case, space=space, outputs=outputs)

    @property
    def name(self) -> str:
        """Name of the case, or of the function."""
        function = self.outputs.function
        return getattr(function, "__name__", "function") if self.case is None else self.case.name

    @cached_property
    def runs(self) -> tuple[Run, ...]:
        """Every engine speed by every model with every spring set. Raises :class:`InputError` where one is missing."""
        return self.outputs.runs(self.case, any(one.key == ENGINE_SPEED for one in self.space))

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """The quantities of every run, then the limit speeds by every model with every set."""
        outputs = self.outputs
        kinds = dict.fromkeys(run._replace(engine_speed=None) for run in self.runs)
        return (
            *(Task(run, outputs.request) for run in self.runs if outputs.quantities),
            *(Task(run, PointRequest((one.quantity,)), one) for one in outputs.limit_speeds for run in kinds),
        )  # fmt: skip

    def _varied(self, values: Iterable[float]) -> dict[Varied, float]:
        """Values (SI, in the order of the space) by what is varied; without values the case as it is."""
        numbers = tuple(map(float, values))
        return dict(zip(self.space, numbers, strict=bool(numbers)))

    def evaluate(self, values: Iterable[float], task: Task) -> Outcome:
        """The outcome of one point, bit-identical to a run of the case with these values."""
        case, function, (run, request, limit) = self.case, self.outputs.function, task
        given = self._varied(values)
        if case is not None and limit is not None:
            at, of_case = (
                lambda engine_speed, point=point: evaluate(
                    case, point, run._replace(engine_speed=engine_speed), request
                )
                for point in (given, {})
            )
            return limit_outcome(limit, at, of_case)
        if case is not None:
            return evaluate(case, given, run, request)
        assert function is not None
        try:
            numbers = function(**{one.name: value for one, value in given.items()})
        except _OF_FUNCTION as error:
            return Outcome(Status("refused", str(error) or type(error).__name__))
        names = request.outputs
        if not isinstance(numbers, Mapping):
            numbers = dict(zip(names, np.atleast_1d(numbers).tolist(), strict=True))
        return Outcome(values={name: float(numbers[name]) for name in names if name in numbers})

    def error_bars(self, values: Iterable[float], run: Run) -> tuple[Uncertainty, ...]:
        """Error bars of the numbers of a point; none of a function."""
        given = self._varied(values)
        return () if self.case is None else bars_of(self.case, given, run, self.outputs.request)

    @property
    def subject(self) -> Any:
        """Case (without titles and notes, to the last bit) or function, keys and versions."""
        case = self.case
        if case is None:
            text = part_digest(self.outputs.function)
        else:
            text = content((
                case.springs, case.rubbing, case.lift_law, case.operation, case.train, case.study, case.published,
            )).decode()  # fmt: skip
        return [text, self.space.identity, versions_digest()]

    def key_of_output(self, name: str, task: Task) -> str:
        """The key of an output for measurements: its name, behind engine speed, model and set where
        there is more than one run.
        """
        if len(self.runs) == 1:
            return name
        return ": ".join(filter(None, (task.run.label, name)))


@dataclass(frozen=True, eq=False, kw_only=True)
class Plan:
    """What a study or a search does with an ``experiment``."""

    experiment: Evaluation
    title: str = ""
    description: str = ""

    @property
    def case(self) -> Case | None:
        """The case, None of a function."""
        return self.experiment.case

    @property
    def case_name(self) -> str:
        """Name of the case, or of the function."""
        return self.experiment.name

    @property
    def varied(self) -> Space:
        """The varied quantities."""
        return self.experiment.space


def with_case_units(case: Case, space: Space) -> Space:
    """The space with the units of the case for quantities that give none."""

    varied = []
    for one in space:
        unit = one.unit
        if not unit and one.operation != "factor":
            with suppress(InputError):  # not in the case: a plain number, or refused when it is set
                unit = "rpm" if one.key == ENGINE_SPEED else unit_in_case(case, one.key)
        made = replace(one, unit=unit)
        given = made.distribution.dimension
        if (unit or one.operation == "factor") and given not in (None, made.dimension):
            raise InputError(
                f"its distribution has the dimension {given}, the quantity {made.dimension}; correct the units",
                one.key,
            )
        varied.append(made)
    return Space(varied)


class Engine:
    """Computes points of some computations, each once: stored ones are read, the others computed by
    ``workers`` at a time. Use it as a context.

    ``together``: points of a job; ``finished`` is called after each. ``read``: points that the
    store had.
    """

    def __init__(
        self,
        computations: Sequence[Computation],
        workers: int,
        folder: Path | None,
        together: int = 1,
        finished: Callable[[], None] | None = None,
    ) -> None:
        self.computations, self.workers = tuple(computations), workers
        self.together, self.finished = together, finished
        self.store, self.read = Store(folder), 0
        self._pool: StandingPool | None = None

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.store.close()
        finally:
            if self._pool is not None:
                self._pool.__exit__()

    def compute(self, jobs: Iterable[PointJob]) -> None:
        """Compute the points that the store lacks."""
        indices = {id(one): index for index, one in enumerate(self.computations)}
        waiting: dict[bytes, Job] = {}
        for computation, values, task in jobs:
            key = computation.digest(values, task)
            if key in self.store:
                self.read += 1
            else:
                waiting.setdefault(key, (indices[id(computation)], values, task))
            if len(waiting) >= JOBS * self.together:
                self._submit(waiting)
                waiting = {}
        self._submit(waiting)

    def outcomes(self, jobs: Sequence[PointJob]) -> list[Outcome]:
        """The outcomes of a batch of points, in order."""
        self.compute(jobs)
        return [self.store.outcome(one.digest(values, task)) for one, values, task in jobs]

    def _submit(self, waiting: Mapping[bytes, Job]) -> None:
        if not waiting:
            return
        if self._pool is None:
            pool = StandingPool(evaluate_jobs, self.computations, self.workers)
            self._pool = pool.__enter__()
        size = max(1, min(self.together, math.ceil(len(waiting) / self.workers)))
        every = list(waiting.items())
        groups = [every[first : first + size] for first in range(0, len(every), size)]
        points = [[job for _, job in group] for group in groups]
        lost = Outcome(Status("worker-lost", LOST, remedy=LOST_REMEDY))
        for index, result in self._pool.stream(points):
            outcomes = [lost] * len(groups[index]) if isinstance(result, Lost) else result
            for (key, _), outcome in zip(groups[index], outcomes, strict=True):
                self.store.add(key, outcome)
            if self.finished is not None:
                self.finished()


def evaluate_jobs(computations: Sequence[Computation], jobs: Sequence[Job]) -> list[Outcome]:
    """Outcomes of a few points, in a worker."""
    return [computations[index].evaluate(values, task) for index, values, task in jobs]
