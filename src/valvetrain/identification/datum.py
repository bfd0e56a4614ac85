"""One measured number and how far it may lie from the true one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln, ndtr, stdtr

from valvetrain.errors import InputError

Array = NDArray[np.float64]
Law = Literal["normal", "student"]


@dataclass(frozen=True, slots=True)
class Datum:
    """A measured ``value`` (SI) of what the computation calls ``key``, with the standard deviation
    ``scatter`` (SI) of its errors.

    ``measurement``: the entry of the file that it belongs to, such as a curve of many data. ``law``
    of the errors: ``normal``, or
    ``student`` with ``freedom`` degrees, of which outliers are part. ``used``: whether it is
    fitted, else it is only compared. ``unit`` it
    is shown in. Raises :class:`InputError` for a scatter that is not positive.

    >>> Datum("preload", 289.0, 1.5).deviation(292.0)
    np.float64(2.0)
    """

    key: str
    value: float
    scatter: float
    measurement: str = ""
    law: Law = "normal"
    freedom: float = 4.0
    used: bool = True
    source: str = ""
    unit: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.value) and math.isfinite(self.scatter) and self.scatter > 0):
            raise InputError(
                f"measurement '{self.name[:60]}' needs a finite value and a positive scatter"
            )
        if self.law not in ("normal", "student") or not self.freedom > 0:
            raise InputError(
                f"the errors of '{self.name[:60]}' are normal, or student with positive freedom; it says '{str(self.law)[:40]}'"
            )

    @property
    def name(self) -> str:
        """The measurement, or the key where it has no name."""
        return self.measurement or self.key

    def deviation(self, computed: Array | float) -> Array:
        """Computed less measured in units of the scatter."""
        return (np.asarray(computed, dtype=float) - self.value) / self.scatter

    def residual(self, computed: Array | float) -> Array:
        """Signed number whose square is minus twice the log likelihood above its peak: the
        deviation where errors are normal.
        """
        off = self.deviation(computed)
        if self.law == "normal":
            return off
        return np.sign(off) * np.sqrt((self.freedom + 1) * np.log1p(off**2 / self.freedom))

    @property
    def log_peak(self) -> float:
        """Logarithm of the likelihood where computed and measured agree."""
        if self.law == "normal":
            return -math.log(self.scatter * math.sqrt(2 * math.pi))
        half = 0.5 * self.freedom
        return float(
            gammaln(half + 0.5)
            - gammaln(half)
            - 0.5 * math.log(self.freedom * math.pi)
            - math.log(self.scatter)
        )

    def percentile(self, computed: Array, weights: Array) -> float:
        """Where the measured value lies in its own prediction, 0 to 100: over the draws
        ``computed`` with ``weights`` and its errors.
        """
        known = np.isfinite(computed)
        if not known.any() or weights[known].sum() <= 0:
            return math.nan
        below = -self.deviation(computed[known])
        share = ndtr(below) if self.law == "normal" else stdtr(self.freedom, below)
        return float(100.0 * np.average(share, weights=weights[known]))
