"""Cuts samples over time into cycles over the cam angle: low-pass, zero in the dwell, outliers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.stations import runs_of
from valvetrain.rig.channels import RigQuantity
from valvetrain.rig.shaft import REVOLUTION, ShaftAngle

#: Attenuation (dB) beyond the stop band, and the window's parameter for it (Kaiser's formula).
ATTENUATION = 80.0
_BETA = 0.1102 * (ATTENUATION - 8.7)
#: Ratio of the stop band to the pass band where nothing else decides.
EDGE = 1.25
#: Points of the kernel that are tabulated per sample, and products computed at once.
_POINTS, _AT_ONCE = 1024, 2_000_000
#: Points per cam revolution where none are specified: the fewest that hold the band.
GRIDS = (360, 720, 1440, 1800, 2400, 3600, 4800, 7200)
#: Share of the sampling rate that is used, so that the filter ends below half of it.
USED_BAND = 0.4
#: Values of one channel over all cycles, at most.
MAX_VALUES = 10_000_000
#: A cycle is an outlier where its distance to the median cycle exceeds the median distance by
#: SPREADS times the spread of distances, is MULTIPLE times the median distance and more than
#: MIN_SHARE of the swing of a cycle; of fewer than MIN_CYCLES none can be identified.
SPREADS, MULTIPLE, MIN_SHARE, MIN_CYCLES = 6.0, 2.0, 2e-3, 5
#: Samples that a clipped channel stays at its end; steps of the converter by which it comes there; samples that show a step.
CLIPPED, CLIP_STEPS, CLIP_SAMPLES = 4, 3.0, 200_000
#: Standard errors by which a trend over the cycles is one.
TREND = 4.0


@dataclass(frozen=True)
class LowPass:
    """Low-pass without phase, evaluated at any time, for samples every ``step`` s; bands in Hz.

    >>> filter_ = LowPass(1e-5, 8e3, 10e3)
    >>> times = np.arange(2000) * 1e-5
    >>> tone = np.sin(2 * np.pi * 500 * times)
    >>> filtered = filter_.at(tone, 0.0, np.array([7.123e-3]))
    >>> bool(abs(filtered[0] - np.sin(2 * np.pi * 500 * 7.123e-3)) < 1e-4)
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
        away = np.arange(self._half * _POINTS + 2) / _POINTS
        cutoff = (
            self.pass_band + self.stop_band
        ) * self.step  # twice the cut-off, in cycles per sample
        window = np.i0(_BETA * np.sqrt(np.clip(1 - (away / self._half) ** 2, 0, None))) / np.i0(
            _BETA
        )
        return np.where(away <= self._half, cutoff * np.sinc(cutoff * away) * window, 0.0)

    def at(self, values: Array, start: float, times: Array) -> Array:
        """Filtered values at ``times`` (s); ``values`` begin at ``start`` (s). NaN where the kernel
        reaches beyond them or meets NaN.
        """
        half, kernel = self._half, self._kernel
        flat = np.ravel(times)
        out = np.full(len(flat), np.nan)
        if len(values) < 2 * half:
            return out.reshape(np.shape(times))
        taps = np.arange(1 - half, half + 1)
        count = max(1, _AT_ONCE // (2 * half))
        for first in range(0, len(flat), count):
            position = (flat[first : first + count] - start) / self.step
            nearest = np.floor(position).astype(np.int64)
            inside = (nearest >= half - 1) & (nearest < len(values) - half)
            index = np.where(inside, nearest, half - 1)[:, np.newaxis] + taps
            away = np.abs(index - np.where(inside, position, half - 1)[:, np.newaxis]) * _POINTS
            low = np.minimum(away.astype(np.int64), len(kernel) - 2)
            weights = kernel[low] + (away - low) * (kernel[low + 1] - kernel[low])
            filtered = np.sum(weights * values[index], axis=1) / np.sum(weights, axis=1)
            out[first : first + count] = np.where(inside, filtered, np.nan)
        return out.reshape(np.shape(times))


class CycleGrid(NamedTuple):
    """Times of the cycles: ``cut_times`` (s), shape (cycles + 1,); ``cam_angle`` (rad of the case),
    shape (angles,); ``times`` (s), both; ``cam_speeds`` (rad/s), shape (cycles,).
    """

    cam_angle: Array
    cut_times: Array
    times: Array
    cam_speeds: Array

    @property
    def cycles(self) -> int:
        """Whole cycles."""
        return len(self.cut_times) - 1


def grid_of(
    shaft: ShaftAngle, angle_count: int, offset: float, reach: float, span: tuple[float, float]
) -> CycleGrid:
    """The whole cycles of a shaft within ``span`` (s) that filters with a half length of ``reach``
    (s) can compute.

    ``offset``: cam angle of the case at the mark (rad). Raises :class:`InputError` where no cycle
    is whole.
    """
    first_time = max(span[0] + reach, shaft.times[0])
    last_time = min(span[1] - reach, shaft.times[-1])
    if last_time <= first_time:
        raise InputError(
            "the recording is shorter than the filter needs; give a longer one, or a wider band",
            "band",
        )
    low, high = shaft.angle_at(np.array([first_time, last_time])) + offset
    first, last = ceil(low / REVOLUTION - 1e-9), int(np.floor(high / REVOLUTION + 1e-9))
    if last - first < 1:
        revolutions = max((high - low) / REVOLUTION, 0)
        raise InputError(
            f"the recording holds no whole cycle, only {revolutions:.2f} cam revolutions; give a longer one"
        )
    if (last - first) * angle_count > MAX_VALUES:
        raise InputError(
            f"{last - first} cycles of {angle_count} angles are more than {MAX_VALUES:.0e} values; take fewer angles",
            "angle_count",
        )
    grid = np.linspace(0.0, REVOLUTION, angle_count, endpoint=False)
    starts = REVOLUTION * np.arange(first, last + 1)
    cuts = shaft.times_at(starts - offset)
    times = shaft.times_at((starts[:-1, np.newaxis] + grid - offset).ravel()).reshape(
        last - first, angle_count
    )
    return CycleGrid(grid, cuts, times, REVOLUTION / np.diff(cuts))


def band_of(
    measured: RigQuantity, band: float | None, angle_count: int | None, min_cam_speed: float
) -> tuple[LowPass, int, str]:
    """The low-pass of a channel, the points per cam revolution that hold its band, and a sentence
    where the band is less than requested.

    ``min_cam_speed`` (rad/s): where a given grid of angles holds the lowest frequency.
    """
    highest = USED_BAND / measured.step
    requested = min(band or highest, highest)
    rate = min_cam_speed / REVOLUTION
    need = 2 * EDGE * requested / rate
    points = angle_count or next((count for count in GRIDS if count >= need), GRIDS[-1])
    stop = min(points * rate / 2, 0.5 / measured.step)
    pass_band = min(requested, stop / EDGE)
    note = ""
    if band is not None and pass_band < 0.999 * band:
        by_grid = stop < 0.5 / measured.step and pass_band < highest
        why = f"{points} angles" if by_grid else f"a sampling rate of {1 / measured.step:.6g} Hz"
        note = f"{measured.quantity}: the band is {pass_band:.4g} Hz, not the requested {band:.4g} Hz, which {why} cannot hold"
    return LowPass(measured.step, pass_band, pass_band * EDGE), points, note


def dwell_of(mean_lift: Array, cam_angle: Array) -> tuple[float, float] | None:
    """First and last angle (rad; the last may be beyond one revolution) of the longest part in
    which a mean lift rests; None where none does.
    """
    low, high = float(np.nanpercentile(mean_lift, 2)), float(np.nanmax(mean_lift))
    resting = mean_lift < low + 0.02 * (high - low)
    if resting.all() or not resting.any():
        return None
    count = len(mean_lift)
    begins = np.flatnonzero(resting & ~np.roll(resting, 1))
    lengths = [int(np.argmin(np.append(np.roll(resting, -begin), False))) for begin in begins]
    longest = int(np.argmax(lengths))
    if lengths[longest] < count / 18:
        return None
    step = REVOLUTION / count
    begin, length = float(cam_angle[begins[longest]]), lengths[longest] * step
    return begin + 0.15 * length, begin + 0.85 * length


def set_to_zero(
    values: Array, raw: RigQuantity, grid: CycleGrid, edges: Array, level: float
) -> tuple[Array, Array]:
    """Values with the dwell at ``level``, and the zero taken off in each dwell; between dwells the
    zero moves along a straight line.

    ``edges``: times (s) at which each dwell begins and ends, shape (dwells, 2); the zero is the
    mean of the samples between them, whatever the grid of angles. Raises :class:`InputError` where
    no dwell was measured.
    """
    samples = np.clip(np.ceil((edges - raw.start) / raw.step).astype(np.int64), 0, len(raw.values))
    zeros = [
        np.nanmean(raw.values[first:last]) if last - first > 2 else np.nan
        for first, last in samples
    ]
    zero = np.array(zeros) - level
    measured = np.isfinite(zero)
    if not measured.any():
        raise InputError(
            "no cycle was measured in the dwell, or it is shorter than three samples; give another",
            "dwell",
        )
    zero = zero[measured]
    return values - np.interp(grid.times, edges.mean(axis=1)[measured], zero), zero


def outliers_of(values: Array) -> list[tuple[int, str]]:
    """Cycles (from 0) that differ from all others, each with the reason; cycles with gaps too."""
    whole = np.isfinite(values).all(axis=1)
    outliers = [(int(cycle), "was not measured as a whole") for cycle in np.flatnonzero(~whole)]
    if np.count_nonzero(whole) < MIN_CYCLES:
        return outliers
    median = np.median(values[whole], axis=0)
    away = np.sqrt(np.mean((values - median) ** 2, axis=1))
    typical = float(np.median(away[whole]))
    spread = 1.4826 * float(np.median(np.abs(away[whole] - typical)))
    far = (
        whole
        & (away > typical + SPREADS * spread)
        & (away > MULTIPLE * typical)
        & (away > MIN_SHARE * np.ptp(median))
    )
    return outliers + [
        (
            int(cycle),
            f"is {away[cycle] / max(typical, 1e-300):.3g} times as far from the median cycle as a typical one",
        )
        for cycle in np.flatnonzero(far)
    ]


def drift_of(values: Array) -> float:
    """Change of the mean of a cycle from the first to the last by a straight line; 0 where it is no trend.

    ``values`` (cycles, angles) of one channel, in its unit.

    >>> bool(abs(drift_of(np.arange(8.0)[:, np.newaxis] + np.zeros((8, 4))) - 7.0) < 1e-9), drift_of(np.zeros((3, 4)))
    (True, 0.0)
    """
    means = values.mean(axis=1)
    count = len(means)
    if count < MIN_CYCLES:
        return 0.0
    line, covariance = np.polyfit(np.arange(count), means, 1, cov=True)
    return float(line[0]) * (count - 1) if abs(line[0]) > TREND * np.sqrt(covariance[0, 0]) else 0.0


def is_clipped(values: Array) -> bool:
    """Whether samples stay at their largest or least value while the signal comes and goes by steps, as at the end of a range.

    >>> wave = np.sin(np.arange(4000) / 50.0)
    >>> is_clipped(wave), is_clipped(np.minimum(wave, 0.9))
    (False, True)
    """
    return any(_stays_at_top(sign * values[np.isfinite(values)]) for sign in (1.0, -1.0))


def _stays_at_top(values: Array) -> bool:
    if len(values) < CLIPPED or not np.ptp(values) > 0:
        return False
    begins, ends = runs_of(values == values.max()).T
    long = (ends - begins >= CLIPPED) & (begins > 0)
    if not long.any():
        return False
    # a peak that rests on one step of the converter is left by one step, a cut one by several
    steps = np.diff(np.unique(values[:CLIP_SAMPLES]))
    left = values.max() - values[begins[long] - 1]
    return bool(np.median(left) > CLIP_STEPS * np.min(steps, initial=np.inf))
