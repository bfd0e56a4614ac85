"""Samples over time to values at any times: one symmetrical low-pass that filters and resamples at once, so nothing is shifted or folded.

The filter is a sinc under a Kaiser window (J. F. Kaiser, "Nonrecursive digital filter design using the I0-sinh window function", IEEE
Symposium on Circuits and Systems 1974): flat below ``pass_band``, 80 dB down above ``stop_band``. It reaches over a few samples only, so a
result does not depend on how long the recording is or in what pieces it was stored.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Attenuation (dB) beyond the stop band, and the window's parameter for it (Kaiser's formula).
ATTENUATION = 80.0
_BETA = 0.1102 * (ATTENUATION - 8.7)
#: Ratio of the stop band to the pass band where nothing else decides.
EDGE = 1.25
#: Places of the kernel that are tabulated per sample, and products made at once.
_PLACES, _AT_ONCE = 1024, 2_000_000


@dataclass(frozen=True)
class LowPass:
    """The filter for samples every ``step`` s; bands in Hz.

    >>> filter_ = LowPass(1e-5, 8e3, 10e3)
    >>> times = np.arange(2000) * 1e-5
    >>> tone = np.sin(2 * np.pi * 500 * times)
    >>> found = filter_.at(tone, 0.0, np.array([7.123e-3]))
    >>> bool(abs(found[0] - np.sin(2 * np.pi * 500 * 7.123e-3)) < 1e-4)
    True
    """

    step: float
    pass_band: float
    stop_band: float

    @property
    def reach(self) -> float:
        """Half length of the kernel (s): nearer to an end of the recording there is no value."""
        return self._half * self.step

    @cached_property
    def _half(self) -> int:
        """Half length (samples), by Kaiser's estimate of the order."""
        width = 2 * np.pi * (self.stop_band - self.pass_band) * self.step
        return max(4, int(np.ceil((ATTENUATION - 7.95) / (2.285 * width) / 2)))

    @cached_property
    def _kernel(self) -> Array:
        """The kernel on a fine grid from its middle to its end."""
        away = np.arange(self._half * _PLACES + 2) / _PLACES
        cutoff = (self.pass_band + self.stop_band) * self.step  # twice the cut-off, in cycles per sample
        window = np.i0(_BETA * np.sqrt(np.clip(1 - (away / self._half) ** 2, 0, None))) / np.i0(_BETA)
        kernel: Array = np.where(away <= self._half, cutoff * np.sinc(cutoff * away) * window, 0.0)
        return kernel

    def at(self, values: Array, start: float, times: Array) -> Array:
        """Filtered values at ``times`` (s); ``values`` begin at ``start`` (s). NaN where the kernel reaches beyond them or meets NaN."""
        flat = np.ravel(times)
        out = np.full(len(flat), np.nan)
        share = max(1, _AT_ONCE // (2 * self._half))
        for first in range(0, len(flat), share):
            out[first : first + share] = self._some(values, (flat[first : first + share] - start) / self.step)
        return out.reshape(np.shape(times))

    def _some(self, values: Array, places: Array) -> Array:
        nearest = np.floor(places).astype(np.int64)
        inside = (nearest >= self._half - 1) & (nearest < len(values) - self._half)
        taps = np.arange(1 - self._half, self._half + 1)
        index = np.where(inside, nearest, self._half - 1)[:, np.newaxis] + taps
        away = np.abs(index - np.where(inside, places, self._half - 1)[:, np.newaxis]) * _PLACES
        low = np.minimum(away.astype(np.int64), len(self._kernel) - 2)
        weights = self._kernel[low] + (away - low) * (self._kernel[low + 1] - self._kernel[low])
        if len(values) < 2 * self._half:
            return np.full(len(places), np.nan)
        summed: Array = np.sum(weights * values[index], axis=1) / np.sum(weights, axis=1)
        return np.where(inside, summed, np.nan)
