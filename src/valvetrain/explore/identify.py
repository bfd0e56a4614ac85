"""``valvetrain.identify`` and the calibration of an experiment: from a file, or of a computation of
one's own.
"""

from __future__ import annotations

import timeit
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError, RunFailedError
from valvetrain.explore.case_paths import vary
from valvetrain.explore.engine import Computation, Engine
from valvetrain.explore.execution import Execution, Watch
from valvetrain.explore.identification_file import (
    IdentificationModel,
    IdentificationPlan,
    read_identification,
)
from valvetrain.explore.identified import Identified
from valvetrain.explore.outputs import Outcome
from valvetrain.explore.posterior import Evaluate, Numbers, Posterior
from valvetrain.explore.solve import solve
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.toml_text import toml_text
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost
from valvetrain.runs.workers import LOST, LOST_REMEDY

#: Points of the priors that are tried until one can be computed; bytes of a stored point and
#: of each of its numbers.
TRIED, POINT_BYTES, NUMBER_BYTES = 40, 1000.0, 150.0
#: Times a point is timed, for the first may wait for kernels.
ROUNDS = 3


def numbers_by(engine: Engine, computation: Computation) -> Evaluate:
    """What gives the numbers of points by the key of each output: those of all tasks, None where one did not complete.

    It raises :class:`RunFailedError` where a point is lost with its worker.
    """
    tasks = computation.tasks

    def numbers_of_point(outcomes: Sequence[Outcome]) -> Numbers:
        if not all(one.status.completed for one in outcomes):
            return None
        return {
            computation.key_of_output(name, task): value
            for task, one in zip(tasks, outcomes, strict=True)
            for name, value in one.values.items()
        }

    def evaluate(points: Array) -> list[Numbers]:
        rows = [tuple(row) for row in np.asarray(points, dtype=float).tolist()]
        outcomes = engine.outcomes([(computation, row, task) for row in rows for task in tasks])
        if any(one.status.code == "worker-lost" for one in outcomes):
            raise RunFailedError(f"a point is lost: {LOST}; {LOST_REMEDY}")
        count = len(tasks)
        return [numbers_of_point(outcomes[count * k : count * (k + 1)]) for k in range(len(rows))]

    return evaluate


def run_identification(
    plan: IdentificationPlan, execution: Execution = Execution(), watch: Watch = Watch()
) -> Identified:
    """The identification of a plan; points that are stored are not computed again.

    Raises :class:`InputError` for a request whose cost, by the time of one point, is beyond its limit, and where nothing
    can be computed.
    """
    fitted, compared, search = plan.fitted, plan.compared, plan.search
    computations = (fitted, *filter(None, [compared]))
    with (
        on_cluster(execution.dask, execution.workers) as workers,
        Engine(computations, workers, execution.output) as engine,
    ):
        posterior = Posterior(plan.unknowns, plan.data, numbers_by(engine, fitted))
        seconds = _seconds(fitted, possible_point(fitted, posterior, search.seed))
        points = search.evaluations_of(len(plan.unknowns))
        left = max(points - engine.store.before // len(fitted.tasks), 0)
        total = left * seconds
        if compared is not None:
            total += (search.draws + 2) * _seconds(compared, posterior.middle)
        size = points * (POINT_BYTES + NUMBER_BYTES * len(plan.data))
        work = f"{left} points of {1e3 * seconds:.3g} ms"
        watch.admit(Cost(total / workers, size), execution.limit, work)
        others = None if compared is None else numbers_by(engine, compared)
        start = posterior.middle if plan.start is None else np.array(plan.start)
        found = solve(posterior, search, engine.store, start, watch.report, others, plan.units)
    return replace(
        found, text=plan.text, name=plan.title, case_file=identified_case(plan, found.best)
    )


def identified_case(plan: IdentificationPlan, best: Mapping[str, float]) -> str:
    """Text of the case of a plan with the values ``best`` (SI); empty of an evaluator of points, and for
    values that no file of the case can hold.
    """
    if plan.case is None:
        return ""
    try:
        case = vary(plan.case, {one: best[one.title] for one in plan.unknowns})
    except InputError:
        return ""
    tree = dict(tables_of(case).bare) | {"title": f"{plan.title}: identified"}
    return toml_text({key: one for key, one in tree.items() if key not in ("study", "description")})


def possible_point(computation: Computation, posterior: Posterior, seed: int) -> Array:
    """Values (SI) of a point that gives every measured number: the middle of the priors or one drawn
    from them. Raises :class:`InputError` where none of several does.
    """
    shares = np.random.default_rng(seed).random((TRIED, len(posterior.unknowns)))
    lacking = ""
    for work in np.vstack([posterior.centre, posterior.from_shares(shares)])[:, None, :]:
        (numbers,) = posterior.outcomes(work)
        given = tuple(key for key, value in (numbers or {}).items() if np.isfinite(value))
        missing = next((one.key for one in posterior.used if one.key not in given), None)
        if missing is None:
            return np.asarray(posterior.values(work)[0])
        if numbers is not None and not lacking:
            lacking = f"no point gives '{missing[:80]}'; {nearest(missing, given)}"
    if lacking:
        raise InputError(lacking, "measurements")
    outcomes = (computation.evaluate(posterior.middle.tolist(), task) for task in computation.tasks)
    why = next(
        (one.status.message for one in outcomes if not one.status.completed), "a number is missing"
    )
    raise InputError(
        f"none of {TRIED + 1} points of the priors can be computed, at their middle because: {why}"
    )


def _seconds(computation: Computation, values: Array) -> float:
    """Shortest time (s) of a point."""
    at = values.tolist()
    return min(
        timeit.repeat(
            lambda: [computation.evaluate(at, task) for task in computation.tasks],
            number=1,
            repeat=ROUNDS,
        )
    )


STEPS = IdentificationModel, read_identification, run_identification
