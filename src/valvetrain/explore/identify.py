"""``valvetrain.identify`` and the calibration of an experiment: from a file, or of a computation of
one's own.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError, RunFailedError
from valvetrain.explore.case_paths import nominal, vary
from valvetrain.explore.draws import Report, silent
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.identification_file import Request, Search, evaluator_of, read_request
from valvetrain.explore.identified import Identified
from valvetrain.explore.observe import CaseEvaluator, Observed, numbers_of, observe
from valvetrain.explore.outputs import Outcome as PointOutcome
from valvetrain.explore.posterior import Datum, Evaluate, Outcome, Posterior, Unknown
from valvetrain.explore.solve import solve
from valvetrain.explore.space import Prior, Varied
from valvetrain.explore.store import Store, versions_digest
from valvetrain.explore.study import seconds_of
from valvetrain.parameters.case import Case
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.toml_text import toml_text
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost, Limits, limits_of, refuse_cost
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.watch import shows_progress
from valvetrain.runs.workers import LOST, LOST_REMEDY, StandingPool, worker_count

Array = NDArray[np.float64]
#: Points of the priors that are tried until one can be computed; bytes of a stored point and
#: of each of its numbers.
TRIED, POINT_BYTES, NUMBER_BYTES = 40, 1000.0, 150.0
#: Work (s of each worker) that a kill may cost at most.
LOST_SECONDS = 5.0
#: Times a point is timed, for the first may wait for kernels.
ROUNDS = 3
#: Called with the estimated cost as text and in seconds before the start.
TellCost = Callable[[str, float], None]


@shows_progress("identify")
def identify(
    quantities: Mapping[str, Prior] | str | os.PathLike[str],
    measurements: Sequence[Datum] = (),
    evaluate: Evaluate | None = None,
    *,
    search: Search = Search(),
    profiles: Sequence[str] = (),
    folder: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    progress: Report | None = None,
    limit: str = "",
) -> Identified:
    """Quantities that meet measurements, with their prior: their most probable
    values, intervals and branches.

    Parameters
    ----------
    quantities : path of an identification file (docs/identification.md), which says all the rest;
        or the prior of each quantity by name
    measurements : data of a computation of one's own
    evaluate : points (n, quantities) in SI -> for each a mapping of names to numbers (SI), None for
        one that is impossible
    search : method and its options; those of the file by default
    profiles : quantities whose profile is computed
    folder : store of the computed points, where an identification that is started again
        continues; none by default
    workers : points at a time of a file's case; results do not depend on it
    progress : called with the share done and a text
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default, of a
        file alone

    Returns
    -------
    Identified: branches, intervals, correlations, what the data determine, and the percentile of
    each measurement in its prediction

    Raises
    ------
    InputError : one sentence on what is wrong with the file or the data, cannot be computed or is
        too large; MissingExtraError where the
        library of a method is not installed; RunFailedError where a point is lost with its worker

    Examples
    --------
    >>> import valvetrain as vt
    >>> def surge(points):
    ...     return [{"load": 7e-3 * rate, "surge": 0.5 * (rate / mass) ** 0.5} for rate, mass in points]
    >>> priors = {"rate": vt.explore.Prior("uniform", 20e3, 60e3), "mass": vt.explore.Prior("normal", centre=0.05, spread=0.01)}
    >>> found = vt.identify(priors, [vt.explore.Datum("load", 280.0, 2.0), vt.explore.Datum("surge", 447.0, 3.0)], surge)
    >>> print(f"{found.best['rate']:.0f} N/m, {1e3 * found.best['mass']:.1f} g")
    40000 N/m, 50.0 g
    """
    place = None if folder is None else Path(folder)
    if isinstance(quantities, Mapping):
        if evaluate is None:
            raise InputError(
                "a computation is missing; give evaluate, or the path of an identification file"
            )
        unknowns = tuple(Unknown(name, prior) for name, prior in quantities.items())
        with Store(place, repr((unknowns, tuple(measurements)))) as journal:
            posterior = Posterior(unknowns, tuple(measurements), journal.through(evaluate))
            return solve(
                posterior,
                search,
                journal,
                start=middle_of(posterior),
                profiles=tuple(profiles),
                report=progress or silent,
            )
    request = read_request(quantities)
    if search != Search():
        request = replace(request, search=search)
    return identify_request(
        replace(request, profiles=tuple(profiles) or request.profiles),
        folder=place,
        workers=workers,
        report=progress or silent,
        limits=limits_of(limit),
        option="limit=",
    )


@shows_progress("identify")
def calibrate(
    experiment: Evaluation,
    measurements: tuple[Datum, ...],
    search: Search | None,
    profiles: tuple[str, ...],
    *,
    workers: int | None = None,
    dask: str = "",
    output: str | os.PathLike[str] | None = None,
    limit: str = "",
    progress: Report | None = None,
) -> Identified:
    """The quantities of an experiment that agree with measurements; see
    :meth:`valvetrain.Experiment.calibrate`.
    """
    search, space, runs = search or Search(), experiment.space, experiment.runs
    names = experiment.outputs.quantities
    known = [experiment.key_of_output(name, run) for run in runs for name in names]
    for one in measurements:
        if one.key not in known:
            raise InputError(
                f"no output is called '{one.key[:80]}'; {nearest(one.key, tuple(known))}"
            )
    unknowns = tuple(Unknown(one.name, _prior_of(one), one.unit) for one in space)
    points = search.evaluations_of(len(unknowns), len(profiles))
    seconds = points * sum(seconds_of(experiment, run) for run in runs)
    with on_cluster(dask, workers) as count:
        cost = Cost(seconds / count, points * (POINT_BYTES + NUMBER_BYTES * len(known)))
        refuse_cost(cost, limits_of(limit), "limit=")
        folder = None if output is None else Path(output)
        with Engine((experiment,), count, folder) as engine, Store(None) as seen:

            def evaluate(points: Array) -> list[Outcome]:
                request = [
                    (experiment, tuple(row), run)
                    for row in np.asarray(points).tolist()
                    for run in runs
                ]
                outcomes = engine.outcomes(request)
                if any(one.status.code == "worker-lost" for one in outcomes):
                    raise RunFailedError(f"a point is lost: {LOST}; {LOST_REMEDY}")
                return [
                    _together(experiment, outcomes[first : first + len(runs)])
                    for first in range(0, len(outcomes), len(runs))
                ]

            correlation = None if space.correlation is None else np.array(space.correlation)
            posterior = Posterior(unknowns, measurements, seen.through(evaluate), correlation)
            before = engine.store.before
            try:
                found = solve(
                    posterior,
                    search,
                    seen,
                    start=middle_of(posterior),
                    profiles=profiles,
                    report=progress or silent,
                )
            except InputError as error:
                point = posterior.values(posterior.centre[None, :])[0].tolist()
                (middle,) = engine.outcomes([(experiment, tuple(point), runs[0])])
                if middle.status.completed:
                    raise
                raise InputError(
                    f"{error.reason}; at their middle: {middle.status.message}"
                ) from error
            return replace(found, evaluations=engine.computed, reused=before)


def _prior_of(one: Varied) -> Prior:
    if not isinstance(one.distribution, Prior):
        raise InputError("is a list of values, which is no prior; give a distribution", one.name)
    return one.distribution


def _together(experiment: Evaluation, outcomes: Sequence[PointOutcome]) -> Outcome:
    """The numbers of all runs of a point by their keys; None where one did not complete."""
    if not all(one.status.completed for one in outcomes):
        return None
    return {
        experiment.key_of_output(name, run): value
        for run, one in zip(experiment.runs, outcomes, strict=True)
        for name, value in one.values.items()
    }


def identify_request(
    request: Request,
    *,
    folder: Path | None = None,
    workers: int | None = None,
    report: Report = silent,
    limits: Limits = Limits(),
    option: str = "--limit ",
    tell: TellCost = lambda phrase, seconds: None,
) -> Identified:
    """The identification of a file; arguments as :func:`identify`, ``tell`` is called with the estimated
    cost.

    Raises :class:`InputError` where the estimate is beyond ``limits`` (the message names
    ``option``) and where nothing can be computed.
    """
    count = worker_count(workers)
    search = request.search
    with (
        Store(folder, f"{request.identity} {versions_digest()}") as journal,
        evaluators_of(request, count) as (evaluate, compare),
    ):
        posterior = Posterior(
            request.unknowns, request.data, journal.through(evaluate), request.correlation
        )
        start = middle_of(posterior)
        try:
            start = np.array(values_of_case(request))
        except InputError:  # it has no single ones
            if search.from_case:
                raise
        seconds = _seconds(evaluate, possible_point(request, posterior))
        journal.at_a_time = count * max(1, round(LOST_SECONDS / max(seconds, 1e-6)))
        points = search.evaluations_of(len(request.unknowns), len(request.profiles))
        left = max(points - len(journal), 0)
        total = left * seconds
        if compare is not None:
            total += (search.draws + 2) * _seconds(compare, middle_of(posterior))
        size = points * (POINT_BYTES + NUMBER_BYTES * len(request.targets))
        phrase = refuse_cost(Cost(total / count, size), limits, option)
        tell(f"{phrase} ({left} points of {1e3 * seconds:.3g} ms)", total / count)
        found = solve(
            posterior,
            search,
            journal,
            start=start,
            profiles=request.profiles,
            report=report,
            compare=None if compare is None else journal.through(compare, b"compared"),
            units={one.key: one.unit for one in request.targets},
        )
    found = replace(found, text=request.text, name=request.title)
    case = identified_case(request, found.best)
    if case is None:
        return found
    tree = dict(tables_of(case).bare) | {"title": f"{request.title}: identified"}
    for key in ("study", "description"):
        tree.pop(key, None)
    return replace(found, case_file=toml_text(tree))


def identified_case(request: Request, best: Mapping[str, float]) -> Case | None:
    """The case of a request with the values ``best`` (SI); None of an evaluator of points, and for values
    that no file of the case can hold.
    """
    if request.evaluator:
        return None
    pairs = zip(request.unknowns, request.varied, strict=True)
    try:
        return vary(
            request.case, {one: best[unknown.name] for unknown, row in pairs for one in row}
        )
    except InputError:
        return None


def middle_of(posterior: Posterior) -> Array:
    """The middles of the priors (SI)."""
    middle: Array = posterior.values(posterior.centre[None, :])[0]
    return middle


@contextmanager
def evaluators_of(request: Request, workers: int) -> Iterator[tuple[Evaluate, Evaluate | None]]:
    """What computes the points of a request: its case under the conditions of its measurements, or
    the evaluator it names; and what computes it under conditions of which nothing is fitted, for
    the draws alone (None where there are none).
    """
    if request.evaluator:
        names = tuple(one.name for one in request.unknowns)
        own = evaluator_of(request.evaluator).points(names, dict(request.options))
        with StandingPool(_own_point, own, workers) as pool:
            yield lambda points: pool.map([tuple(map(float, point)) for point in points]), None
        return
    first, later = request.parts
    every = tuple(Observed(request.case, request.varied, targets) for targets in (first, later))
    with StandingPool(observe, every, workers) as pool:
        yield CaseEvaluator(pool, 0), CaseEvaluator(pool, 1) if later else None


def _own_point(evaluate: Callable[[Sequence[float]], Outcome], point: Sequence[float]) -> Outcome:
    return evaluate(point)


def values_of_case(request: Request) -> tuple[float, ...]:
    """The values (SI) that the case itself holds of the quantities; a factor is one, an offset
    zero. Raises :class:`InputError` for one that cannot be read from it.
    """
    if request.evaluator:
        names = tuple(one.name for one in request.unknowns)
        return tuple(evaluator_of(request.evaluator).values(names))
    try:
        return tuple(nominal(request.case, row[0]) for row in request.varied)
    except InputError as error:
        raise InputError(f"{error.where} {error.reason}", "search.from_case") from None


def possible_point(request: Request, posterior: Posterior) -> Array:
    """Values (SI) of a point that gives every measured number: the middle of the priors or one drawn
    from them. Raises :class:`InputError` where none of several does.
    """
    random = np.random.default_rng(request.search.seed)
    drawn = posterior.from_shares(random.random((TRIED, len(posterior.unknowns))))
    lacking = ""
    for work in np.vstack([posterior.centre, drawn])[:, None, :]:
        (outcome,) = posterior.outcomes(work)
        if outcome is None:
            continue
        known = tuple(key for key, value in outcome.items() if np.isfinite(value))
        missing = next((one.key for one in posterior.used if one.key not in known), None)
        if missing is None:
            return np.asarray(posterior.values(work)[0])
        lacking = lacking or f"no point gives '{missing[:80]}'; {nearest(missing, known)}"
    if lacking:
        raise InputError(lacking, "measurements")
    reason = "; narrow the priors to what is possible"
    if not request.evaluator:
        observed = Observed(request.case, request.varied, request.targets)
        try:
            case = observed.case_at(middle_of(posterior).tolist())
            numbers_of(case, observed.stations, observed.targets)
        except FAILURES as error:
            reason = f", at their middle because: {error}"
    raise InputError(f"none of {TRIED + 1} points of the priors can be computed{reason}")


def _seconds(evaluate: Evaluate, values: Array) -> float:
    """Shortest time (s) of a point."""
    times = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        evaluate(values[None, :])
        times.append(time.perf_counter() - begun)
    return min(times)
