"""The engine of experiments: the evaluation of a case or a function at points of a space, each
computed once by processes of this machine or the cluster in use, and stored as it comes.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import unit_in_case
from valvetrain.explore.evaluate import Point, evaluate
from valvetrain.explore.outputs import Outcome, Outputs, Run
from valvetrain.explore.space import ENGINE_SPEED, Space, Varied
from valvetrain.explore.store import Store, versions_digest
from valvetrain.parameters.case import Case
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.identity import content, function_text
from valvetrain.parameters.loading import load_case
from valvetrain.runs.workers import LOST, LOST_REMEDY, Lost, StandingPool
from valvetrain.solution.status import Status
from valvetrain.units import format_quantity

Array = NDArray[np.float64]
#: Jobs that are submitted at a time, which bounds memory and the wait for any of them.
JOBS = 512
#: A point to be computed: its evaluation, values (SI) of the space, and the run.
PointJob = tuple["Evaluation", tuple[float, ...], Run]
#: The same for a worker, the evaluation by its index.
Job = tuple[int, tuple[float, ...], Run]
#: Errors of a function of one's own that make its point a refused one; others end the experiment.
_OF_FUNCTION = (InputError, ArithmeticError, ValueError)


@dataclass(frozen=True, eq=False, init=False)
class Evaluation:
    """What is computed at every point of a space: ``outputs`` of a ``case``, or of their function
    where it is None, by all ``runs``.
    """

    case: Case | None
    space: Space
    outputs: Outputs
    runs: tuple[Run, ...] = ()

    def __init__(
        self,
        case: Case | str | Path | None,
        space: Space,
        outputs: Outputs,
        runs: Sequence[Run] = (),
    ) -> None:
        if case is not None and not isinstance(case, Case):
            case = load_case(case)
        if (case is None) == (outputs.function is None):
            raise InputError(
                "an experiment evaluates a case or a function; give one of the two", "case"
            )
        if case is not None:
            if any(one.key != ENGINE_SPEED for one in space):
                tables_of(case)  # refuses a case whose values cannot be varied
            for one in space:  # runs have speeds of their own, which this would not change
                if one.key.startswith(("operation.engine_speeds", "operation.cam_speeds")):
                    raise InputError(f"is no speed of these runs; vary {ENGINE_SPEED}", one.key)
            space = with_case_units(case, space)
        speed_is_varied = any(one.key == ENGINE_SPEED for one in space)
        for name, value in (
            ("case", case),
            ("space", space),
            ("outputs", outputs),
            ("runs", tuple(runs) or outputs.runs(case, speed_is_varied)),
        ):
            object.__setattr__(self, name, value)

    def point(self, values: Iterable[float], run: Run) -> Point:
        """One point of a case: values (SI, in the order of the space) at one of the runs."""
        assert self.case is not None
        pairs = tuple(zip(self.space, map(float, values), strict=True))
        return Point(self.case, pairs, *run, self.outputs.request)

    def evaluate(self, values: Iterable[float], run: Run) -> Outcome:
        """The outcome of one point, bit-identical to a run of the case with these values."""
        function = self.outputs.function
        if function is None:
            return evaluate(self.point(values, run))
        given = dict(zip(self.space.names, map(float, values), strict=True))
        try:
            numbers = function(**given)
        except _OF_FUNCTION as error:
            return Outcome(Status("refused", str(error) or type(error).__name__))
        names = self.outputs.quantities
        if not isinstance(numbers, Mapping):
            numbers = dict(zip(names, np.atleast_1d(numbers).tolist(), strict=True))
        return Outcome(values={name: float(numbers[name]) for name in names if name in numbers})

    def rows(self, draws: Array) -> Iterator[tuple[Array, Run]]:
        """Every draw at every run, in the order of the rows of the result."""
        yield from itertools.product(draws, self.runs)

    @cached_property
    def _base(self) -> bytes:
        """Digest of what all points share: case or function, keys, outputs and versions."""
        keys = [[one.key, one.operation, one.si_unit] for one in self.space]
        subject = (
            function_text(self.outputs.function) if self.case is None else _case_text(self.case)
        )
        request = self.outputs.request
        parts = [subject, keys, list(request.outputs), request.rest_model, versions_digest()]
        return hashlib.blake2b(json.dumps(parts, sort_keys=True).encode(), digest_size=16).digest()

    def digest(self, values: Iterable[float], run: Run) -> bytes:
        """16 bytes that change with anything that can change the numbers of a point, to the last
        bit of a value.
        """
        speed = None if run[0] is None else float(run[0]).hex()
        own = json.dumps([[float(value).hex() for value in values], speed, run[1], run[2]])
        return hashlib.blake2b(self._base + own.encode(), digest_size=16).digest()

    def key_of_output(self, name: str, run: Run) -> str:
        """The key of an output for measurements: its name, behind engine speed, model and set where
        there is more than one run.
        """
        if len(self.runs) == 1:
            return name
        speed = [] if run[0] is None else [format_quantity(run[0], "rpm")]
        where = ", ".join([*speed, *filter(None, run[1:])])
        return f"{where}: {name}" if where else name


def with_case_units(case: Case, space: Space) -> Space:
    """The space with the units of the case for quantities that give none."""

    def unit_of(one: Varied) -> str:
        if one.unit or one.operation == "factor":
            return one.unit
        if one.key == ENGINE_SPEED:
            return "rpm"
        try:
            return unit_in_case(case, one.key)
        except InputError:  # not in the case: a plain number, or refused when it is set
            return ""

    varied = [
        replace(one, unit=unit) if (unit := unit_of(one)) != one.unit else one for one in space
    ]
    for one in varied:
        given = one.distribution.dimension
        due = one.dimension if one.unit or one.operation == "factor" else given
        if given not in (None, due):
            raise InputError(
                f"its distribution has the dimension {given}, the quantity {due}; correct the units",
                one.key,
            )
    return Space(varied, space.correlation)


def _case_text(case: Case) -> str:
    """The case for a digest, without titles and notes, to the last bit."""
    bare = (
        case.springs, case.rubbing, case.lift_law, case.operation, case.train, case.study, case.published,
    )  # fmt: skip
    return content(bare).decode()


class Engine:
    """Computes points of some evaluations, each once: stored ones are read, the others computed by
    ``workers`` at a time. Use it as a context.

    ``together``: points of a job; ``finished`` is called after each. ``read``: points that the
    store had.
    """

    def __init__(
        self,
        evaluations: Sequence[Evaluation],
        workers: int,
        folder: Path | None,
        together: int = 1,
        finished: Callable[[], None] | None = None,
    ) -> None:
        self.evaluations, self.workers = tuple(evaluations), workers
        self._indices = {id(one): index for index, one in enumerate(self.evaluations)}
        self.together, self.finished = together, finished
        self.store, self.read = Store(folder), 0
        self._pool: StandingPool | None = None

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.store.close()
        finally:
            self._end_pool()

    def include(self, evaluation: Evaluation) -> None:
        """Add an evaluation."""
        self._indices[id(evaluation)] = len(self.evaluations)
        self.evaluations = (*self.evaluations, evaluation)
        self._end_pool()  # its processes do not have the new one

    def _end_pool(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.__exit__()

    @property
    def computed(self) -> int:
        """Points that were computed since the start."""
        return self.store.computed

    def compute(self, jobs: Iterable[PointJob]) -> None:
        """Compute the points that the store lacks."""
        waiting: dict[bytes, Job] = {}
        for evaluation, values, run in jobs:
            key = evaluation.digest(values, run)
            if key in self.store:
                self.read += 1
            else:
                waiting.setdefault(key, (self._indices[id(evaluation)], values, run))
            if len(waiting) >= JOBS * self.together:
                self._submit(waiting)
                waiting = {}
        self._submit(waiting)

    def outcomes(self, jobs: Sequence[PointJob]) -> list[Outcome]:
        """The outcomes of a batch of points, in order."""
        self.compute(jobs)
        return [self.store.outcome(one.digest(values, run)) for one, values, run in jobs]

    def _submit(self, waiting: Mapping[bytes, Job]) -> None:
        if not waiting:
            return
        if self._pool is None:
            pool = StandingPool(evaluate_jobs, self.evaluations, self.workers)
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


def evaluate_jobs(evaluations: Sequence[Evaluation], jobs: Sequence[Job]) -> list[Outcome]:
    """Outcomes of a few points, in a worker."""
    return [evaluations[index].evaluate(values, run) for index, values, run in jobs]
