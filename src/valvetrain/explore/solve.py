"""From a posterior and a search to the answer."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any

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
from valvetrain.explore.ensembles import ensemble, evolution, nested
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
    places_of,
    profile,
    starts,
)
from valvetrain.explore.posterior import Evaluate, Outcome, Posterior
from valvetrain.runs.stopping import Stopped
from valvetrain.solution.atomic import digest, lock

Array = NDArray[np.float64]
NAME = "points.jsonl"
_SUM = 16


class Journal:
    """Outcomes of points by their bits, in a file of the folder ``folder``; None keeps them in
    memory alone.

    ``identity`` is what the outcomes depend on (case, file, version): a journal of another is
    refused, and so is one that another process
    writes. ``before``: points that were there; ``computed``: those that came since. ``at_a_time``:
    most points that
    are computed before they are written, 0 for all that are asked for at once. Use it as a context.
    """

    def __init__(self, folder: Path | None, identity: str) -> None:
        self._known: dict[bytes, Outcome] = {}
        self._file = None
        self.computed = self.before = self.at_a_time = 0
        if folder is None:
            return
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / NAME
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        self._file = os.fdopen(handle, "r+b")
        if not lock(handle):
            self._file.close()
            raise InputError(
                "another process works on this identification; wait for it, or choose another folder",
                str(folder),
            )
        try:
            self._read(identity, path)
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._file is not None:
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()

    def __len__(self) -> int:
        return len(self._known)

    def through(self, evaluate: Evaluate, part: bytes = b"") -> Evaluate:
        """``evaluate`` with every point computed once: those that are known are read, the others
        written as they come.

        ``part`` keeps apart what several computations tell of one point.
        """

        def recorded(points: Array) -> Sequence[Outcome]:
            keys = [part + np.ascontiguousarray(point, dtype=float).tobytes() for point in points]
            new = [
                place
                for place, key in enumerate(keys)
                if key not in self._known and key not in keys[:place]
            ]
            size = self.at_a_time or max(len(new), 1)
            for first in range(0, len(new), size):
                places = new[first : first + size]
                found = evaluate(points[places])
                self._write(
                    [(keys[place], outcome) for place, outcome in zip(places, found, strict=True)]
                )
            return [self._known[key] for key in keys]

        return recorded

    def points(self, quantities: int) -> list[tuple[Array, Outcome]]:
        """Every known point (values of so many ``quantities``) and its outcome, without those of a
        part.
        """
        known = [
            (key, outcome) for key, outcome in self._known.items() if len(key) == 8 * quantities
        ]
        return [(np.frombuffer(key, dtype=float), outcome) for key, outcome in known]

    def outcome(self, point: Array) -> Outcome:
        """What is known of a point; None also of one that was never computed."""
        return self._known.get(np.ascontiguousarray(point, dtype=float).tobytes())

    def _read(self, identity: str, path: Path) -> None:
        assert self._file is not None
        end = 0
        for number, line in enumerate(self._file):
            record = _content(line)
            if record is None:
                break  # what a kill cut short, and anything behind it, is computed again
            end += len(line)
            if number == 0:
                if record != identity:
                    asked, _, version = identity.partition(" ")
                    if version and str(record).partition(" ")[0] == asked:
                        raise InputError(
                            "holds points that another version of valvetrain or of its libraries computed; go on with that version, or "
                            "remove the file to begin anew",
                            str(path),
                        )
                    raise InputError(
                        "holds points of another identification; give another folder", str(path)
                    )
            else:
                point, outcome = record
                self._known[bytes.fromhex(point)] = outcome
        self.before = len(self._known)
        self._file.truncate(end)
        self._file.seek(end)
        if end == 0:
            self._file.write(_line(identity))
            self._file.flush()

    def _write(self, found: Sequence[tuple[bytes, Outcome]]) -> None:
        lines = []
        for key, outcome in found:
            told = (
                None if outcome is None else {name: float(value) for name, value in outcome.items()}
            )
            self._known[key] = told
            lines.append(_line([key.hex(), told]))
        self.computed += len(found)
        if self._file is not None:
            self._file.write(b"".join(lines))
            self._file.flush()


def read_points(path: Path, quantities: int) -> list[tuple[Array, Outcome]]:
    """Every point of a file of computed points (values of so many ``quantities`` in SI) and its
    outcome, without those of a part.

    Raises :class:`InputError` where the file cannot be read or holds none.
    """
    try:
        with path.open("rb") as file:
            records = [_content(line) for line in file]
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", str(path)) from None
    whole = records[1 : records.index(None)] if None in records else records[1:]
    found = [
        (np.frombuffer(bytes.fromhex(key), dtype=float), outcome)
        for key, outcome in whole
        if len(key) == 16 * quantities
    ]
    if not found:
        raise InputError(f"holds no points of {quantities} quantities", str(path))
    return found


def _line(record: object) -> bytes:
    body = json.dumps(record, separators=(",", ":")).encode()
    return digest(body)[:_SUM].encode() + b" " + body + b"\n"


def _content(line: bytes) -> Any:
    """The record of a line; None where its bytes are not those that were written."""
    body = line[_SUM + 1 : -1]
    if not line.endswith(b"\n") or digest(body)[:_SUM].encode() != line[:_SUM]:
        return None
    return json.loads(body)


def finite(outcome: Outcome, key: str) -> float:
    """One number of an outcome, NaN where it is not there."""
    return math.nan if outcome is None else float(outcome.get(key, math.nan))


Labels = NDArray[np.int64]
Places = NDArray[np.int64]
#: Quantile of the normal law at :data:`HIGH`.
_NORMAL = 1.959963984540054


def solve(
    posterior: Posterior,
    search: Search,
    journal: Journal,
    *,
    begin: Array | None = None,
    profiles: Sequence[str] = (),
    name: str = "",
    report: Report = silent,
    compare: Evaluate | None = None,
    units: Mapping[str, str] = MappingProxyType({}),
) -> Identified:
    """Search the posterior, find its branches, and tell of each what the data determine.

    ``begin`` (n, quantities): starts of a search for a point in SI, beside those of ``search``; an
    ensemble begins about what they lead to.
    ``compare``: tells of a point what is not fitted, asked for ``search.draws`` of the draws.
    ``units``: those that computed quantities are
    shown in, by key. A stop in a search leaves what it had, one before that raises
    :class:`Stopped`.
    """
    began = time.perf_counter()
    given = None if begin is None else posterior.work_of(begin)
    if search.method in ("nested", "ensemble"):
        if search.method == "nested":
            draws = nested(
                posterior,
                seed=search.seed,
                live_points=search.live_points,
                lanes=search.lanes,
                precision=search.precision,
                report=report,
            )
        else:
            around = None if given is None else _around(posterior, search, given, report)
            draws = ensemble(
                posterior,
                seed=search.seed,
                walkers=search.walkers,
                steps=search.steps,
                around=around,
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
        places, counts = even_draws(draws.weights, search.draws, search.seed)
        tables.append(
            _table(posterior, draws.work, places, compare, counts.astype(float), peaks[0])
        )
    computed = {key: values for table in tables for key, values in table.computed.items()}
    return Identified(
        search.method,
        posterior.unknowns,
        branches,
        posterior.values(draws.work),
        draws.weights,
        labels,
        _predicted(posterior, tables),
        _predictions(posterior, tables, units),
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


def _conflicts(posterior: Posterior, peak: Peak, journal: Journal) -> tuple[Conflict, ...]:
    """What meeting a datum that the likeliest point misses costs the others, over all points that
    were computed.
    """
    return conflicts_of(
        posterior,
        (posterior.values(peak.work[None, :])[0], peak.outcome),
        journal.points(len(posterior.unknowns)),
    )


def _around(posterior: Posterior, search: Search, given: Array, report: Report) -> Array:
    """Draws of the linearised posterior about what least squares reach from ``given``: walkers that
    begin there are spread already.
    """
    step = search.difference_step or None
    peaks = [
        least_squares(
            posterior,
            one,
            iterations=search.iterations,
            step=step,
            report=lambda text: report(0.0, text),
        )
        for one in given
    ]
    return places_of(posterior, ends_of(posterior, peaks), search.draws, search.seed)[0]


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

        def told(text: str, number: int = number) -> None:
            report(number / len(begins), f"start {number + 1} of {len(begins)}, {text}")

        try:
            if search.method == "cma-es":
                point, whole = evolution(
                    posterior,
                    begin,
                    seed=search.seed + number,
                    evaluations=search.evaluations,
                    population=search.population,
                    report=lambda share, text: told(text),
                )
                if not whole:
                    raise Stopped("stopped")
                begin = point
            peaks.append(
                least_squares(
                    posterior,
                    begin,
                    iterations=search.iterations,
                    step=search.difference_step or None,
                    report=told,
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
    """What one computation tells of the draws, by key (NaN where it was not asked), with the
    ``weights`` of those it was asked for, and of
    the likeliest point."""

    computed: dict[str, Array]
    weights: Array
    best: Outcome


def _table(
    posterior: Posterior,
    work: Array,
    places: Places,
    evaluate: Evaluate,
    weights: Array,
    peak: Peak,
) -> _Table:
    (best, *outcomes) = evaluate(posterior.values(np.vstack([peak.work, work[places]])))
    keys = dict.fromkeys(key for outcome in outcomes if outcome is not None for key in outcome)
    computed = {key: np.full(len(work), np.nan) for key in keys}
    for place, outcome in zip(places, outcomes, strict=True):
        for key in keys:
            computed[key][place] = finite(outcome, key)
    every = np.zeros(len(work))
    every[places] = weights
    return _Table(computed, every, best)


def _predicted(posterior: Posterior, tables: Sequence[_Table]) -> tuple[Predicted, ...]:
    found = []
    for datum in posterior.data:
        table = next((one for one in tables if datum.key in one.computed), tables[0])
        over = table.computed.get(datum.key, np.full(len(table.weights), np.nan))
        low, middle, high = percentiles(over, table.weights, (LOW, 50.0, HIGH))
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
    posterior: Posterior, tables: Sequence[_Table], units: Mapping[str, str]
) -> tuple[Prediction, ...]:
    """Every computed number that no datum is about."""
    measured = {one.key for one in posterior.data}
    return tuple(
        Prediction(
            key,
            units.get(key, ""),
            finite(table.best, key),
            *percentiles(values, table.weights, (LOW, 50.0, HIGH)),
        )
        for table in tables
        for key, values in table.computed.items()
        if key not in measured
    )
