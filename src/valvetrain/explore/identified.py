"""What an identification found: branches with intervals, what the data determine, where each
measurement is in its prediction.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.explore.draws import Information, even_draws
from valvetrain.explore.fit import Fit
from valvetrain.explore.least_squares import Profile
from valvetrain.explore.posterior import Datum, Outcome, Posterior, Unknown
from valvetrain.solution.display import verdict_first
from valvetrain.solution.saveable import Reported

if TYPE_CHECKING:
    import xarray


Array = NDArray[np.float64]
#: Scatters within which a datum is met.
MET = 2.0
#: Points that are looked at together: a curve of many data over many points would fill the memory.
_TOGETHER = 2000
#: Values are stored as they were computed: one on a bound may be beyond it by rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Conflict:
    """A fitted ``datum`` that the likeliest point misses by ``off`` scatters, and the likeliest of
    the computed points that meet it.

    Of a measurement of several values the one that is missed most, of ``values`` that are missed.
    ``meeting``: number of computed points within :data:`MET` scatters of
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
    values: int = 1


def conflicts_of(
    posterior: Posterior, best: tuple[Array, Outcome], points: Sequence[tuple[Array, Outcome]]
) -> tuple[Conflict, ...]:
    """Conflicts of the likeliest point ``best`` (values in SI, outcome) with the computed
    ``points``, most missed first.

    Impossible points, and those outside the bounds of the priors, count for none.

    Examples
    --------
    >>> from valvetrain.explore.posterior import Unknown
    >>> from valvetrain.explore.space import Prior
    >>> data = (Datum("load", 280.0, 2.0), Datum("same load", 300.0, 2.0), Datum("rate", 40e3, 9e3))
    >>> posterior = Posterior((Unknown("rate", Prior("uniform", 20e3, 60e3)),), data, lambda points: [])
    >>> points = [(np.array([rate]), {"load": 7e-3 * rate, "same load": 7e-3 * rate, "rate": rate}) for rate in range(36000, 46000, 100)]
    >>> one, other = conflicts_of(posterior, points[54], points)
    >>> one.datum.key, one.instead[0][0].key
    ('same load', 'load')
    """
    own = _deviations(posterior, [best])[0]
    beyond = {place: float(size) for place, size in enumerate(own) if abs(size) > MET}
    missed = _worst(posterior.used, beyond)
    if not missed:
        return ()
    names = [posterior.used[place].name for place in beyond]
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
            names.count(posterior.used[place].name),
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
    reported = np.array(
        [
            [np.nan if outcome is None else outcome.get(one.key, np.nan) for one in posterior.used]
            for _, outcome in points
        ]
    )
    return np.column_stack(
        [one.deviation(reported[:, place]) for place, one in enumerate(posterior.used)]
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
    retained = _worst(data, {place: float(other[place]) for place in worse})
    return tuple(
        (data[place], off) for place, off in sorted(retained.items(), key=lambda one: -abs(one[1]))
    )


#: Ends of the intervals (percent).
LOW, HIGH = 2.5, 97.5


@dataclass(frozen=True, slots=True)
class Interval:
    """A quantity as it was found (SI): ``best``, at the likeliest point; ``mean``, ``deviation``
    and the interval that holds 95 %.
    """

    best: float
    mean: float
    deviation: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Branch:
    """A separate part of the posterior with its probability ``share``; ``misfit``: least sum of squared scaled misses, priors
    included; ``fit``: how well it meets the data, None of a search that was stopped. Intervals are
    widened where it does not.
    """

    share: float
    misfit: float
    quantities: Mapping[str, Interval]
    correlation: Array
    information: Information
    fit: Fit | None = None


@dataclass(frozen=True, slots=True)
class Predicted:
    """A measurement and its prediction (SI): computed at the ``best`` point, 2.5, 50 and 97.5 %
    of the computed values over the
    posterior, and the ``percentile`` of the measured value among what would be measured
    (0 to 100). ``start``: computed at the start, NaN where that cannot be computed."""

    datum: Datum
    best: float
    low: float
    middle: float
    high: float
    percentile: float
    start: float = np.nan

    @property
    def off(self) -> float:
        """Computed less measured at the ``best`` point, in scatters of the measured value."""
        return float(self.datum.deviation(self.best))


@dataclass(frozen=True, slots=True)
class Prediction:
    """A computed number that was not measured (SI; shown in ``unit``): at the ``best`` point, and
    2.5, 50 and 97.5 % over the posterior.
    """

    key: str
    unit: str
    best: float
    low: float
    middle: float
    high: float


@dataclass(frozen=True, eq=False)
class Identified(Reported):
    """The answer of :func:`valvetrain.identify`. SI throughout.

    ``branches``, the most probable first; ``values`` (draw, quantity) with ``weights`` (draw) and
    ``branch_of`` (draw); ``predicted``:
    every measurement with its prediction; ``predictions`` of what was not measured;
    ``conflicts``: what meeting a missed measurement
    costs the others; ``computed``: each computed quantity over the draws; ``log_evidence`` with its
    error (NaN where it was not found);
    ``notes`` on the search; ``start``: values that the case has, or the middles of the priors;
    ``meanings``: what likeliest values amount to, by quantity; ``case_file``: text of the case with
    the likeliest values, ``text``: that of the identification file (empty without one);
    ``evaluations``: points that were computed, ``reused``: those of an
    earlier start; ``whole``: False where
    it was cut short.

    >>> import valvetrain as vt
    >>> found = vt.identify({"rate": vt.explore.Prior("uniform", 20e3, 60e3)}, [vt.explore.Datum("force", 280.0, 2.0)],
    ...                     lambda points: [{"force": 7e-3 * rate} for (rate,) in points])
    >>> found
    fitted, not checked: measured 1, unknown 1, so almost any model meets the data
      Identified by least-squares: rate
    >>> round(found.percentile("force"))
    50
    """

    report_word = "identification"

    method: str
    unknowns: tuple[Unknown, ...]
    branches: tuple[Branch, ...]
    values: Array
    weights: Array
    branch_of: NDArray[np.int64]
    predicted: tuple[Predicted, ...]
    predictions: tuple[Prediction, ...]
    computed: Mapping[str, Array]
    log_evidence: float = np.nan
    evidence_error: float = np.nan
    evidence_kind: str = ""
    profiles: tuple[Profile, ...] = ()
    notes: tuple[str, ...] = ()
    evaluations: int = 0
    reused: int = 0
    whole: bool = True
    wall_time: float = field(default=0.0, compare=False)
    name: str = ""
    conflicts: tuple[Conflict, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    meanings: Mapping[str, str] = field(default_factory=dict)
    case_file: str = ""
    text: str = ""

    @property
    def fit(self) -> Fit | None:
        """How well the most probable branch meets the data; None of a search that was stopped."""
        return self.branches[0].fit

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities that were looked for."""
        return tuple(one.name for one in self.unknowns)

    @property
    def best(self) -> Mapping[str, float]:
        """The likeliest point of the most probable branch, by quantity."""
        return {name: one.best for name, one in self.branches[0].quantities.items()}

    def percentile(self, measurement: str) -> float:
        """Percentile of a measurement of one value. Raises :class:`InputError` unless
        one of that name has one value.
        """
        fits = [one for one in self.predicted if measurement in (one.datum.name, one.datum.key)]
        if len(fits) != 1:
            raise InputError(
                f"{len(fits) or 'no'} measured values are called '{measurement[:60]}'; look through 'predicted'"
            )
        return fits[0].percentile

    def to_xarray(self) -> xarray.Dataset:
        """A Dataset over draw: the quantities (SI), the weight and branch of each draw, and every
        computed number.
        """
        import xarray

        columns: dict[str, Any] = dict(zip(self.names, self.values.T, strict=True))
        columns |= {f"computed {name}": values for name, values in self.computed.items()}
        columns |= {"weight": self.weights, "branch": self.branch_of}
        data = {name: ("draw", values) for name, values in columns.items()}
        return xarray.Dataset(data, attrs={"method": self.method, "title": self.name})

    def to_arviz(self, draws: int = 1000, seed: int = 1) -> Any:
        """About ``draws`` equally weighted draws of the posterior as ArviZ takes them. Raises
        :class:`MissingExtraError` where ArviZ is not installed.
        """
        arviz = _arviz()
        index, counts = even_draws(self.weights, draws, seed)
        rows = np.repeat(self.values[index], counts, axis=0)[None]
        posterior = {name: rows[..., k] for k, name in enumerate(self.names)}
        try:
            return arviz.from_dict(posterior=posterior)
        except TypeError:  # from ArviZ 1.0
            return arviz.from_dict({"posterior": posterior})

    def __repr__(self) -> str:
        return verdict_first(self, [f"Identified by {self.method}: {', '.join(self.names)}"])


def _arviz() -> Any:
    try:
        with warnings.catch_warnings():  # of its next version
            warnings.simplefilter("ignore")
            return import_module("arviz")
    except ImportError as error:
        raise MissingExtraError(
            "arviz is not installed; install it with pip install 'valvetrain[posterior]'"
        ) from error


def percentiles(values: Array, weights: Array, shares: tuple[float, ...]) -> tuple[float, ...]:
    """Weighted percentiles (0 to 100) of values that are not NaN, by the middle of each weight; NaN
    where there is none.
    """
    known = np.isfinite(values) & (weights > 0)
    if not known.any():
        return (np.nan,) * len(shares)
    order = np.argsort(values[known], kind="stable")
    sorted_values, sorted_weights = values[known][order], weights[known][order]
    middle = np.cumsum(sorted_weights) - 0.5 * sorted_weights
    return tuple(
        float(one)
        for one in np.interp(np.array(shares) / 100.0, middle / sorted_weights.sum(), sorted_values)
    )
