"""From a posterior and a search to the answer."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.draws import (
    Draws,
    Report,
    branches_of_draws,
    even_draws,
    information_of,
    silent,
)
from valvetrain.explore.fit import fit_of, predictive, widenings
from valvetrain.explore.identification_file import Search
from valvetrain.explore.identified import (
    HIGH,
    LOW,
    Branch,
    Conflict,
    Identified,
    Interval,
    Predicted,
    Prediction,
    conflicts_of,
    percentiles,
)
from valvetrain.explore.least_squares import (
    Ends,
    Peak,
    best_starts,
    covariance_of,
    ends_of,
    least_squares,
    linear_draws,
    profile,
    starts,
)
from valvetrain.explore.nested import nested
from valvetrain.explore.posterior import Evaluate, Outcome, Posterior
from valvetrain.explore.store import Store
from valvetrain.runs.stopping import Stopped

Array = NDArray[np.float64]


def finite(outcome: Outcome, key: str) -> float:
    """One number of an outcome, NaN where it is not there."""
    return math.nan if outcome is None else float(outcome.get(key, math.nan))


Labels = NDArray[np.int64]
Places = NDArray[np.int64]
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
    begin: Array | None = None,
    profiles: Sequence[str] = (),
    name: str = "",
    report: Report = silent,
    compare: Evaluate | None = None,
    units: Mapping[str, str] = MappingProxyType({}),
) -> Identified:
    """Search the posterior, find its branches, and report for each what the data determine.

    ``begin`` (n, quantities): starts of a search for a point in SI, in addition to those of ``search``.
    ``compare``: computes what is not fitted, for ``search.draws`` of the draws.
    ``units``: those that computed quantities are
    shown in, by key. A stop in a search leaves what it had, one before that raises
    :class:`Stopped`.
    """
    began = time.perf_counter()
    given = None if begin is None else posterior.work_of(begin)
    if search.method == "nested":
        draws = nested(
            posterior,
            seed=search.seed,
            live_points=search.live_points,
            lanes=search.lanes,
            precision=search.precision,
            report=report,
        )
        labels = (
            branches_of_draws(posterior, draws, search.seed)
            if draws.whole
            else np.zeros(len(draws.work), dtype=np.int64)
        )
        peaks = _peaks(posterior, draws, labels)
        shares = np.array(
            [draws.weights[labels == number].sum() for number in range(labels.max() + 1)]
        )
        branches = _sampled(posterior, draws, labels, peaks, shares)
    else:
        ends, whole = _ends(posterior, search, given, report)
        if whole:
            draws, labels = linear_draws(posterior, ends, search.draws, search.seed)
        else:
            work = np.array([peak.work for peak in ends.peaks])
            draws, labels = (
                Draws(
                    work, ends.shares, ends.log_evidence, evidence_kind="linearised", whole=False
                ),
                np.arange(len(work)),
            )
        peaks = ends.peaks
        branches = _linear(posterior, ends)
    found = (
        tuple(
            profile(posterior, peaks[0], one, report=lambda text: report(0.99, text))
            for one in profiles
        )
        if draws.whole
        else ()
    )
    if draws.whole:
        branches = tuple(
            replace(one, fit=fit_of(posterior, peak.work, peak.outcome, peak.jacobian))
            for one, peak in zip(branches, peaks, strict=True)
        )
    tables = [
        _table(
            posterior,
            draws.work,
            np.arange(len(draws.work)),
            posterior.evaluate,
            draws.weights,
            peaks[0],
        )
    ]
    if compare is not None and draws.whole:
        report(0.99, "what is compared only")
        indices, counts = even_draws(draws.weights, search.draws, search.seed)
        tables.append(
            _table(posterior, draws.work, indices, compare, counts.astype(float), peaks[0])
        )
    computed = {key: values for table in tables for key, values in table.computed.items()}
    if search.method == "nested" and draws.whole:
        branches = _checked(posterior, branches, tables[0], labels)
    branches = tuple(
        _widened(posterior, one, peak) for one, peak in zip(branches, peaks, strict=True)
    )
    fit = branches[0].fit
    widening = 1.0 if fit is None else fit.widening
    return Identified(
        search.method,
        posterior.unknowns,
        branches,
        posterior.values(draws.work),
        draws.weights,
        labels,
        _predicted(posterior, tables, widening),
        _predictions(posterior, tables, units, widening),
        computed,
        draws.log_evidence,
        draws.evidence_error,
        draws.evidence_kind,
        found,
        draws.notes,
        journal.computed,
        journal.before,
        draws.whole,
        time.perf_counter() - began,
        name,
        _conflicts(posterior, peaks[0], journal),
    )


def _checked(
    posterior: Posterior, branches: Sequence[Branch], table: _Table, labels: Labels
) -> tuple[Branch, ...]:
    """Branches with the posterior predictive p value over their draws."""
    found = []
    for number, branch in enumerate(branches):
        assert branch.fit is not None
        value = predictive(posterior, table.computed, table.weights * (labels == number))
        found.append(replace(branch, fit=replace(branch.fit, predictive=value)))
    return tuple(found)


def _widened(posterior: Posterior, branch: Branch, peak: Peak) -> Branch:
    """The branch with the intervals that it has once the scatter of all data is as large as their
    misfit requires, no wider than the priors leave them.
    """
    if branch.fit is None or branch.fit.widening == 1.0:
        return branch
    factors = widenings(posterior, peak.jacobian, branch.fit.widening)
    quantities = {}
    for factor, one in zip(factors.tolist(), posterior.unknowns, strict=True):
        interval = branch.quantities[one.name]
        low, best, high = one.prior.work(
            np.array([interval.low, interval.best, interval.high], dtype=float)
        )
        middle = min(max(best, low), high)
        ends = one.prior.value(middle + factor * (np.array([low, high]) - middle))
        quantities[one.name] = replace(
            interval,
            deviation=factor * interval.deviation,
            low=float(ends[0]),
            high=float(ends[1]),
        )
    return replace(branch, quantities=quantities)


def _conflicts(posterior: Posterior, peak: Peak, journal: Store) -> tuple[Conflict, ...]:
    """What meeting a datum that the likeliest point misses costs the others, over all points that
    were computed.
    """
    return conflicts_of(
        posterior,
        (posterior.values(peak.work[None, :])[0], peak.outcome),
        journal.points(),
    )


def _ends(
    posterior: Posterior, search: Search, given: Array | None, report: Report
) -> tuple[Ends, bool]:
    """Peaks of a search from several starts, and whether none was cut short."""
    begins = np.empty((0, len(posterior.unknowns))) if given is None else given
    if search.keep:
        begins = np.vstack(
            [
                begins,
                best_starts(posterior, starts(posterior, search.starts, search.seed), search.keep),
            ]
        )
    if not len(begins):
        raise InputError("keep is 0, so that nothing is searched from; keep 1 or more")
    peaks: list[Peak] = []
    for number, begin in enumerate(begins):

        def reported(text: str, number: int = number) -> None:
            report(number / len(begins), f"start {number + 1} of {len(begins)}, {text}")

        try:
            peaks.append(
                least_squares(
                    posterior,
                    begin,
                    iterations=search.iterations,
                    step=search.difference_step or None,
                    report=reported,
                )
            )
        except Stopped:
            if not peaks:
                raise
            return ends_of(posterior, peaks[:1]), False
    return ends_of(posterior, peaks), True


def _peaks(posterior: Posterior, draws: Draws, labels: Labels) -> tuple[Peak, ...]:
    """Least squares from the likeliest draw of each branch, so that slopes are taken at its peak."""
    at = posterior.at(draws.work).log_posterior
    found = []
    for number in range(labels.max() + 1):
        here = np.flatnonzero(labels == number)
        begin = draws.work[here[np.argmax(at[here])]]
        if not draws.whole:  # stopped: what is known already must do
            outcome = posterior.at(begin[None, :]).outcomes[0]
            slopes = np.zeros((len(posterior.used), len(begin)))
            off = posterior.residuals(outcome)
            misfit = (
                np.nan if off is None else float(off @ off + np.sum(posterior.pulls(begin) ** 2))
            )
            found.append(Peak(begin, outcome, misfit, slopes, covariance_of(posterior, slopes), 0))
        else:
            found.append(least_squares(posterior, begin, iterations=4))
    return tuple(found)


def _sampled(
    posterior: Posterior, draws: Draws, labels: Labels, peaks: Sequence[Peak], shares: Array
) -> tuple[Branch, ...]:
    values = posterior.values(draws.work)
    branches = []
    for number, (peak, share) in enumerate(zip(peaks, shares, strict=True)):
        here = labels == number
        weights, inside = draws.weights[here] / draws.weights[here].sum(), values[here]
        mean = weights @ inside
        deviation = np.sqrt(weights @ (inside - mean) ** 2)
        off = (inside - mean) / np.where(deviation > 0, deviation, 1.0)
        best = posterior.values(peak.work[None, :])[0]
        quantities = {
            one: Interval(
                float(best[k]),
                float(mean[k]),
                float(deviation[k]),
                *percentiles(inside[:, k], weights, (LOW, HIGH)),
            )
            for k, one in enumerate(posterior.names)
        }
        correlation = (off * weights[:, None]).T @ off
        branches.append(
            Branch(
                float(share),
                peak.misfit,
                quantities,
                correlation,
                information_of(posterior, peak.jacobian, draws.whole),
            )
        )
    return tuple(branches)


def _linear(posterior: Posterior, ends: Ends) -> tuple[Branch, ...]:
    branches = []
    for peak, share in zip(ends.peaks, ends.shares, strict=True):
        deviation = np.sqrt(np.diag(peak.covariance))
        low, best, high = posterior.values(
            peak.work + np.outer((-_NORMAL, 0.0, _NORMAL), deviation)
        )
        slope = np.where([one.prior.logarithmic for one in posterior.unknowns], best, 1.0)
        quantities = {
            one: Interval(
                float(best[k]),
                float(best[k]),
                float(slope[k] * deviation[k]),
                float(low[k]),
                float(high[k]),
            )
            for k, one in enumerate(posterior.names)
        }
        information = information_of(posterior, peak.jacobian)
        branches.append(
            Branch(float(share), peak.misfit, quantities, information.correlation, information)
        )
    return tuple(branches)


@dataclass(frozen=True, eq=False)
class _Table:
    """Numbers of one computation over the draws, by key (NaN where not computed), with the
    ``weights`` of the computed draws, and those of the likeliest point."""

    computed: dict[str, Array]
    weights: Array
    best: Outcome


def _table(
    posterior: Posterior,
    work: Array,
    indices: Places,
    evaluate: Evaluate,
    weights: Array,
    peak: Peak,
) -> _Table:
    (best, *outcomes) = evaluate(posterior.values(np.vstack([peak.work, work[indices]])))
    keys = dict.fromkeys(key for outcome in outcomes if outcome is not None for key in outcome)
    computed = {key: np.full(len(work), np.nan) for key in keys}
    for index, outcome in zip(indices, outcomes, strict=True):
        for key in keys:
            computed[key][index] = finite(outcome, key)
    every = np.zeros(len(work))
    every[indices] = weights
    return _Table(computed, every, best)


def _ends_of(
    key: str, values: Array, weights: Array, widening: float
) -> tuple[float, float, float]:
    """2.5, 50 and 97.5 %, the ends ``widening`` times as far from the middle; of an amount never below
    zero.
    """
    low, middle, high = percentiles(values, weights, (LOW, 50.0, HIGH))
    wide = middle + widening * (low - middle)
    if AMOUNT.search(key) and low >= 0:
        wide = max(wide, 0.0)
    return wide, middle, middle + widening * (high - middle)


def _predicted(
    posterior: Posterior, tables: Sequence[_Table], widening: float
) -> tuple[Predicted, ...]:
    found = []
    for datum in posterior.data:
        table = next((one for one in tables if datum.key in one.computed), tables[0])
        over = table.computed.get(datum.key, np.full(len(table.weights), np.nan))
        low, middle, high = _ends_of(datum.key, over, table.weights, widening)
        found.append(
            Predicted(
                datum,
                finite(table.best, datum.key),
                low,
                middle,
                high,
                datum.percentile(over, table.weights),
            )
        )
    return tuple(found)


def _predictions(
    posterior: Posterior, tables: Sequence[_Table], units: Mapping[str, str], widening: float
) -> tuple[Prediction, ...]:
    """Every computed number that no datum is about."""
    measured = {one.key for one in posterior.data}
    return tuple(
        Prediction(
            key,
            units.get(key, ""),
            finite(table.best, key),
            *_ends_of(key, values, table.weights, widening),
        )
        for table in tables
        for key, values in table.computed.items()
        if key not in measured
    )
