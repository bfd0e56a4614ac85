"""Which data contradict each other: what the others lose where a computed point meets a datum that
the likeliest point misses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.identification.datum import Datum
from valvetrain.identification.posterior import Outcome, Posterior

Array = NDArray[np.float64]
#: Scatters within which a datum is met.
MET = 2.0
#: Points that are looked at together: a curve of many data over many points would fill the memory.
_TOGETHER = 2000
#: Values are kept as they were computed: one on a bound may lie beyond it by rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Conflict:
    """A fitted ``datum`` that the likeliest point misses by ``off`` scatters, and the likeliest of
    the computed points that meet it.

    Of a measurement of several values the one that is missed most. ``meeting``: number of computed
    points within :data:`MET` scatters of
    it. ``cost``: misfit of the likeliest of them above that of the likeliest point (priors
    included), NaN where there is none; negative
    where another branch has the smaller misfit and the smaller probability. ``instead``: data that
    it misses, by a scatter or more beyond
    what the likeliest point does, with their scatters, of each measurement the worst. A search goes
    where the posterior is high, so the
    cost is what the search found, an upper bound.
    """

    datum: Datum
    off: float
    meeting: int
    cost: float
    instead: tuple[tuple[Datum, float], ...]


def conflicts_of(
    posterior: Posterior, best: tuple[Array, Outcome], points: Sequence[tuple[Array, Outcome]]
) -> tuple[Conflict, ...]:
    """Conflicts of the likeliest point ``best`` (values in SI, outcome) with the computed
    ``points``, most missed first.

    Impossible points, and those outside the bounds of the priors, count for none.

    Examples
    --------
    >>> from valvetrain.identification.posterior import Unknown
    >>> from valvetrain.identification.prior import Prior
    >>> data = (Datum("load", 280.0, 2.0), Datum("same load", 300.0, 2.0), Datum("rate", 40e3, 9e3))
    >>> posterior = Posterior((Unknown("rate", Prior("uniform", 20e3, 60e3)),), data, lambda points: [])
    >>> points = [(np.array([rate]), {"load": 7e-3 * rate, "same load": 7e-3 * rate, "rate": rate}) for rate in range(36000, 46000, 100)]
    >>> one, other = conflicts_of(posterior, points[54], points)
    >>> one.datum.key, one.instead[0][0].key
    ('same load', 'load')
    """
    own = _deviations(posterior, [best])[0]
    missed = _worst(
        posterior.used, {place: float(size) for place, size in enumerate(own) if abs(size) > MET}
    )
    if not missed:
        return ()
    least = float(_misfits(posterior, np.array([best[0]]), own[None, :])[0])
    meeting, cheapest = dict.fromkeys(missed, 0), dict.fromkeys(missed, np.inf)
    others: dict[int, Array] = {}
    for first in range(0, len(points), _TOGETHER):
        part = [
            point
            for point in points[first : first + _TOGETHER]
            if point[1] is not None and _inside(posterior, point[0])
        ]
        if not part:
            continue
        off = _deviations(posterior, part)
        misfit = _misfits(posterior, np.array([values for values, _ in part]), off)
        for place in missed:
            met = np.flatnonzero((np.abs(off[:, place]) <= MET) & np.isfinite(misfit))
            meeting[place] += len(met)
            if len(met) and misfit[met].min() < cheapest[place]:
                row = int(met[np.argmin(misfit[met])])
                cheapest[place], others[place] = float(misfit[row]), off[row]
    found = [
        Conflict(
            posterior.used[place],
            off_by,
            meeting[place],
            cheapest[place] - least if place in others else np.nan,
            _instead(posterior.used, own, others[place], place) if place in others else (),
        )
        for place, off_by in missed.items()
    ]
    return tuple(sorted(found, key=lambda one: -abs(one.off)))


def _inside(posterior: Posterior, values: Array) -> bool:
    """Whether the priors hold a point possible."""
    return all(
        one.prior.low - _ROUNDING * abs(one.prior.low)
        <= value
        <= one.prior.high + _ROUNDING * abs(one.prior.high)
        for one, value in zip(posterior.unknowns, values, strict=True)
    )


def _deviations(posterior: Posterior, points: Sequence[tuple[Array, Outcome]]) -> Array:
    """Misses (points, data) of the fitted data in scatters; NaN where a point lacks one."""
    told = np.array(
        [
            [np.nan if outcome is None else outcome.get(one.key, np.nan) for one in posterior.used]
            for _, outcome in points
        ]
    )
    return np.column_stack(
        [one.deviation(told[:, place]) for place, one in enumerate(posterior.used)]
    )


def _misfits(posterior: Posterior, values: Array, off: Array) -> Array:
    """Sum of squared scaled misses of each point, priors included; NaN for one that lacks a datum."""
    work = posterior.work_of(values)
    data = sum(
        one.residual(one.value + one.scatter * off[:, place]) ** 2
        for place, one in enumerate(posterior.used)
    )
    pulls = sum(one.prior.pull(work[:, place]) ** 2 for place, one in enumerate(posterior.unknowns))
    return np.asarray(data + pulls, dtype=float)


def _worst(data: Sequence[Datum], off: Mapping[int, float]) -> dict[int, float]:
    """Of each measurement the datum that is missed most, in the order of the data."""
    worst: dict[str, int] = {}
    for place, size in off.items():
        name = data[place].name
        if name not in worst or abs(size) > abs(off[worst[name]]):
            worst[name] = place
    return {place: off[place] for place in sorted(worst.values())}


def _instead(
    data: Sequence[Datum], own: Array, other: Array, met: int
) -> tuple[tuple[Datum, float], ...]:
    """What the point ``other`` misses by a scatter or more beyond what the likeliest one does,
    worst first.
    """
    worse = [
        place
        for place in range(len(data))
        if place != met and abs(other[place]) > max(MET, abs(own[place]) + 1.0)
    ]
    kept = _worst(data, {place: float(other[place]) for place in worse})
    return tuple(
        (data[place], off) for place, off in sorted(kept.items(), key=lambda one: -abs(one[1]))
    )
