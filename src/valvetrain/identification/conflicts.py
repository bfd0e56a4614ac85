"""Which data contradict each other: what the others lose where a computed point meets a datum that the likeliest point misses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.identification.datum import Datum
from valvetrain.identification.posterior import Outcome, Posterior

Array = NDArray[np.float64]
#: Scatters within which a datum is met.
MET = 2.0


@dataclass(frozen=True, slots=True)
class Conflict:
    """A fitted ``datum`` that the likeliest point misses by ``off`` scatters, and the likeliest of the computed points that meet it.

    ``meeting``: number of computed points within :data:`MET` scatters of it. ``cost``: misfit of the likeliest of them above the least of
    all (priors included), NaN where there is none. ``instead``: data that it misses, by a scatter or more beyond what the likeliest point
    does, with their scatters. A search goes where the posterior is high, so the cost is what the search found, an upper bound.
    """

    datum: Datum
    off: float
    meeting: int
    cost: float
    instead: tuple[tuple[Datum, float], ...]


def conflicts_of(posterior: Posterior, points: Iterable[tuple[Array, Outcome]]) -> tuple[Conflict, ...]:
    """Conflicts among computed ``points`` (values in SI, outcome), those that the likeliest point misses most first; impossible points
    count for none.

    Examples
    --------
    >>> from valvetrain.identification.posterior import Unknown
    >>> from valvetrain.identification.prior import Prior
    >>> data = (Datum("load", 280.0, 2.0), Datum("same load", 300.0, 2.0), Datum("rate", 40e3, 9e3))
    >>> posterior = Posterior((Unknown("rate", Prior("uniform", 20e3, 60e3)),), data, lambda points: [])
    >>> points = [(np.array([rate]), {"load": 7e-3 * rate, "same load": 7e-3 * rate, "rate": rate}) for rate in range(36000, 46000, 100)]
    >>> one, other = conflicts_of(posterior, points)
    >>> one.datum.key, one.instead[0][0].key
    ('same load', 'load')
    """
    kept = [(values, off) for values, outcome in points if (off := _deviations(posterior, outcome)) is not None]
    if not kept:
        return ()
    work = posterior.work_of(np.array([values for values, _ in kept]))
    off = np.array([row for _, row in kept])
    misfit = _misfits(posterior, work, off)
    least = int(np.argmin(misfit))
    found = []
    for place, datum in enumerate(posterior.used):
        if abs(off[least, place]) <= MET:
            continue
        meeting = np.flatnonzero(np.abs(off[:, place]) <= MET)
        if not len(meeting):
            found.append(Conflict(datum, float(off[least, place]), 0, np.nan, ()))
            continue
        best = int(meeting[np.argmin(misfit[meeting])])
        found.append(
            Conflict(
                datum,
                float(off[least, place]),
                len(meeting),
                float(misfit[best] - misfit[least]),
                _missed(posterior.used, off, least, best),
            )
        )
    return tuple(sorted(found, key=lambda one: -abs(one.off)))


def _deviations(posterior: Posterior, outcome: Outcome) -> Array | None:
    """Misses of the fitted data in scatters; None for a point that is impossible or lacks one."""
    if outcome is None:
        return None
    off = np.array([float(one.deviation(outcome.get(one.key, np.nan))) for one in posterior.used])
    return off if np.all(np.isfinite(off)) else None


def _misfits(posterior: Posterior, work: Array, off: Array) -> Array:
    """Sum of squared scaled misses of each point, priors included."""
    data = np.array([one.residual(one.value + one.scatter * off[:, place]) for place, one in enumerate(posterior.used)])
    pulls = np.array([posterior.pulls(row) for row in work])
    return np.asarray(np.sum(data**2, axis=0) + np.sum(pulls**2, axis=1))


def _missed(data: Sequence[Datum], off: Array, least: int, best: int) -> tuple[tuple[Datum, float], ...]:
    """What the point ``best`` misses, by a scatter or more beyond what the likeliest one does, worst first."""
    worse = [place for place in range(len(data)) if abs(off[best, place]) > max(MET, abs(off[least, place]) + 1.0)]
    return tuple((data[place], float(off[best, place])) for place in sorted(worse, key=lambda place: -abs(off[best, place])))
