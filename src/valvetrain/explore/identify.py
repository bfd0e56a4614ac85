"""``valvetrain.identify`` and the calibration of an experiment: from a file, or of a computation of
one's own.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError, RunFailedError
from valvetrain.explore.case_paths import nominal, vary
from valvetrain.explore.draws import Report, silent
from valvetrain.explore.engine import Computation, Engine, Evaluation, Place
from valvetrain.explore.identification_file import Request, Search, evaluator_of, read_request
from valvetrain.explore.identified import Identified
from valvetrain.explore.observe import IMPOSSIBLE, Observed
from valvetrain.explore.outputs import Outcome
from valvetrain.explore.posterior import Datum, Evaluate, Numbers, Posterior, Unknown
from valvetrain.explore.solve import solve
from valvetrain.explore.space import Prior, Varied
from valvetrain.explore.store import versions_digest
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.toml_text import toml_text
from valvetrain.runs.cluster import on_cluster
from valvetrain.runs.cost import Cost, Limits, cost_text, limits_of, refuse_cost
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.workers import LOST, LOST_REMEDY, worker_count

Array = NDArray[np.float64]
#: Points of the priors that are tried until one can be computed; bytes of a stored point and
#: of each of its numbers.
TRIED, POINT_BYTES, NUMBER_BYTES = 40, 1000.0, 150.0
#: Times a point is timed, for the first may wait for kernels; points that a computation of one's own gets at once, at most.
ROUNDS, TOGETHER = 3, 1_000_000
#: Called with the estimated cost as text and in seconds before the start.
TellCost = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class OwnPoints(Computation):
    """Points that a ``function`` of one's own computes, many at a time; ``identity``: what they are stored by."""

    function: Evaluate
    identity: str

    @property
    def subject(self) -> str:
        """What the points are stored by."""
        return self.identity

    def evaluate(self, values: Iterable[float], run: Any) -> Outcome:
        """The outcome of one point."""
        return self.outcomes([(tuple(values), run)])[0]

    def outcomes(self, places: Sequence[Place]) -> list[Outcome]:
        """The outcomes of a batch."""
        numbers = self.function(np.array([values for values, _ in places]))
        return [Outcome(IMPOSSIBLE) if one is None else Outcome(values=one) for one in numbers]


@dataclass(frozen=True, eq=False)
class PackagePoints(Computation):
    """Points of a request that the evaluator of a package computes."""

    request: Request

    @property
    def subject(self) -> list[str]:
        """The request, and the versions."""
        return [self.request.identity, versions_digest()]

    def evaluate(self, values: Iterable[float], run: Any) -> Outcome:
        """The outcome of one point."""
        names = tuple(one.name for one in self.request.unknowns)
        compute = evaluator_of(self.request.evaluator).points(names, dict(self.request.options))
        numbers = compute(tuple(map(float, values)))
        return Outcome(IMPOSSIBLE) if numbers is None else Outcome(values=numbers)


