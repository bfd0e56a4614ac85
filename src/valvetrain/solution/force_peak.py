"""Peak of a force over one closed cycle: below a cut-off frequency, as a load cell of that bandwidth
shows it, and of every instant, with how long that lasts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array
from valvetrain.solution.provenance import Provenance

#: Cut-off (Hz) of the peak of a force where a case gives no other: above it, heights rest on contact
#: constants that nobody knows, and on the mesh.
FORCE_BANDWIDTH = 10e3
#: Name of the cut-off (Hz) among the options of a run's provenance.
BANDWIDTH = "force_bandwidth"
#: Order of the Butterworth filter, run forward and backward: 6 dB down at the cutoff, no phase
#: shift.
FILTER_ORDER = 4
#: Least values per period of the cut-off in a filtered force; harmonics that are kept, in cut-offs.
FINENESS, KEPT = 32, 6
#: Share of the raw peak that its height above the filtered force must have to be a spike.
LEAST_SPIKE = 0.01
#: Longest bin (s) over which a force is averaged for its peak.
LONGEST_BIN = 4e-6


def bandwidth_of(provenance: Provenance) -> float:
    """Cut-off (Hz) of the peaks of a run's spring forces."""
    found = provenance.options.get(BANDWIDTH)
    return float(found) if isinstance(found, (int, float)) else FORCE_BANDWIDTH


def band_text(cut_off: float) -> str:
    """``below 10 kHz`` of a cut-off in Hz; ``below the cut-off`` of NaN, where it varies."""
    return f"below {'the cut-off' if math.isnan(cut_off) else f'{cut_off / 1e3:g} kHz'}"


@dataclass(frozen=True, slots=True)
class ForcePeak:
    """Peak (N) of a force ``below`` the cut-off and its ``place``, 0 to 1 of the cycle; ``duration``
    (s) of the raw peak: that of the rectangle of its height above the filtered force and of the
    same impulse; NaN where the raw peak is less than 1 % above.
    """

    below: float
    place: float
    duration: float

    def quantities(self, word: str) -> dict[str, float]:
        """The peak and the duration of the raw one, by the names of docs/quantities.md; ``word``:
        ``spring_force``.
        """
        found = {f"peak_{word}": self.below}
        return (
            found
            if math.isnan(self.duration)
            else found | {f"raw_peak_{word}_duration": self.duration}
        )


def force_peak(
    values: Array, interval: float, cutoff: float, raw: float, place: float, averaged: int = 1
) -> ForcePeak:
    """Peak of one closed cycle of a force; where its record is too coarse to hold anything above the
    cut-off, that of every instant.

    ``values`` (n,) N at even times, ``interval`` (s) apart, the first follows the last; ``averaged``:
    count of even instants from each time on of which a value is the mean. ``cutoff`` in Hz. ``raw`` peak (N) of every
    instant at ``place``, 0 to 1 of the cycle. A cycle that does not repeat has a jump where its ends meet,
    which the filter smooths and lets ring by a tenth of it.
    """
    if len(values) < 3 or not cutoff < 0.5 / interval:
        return ForcePeak(raw, place % 1.0, math.nan)
    smooth = filtered_cycle(values, interval, cutoff, averaged)
    below, top = _top(smooth)
    count, shift = len(values), (averaged - 1) / (2 * averaged)
    around = np.append(smooth, smooth[0])
    grid = np.arange(len(around)) / len(smooth)
    height = raw - float(np.interp(place % 1.0, grid, around))
    if not height > LEAST_SPIKE * abs(raw):
        return ForcePeak(below, top, math.nan)
    above = values - np.interp((np.arange(count) + shift) / count, grid, around)
    here = round(place % 1.0 * count - shift) % count
    turned = np.roll(above, count // 2 - here)
    ends = np.flatnonzero(turned <= 0)
    split = int(np.searchsorted(ends, count // 2))
    first = int(ends[split - 1]) + 1 if split else 0
    last = int(ends[split]) if split < len(ends) else count
    impulse = float(np.sum(turned[first:last])) * interval
    lasted = impulse / height if impulse > 0 else math.nan
    return ForcePeak(below, top, lasted)


def _top(values: Array) -> tuple[float, float]:
    """Largest value of a closed cycle and its place, 0 to 1: the top of the parabola there."""
    top, count = int(np.argmax(values)), len(values)
    before, here, after = (float(values[(top + step) % count]) for step in (-1, 0, 1))
    bend = before - 2 * here + after
    if not bend < 0:
        return here, top / count
    moved = (before - after) / (2 * bend)
    return here - bend * moved**2 / 2, (top + moved) / count % 1.0


def filtered_cycle(values: Array, interval: float, cutoff: float, averaged: int = 1) -> Array:
    """One closed cycle of a force (n,) below ``cutoff`` (Hz), 6 dB down there, at even places of its
    own count, a power of 2; see :func:`force_peak`.
    """
    count, period = len(values), len(values) * interval
    spectrum = np.fft.rfft(values)[: int(KEPT * cutoff * period) + 1] / count
    order = np.arange(len(spectrum))
    if 2 * order[-1] == count:
        spectrum[-1] /= 2
    frequency = order / period
    gain = 1.0 / (1.0 + (frequency / cutoff) ** (2 * FILTER_ORDER))
    # A mean weakens a harmonic, and stands in the middle of its instants.
    turn = np.pi * order / count
    weakened = np.ones(len(order))
    weakened[1:] = np.sin(turn[1:]) / (averaged * np.sin(turn[1:] / averaged))
    spectrum = spectrum / weakened * np.exp(-1j * turn * (1 - 1 / averaged))
    least = max(2 * len(spectrum), FINENESS * cutoff * period)
    fine = 2 ** math.ceil(math.log2(least))
    return np.asarray(np.fft.irfft(spectrum * gain, fine) * fine)


def steps_per_bin(steps: int, time_step: float) -> int:
    """Steps averaged for a peak: the most that divide a cycle of ``steps`` and last no longer than
    :data:`LONGEST_BIN`.
    """
    most = max(1, int(LONGEST_BIN / time_step))
    return next(size for size in range(most, 0, -1) if steps % size == 0)
