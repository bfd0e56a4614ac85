"""The posterior of unknown quantities: priors times likelihood, over batches of points in working
coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.data import Datum
from valvetrain.explore.prior import Prior

Array = NDArray[np.float64]
#: What a computation tells of one point, by key (SI); None for a point that cannot be computed,
#: such as an impossible spring.
Outcome = Mapping[str, float] | None
#: Values (points, quantities) in SI -> the outcome of each point. What is told of a point must not
#: depend on those beside it.
Evaluate = Callable[[Array], Sequence[Outcome]]


@dataclass(frozen=True)
class Unknown:
    """A quantity that is looked for: ``name``, its ``prior``, and the ``unit`` it is shown in."""

    name: str
    prior: Prior
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Points:
    """Evaluated points: ``work`` (n, quantities), ``outcomes``, ``log_prior``, ``log_likelihood``
    (n), minus infinity where impossible.
    """

    work: Array
    outcomes: tuple[Outcome, ...]
    log_prior: Array
    log_likelihood: Array

    @property
    def log_posterior(self) -> Array:
        """Logarithm of prior times likelihood, not normalised."""
        return self.log_prior + self.log_likelihood


@dataclass(frozen=True, eq=False)
class Posterior:
    """``unknowns`` with their priors, ``data`` and the computation ``evaluate`` between them.

    Raises :class:`InputError` for none of either and for names that occur twice.
    """

    unknowns: tuple[Unknown, ...]
    data: tuple[Datum, ...]
    evaluate: Evaluate

    def __post_init__(self) -> None:
        names = [one.name for one in self.unknowns]
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
        return tuple(one.name for one in self.unknowns)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest working coordinates."""
        low, high = np.array([one.prior.work_bounds for one in self.unknowns]).T
        return low, high

    @cached_property
    def centre(self) -> Array:
        """Middle of the priors in working coordinates."""
        return np.array([one.prior.work_centre for one in self.unknowns])

    @cached_property
    def spread(self) -> Array:
        """Standard deviations of the priors in working coordinates."""
        return np.array([one.prior.work_spread for one in self.unknowns])

    def values(self, work: Array) -> Array:
        """Values (n, quantities) in SI of working coordinates."""
        return np.column_stack(
            [one.prior.value(work[:, place]) for place, one in enumerate(self.unknowns)]
        )

    def work_of(self, values: Array) -> Array:
        """Working coordinates of values (n, quantities) in SI, those outside the bounds moved to
        them.
        """
        inside = [
            np.clip(values[:, place], one.prior.low, one.prior.high)
            for place, one in enumerate(self.unknowns)
        ]
        return np.column_stack(
            [one.prior.work(inside[place]) for place, one in enumerate(self.unknowns)]
        )

    def from_shares(self, shares: Array) -> Array:
        """Working coordinates of points of the unit cube, over which the prior is even."""
        return np.column_stack(
            [one.prior.from_share(shares[:, place]) for place, one in enumerate(self.unknowns)]
        )

    def log_prior(self, work: Array) -> Array:
        """Logarithm of the prior density (n) over working coordinates."""
        return np.asarray(
            np.sum(
                [one.prior.log_density(work[:, place]) for place, one in enumerate(self.unknowns)],
                axis=0,
            )
        )

    def pulls(self, work: Array) -> Array:
        """What least squares add for the priors, (quantities)."""
        return np.array(
            [float(one.prior.pull(work[place])) for place, one in enumerate(self.unknowns)]
        )

    def at(self, work: Array) -> Points:
        """Evaluate points (n, quantities); those outside the bounds are not computed."""
        prior = self.log_prior(work)
        inside = np.flatnonzero(np.isfinite(prior))
        outcomes: list[Outcome] = [None] * len(work)
        if len(inside):
            for place, outcome in zip(
                inside, self.evaluate(self.values(work[inside])), strict=True
            ):
                outcomes[place] = outcome
        likelihood = np.array([self.log_likelihood(one) for one in outcomes])
        return Points(work, tuple(outcomes), prior, likelihood)

    def residuals(self, outcome: Outcome) -> Array | None:
        """Scaled misses of the used data; None where the point is impossible or a used quantity was
        not computed.
        """
        if outcome is None:
            return None
        computed = np.array([outcome.get(one.key, np.nan) for one in self.used], dtype=float)
        if not np.all(np.isfinite(computed)):
            return None
        return np.array(
            [float(one.residual(value)) for one, value in zip(self.used, computed, strict=True)]
        )

    @cached_property
    def log_peak(self) -> float:
        """Logarithm of the likelihood of computed values that equal all measured ones."""
        return sum(one.log_peak for one in self.used)

    def log_likelihood(self, outcome: Outcome) -> float:
        """Logarithm of the likelihood of the used data; minus infinity where :meth:`residuals` is
        None.
        """
        off = self.residuals(outcome)
        return -np.inf if off is None else self.log_peak - 0.5 * float(off @ off)
