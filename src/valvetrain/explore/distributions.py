"""Distributions of one quantity: flat or normal between bounds, or a list of values.

A distribution is flat or normal in a working coordinate, the value itself or its logarithm, between
bounds. Studies read it as a scatter or a range, identifications as a prior.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.units import Given, numbers_of

Kind = Literal["uniform", "log-uniform", "normal", "lognormal"]
KINDS: tuple[str, ...] = get_args(Kind)
#: A tolerance is this many standard deviations by default, as shops draw their limits.
SIGMAS = 3.0
#: Bounds of a normal distribution that has none, in standard deviations: values beyond have a
#: probability of 1e-15.
FAR = 8.0


@dataclass(frozen=True)
class Prior:
    """Distribution of one quantity (SI): its scatter, its range, or its prior before any
    measurement.

    ``kind``: ``uniform`` or ``log-uniform`` between ``low`` and ``high``; ``normal`` of mean
    ``centre`` and standard deviation ``spread``; ``lognormal`` of median ``centre`` whose logarithm
    has the standard deviation ``spread``. Bounds truncate a normal and a lognormal one. ``source``:
    where it comes from. ``dimension``: that of the units it was given in, None for SI numbers; a case
    must agree. Raises :class:`InputError` for bounds or spreads that make no density.

    >>> wire = Prior("normal", low=3.5e-3, centre=3.8e-3, spread=0.05e-3, source="tolerance of the wire")
    >>> float(wire.at(0.5).round(6))
    0.0038
    """

    kind: Kind
    low: float = -math.inf
    high: float = math.inf
    centre: float = math.nan
    spread: float = math.nan
    source: str = ""
    dimension: str | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(
                f"distribution '{str(self.kind)[:40]}' is unknown; use one of {', '.join(KINDS)}"
            )
        if not self.low < self.high:
            raise InputError(
                f"low ({self.low:g}) is not below high ({self.high:g}); correct the bounds"
            )
        needed = (self.low, self.high) if self.flat else (self.centre, self.spread)
        if not all(map(math.isfinite, needed)) or self.spread <= 0:
            words = "two finite bounds" if self.flat else "a finite middle and a positive spread"
            raise InputError(f"a {self.kind} distribution needs {words}; give both")
        if self.logarithmic and needed[0] <= 0:
            raise InputError(
                f"a {self.kind} distribution is of positive values; give positive numbers"
            )
        if not self.flat and not (self.low <= self.centre <= self.high and self.inside > 0):
            raise InputError(
                f"the middle {self.centre:g} is outside the bounds {self.low:g} to {self.high:g}; widen them"
            )

    @property
    def flat(self) -> bool:
        """Whether no value between the bounds is likelier than another, in the working coordinate."""
        return self.kind in ("uniform", "log-uniform")

    @property
    def logarithmic(self) -> bool:
        """Whether the working coordinate is the logarithm of the value."""
        return self.kind in ("log-uniform", "lognormal")

    def work(self, value: Array | float) -> Array:
        """Working coordinate of a value (SI)."""
        return np.log(value) if self.logarithmic else np.asarray(value, dtype=float)

    def value(self, work: Array | float) -> Array:
        """Value (SI) of a working coordinate, clipped to the bounds against rounding."""
        found = np.asarray(work, dtype=float)
        if self.logarithmic:  # one by one: the bits of a value do not depend on its neighbours
            found = np.array([math.exp(one) for one in found.ravel()]).reshape(found.shape)
        return np.asarray(np.clip(found, self.low, self.high))

    @cached_property
    def work_centre(self) -> float:
        """Middle of the prior in the working coordinate."""
        return 0.5 * sum(self.work_bounds) if self.flat else float(self.work(self.centre))

    @cached_property
    def work_spread(self) -> float:
        """Standard deviation of the prior in the working coordinate, that of the normal one before
        its bounds truncate it.
        """
        low, high = self.work_bounds
        return (high - low) / math.sqrt(12.0) if self.flat else self.spread

    @cached_property
    def work_bounds(self) -> tuple[float, float]:
        """Lowest and highest working coordinate; where a normal one has no bound, :data:`FAR`
        deviations away.
        """
        low, high = (
            -math.inf if self.logarithmic and bound <= 0 else float(self.work(bound))
            for bound in (self.low, self.high)
        )
        if self.flat:
            return low, high
        middle, reach = float(self.work(self.centre)), FAR * self.spread
        return max(low, middle - reach), min(high, middle + reach)

    @cached_property
    def inside(self) -> float:
        """Share of the normal density between the bounds."""
        low, high = (
            (bound - float(self.work(self.centre))) / self.spread for bound in self.work_bounds
        )
        return float(ndtr(high) - ndtr(low))

    def at(self, share: ArrayLike) -> Array:
        """Values (SI) below which ``share`` (0 to 1) of all are, in the shape of ``share``."""
        return self.value(self.from_share(np.asarray(share, dtype=float)))

    def levels(self, count: int) -> tuple[float, ...]:
        """``count`` values (SI) that a grid steps through: evenly spaced with both ends, of a
        normal one the middles of parts of equal probability.
        """
        if count == 1:
            return (self.middle,)
        shares = np.linspace(0.0, 1.0, count) if self.flat else (np.arange(count) + 0.5) / count
        if self.kind == "uniform":
            return tuple(np.linspace(self.low, self.high, count).tolist())
        return tuple(self.at(shares).tolist())

    @property
    def middle(self) -> float:
        """Median (SI)."""
        return float(self.at(0.5))

    def from_share(self, share: Array | float) -> Array:
        """Working coordinate below which the prior has the probability ``share``."""
        low, high = self.work_bounds
        if self.flat:
            return np.asarray(low + np.asarray(share) * (high - low))
        begin = ndtr((low - self.work_centre) / self.spread)
        scores = ndtri(begin + np.asarray(share) * self.inside)
        return np.asarray(np.clip(self.work_centre + self.spread * scores, low, high))

    def share(self, work: Array | float) -> Array:
        """Probability of the prior below a working coordinate."""
        low, high = self.work_bounds
        at = np.clip(work, low, high)
        if self.flat:
            return np.asarray((at - low) / (high - low))
        begin = ndtr((low - self.work_centre) / self.spread)
        return np.asarray(
            np.clip((ndtr((at - self.work_centre) / self.spread) - begin) / self.inside, 0.0, 1.0)
        )

    def share_of(self, value: float) -> float:
        """Probability of the prior below a value (SI), nan of one beyond the bounds."""
        return float(self.share(self.work(value))) if self.low <= value <= self.high else math.nan

    def log_density(self, work: Array | float) -> Array:
        """Logarithm of the density over the working coordinate; minus infinity beyond the bounds."""
        low, high = self.work_bounds
        at = np.asarray(work, dtype=float)
        outside = (at < low) | (at > high)
        if self.flat:
            return np.where(outside, -np.inf, -math.log(high - low))
        normal = -0.5 * ((at - self.work_centre) / self.spread) ** 2 - math.log(
            self.spread * math.sqrt(2 * math.pi) * self.inside
        )
        return np.where(outside, -np.inf, normal)

    def pull(self, work: Array | float) -> Array:
        """What least squares add for the prior: distance from its middle in standard deviations,
        zero of a flat one.
        """
        off = np.asarray(work, dtype=float) - self.work_centre
        return np.zeros(off.shape) if self.flat else off / self.spread


def Uniform(low: Given, high: Given) -> Prior:
    """Every value from ``low`` to ``high`` alike; SI, or text with a unit, as of all distributions.

    Parameters
    ----------
    low, high : smallest and largest value: SI, text with a unit, or a pint quantity

    Returns
    -------
    Prior

    Raises
    ------
    InputError : numbers that make no distribution, a unit that is not known

    Examples
    --------
    >>> Uniform(1.0, 3.0).levels(3)
    (1.0, 2.0, 3.0)
    """
    (least, largest), dimension = numbers_of(low, high)
    return Prior("uniform", least, largest, dimension=dimension)


def Normal(
    mean: Given, standard_deviation: Given, low: Given = -math.inf, high: Given = math.inf
) -> Prior:
    """Gauss about ``mean`` with ``standard_deviation``, truncated at ``low`` and ``high``.

    Parameters
    ----------
    mean, standard_deviation : SI, text with a unit, or a pint quantity
    low, high : bounds, likewise

    Returns
    -------
    Prior

    Raises
    ------
    InputError : numbers that make no distribution, a unit that is not known

    Examples
    --------
    >>> round(float(Normal(10.0, 1.0).at(0.975)), 3)
    11.96
    """
    (least, largest, middle, spread), dimension = numbers_of(low, high, mean, standard_deviation)
    return Prior("normal", least, largest, middle, spread, dimension=dimension)


def LogNormal(median: Given, factor: float) -> Prior:
    """The logarithm is normal: half of all values are below ``median``, two thirds within a factor
    of ``factor`` about it.

    Parameters
    ----------
    median : SI, text with a unit, or a pint quantity
    factor : above 1

    Returns
    -------
    Prior

    Raises
    ------
    InputError : numbers that make no distribution, a unit that is not known

    Examples
    --------
    >>> round(float(LogNormal(2.0, 1.5).at(0.5)), 6)
    2.0
    """
    if not (math.isfinite(factor) and factor > 1):
        raise InputError("a lognormal distribution has a finite factor above 1; correct it")
    (middle,), dimension = numbers_of(median)
    return Prior("lognormal", centre=middle, spread=math.log(factor), dimension=dimension)


@dataclass(frozen=True)
class Values:
    """One of ``values`` (SI, text with units or pint quantities), each as likely as the others; a
    grid steps through them in their order.

    >>> Values((1.0, 2.0, 4.0)).at([0.1, 0.9]).tolist()
    [1.0, 4.0]
    """

    values: tuple[float, ...]
    dimension: str | None = field(default=None, compare=False, repr=False)
    kind = "values"

    if TYPE_CHECKING:  # arguments may have other types than the fields

        def __init__(self, values: Sequence[Given], dimension: str | None = None) -> None: ...

    def __post_init__(self) -> None:
        values, dimension = numbers_of(*self.values, dimension=self.dimension)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "dimension", dimension)
        if not self.values or not np.all(np.isfinite(self.values)):
            raise InputError(
                "a list of values holds at least one, and finite numbers only; correct it"
            )

    def at(self, share: ArrayLike) -> Array:
        """Values (SI) at ``share`` (0 to 1), each over an equal part."""
        index = np.minimum(
            (np.asarray(share, dtype=float) * len(self.values)).astype(int), len(self.values) - 1
        )
        return np.asarray(np.asarray(self.values)[index])

    def share_of(self, value: float) -> float:
        """The middle of the part of a value, nan of one that is not listed."""
        here = value in self.values
        return (self.values.index(value) + 0.5) / len(self.values) if here else math.nan

    def levels(self, count: int) -> tuple[float, ...]:
        """The values themselves."""
        return self.values

    @property
    def middle(self) -> float:
        """The value in the middle of the list."""
        return self.values[len(self.values) // 2]


Distribution = Prior | Values
