"""The posterior of unknown quantities: measured data, priors times likelihood, over batches of
points in working coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtr

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.explore.space import Varied


@dataclass(frozen=True, slots=True)
class Datum:
    """A measured ``value`` (SI) of what the computation calls ``key``, with the standard deviation
    ``scatter`` (SI) of its errors.

    ``measurement``: the entry of the file that it belongs to, such as a curve of many data. ``used``: whether it is
    fitted, else it is only compared. ``unit`` it is shown in. Raises :class:`InputError` for a scatter that is not positive.

    >>> Datum("preload", 289.0, 1.5).deviation(292.0)
    np.float64(2.0)
    """

    key: str
    value: float
    scatter: float
    measurement: str = ""
    used: bool = True
    source: str = ""
    unit: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.value) and math.isfinite(self.scatter) and self.scatter > 0):
            raise InputError(
                f"measurement '{self.name[:60]}' needs a finite value and a positive scatter"
            )

    @property
    def name(self) -> str:
        """The measurement, or the key where it has no name."""
        return self.measurement or self.key

    def deviation(self, computed: Array | float) -> Array:
        """Computed less measured in units of the scatter."""
        return (np.asarray(computed, dtype=float) - self.value) / self.scatter

    def percentile(self, computed: Array) -> float:
        """Position of the measured value in its own prediction, 0 to 100: over the draws ``computed``
        and its errors; NaN without any.
        """
        shares = ndtr(-self.deviation(computed[np.isfinite(computed)]))
        return float(100.0 * np.mean(shares)) if len(shares) else math.nan


#: Computed numbers of one point by key (SI); None for a point that cannot be computed, such as an
#: impossible spring.
Numbers = Mapping[str, float] | None
#: Values (points, quantities) in SI -> the numbers of each point, which must not depend on the
#: other points of the batch.
Evaluate = Callable[[Array], Sequence[Numbers]]


@dataclass(frozen=True, eq=False)
class Posterior:
    """``unknowns`` with their independent priors, ``data`` and the computation ``evaluate`` between them.

    Raises :class:`InputError` for none of either and for names that occur twice.
    """

    unknowns: Sequence[Varied]
    data: tuple[Datum, ...]
    evaluate: Evaluate

    def __post_init__(self) -> None:
        names = self.names
        if not names or not self.used:
            raise InputError(
                "an identification needs one quantity to find and one measurement that is used, or more"
            )
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f"quantity '{twice[:60]}' is there twice; remove one")

    @cached_property
    def used(self) -> tuple[Datum, ...]:
        """Data that are fitted."""
        return tuple(one for one in self.data if one.used)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(one.title for one in self.unknowns)

    def each(self, method: str, columns: Array) -> Array:
        """A ``method`` of every prior over its column of ``columns`` (n, quantities)."""
        pairs = zip(self.unknowns, columns.T, strict=True)
        return np.column_stack([getattr(one.prior, method)(column) for one, column in pairs])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest working coordinates."""
        low, high = np.array([one.prior.work_bounds for one in self.unknowns]).T
        return low, high

    @cached_property
    def centre(self) -> Array:
        """Middle of the priors in working coordinates."""
        return np.array([one.prior.work_centre for one in self.unknowns])

    @property
    def middle(self) -> Array:
        """Middles of the priors (SI)."""
        return np.asarray(self.values(self.centre[None, :])[0])

    @cached_property
    def spread(self) -> Array:
        """Standard deviations of the priors in working coordinates."""
        return np.array([one.prior.work_spread for one in self.unknowns])

    def values(self, work: Array) -> Array:
        """Values (n, quantities) in SI of working coordinates."""
        return self.each("value", work)

    def work_of(self, values: Array) -> Array:
        """Working coordinates of values (n, quantities) in SI, those outside the bounds moved to
        them.
        """
        low, high = np.array([(one.prior.low, one.prior.high) for one in self.unknowns]).T
        return self.each("work", np.clip(values, low, high))

    def remaining(self, jacobian: Array, scatter: float = 1.0) -> Array:
        """Covariance (quantities, quantities), in standard deviations of the priors, that data of
        the slopes ``jacobian`` (data, quantities) leave once each scatters ``scatter`` times as far.
        """
        information = np.eye(len(self.unknowns)) + jacobian.T @ jacobian / scatter**2
        return np.asarray(np.linalg.inv(information), dtype=float)

    def from_shares(self, shares: Array) -> Array:
        """Working coordinates of points of the unit cube, over which the prior is even."""
        return self.each("from_share", shares)

    def log_prior(self, work: Array) -> Array:
        """Logarithm of the prior density (n) over working coordinates."""
        return np.asarray(np.sum(self.each("log_density", work), axis=1))

    def outcomes(self, work: Array) -> list[Numbers]:
        """What is computed at points (n, quantities); None of those outside the bounds, which are
        not computed.
        """
        inside = np.flatnonzero(np.isfinite(self.log_prior(work)))
        outcomes: list[Numbers] = [None] * len(work)
        if len(inside):
            for index, one in zip(inside, self.evaluate(self.values(work[inside])), strict=True):
                outcomes[index] = one
        return outcomes

    def residuals(self, outcomes: Sequence[Numbers]) -> Array:
        """Scaled misses (n, data) of the used data, all NaN where a point is impossible or lacks a number."""
        columns = [[(one or {}).get(datum.key, np.nan) for one in outcomes] for datum in self.used]
        pairs = zip(self.used, columns, strict=True)
        misses = np.column_stack([datum.deviation(np.array(column)) for datum, column in pairs])
        misses[~np.all(np.isfinite(misses), axis=1)] = np.nan
        return misses

    def misses(self, work: Array) -> Array:
        """Scaled misses (n, data and quantities) of the used data and from the priors."""
        return np.hstack([self.residuals(self.outcomes(work)), self.each("pull", work)])

    def log_likelihood(self, work: Array) -> Array:
        """Logarithm of the likelihood (n) of the used data, minus infinity where a point is
        impossible or lacks a number.
        """
        off = self.residuals(self.outcomes(work))
        top = sum(-math.log(one.scatter * math.sqrt(2 * math.pi)) for one in self.used)
        return np.asarray(np.nan_to_num(top - 0.5 * np.sum(off**2, axis=1), nan=-np.inf))

    def log_posterior(self, work: Array) -> Array:
        """Logarithm (n) of prior times likelihood, not normalised."""
        return self.log_prior(work) + self.log_likelihood(work)
