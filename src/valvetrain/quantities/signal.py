"""Forces in a stated bandwidth by a zero-phase low-pass, and peaks of sampled periodic signals."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.quantities.cycle import is_closed
from valvetrain.solution.force_peak import FILTER_ORDER
from valvetrain.solution.result import Solution
from valvetrain.solution.study import LiftEvent


def low_pass(time: Array, values: Array, cutoff_frequency: float, closed: bool = False) -> Array:
    """Zero-phase low-pass of evenly sampled ``values``; cutoff in Hz, 6 dB down there; ``closed``:
    they are one whole period.

    Raises :class:`InputError` when the samples are uneven or too far apart for the cutoff.
    """
    steps = np.diff(time)
    if len(steps) < 2 or np.ptp(steps) > 1e-6 * float(np.mean(steps)) + 1e-15:
        raise InputError(
            "a zero-phase filter needs evenly spaced samples; set a constant output step"
        )
    nyquist = 0.5 / float(np.mean(steps))
    if cutoff_frequency >= nyquist:
        needed = f"{cutoff_frequency / 1e3:g} kHz needs samples closer than {0.5e6 / cutoff_frequency:.3g} us"
        raise InputError(f"a bandwidth of {needed}; refine the output step")
    # Forward and backward runs of the digital filter multiply the spectrum by the square of its
    # gain. The mirrored
    # pads are longer than its memory, so that the ends do not see each other. (scipy.signal would
    # cost half a second to load.)
    pad = 0 if closed else min(len(values) - 1, int(np.ceil(20 * nyquist / cutoff_frequency)))
    padded = (
        np.concatenate(
            [2 * values[0] - values[pad:0:-1], values, 2 * values[-1] - values[-2 : -pad - 2 : -1]]
        )
        if pad
        else values
    )
    warped = np.tan(np.pi / 2 * np.fft.rfftfreq(len(padded), 0.5)) / np.tan(
        np.pi / 2 * cutoff_frequency / nyquist
    )
    return np.fft.irfft(np.fft.rfft(padded) / (1.0 + warped ** (2 * FILTER_ORDER)), len(padded))[
        pad : pad + len(values)
    ]


def filtered_force(
    solution: Solution, cutoff_frequency: float, channel: str = "seat_force"
) -> Array | None:
    """A force channel (sample,) below ``cutoff_frequency`` (Hz); None when the run is sampled too
    coarsely or unevenly for it.

    Where the run holds substeps (``<channel>_fine``) these are filtered, and each sample gets the
    largest value of its interval.
    """
    try:
        if solution.has(f"{channel}_fine"):
            # the last sample has no substeps after it; its row repeats the end value and takes no part
            fine = solution.channel(f"{channel}_fine")
            interval = float(solution.time[1] - solution.time[0]) / fine.shape[1]
            series = fine[:-1].ravel()
            filtered = low_pass(interval * np.arange(len(series)), series, cutoff_frequency)
            rows = filtered.reshape(-1, fine.shape[1])
            return np.append(rows.max(axis=1), rows[-1, -1])
        return low_pass(
            solution.time, solution.channel(channel), cutoff_frequency, is_closed(solution)
        )
    except InputError:
        return None


def fine_series(
    solution: Solution, channel: str = "seat_force", record: str = "fine"
) -> tuple[Array, Array, Array]:
    """Time (s), cam angle (rad, unwrapped) and values of a channel between its samples, from its
    ``record`` "fine" or "finest"; the samples themselves where the run has none.
    """
    if not solution.has(f"{channel}_{record}"):
        return solution.time, solution.cam_angle, solution.channel(channel)
    fine = solution.channel(f"{channel}_{record}")[:-1]
    share = np.arange(fine.shape[1]) / fine.shape[1]
    time, angle = (
        values[:-1, None] + np.diff(values)[:, None] * share
        for values in (solution.time, solution.cam_angle)
    )
    return time.ravel(), angle.ravel(), fine.ravel()


def extreme_series(solution: Solution, channel: str, kind: str) -> tuple[Array, Array]:
    """Cam angle (rad, unwrapped) and value of the ``kind`` (``highest`` or ``lowest``) force of
    every step, one per sample interval; :func:`fine_series` where the run has none.
    """
    name = f"{channel}_{kind}"
    if not solution.has(name):
        return fine_series(solution, channel)[1:]
    time, angle = solution.time, solution.cam_angle
    return np.interp(solution.channel(f"{name}_time")[:-1], time, angle), solution.channel(name)[
        :-1
    ]


def fine_filtered(
    solution: Solution, cutoff_frequency: float, channel: str = "seat_force"
) -> Array | None:
    """Values of :func:`fine_series` below ``cutoff_frequency`` (Hz); None when the samples do not
    allow it.
    """
    time, _, values = fine_series(solution, channel)
    if len(time) < 3:
        return None
    try:
        # Steps follow from the angle by rounding only; the mean step makes them even again.
        even = np.linspace(time[0], time[-1], len(time))
        evened = even if np.allclose(even, time, rtol=0, atol=1e-3 * (even[1] - even[0])) else time
        return low_pass(evened, values, cutoff_frequency, is_closed(solution))
    except InputError:
        return None


Window = Literal["before the event", "event", "after the event"]
#: The windows in order of cam angle.
WINDOWS: tuple[Window, ...] = ("before the event", "event", "after the event")
_TURN = 2 * math.pi


def window_bounds(event: LiftEvent, window: Window) -> tuple[float, float]:
    """First and last cam angle (rad) of a window; the first begins at the cam's zero, the last ends
    after a whole turn.
    """
    return {
        WINDOWS[0]: (0.0, event.start),
        WINDOWS[1]: (event.start, event.end),
        WINDOWS[2]: (event.end, _TURN),
    }[window]


Index = Ints


def prominent_peaks(values: ArrayLike, prominence: float) -> Index:
    """Indices of inner local maxima that rise by ``prominence`` above the saddle to any higher one;
    the middle of a flat top.
    """
    curve = np.asarray(values, dtype=float)
    if len(curve) < 3:
        return np.zeros(0, dtype=np.int64)
    # Runs of equal values count as one, so that a flat top is one maximum.
    starts = np.flatnonzero(np.r_[True, np.diff(curve) != 0.0])
    ends = np.r_[starts[1:], len(curve)] - 1
    level = curve[starts]
    inner = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    peaks = (starts[inner] + ends[inner]) // 2
    standing: Index = peaks[prominences(curve, peaks) >= prominence]
    return standing


def ring_peak(values: Array) -> float:
    """Largest value of one closed turn of even samples: the top of the parabola through the largest
    sample and its neighbours.
    """
    place = int(np.argmax(values))
    before, top, after = (float(values[(place + step) % len(values)]) for step in (-1, 0, 1))
    bend = before - 2 * top + after
    return top - (after - before) ** 2 / (8 * bend) if bend < 0 else top


def ring_top(cam_angle: Array, values: Array) -> float:
    """Angle (rad) of :func:`ring_peak`; of a level top its middle, straight on from its first
    sample.
    """
    place, step = int(np.argmax(values)), 2 * np.pi / len(values)
    before, top, after = (float(values[(place + one) % len(values)]) for one in (-1, 0, 1))
    bend = before - 2 * top + after
    return float(cam_angle[place]) + (step * (before - after) / (2 * bend) if bend < 0 else 0.0)


def ring_value(cam_angle: Array, values: Array, place: float) -> float:
    """Value of one closed turn of even samples at an angle (rad): the cubic through the two samples
    on either side of it.
    """
    step = 2 * np.pi / len(values)
    first = int(np.floor((place - float(cam_angle[0])) / step))
    share = (place - float(cam_angle[0])) / step - first
    a, b, c, d = (float(values[(first + one) % len(values)]) for one in (-1, 0, 1, 2))
    slope, end = (c - a) / 2, (d - b) / 2
    return b + share * (
        slope + share * (3 * (c - b) - 2 * slope - end + share * (slope + end - 2 * (c - b)))
    )


def prominences(values: Array, peaks: Index) -> Array:
    """Prominence of each peak: its height above the higher of the lowest points on its two sides,
    up to a higher value or the end.
    """
    # Turning points suffice. scipy.signal gives the same, but takes a quarter of a second to import.
    rise = np.sign(np.diff(values))
    turning = np.flatnonzero(rise[1:] * rise[:-1] <= 0) + 1
    stops = np.unique(np.r_[0, turning, len(values) - 1, peaks])
    level = values[stops].tolist()
    lowest = np.maximum(_lowest_since_higher(level), _lowest_since_higher(level[::-1])[::-1])
    where = np.searchsorted(stops, peaks)
    rises: Array = values[peaks] - lowest[where]
    return rises


def _lowest_since_higher(level: list[float]) -> Array:
    """Lowest value from each place back to the last higher one or the begin, in one pass."""
    found, open_ = np.empty(len(level)), list[tuple[float, float]]()
    for place, value in enumerate(level):
        lowest = value
        while open_ and open_[-1][0] <= value:
            lowest = min(lowest, open_.pop()[1])
        open_.append((value, lowest))
        found[place] = lowest
    return found


def separate_spikes(position: Array, size: Array, separation: float, threshold: float) -> Index:
    """Indices of the largest values, largest first, at least ``separation`` apart and at least
    ``threshold`` in size.
    """
    candidates = np.flatnonzero(
        (size >= threshold)
        & (size >= np.r_[size[1:], -np.inf])
        & (size >= np.r_[-np.inf, size[:-1]])
    )
    chosen: list[int] = []
    for index in candidates[np.argsort(-size[candidates], kind="stable")]:
        if all(abs(position[index] - position[other]) >= separation for other in chosen):
            chosen.append(int(index))
    return np.array(chosen, dtype=np.int64)
