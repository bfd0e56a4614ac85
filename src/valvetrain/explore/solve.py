"""From a posterior and a search to the answer."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.draws import (
    Draws,
    Report,
    branches_of_peaks,
    even_draws,
    linear_draws,
    percentiles,
    silent,
)
from valvetrain.explore.fit import conflicts_of, fit_of, information_of, predictive, widenings
from valvetrain.explore.identification_file import Search
from valvetrain.explore.identified import (
    HIGH,
    LOW,
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
    least_squares,
    profile,
)
from valvetrain.explore.nested import nested
from valvetrain.explore.posterior import Evaluate, Posterior
from valvetrain.explore.store import Store
from valvetrain.runs.stopping import Stopped

Array = NDArray[np.float64]
#: Ends of keys whose numbers are never negative.
AMOUNT = re.compile(
    r"(amplitude_force|range|frequency|count|energy|impulse|duration|mass|stress)$|(^|_| )peak_\w*force$"
)
#: Quantile of the normal law at :data:`HIGH`.
_NORMAL = 1.959963984540054


def solve(
    posterior: Posterior,
    search: Search,
    journal: Store,
    *,
    start: Array,
    profiles: Sequence[str] = (),
    report: Report = silent,
    compare: Evaluate | None = None,
    units: Mapping[str, str] = MappingProxyType({}),
) -> Identified:
    """Search the posterior, find its branches, and report for each what the data determine.

    ``start`` (quantities): values (SI) to compare with, and to begin at where the search says so.
    ``compare``: computes what is not fitted, for ``search.draws`` of the draws. ``units``: those
    that computed quantities are shown in, by key. A stop in a search leaves what it had, one before
    that raises :class:`Stopped`.
    """
    began = time.perf_counter()
    if search.method == "nested":
        draws = nested(
            posterior,
            seed=search.seed,
            live_points=search.live_points,
            lanes=search.lanes,
            precision=search.precision,
            report=report,
        )
        peaks = [_peak_of_draws(posterior, draws, number) for number in range(len(draws.shares))]
        branches = [_sampled(posterior, draws, number, peak) for number, peak in enumerate(peaks)]
    else:
        peaks, shares, draws = _searched(posterior, search, start, report)
        branches = [
            _linear(posterior, peak, share) for peak, share in zip(peaks, shares, strict=True)
        ]
    every = (np.arange(len(draws.work)), draws.weights)
    columns = _columns(posterior, draws, peaks[0], start, posterior.evaluate, *every)
    if compare is not None and draws.whole:
        report(0.99, "what is compared only")
        places, counts = even_draws(draws.weights, search.draws, search.seed)
        columns |= _columns(posterior, draws, peaks[0], start, compare, places, counts)
    computed = {key: one.values for key, one in columns.items()}
    if draws.whole:
        for number, (branch, peak) in enumerate(zip(branches, peaks, strict=True)):
            fit = fit_of(posterior, peak.work, peak.outcome, peak.jacobian)
            if search.method == "nested":
                inside = draws.weights * (draws.labels == number)
                fit = replace(fit, predictive=predictive(posterior, computed, inside))
            branches[number] = _widened(posterior, replace(branch, fit=fit), peak)
    first = branches[0].fit
    widening = 1.0 if first is None else first.widening
    nothing = Column(math.nan, math.nan, np.full(len(draws.work), np.nan), draws.weights)
    predicted = []
    for one in posterior.data:
        column = columns.get(one.key, nothing)
        ends = column.ends(one.key, widening)
        percentile = one.percentile(column.values, column.weights)
        predicted.append(
            Predicted(one.key, one.unit, column.best, *ends, one, percentile, column.start)
        )
    measured = {one.key for one in posterior.data}
    likeliest = posterior.values(peaks[0].work[None, :])[0]
    return Identified(
        method=search.method,
        unknowns=posterior.unknowns,
        branches=tuple(branches),
        values=posterior.values(draws.work),
        weights=draws.weights,
        branch_of=draws.labels,
        predicted=tuple(predicted),
        predictions=tuple(
            Prediction(key, units.get(key, ""), column.best, *column.ends(key, widening))
            for key, column in columns.items()
            if key not in measured
        ),
        computed=computed,
        log_evidence=draws.log_evidence,
        profiles=tuple(profile(posterior, peaks[0], one) for one in profiles if draws.whole),
        note=draws.note,
        evaluations=journal.computed,
        reused=journal.before,
        whole=draws.whole,
        wall_time=time.perf_counter() - began,
        start=dict(zip(posterior.names, start.tolist(), strict=True)),
        conflicts=conflicts_of(
            posterior,
            (likeliest, peaks[0].outcome),
            journal.points(),
        ),
    )


@dataclass(frozen=True, eq=False)
class Column:
    """A computed number (SI; NaN where it was not computed): at the ``best`` point, at the
    ``start``, and its ``values`` over the draws with the ``weights`` of those that were computed.
    """

    best: float
    start: float
    values: Array
    weights: Array

    def ends(self, key: str, widening: float) -> tuple[float, float, float]:
        """2.5, 50 and 97.5 %, the ends ``widening`` times as far from the middle; of an amount
        never below zero.
        """
        low, middle, high = percentiles(self.values, self.weights, (LOW, 50.0, HIGH))
        wide = middle + widening * (low - middle)
        if AMOUNT.search(key) and low >= 0:
            wide = max(wide, 0.0)
        return wide, middle, middle + widening * (high - middle)


def _columns(
    posterior: Posterior,
    draws: Draws,
    peak: Peak,
    start: Array,
    evaluate: Evaluate,
    places: NDArray[np.int64],
    counts: NDArray[Any],
) -> dict[str, Column]:
    """What ``evaluate`` computes, by key: of the draws at ``places`` with their weights ``counts``."""
    points = posterior.values(np.vstack([peak.work, draws.work[places]]))
    best, *outcomes = evaluate(points)
    begun = evaluate(start[None, :])[0] if draws.whole else None
    weights = np.zeros(len(draws.work))
    weights[places] = counts
    found = {}
    for key in dict.fromkeys(key for one in outcomes if one is not None for key in one):
        values = np.full(len(draws.work), np.nan)
        values[places] = [(one or {}).get(key, math.nan) for one in outcomes]
        likeliest, early = ((one or {}).get(key, math.nan) for one in (best, begun))
        found[key] = Column(likeliest, early, values, weights)
    return found


def _searched(
    posterior: Posterior, search: Search, start: Array, report: Report
) -> tuple[list[Peak], list[float], Draws]:
    """The peak of each branch by least squares from several starts, its probability, and linearised
    draws.
    """
    begins = np.empty((0, len(posterior.unknowns)))
    if search.from_case:
        begins = posterior.work_of(start[None, :])
    if search.keep:
        begins = np.vstack(
            [begins, best_starts(posterior, search.starts, search.keep, search.seed)]
        )
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
            return [best], [1.0], Draws(best.work[None, :], np.ones(1), single, whole=False)
    peaks, shares, evidence = branches_of_peaks(posterior, peaks)
    draws = linear_draws(posterior, peaks, shares, search.draws, search.seed)
    return peaks, shares, replace(draws, log_evidence=evidence)


def _peak_of_draws(posterior: Posterior, draws: Draws, number: int) -> Peak:
    """Least squares from the likeliest draw of a branch, so that slopes are taken at its peak; the
    draw itself where the search was stopped.
    """
    inside = draws.work[draws.labels == number]
    begin = inside[np.argmax(posterior.log_posterior(inside))]
    if draws.whole:
        return least_squares(posterior, begin, iterations=4)
    misfit = float(np.sum(posterior.misses(begin[None, :]) ** 2))
    slopes = np.zeros((len(posterior.used), len(begin)))
    return Peak(begin, posterior.outcomes(begin[None, :])[0], misfit, slopes)


def _sampled(posterior: Posterior, draws: Draws, number: int, peak: Peak) -> Branch:
    """A branch by its draws."""
    here = draws.labels == number
    weights, inside = draws.weights[here], posterior.values(draws.work[here])
    mean = np.average(inside, axis=0, weights=weights)
    off = inside - mean
    deviation = np.sqrt(np.average(off**2, axis=0, weights=weights))
    scaled = off / np.where(deviation > 0, deviation, 1.0)
    best = posterior.values(peak.work[None, :])[0]
    quantities = {
        name: Interval(
            float(best[k]),
            float(mean[k]),
            float(deviation[k]),
            *percentiles(inside[:, k], weights, (LOW, HIGH)),
        )
        for k, name in enumerate(posterior.names)
    }
    correlation = (scaled * (weights / weights.sum())[:, None]).T @ scaled
    information = information_of(posterior, peak.jacobian)
    return Branch(float(weights.sum()), peak.misfit, quantities, correlation, information)


def _linear(posterior: Posterior, peak: Peak, share: float) -> Branch:
    """A branch by the normal posterior about its peak."""
    covariance = covariance_of(posterior, peak.jacobian)
    deviation = np.sqrt(np.diag(covariance))
    low, best, high = posterior.values(peak.work + np.outer((-_NORMAL, 0.0, _NORMAL), deviation))
    slope = np.where([one.prior.logarithmic for one in posterior.unknowns], best, 1.0)
    columns = np.array([best, best, slope * deviation, low, high]).T.tolist()
    quantities = {name: Interval(*row) for name, row in zip(posterior.names, columns, strict=True)}
    correlation = covariance / np.outer(deviation, deviation)
    information = information_of(posterior, peak.jacobian)
    return Branch(share, peak.misfit, quantities, correlation, information)


def _widened(posterior: Posterior, branch: Branch, peak: Peak) -> Branch:
    """The branch with the intervals that it has once the scatter of all data is as large as their
    misfit requires, no wider than the priors leave them.
    """
    if branch.fit is None or branch.fit.widening == 1.0:
        return branch
    factors = widenings(posterior, peak.jacobian, branch.fit.widening).tolist()
    quantities = {}
    for factor, one in zip(factors, posterior.unknowns, strict=True):
        interval = branch.quantities[one.name]
        low, best, high = one.prior.work(np.array([interval.low, interval.best, interval.high]))
        middle = min(max(best, low), high)
        ends = one.prior.value(middle + factor * (np.array([low, high]) - middle)).tolist()
        quantities[one.name] = replace(
            interval, deviation=factor * interval.deviation, low=ends[0], high=ends[1]
        )
    return replace(branch, quantities=quantities)
