"""From a posterior and a search to the answer."""

from __future__ import annotations

import math
import re
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from valvetrain.arrays import Array
from valvetrain.explore.draws import (
    Draws,
    branches_of_draws,
    branches_of_peaks,
    even_places,
    likeliest_of_clusters,
    linear_draws,
    nested,
)
from valvetrain.explore.execution import silent
from valvetrain.explore.identification_file import Search
from valvetrain.explore.identified import (
    SHARES,
    Branch,
    Identified,
    Interval,
    Predicted,
    Prediction,
)
from valvetrain.explore.least_squares import (
    Peak,
    best_starts,
    covariance_of,
    fit_of,
    information_of,
    least_squares,
)
from valvetrain.explore.posterior import Evaluate, Posterior
from valvetrain.explore.store import Store
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.workers import Progress

#: Ends of keys whose numbers are never negative.
AMOUNT = re.compile(
    r"(amplitude_force|range|frequency|count|energy|impulse|duration|mass|stress)$|(^|_| )peak_\w*force$"
)
#: Quantile of the normal law at the upper end of an interval.
_NORMAL = 1.959963984540054
#: Iterations of least squares that begin at the likeliest draw of a cluster.
ENDING = 4


def solve(
    posterior: Posterior,
    search: Search,
    store: Store,
    start: Array,
    report: Progress = silent,
    compare: Evaluate | None = None,
    units: Mapping[str, str] = MappingProxyType({}),
) -> Identified:
    """Search the posterior, find its branches, and report for each what the data determine.

    ``start`` (quantities): values (SI) to compare with, and to begin at where the search says so.
    ``compare``: computes what is not fitted, for ``search.draws`` of the draws. ``units``:
    those that computed quantities are shown in, by key. ``store``: counts the points. A stop in a search leaves
    what it had, one before that raises :class:`Stopped`.
    """
    began = time.perf_counter()
    sampled = search.method == "nested"
    if sampled:
        peaks, shares, draws = _sampled(posterior, search, report)
    else:
        peaks, shares, draws = _searched(posterior, search, start, report)
    values = posterior.values(draws.work)
    branches = tuple(
        _branch(posterior, peak, share, draws.whole, values[draws.labels == number] if sampled else None)
        for number, (peak, share) in enumerate(zip(peaks, shares, strict=True))
    )  # fmt: skip
    points = np.vstack([posterior.values(peaks[0].work[None, :]), start, values])
    columns = defaultdict[str, Array](lambda: np.full(len(points), np.nan))

    def compute(evaluate: Evaluate, rows: Sequence[int]) -> None:
        for row, numbers in zip(rows, evaluate(points[rows]), strict=True):
            for key, value in (numbers or {}).items():
                columns[key][row] = value

    compute(posterior.evaluate, [k for k in range(len(points)) if draws.whole or k != 1])
    if compare is not None and draws.whole:
        report(0.99, "what is compared only")
        chosen = even_places(len(values), min(search.draws, len(values)), search.seed)
        compute(compare, [0, 1, *(2 + chosen).tolist()])
    fit, measured = branches[0].fit, {one.key: one for one in posterior.data}
    predicted, predictions = list[Predicted](), list[Prediction]()
    for key in dict.fromkeys([*measured, *columns]):
        best, begun, *_ = columns[key].tolist()
        of_draws, datum = columns[key][2:], measured.get(key)
        ends = (best, *_interval(key, of_draws, fit.widening if fit is not None else 1.0))
        if datum is None:
            predictions.append(Prediction(key, units.get(key, ""), *ends))
        else:
            percentile = datum.percentile(of_draws)
            predicted.append(Predicted(key, datum.unit, *ends, datum, percentile, begun))
    return Identified(
        method=search.method,
        unknowns=tuple(posterior.unknowns),
        branches=branches,
        values=values,
        branch_of=draws.labels,
        predicted=tuple(predicted),
        predictions=tuple(predictions),
        computed={key: column[2:] for key, column in columns.items()},
        log_evidence=draws.log_evidence,
        note=draws.note,
        evaluations=store.computed,
        reused=store.before,
        whole=draws.whole,
        wall_time=time.perf_counter() - began,
        start=dict(zip(posterior.names, start.tolist(), strict=True)),
    )


def _interval(key: str, values: Array, widening: float) -> tuple[float, float, float]:
    """2.5, 50 and 97.5 % of the finite ``values``, the ends ``widening`` times as far from the middle; of an amount never
    below zero.
    """
    values = values[np.isfinite(values)]
    if not len(values):
        return math.nan, math.nan, math.nan
    low, middle, high = np.quantile(values, SHARES, method="hazen").tolist()
    wide = middle + widening * (low - middle)
    wide = max(wide, 0.0) if AMOUNT.search(key) and low >= 0 else wide
    return wide, middle, middle + widening * (high - middle)


