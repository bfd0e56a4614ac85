"""Cycles over the cam angle from samples over time: cut, low-passed, set to zero in the dwell,
outliers named.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.rig.channels import RigQuantity
from valvetrain.rig.shaft import TURN, ShaftAngle

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
        cutoff = (
            self.pass_band + self.stop_band
        ) * self.step  # twice the cut-off, in cycles per sample
        window = np.i0(_BETA * np.sqrt(np.clip(1 - (away / self._half) ** 2, 0, None))) / np.i0(
            _BETA
        )
        kernel: Array = np.where(away <= self._half, cutoff * np.sinc(cutoff * away) * window, 0.0)
        return kernel

    def at(self, values: Array, start: float, times: Array) -> Array:
        """Filtered values at ``times`` (s); ``values`` begin at ``start`` (s). NaN where the kernel
        reaches beyond them or meets NaN.
        """
        flat = np.ravel(times)
        out = np.full(len(flat), np.nan)
        share = max(1, _AT_ONCE // (2 * self._half))
        for first in range(0, len(flat), share):
            out[first : first + share] = self._some(
                values, (flat[first : first + share] - start) / self.step
            )
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


#: Points of a cam turn that are taken where nobody gives a number: the fewest that hold the band.
GRIDS = (360, 720, 1440, 1800, 2400, 3600, 4800, 7200)
#: Share of the sampling rate that a recording tells, so that the filter ends below half of it.
TOLD = 0.4
#: Most values of one channel over all cycles.
MAX_VALUES = 50_000_000
#: A cycle is an outlier where its distance to the median cycle is this many times the usual spread
#: of distances, and this many times
#: the usual distance; with fewer cycles nobody can tell.
FAR, TIMES, FEWEST = 6.0, 2.0, 5
#: Share of the swing of a cycle below which no distance matters.
LEAST = 2e-3


@dataclass(frozen=True, eq=False)
class CycleGrid:
    """Where cycles lie: ``cut_times`` (s), shape (cycles + 1,); ``cam_angle`` (rad of the case),
    shape (angles,); ``times`` (s), both.
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
    """The whole cycles of a shaft within ``span`` (s), where filters that reach ``reach`` (s) to
    either side have what they need.

    ``offset``: cam angle of the case at the mark (rad). Raises :class:`InputError` where no cycle
    is whole.
    """
    first_time, last_time = (
        max(span[0] + reach, shaft.times[0]),
        min(span[1] - reach, shaft.times[-1]),
    )
    if last_time <= first_time:
        raise InputError(
            "the recording is shorter than the filter needs; give a longer one, or keep a wider band",
            "band",
        )
    low, high = shaft.angle_at(np.array([first_time, last_time])) + offset
    first, last = ceil(low / TURN - 1e-9), int(np.floor(high / TURN + 1e-9))
    if last - first < 1:
        turns = (high - low) / TURN
        raise InputError(
            f"the recording holds no whole cycle, only {max(turns, 0):.2f} cam turns; give a longer one"
        )
    if (last - first) * angle_count > MAX_VALUES:
        raise InputError(
            f"{last - first} cycles of {angle_count} angles are more than {MAX_VALUES:.0e} values; take fewer angles",
            "angle_count",
        )
    grid = np.linspace(0.0, TURN, angle_count, endpoint=False)
    starts = TURN * np.arange(first, last + 1)
    cuts = shaft.times_at(starts - offset)
    times = shaft.times_at((starts[:-1, np.newaxis] + grid - offset).ravel()).reshape(
        last - first, angle_count
    )
    return CycleGrid(grid, cuts, times, TURN / np.diff(cuts))


def band_of(
    one: RigQuantity, band: float | None, angle_count: int | None, slowest: float
) -> tuple[LowPass, int, str]:
    """The low-pass of a channel, the points of a cam turn that hold it, and a sentence where the
    band is less than was asked for.

    ``slowest``: lowest speed of the cam (rad/s), at which a given grid of angles holds the lowest
    frequency.
    """
    told = TOLD / one.step
    wanted = min(band or told, told)
    turns = slowest / TURN
    need = 2 * EDGE * wanted / turns
    points = angle_count or next((count for count in GRIDS if count >= need), GRIDS[-1])
    stop = min(points * turns / 2, 0.5 / one.step)
    kept = min(wanted, stop / EDGE)
    note = ""
    if band is not None and kept < 0.999 * band:
        why = (
            f"{points} angles"
            if stop < 0.5 / one.step and kept < told
            else f"a sampling rate of {1 / one.step:.6g} Hz"
        )
        note = f"{one.quantity}: the band is {kept:.4g} Hz, not the {band:.4g} Hz asked for, which {why} cannot hold"
    return LowPass(one.step, kept, kept * EDGE), points, note


def dwell_of(mean_lift: Array, cam_angle: Array) -> tuple[float, float] | None:
    """First and last angle (rad; the last may be beyond one turn) of the longest part in which a
    mean lift rests; None where none does.
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
    step = TURN / count
    begin, length = float(cam_angle[begins[longest]]), lengths[longest] * step
    return begin + 0.15 * length, begin + 0.85 * length


def set_to_zero(
    values: Array, raw: RigQuantity, grid: CycleGrid, edges: Array, level: float
) -> tuple[Array, Array]:
    """Values with the dwell at ``level``, and what was taken off in each dwell; between dwells the
    zero moves along a straight line.

    ``edges``: times (s) at which each dwell begins and ends, shape (dwells, 2); the samples between
    them tell its zero, so that the grid
    of angles does not. Raises :class:`InputError` where no dwell was measured.
    """
    places = np.clip(np.ceil((edges - raw.start) / raw.step).astype(np.int64), 0, len(raw.values))
    found = (
        np.array(
            [
                np.nanmean(raw.values[first:last]) if last - first > 2 else np.nan
                for first, last in places
            ]
        )
        - level
    )
    known = np.isfinite(found)
    if not known.any():
        raise InputError(
            "no cycle was measured in the dwell, or it is shorter than three samples; give another",
            "dwell",
        )
    return values - np.interp(grid.times, edges.mean(axis=1)[known], found[known]), found[known]


def outliers_of(values: Array) -> list[tuple[int, str]]:
    """Cycles (from 0) that differ from all others, each with why; cycles with gaps too."""
    found = [
        (int(place), "was not measured as a whole")
        for place in np.flatnonzero(~np.isfinite(values).all(axis=1))
    ]
    whole = np.isfinite(values).all(axis=1)
    if np.count_nonzero(whole) < FEWEST:
        return found
    middle = np.median(values[whole], axis=0)
    away = np.sqrt(np.mean((values - middle) ** 2, axis=1))
    usual = float(np.median(away[whole]))
    spread = 1.4826 * float(np.median(np.abs(away[whole] - usual)))
    far = np.flatnonzero(
        whole
        & (away > usual + FAR * spread)
        & (away > TIMES * usual)
        & (away > LEAST * np.ptp(middle))
    )
    return found + [
        (
            int(place),
            f"lies {away[place] / max(usual, 1e-300):.3g} times as far from the median cycle as usual",
        )
        for place in far
    ]