@shows_progress("identify")
def identify(
    quantities: Mapping[str, Prior] | str | os.PathLike[str],
    measurements: Sequence[Datum] = (),
    evaluate: Evaluate | None = None,
    *,
    search: Search = Search(),
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
    place, report = None if folder is None else Path(folder), progress or silent
    if isinstance(quantities, Mapping):
        if evaluate is None:
            raise InputError(
                "a computation is missing; give evaluate, or the path of an identification file"
            )
        unknowns = tuple(Unknown(name, prior) for name, prior in quantities.items())
        points = OwnPoints(evaluate, repr((unknowns, tuple(measurements))))
        with Engine((points,), 1, place, TOGETHER) as engine:
            posterior = Posterior(unknowns, tuple(measurements), numbers_by(engine, points))
            return solve(posterior, search, engine.store, report=report)
    request = read_request(quantities)
    if search != Search():
        request = replace(request, search=search)
    return identify_request(
        request,
        folder=place,
        workers=workers,
        report=report,
        limits=limits_of(limit),
        option="limit=",
    )


def numbers_by(engine: Engine, computation: Computation) -> Evaluate:
    """What gives the numbers of points by the key of each output: those of all runs, None where one did not complete.

    It raises :class:`RunFailedError` where a point is lost with its worker.
    """
    runs = computation.runs

    def numbers_of_point(outcomes: Sequence[Outcome]) -> Numbers:
        if not all(one.status.completed for one in outcomes):
            return None
        return {
            computation.key_of_output(name, run): value
            for run, one in zip(runs, outcomes, strict=True)
            for name, value in one.values.items()
        }

    def evaluate(points: Array) -> list[Numbers]:
        rows = [tuple(row) for row in np.asarray(points, dtype=float).tolist()]
        outcomes = engine.outcomes([(computation, row, run) for row in rows for run in runs])
        if any(one.status.code == "worker-lost" for one in outcomes):
            raise RunFailedError(f"a point is lost: {LOST}; {LOST_REMEDY}")
        count = len(runs)
        return [numbers_of_point(outcomes[count * k : count * (k + 1)]) for k in range(len(rows))]

    return evaluate


@shows_progress("identify")
def calibrate(
    experiment: Evaluation,
    measurements: tuple[Datum, ...],
    search: Search | None,
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
    space = experiment.space
    if space.correlation is not None:
        raise InputError("the priors of a calibration are independent; leave it out", "correlation")
    unknowns = tuple(Unknown(one.name, _prior_of(one), one.unit) for one in space)
    place = None if output is None else Path(output)
    with on_cluster(dask, workers) as count:
        return _identified(
            Sought(unknowns, measurements, experiment), search or Search(), place, count, progress or silent, limits_of(limit), "limit=",
        )  # fmt: skip


def _prior_of(one: Varied) -> Prior:
    if not isinstance(one.distribution, Prior):
        raise InputError("is a list of values, which is no prior; give a distribution", one.name)
    return one.distribution


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
    fitted, compared = computations_of(request)
    start = None
    try:
        start = np.array(values_of_case(request))
    except InputError:  # it has no single ones
        if request.search.from_case:
            raise
    units = {one.key: one.unit for one in request.targets}
    sought = Sought(request.unknowns, request.data, fitted, compared, start, units)
    result = _identified(
        sought, request.search, folder, worker_count(workers), report, limits, option, tell
    )
    result = replace(result, text=request.text, name=request.title)
    return replace(result, case_file=identified_case(request, result.best))


@dataclass(frozen=True, eq=False)
class Sought:
    """What is identified: ``unknowns``, ``data``, what computes points of both and, for the draws alone, what is
    ``compared``; values ``start`` (SI) of the case, and ``units`` of computed numbers.
    """

    unknowns: tuple[Unknown, ...]
    data: tuple[Datum, ...]
    fitted: Computation
    compared: Computation | None = None
    start: Array | None = None
    units: Mapping[str, str] = field(default_factory=dict)


def _identified(
    sought: Sought,
    search: Search,
    folder: Path | None,
    workers: int,
    report: Report,
    limits: Limits,
    option: str,
    tell: TellCost = lambda phrase, seconds: None,
) -> Identified:
    """The answer of a search whose cost, by the time of one point, is within the limits."""
    fitted, compared = sought.fitted, sought.compared
    with Engine((fitted, *filter(None, [compared])), workers, folder) as engine:
        posterior = Posterior(sought.unknowns, sought.data, numbers_by(engine, fitted))
        seconds = _seconds(fitted, possible_point(fitted, posterior, search.seed))
        points = search.evaluations_of(len(sought.unknowns))
        left = max(points - engine.store.before // len(fitted.runs), 0)
        total = left * seconds
        if compared is not None:
            total += (search.draws + 2) * _seconds(compared, posterior.middle)
        size = points * (POINT_BYTES + NUMBER_BYTES * len(sought.data))
        cost = Cost(total / workers, size)
        refuse_cost(cost, limits, option)
        phrase = cost_text(cost)
        tell(f"{phrase} ({left} points of {1e3 * seconds:.3g} ms)", total / workers)
        others = None if compared is None else numbers_by(engine, compared)
        return solve(
            posterior, search, engine.store, start=sought.start, report=report, compare=others, units=sought.units
        )  # fmt: skip


def computations_of(request: Request) -> tuple[Computation, Computation | None]:
    """What computes the points of a request: its case under the conditions of its measurements, or
    the evaluator it names; and what computes it under conditions of which nothing is fitted, for
    the draws alone (None where there are none).
    """
    if request.evaluator:
        return PackagePoints(request), None
    first, later = (Observed(request.case, request.varied, part) for part in request.parts)
    return first, later if later.targets else None


def identified_case(request: Request, best: Mapping[str, float]) -> str:
    """Text of the case of a request with the values ``best`` (SI); empty of an evaluator of points, and for
    values that no file of the case can hold.
    """
    pairs = zip(request.unknowns, request.varied, strict=not request.evaluator)
    values = {one: best[unknown.name] for unknown, row in pairs for one in row}
    try:
        case = None if request.evaluator else vary(request.case, values)
    except InputError:
        case = None
    if case is None:
        return ""
    tree = dict(tables_of(case).bare) | {"title": f"{request.title}: identified"}
    for key in ("study", "description"):
        tree.pop(key, None)
    return toml_text(tree)


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


def possible_point(computation: Computation, posterior: Posterior, seed: int) -> Array:
    """Values (SI) of a point that gives every measured number: the middle of the priors or one drawn
    from them. Raises :class:`InputError` where none of several does.
    """
    shares = np.random.default_rng(seed).random((TRIED, len(posterior.unknowns)))
    lacking = ""
    for work in np.vstack([posterior.centre, posterior.from_shares(shares)])[:, None, :]:
        (numbers,) = posterior.outcomes(work)
        if numbers is None:
            continue
        given = tuple(key for key, value in numbers.items() if np.isfinite(value))
        missing = next((one.key for one in posterior.used if one.key not in given), None)
        if missing is None:
            return np.asarray(posterior.values(work)[0])
        lacking = lacking or f"no point gives '{missing[:80]}'; {nearest(missing, given)}"
    if lacking:
        raise InputError(lacking, "measurements")
    outcomes = (computation.evaluate(posterior.middle.tolist(), run) for run in computation.runs)
    why = next(
        (one.status.message for one in outcomes if not one.status.completed), "a number is missing"
    )
    raise InputError(
        f"none of {TRIED + 1} points of the priors can be computed, at their middle because: {why}"
    )


def _seconds(computation: Computation, values: Array) -> float:
    """Shortest time (s) of a point."""
    times = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        for run in computation.runs:
            computation.evaluate(values.tolist(), run)
        times.append(time.perf_counter() - begun)
    return min(times)
