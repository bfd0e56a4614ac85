"""From a posterior and a search to the answer."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.draws import (
    Draws,
    branches_of_peaks,
    even_draws,
    linear_draws,
    nested,
    percentiles,
)
from valvetrain.explore.execution import silent
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
    Fit,
    Peak,
    best_starts,
    covariance_of,
    fit_of,
    information_of,
    least_squares,
    widenings,
)
from valvetrain.explore.posterior import Evaluate, Posterior
from valvetrain.explore.space import Array
from valvetrain.explore.store import Store
from valvetrain.runs.stopping import Stopped
from valvetrain.runs.workers import Progress

#: Ends of keys whose numbers are never negative.
AMOUNT = re.compile(
    r"(amplitude_force|range|frequency|count|energy|impulse|duration|mass|stress)$|(^|_| )peak_\w*force$"
)
#: Quantile of the normal law at :data:`HIGH`.
_NORMAL = 1.959963984540054


def solve(
    posterior: Posterior,
    search: Search,
    store: Store,
    *,
    start: Array | None = None,
    report: Progress = silent,
    compare: Evaluate | None = None,
    units: Mapping[str, str] = MappingProxyType({}),
) -> Identified:
    """Search the posterior, find its branches, and report for each what the data determine.

    ``start`` (quantities): values (SI) to compare with, and to begin at where the search says so; the middles of
    the priors by default. ``compare``: computes what is not fitted, for ``search.draws`` of the draws. ``units``:
    those that computed quantities are shown in, by key. ``store``: counts the points. A stop in a search leaves
    what it had, one before that raises :class:`Stopped`.
    """
    began = time.perf_counter()
    start = posterior.middle if start is None else start
    if search.method == "nested":
        draws = nested(posterior, search, report)
        peaks = [_peak_of_draws(posterior, draws, number) for number in range(len(draws.shares))]
        shares = draws.shares
    else:
        peaks, shares, draws = _searched(posterior, search, start, report)
    every = (np.arange(len(draws.work)), draws.weights)
    columns = _columns(posterior, draws, peaks[0], start, posterior.evaluate, *every)
    if compare is not None and draws.whole:
        report(0.99, "what is compared only")
        chosen = even_draws(draws.weights, search.draws, search.seed)
        columns |= _columns(posterior, draws, peaks[0], start, compare, *chosen)
    computed = {key: one.values for key, one in columns.items()}
    branches = []
    for number, (peak, share) in enumerate(zip(peaks, shares, strict=True)):
        fit, inside = None, draws.weights * (draws.labels == number)
        if draws.whole:
            fit = fit_of(posterior, peak.work, peak.outcome, peak.jacobian)
        of_draws = (draws, inside) if search.method == "nested" else None
        branches.append(_branch(posterior, peak, share, fit, of_draws))
    widening = 1.0 if branches[0].fit is None else branches[0].fit.widening
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
        note=draws.note,
        evaluations=store.computed,
        reused=store.before,
        whole=draws.whole,
        wall_time=time.perf_counter() - began,
        start=dict(zip(posterior.names, start.tolist(), strict=True)),
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
    columns = {}
    for key in dict.fromkeys(key for one in outcomes if one is not None for key in one):
        values = np.full(len(draws.work), np.nan)
        values[places] = [(one or {}).get(key, math.nan) for one in outcomes]
        likeliest, early = ((one or {}).get(key, math.nan) for one in (best, begun))
        columns[key] = Column(likeliest, early, values, weights)
    return columns


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


def _branch(
    posterior: Posterior,
    peak: Peak,
    share: float,
    fit: Fit | None,
    of_draws: tuple[Draws, Array] | None,
) -> Branch:
    """A branch by its draws and their weights, or by the normal posterior about its peak where there are none. Its
    intervals are those once the scatter of all data is as large as their misfit requires, no wider than the priors leave.
    """
    best = posterior.values(peak.work[None, :])[0]
    if of_draws is None:
        covariance = covariance_of(posterior, peak.jacobian)
        away = np.sqrt(np.diag(covariance))
        low, mean, high = posterior.values(peak.work + np.outer((-_NORMAL, 0.0, _NORMAL), away))
        logarithmic = [one.prior.logarithmic for one in posterior.unknowns]
        deviation = np.where(logarithmic, best, 1.0) * away
        correlation = covariance / np.outer(away, away)
    else:
        here = of_draws[1] > 0
        weights, inside = of_draws[1][here], posterior.values(of_draws[0].work[here])
        mean = np.average(inside, axis=0, weights=weights)
        deviation = np.sqrt(np.average((inside - mean) ** 2, axis=0, weights=weights))
        scaled = (inside - mean) / np.where(deviation > 0, deviation, 1.0)
        correlation = (scaled * (weights / weights.sum())[:, None]).T @ scaled
        low, high = np.array([percentiles(one, weights, (LOW, HIGH)) for one in inside.T]).T
    wider = np.ones(len(best))
    if fit is not None and fit.widening != 1.0:
        wider = widenings(posterior, peak.jacobian, fit.widening)
        places = posterior.each("work", np.array([low, best, high]))
        middle = np.clip(places[1], places[0], places[2])
        low, high = posterior.values(middle + wider * (places[[0, 2]] - middle))
    rows = np.array([best, mean, wider * deviation, low, high]).T.tolist()
    quantities = {name: Interval(*row) for name, row in zip(posterior.names, rows, strict=True)}
    information = information_of(posterior, peak.jacobian)
    return Branch(share, peak.misfit, quantities, correlation, information, fit)
