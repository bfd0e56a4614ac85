"""What is known of a quantity before any measurement: a prior density with its source.

Each prior is flat or normal in a working coordinate, the value itself or its logarithm, between
bounds. All methods work there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from valvetrain.errors import InputError

Array = NDArray[np.float64]
Kind = Literal["uniform", "log-uniform", "normal", "lognormal"]
KINDS: tuple[str, ...] = get_args(Kind)
#: Bounds of a normal prior that has none, in standard deviations: what lies beyond has a
#: probability of 1e-15.
FAR = 8.0


@dataclass(frozen=True)
class Prior:
    """Prior density of one quantity (SI).

    ``kind``: ``uniform`` or ``log-uniform`` between ``low`` and ``high``; ``normal`` of mean
    ``centre`` and standard deviation
    ``spread``; ``lognormal`` of median ``centre`` whose logarithm has the standard deviation
    ``spread``. Bounds truncate a normal and a
    lognormal one. ``source``: where it comes from.

    Raises :class:`InputError` for bounds or spreads that make no density.

    >>> wire = Prior("normal", low=3.5e-3, centre=3.8e-3, spread=0.05e-3, source="tolerance of the wire")
    >>> float(wire.from_share(0.5).round(6))
    0.0038
    """

    kind: Kind
    low: float = -math.inf
    high: float = math.inf
    centre: float = math.nan
    spread: float = math.nan
    source: str = ""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(
                f"prior '{str(self.kind)[:40]}' is unknown; use one of {', '.join(KINDS)}"
            )
        if not self.low < self.high:
            raise InputError(
                f"the prior lies between {self.low:g} and {self.high:g}; its low end must lie below its high end"
            )
        if self.flat and not (math.isfinite(self.low) and math.isfinite(self.high)):
            raise InputError(f"a {self.kind} prior needs both bounds; give low and high")
        if not self.flat and not (
            math.isfinite(self.centre) and math.isfinite(self.spread) and self.spread > 0
        ):
            raise InputError(
                f"a {self.kind} prior needs its middle and a positive spread; give both"
            )
        if self.logarithmic and (self.low <= 0 if self.flat else self.centre <= 0):
            raise InputError(f"a {self.kind} prior is of positive values; give positive numbers")
        if not self.flat and not self.low <= self.centre <= self.high:
            raise InputError(
                f"the middle {self.centre:g} of the prior lies outside its bounds {self.low:g} to {self.high:g}; widen them"
            )
        if not self.flat and self.inside <= 0:
            raise InputError("the bounds of the prior leave nothing of it; widen them")

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
        """Value (SI) of a working coordinate, kept within the bounds against rounding."""
        found = np.asarray(work, dtype=float)
        if (
            self.logarithmic
        ):  # one by one, so that the bits of a value do not depend on those beside it
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
        if self.flat:
            return float(self.work(self.low)), float(self.work(self.high))
        middle = float(self.work(self.centre))
        low = (
            -math.inf
            if self.logarithmic and self.low <= 0
            else float(self.work(self.low))
            if math.isfinite(self.low)
            else -math.inf
        )
        high = float(self.work(self.high)) if math.isfinite(self.high) else math.inf
        return max(low, middle - FAR * self.spread), min(high, middle + FAR * self.spread)

    @cached_property
    def inside(self) -> float:
        """Share of the normal density that lies between the bounds."""
        low, high = (
            (bound - float(self.work(self.centre))) / self.spread for bound in self.work_bounds
        )
        return float(ndtr(high) - ndtr(low))

    def from_share(self, share: Array | float) -> Array:
        """Working coordinate below which the prior has the probability ``share``."""
        low, high = self.work_bounds
        if self.flat:
            return np.asarray(low + np.asarray(share) * (high - low))
        begin = ndtr((low - self.work_centre) / self.spread)
        found = self.work_centre + self.spread * ndtri(begin + np.asarray(share) * self.inside)
        return np.asarray(np.clip(found, low, high))

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
        return (
            np.zeros(np.shape(work))
            if self.flat
            else (np.asarray(work, dtype=float) - self.work_centre) / self.spread
        )
