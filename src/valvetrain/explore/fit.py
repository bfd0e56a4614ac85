"""What the data determine of each quantity, how well a model meets them, and what meeting a missed
measurement costs the others.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from valvetrain.explore.posterior import Datum, Numbers, Posterior

Array = NDArray[np.float64]
#: With a p value below this the model is reported as unable to meet the data, which happens to one correct model in a
#: hundred.
REFUSED = 0.01
#: Degrees of freedom below which nothing is left to test.
NOTHING_LEFT = 0.5
#: A quantity is on its bound within this share of the prior's deviation.
ON_BOUND = 1e-6
#: Posterior correlation beyond which two quantities are one, and information (over the prior's)
#: that each would have were the other known.
TWINS, KNOWN_ALONE = 0.9, 4.0
#: Share of the prior's deviation that must be left of one of the two, for a narrow stretch within a
#: wide prior is knowledge all the same.
OPEN = 0.4
#: Least part of a combination that makes a quantity a member of its group.
NAMED = 0.3
#: Scatters within which a datum is met.
MET = 2.0
#: Points that are looked at together: a curve of many data over many points would fill the memory.
_TOGETHER = 2000
#: Values are stored as they were computed: one on a bound may be beyond it by rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Information:
    """``determined`` (quantities): share of the prior's variance that the data remove. ``brought``
    (measurements, quantities): share that each measurement has of all the data's information on a
    quantity, the others known. ``lost`` (measurements, quantities): share by which the variance is
    smaller than it were without that measurement. ``groups``: places of quantities of which the
    data determine a combination only.
    """

    measurements: tuple[str, ...]
    determined: Array
    brought: Array
    lost: Array
    groups: tuple[tuple[int, ...], ...]


def information_of(posterior: Posterior, jacobian: Array) -> Information:
    """From the slopes (used data, quantities) at the likeliest point."""
    owners = np.array([one.name for one in posterior.used])
    measurements = tuple(dict.fromkeys(owners.tolist()))
    every = np.sum(jacobian**2, axis=0)
    parts = np.array([np.sum(jacobian[owners == name] ** 2, axis=0) for name in measurements])
    brought = parts / np.where(every > 0, every, 1.0)
    covariance = posterior.remaining(jacobian)
    without = [np.diag(posterior.remaining(jacobian[owners != name])) for name in measurements]
    lost = np.clip(1.0 - np.diag(covariance) / np.array(without), 0.0, 1.0)
    determined = 1.0 - np.diag(covariance)
    return Information(measurements, determined, brought, lost, _groups(jacobian, covariance))


def _groups(jacobian: Array, covariance: Array) -> tuple[tuple[int, ...], ...]:
    """Pairs that are one, then larger groups of which a combination is left to the priors."""
    alone, vague = np.sum(jacobian**2, axis=0), np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(vague, vague)
    found: list[tuple[int, ...]] = [
        pair
        for pair in itertools.combinations(range(len(vague)), 2)
        if np.all(alone[list(pair)] > KNOWN_ALONE)
        and abs(correlation[pair]) > TWINS
        and np.any(vague[list(pair)] > OPEN)
    ]
    paired = {place for pair in found for place in pair}
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    for value, vector in zip(values, vectors.T, strict=True):
        large = np.flatnonzero(np.abs(vector) > NAMED).tolist()
        if value < 1.0 and len(large) > 2 and set(large) - paired:
            if np.all(alone[large] > KNOWN_ALONE):
                found.append(tuple(large))
                paired |= set(large)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Fit:
    """``chi_square`` of the residuals and the pulls of the priors with its degrees of ``freedom``;
    ``p_value``: how often a correct model has a larger one, NaN where no freedom is left.

    ``predictive``: posterior predictive p value over draws (A. Gelman, X.-L. Meng, H. Stern, Statistica
    Sinica 6 (1996) 733), NaN without a sampled posterior.

    >>> Fit(470.0, 38.0, 0.0).phrase
    'chi-square 470 for 38 degrees of freedom, p < 1e-06'
    >>> round(Fit(470.0, 38.0, 0.0).widening, 2)
    3.52
    """

    chi_square: float
    freedom: float
    p_value: float
    predictive: float = math.nan

    @property
    def missed(self) -> bool:
        """Whether the model cannot meet the data."""
        return any(value < REFUSED for value in (self.p_value, self.predictive))

    @property
    def widening(self) -> float:
        """Factor on the scatter of all data that makes the misfit the expected one (R. T. Birge,
        Physical Review 40 (1932) 207); 1 where the model meets them.
        """
        if not self.missed:
            return 1.0
        return math.sqrt(max(self.chi_square / max(self.freedom, 1.0), 1.0))

    @property
    def phrase(self) -> str:
        """Chi-square, degrees of freedom and p values."""
        found = f"chi-square {self.chi_square:.4g}"
        if math.isnan(self.p_value):
            found += ", no degree of freedom left to test by"
        else:
            found += f" for {self.freedom:.3g} degrees of freedom, p {_odds(self.p_value)}"
        if math.isnan(self.predictive):
            return found
        return f"{found}, posterior predictive p {_odds(self.predictive)}"


def _odds(value: float) -> str:
    return "< 1e-06" if value < 1e-6 else f"{value:.2g}"


def fit_of(posterior: Posterior, work: Array, outcome: Numbers, jacobian: Array) -> Fit:
    """The fit at the likeliest point ``work`` (quantities) by the slopes there (data, quantities).

    Every datum and every normal prior counts one degree of freedom; every quantity takes one, a flat
    one as far as the data determine it, one on its bound none. Student errors enter by the normal
    score of their probability.

    >>> from valvetrain.explore.posterior import Datum, Unknown
    >>> from valvetrain.explore.space import Prior
    >>> data = tuple(Datum(f"load {k}", value, 1.0) for k, value in enumerate((9.0, 10.0, 14.0)))
    >>> posterior = Posterior((Unknown("load", Prior("uniform", 0.0, 1e3)),), data, lambda points: [])
    >>> found = fit_of(posterior, np.array([11.0]), {one.key: 11.0 for one in data}, np.full((3, 1), 288.7))
    >>> print(found.phrase)
    chi-square 14 for 2 degrees of freedom, p 0.00091
    """
    scores = posterior.scores(posterior.computed([outcome]))
    chi_square = float(np.sum(scores**2) + np.sum(posterior.pulls(work[None, :]) ** 2))
    low, high = posterior.bounds
    near = ON_BOUND * posterior.spread
    free = (work > low + near) & (work < high - near)
    flat = np.array([one.prior.flat for one in posterior.unknowns])
    determined = 1.0 - np.diag(posterior.remaining(jacobian))
    freedom = len(posterior.used) + np.sum(~flat) - np.sum(np.where(flat, determined, 1.0)[free])
    p_value = float(chdtrc(freedom, chi_square)) if freedom > NOTHING_LEFT else math.nan
    return Fit(chi_square, float(freedom), p_value)


def predictive(posterior: Posterior, computed: Mapping[str, Array], weights: Array) -> float:
    """Posterior predictive p value: how often data drawn again at a draw are farther from it than the
    measured ones, over draws with ``weights``.
    """
    missing = np.full(len(weights), np.nan)
    columns = [computed.get(one.key, missing) for one in posterior.used]
    misfit = np.sum(posterior.scores(np.column_stack(columns)) ** 2, axis=1)
    known = np.isfinite(misfit)
    if not known.any():
        return math.nan
    odds = chdtrc(float(len(posterior.used)), misfit[known])
    return float(np.average(odds, weights=weights[known]))


def widenings(posterior: Posterior, jacobian: Array, scatter: float) -> Array:
    """Factor (quantities) on each deviation once all data have ``scatter`` times theirs and the
    priors stay as they are.
    """
    narrow, wide = (np.diag(posterior.remaining(jacobian, one)) for one in (1.0, scatter))
    return np.asarray(np.sqrt(wide / narrow))


@dataclass(frozen=True, slots=True)
class Conflict:
    """A fitted ``datum`` that the likeliest point misses by ``off`` scatters, and the likeliest of
    the computed points that meet it.

    Of a measurement of several values the one that is missed most, of ``values`` that are missed.
    ``meeting``: number of computed points within :data:`MET` scatters of it. ``cost``: misfit of
    the likeliest of them above that of the likeliest point (priors included), NaN where there is
    none; negative where another branch has the smaller misfit and the smaller probability.
    ``instead``: data that it misses, by a scatter or more beyond what the likeliest point does, with
    their scatters, of each measurement the worst. A search goes where the posterior is high, so the
    cost is an upper bound.
    """

    datum: Datum
    off: float
    meeting: int
    cost: float
    instead: tuple[tuple[Datum, float], ...]
    values: int = 1


def conflicts_of(
    posterior: Posterior, best: tuple[Array, Numbers], points: Sequence[tuple[Array, Numbers]]
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
    data = posterior.used
    (misses,), (least,) = _deviations(posterior, [best])
    beyond = np.flatnonzero(np.abs(misses) > MET).tolist()
    missed = _worst(data, beyond, misses)
    meeting = dict.fromkeys(missed, 0)
    cheapest: dict[int, tuple[float, Array]] = {}
    for first in range(0, len(points) if missed else 0, _TOGETHER):
        off, misfit = _deviations(posterior, points[first : first + _TOGETHER])
        for place in missed:
            met = np.flatnonzero((np.abs(off[:, place]) <= MET) & np.isfinite(misfit))
            meeting[place] += len(met)
            if len(met):
                row = met[np.argmin(misfit[met])]
                cheapest[place] = min(
                    cheapest.get(place, (np.inf, off[row])),
                    (float(misfit[row]), off[row]),
                    key=lambda one: one[0],
                )
    found = []
    for place in missed:
        cost, other = cheapest.get(place, (np.nan, misses))
        worse = np.flatnonzero(np.abs(other) > np.maximum(MET, np.abs(misses) + 1.0)).tolist()
        instead = tuple((data[one], float(other[one])) for one in _worst(data, worse, other))
        name = data[place].name
        count = sum(data[one].name == name for one in beyond)
        found.append(
            Conflict(
                data[place],
                float(misses[place]),
                meeting[place],
                cost - float(least),
                instead,
                count,
            )
        )
    return tuple(found)


def _deviations(
    posterior: Posterior, points: Sequence[tuple[Array, Numbers]]
) -> tuple[Array, Array]:
    """Misses (points, data) of the fitted data in scatters and the misfit (points), priors included;
    NaN where a point is impossible, lacks a datum or is outside the priors.
    """
    values = np.array([one for one, _ in points])
    work = posterior.work_of(values)
    outside = np.abs(posterior.values(work) - values) > _ROUNDING * np.abs(values)
    outcomes = [outcome for _, outcome in points]
    computed = posterior.computed(outcomes)
    columns = zip(posterior.used, computed.T, strict=True)
    off = np.column_stack([one.deviation(column) for one, column in columns])
    misfit = np.sum(posterior.residuals(outcomes) ** 2, axis=1)
    misfit += np.sum(posterior.pulls(work) ** 2, axis=1)
    misfit[outside.any(axis=1)] = np.nan
    return off, misfit


def _worst(data: Sequence[Datum], places: Sequence[int], off: Array) -> list[int]:
    """Of each measurement the one of ``places`` that is missed most, the worst first."""
    worst: dict[str, int] = {}
    for place in sorted(places, key=lambda one: -abs(off[one])):
        worst.setdefault(data[place].name, place)
    return list(worst.values())