def _searched(
    posterior: Posterior, search: Search, start: Array, report: Progress
) -> tuple[list[Peak], list[float], Draws]:
    """The peak of each branch by least squares from several starts, its probability, and linearised
    draws.
    """
    begins = posterior.work_of(start[None, :])[: int(search.from_case)]
    if search.keep:
        starts = best_starts(posterior, search.starts, search.keep, search.seed)
        begins = np.vstack([begins, starts])
    peaks: list[Peak] = []
    iterations, step = search.iterations, search.difference_step
    for number, one in enumerate(begins):

        def reported(text: str, number: int = number) -> None:
            report(number / len(begins), f"start {number + 1} of {len(begins)}, {text}")

        try:
            peaks.append(
                least_squares(posterior, one, iterations=iterations, step=step, report=reported)
            )
        except Stopped:
            if not peaks:
                raise
            best = min(peaks, key=lambda one: one.misfit)
            single = np.zeros(1, dtype=np.int64)
            return [best], [1.0], Draws(best.work[None, :], single, whole=False)
    peaks, shares, evidence = branches_of_peaks(posterior, peaks)
    draws = linear_draws(posterior, peaks, shares, search.draws, search.seed)
    return peaks, shares, replace(draws, log_evidence=evidence)


def _sampled(
    posterior: Posterior, search: Search, report: Progress
) -> tuple[list[Peak], list[float], Draws]:
    """Draws by nested sampling, with the peak of each branch by least squares from the likeliest draws of their clusters, and
    its probability; the likeliest draw where the search was stopped.
    """
    draws = nested(posterior, search, report)
    if draws.whole:
        begins = likeliest_of_clusters(posterior, draws.work, search.seed)
        ends = [least_squares(posterior, one, iterations=ENDING) for one in begins]
        peaks, _, _ = branches_of_peaks(posterior, ends)
        peaks, shares, labels = branches_of_draws(posterior, peaks, draws.work)
        return peaks, shares, replace(draws, labels=labels)
    best = draws.work[[np.argmax(posterior.log_posterior(draws.work))]]
    misfit = float(np.sum(posterior.misses(best) ** 2))
    slopes = np.zeros((len(posterior.used), len(best[0])))
    return [Peak(best[0], posterior.outcomes(best)[0], misfit, slopes)], [1.0], draws


def _branch(
    posterior: Posterior, peak: Peak, share: float, whole: bool, values: Array | None
) -> Branch:
    """A branch by ``values`` (n, quantities; SI) of its draws, or by the normal posterior about its peak where there are none.
    Its intervals are those once the scatter of all data is as large as their misfit requires, no wider than the priors leave.
    """
    fit = fit_of(posterior, peak) if whole else None
    best = posterior.values(peak.work[None, :])[0]
    if values is None:
        covariance = covariance_of(posterior, peak.jacobian)
        away = np.sqrt(np.diag(covariance))
        low, mean, high = posterior.values(peak.work + np.outer((-_NORMAL, 0.0, _NORMAL), away))
        logarithmic = [one.prior.logarithmic for one in posterior.unknowns]
        deviation = np.where(logarithmic, best, 1.0) * away
        correlation = covariance / np.outer(away, away)
    else:
        mean, deviation = np.mean(values, axis=0), np.std(values, axis=0)
        scaled = (values - mean) / np.where(deviation > 0, deviation, 1.0)
        correlation = scaled.T @ scaled / len(values)
        low, _, high = np.quantile(values, SHARES, axis=0, method="hazen")
    wider = np.ones(len(best))
    if fit is not None and fit.missed:
        wide, narrow = (
            np.diag(posterior.remaining(peak.jacobian, one)) for one in (fit.widening, 1.0)
        )
        wider = np.sqrt(wide / narrow)
        places = posterior.each("work", np.array([low, best, high]))
        middle = np.clip(places[1], places[0], places[2])
        low, high = posterior.values(middle + wider * (places[[0, 2]] - middle))
    rows = np.array([best, mean, wider * deviation, low, high]).T.tolist()
    quantities = {name: Interval(*row) for name, row in zip(posterior.names, rows, strict=True)}
    information = information_of(posterior, peak.jacobian)
    return Branch(share, peak.misfit, quantities, correlation, information, fit)
