"""Displacements over the cam angle, cycle by cycle, their peaks, and the window in which the valve is closed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: Points between frames at which a peak is looked for, and the longest gap (frames) across which a motion is drawn.
FINE, LONGEST_GAP = 16, 2.5
#: Share of the largest motion below which the valve is taken for closed, and the angle (rad) over which surge is averaged for it.
CLOSED, AVERAGED = 0.06, np.radians(24.0)
#: Share of the closed window that is left out at either end for ramps, beside what the averaging reaches.
MARGIN = 0.06


@dataclass(frozen=True, slots=True)
class CoilPeak:
    """Largest displacement (m, towards the seat) of one coil section a cycle: ``mean`` over ``cycles`` of them, ``scatter`` (standard
    deviation of a cycle, NaN of a single one), ``spread`` of the mean (its standard deviation, the place of the highlight included)."""

    coil: int
    mean: float
    scatter: float
    spread: float
    cycles: int

    def __repr__(self) -> str:
        return f"CoilPeak: coil {self.coil}, {1e3 * self.mean:.4g} mm, scatter {1e3 * self.scatter:.2g} mm over {self.cycles} cycles"


def whole_turns(cam_angle: Array) -> list[int]:
    """Numbers of the turns that the film shows whole; the begun one where none is."""
    step = float(np.median(np.diff(cam_angle)))
    first, last = int(np.ceil((cam_angle[0] - step) / TURN - 1e-9)), int(np.floor((cam_angle[-1] + step) / TURN + 1e-9))
    return list(range(first, last)) or [int(np.floor(0.5 * (cam_angle[0] + cam_angle[-1]) / TURN))]


def on_grid(cam_angle: Array, moved: Array, turns: list[int], grid: Array) -> Array:
    """Displacement of one coil (frames,) on a grid of cam angles: (turns, angles); NaN where frames are missing or lost."""
    from scipy.interpolate import CubicSpline

    good = np.isfinite(moved)
    values = np.full((len(turns), len(grid)), np.nan)
    if good.sum() < 4:
        return values
    angle = cam_angle[good]
    curve = CubicSpline(angle, moved[good])
    step = float(np.median(np.diff(cam_angle)))
    for row, turn in enumerate(turns):
        at = grid + TURN * turn
        after = np.clip(np.searchsorted(angle, at), 1, len(angle) - 1)
        near = np.minimum(np.abs(at - angle[after]), np.abs(at - angle[after - 1])) <= step
        inside = (at >= angle[0] - 0.5 * step) & (at <= angle[-1] + 0.5 * step)
        bridged = angle[after] - angle[after - 1] <= LONGEST_GAP * step
        values[row] = np.where(inside & near & bridged, curve(at), np.nan)
    return values


def peaks(cam_angle: Array, moved: Array, spread: Array, turns: list[int]) -> tuple[CoilPeak, ...]:
    """Largest displacement of every coil (frames, coils) in every whole turn, between frames by a cubic spline."""
    from scipy.interpolate import CubicSpline

    found = []
    for coil in range(moved.shape[1]):
        good = np.isfinite(moved[:, coil])
        angle, place = cam_angle[good], moved[good, coil]
        curve = CubicSpline(angle, place) if len(angle) >= 4 else None
        tops = []
        for turn in turns:
            inside = np.flatnonzero((angle >= TURN * turn) & (angle < TURN * (turn + 1)))
            if curve is None or len(inside) < 4:
                continue
            fine = np.interp(np.arange(0, len(inside) - 1 + 1e-9, 1 / FINE), np.arange(len(inside)), angle[inside])
            tops.append(float(curve(fine).max()))
        if not tops:
            raise InputError("the film shows no turn of the cam with a motion; film a whole turn or more", "film")
        own = float(np.nanmedian(spread[:, coil]))
        scatter = float(np.std(tops, ddof=1)) if len(tops) > 1 else float("nan")
        of_mean = max(own, 0.0 if np.isnan(scatter) else scatter) / np.sqrt(len(tops))
        found.append(CoilPeak(coil + 1, float(np.mean(tops)), scatter, float(of_mean), len(tops)))
    return tuple(found)


def mean_of(values: Array) -> Array:
    """Mean over the rows that know a column, NaN where none does."""
    count = np.isfinite(values).sum(axis=0)
    return np.asarray(np.where(count > 0, np.nansum(values, axis=0) / np.maximum(count, 1), np.nan))


def closed_window(grid: Array, mean: Array) -> tuple[float, float]:
    """First and last cam angle (rad, the last one may lie beyond a turn) between which the valve is closed, by the uppermost coil's mean.

    Raises :class:`InputError` where nothing like a dwell is there.
    """
    count = len(grid)
    known = np.isfinite(mean)
    if known.sum() < 8:
        raise InputError("the upper coil is hardly seen, so the closed valve is not found; give the dwell", "dwell")
    filled = np.interp(np.arange(count), np.flatnonzero(known), mean[known], period=count)
    wide = max(1, round(float(AVERAGED / (grid[1] - grid[0]))))
    smooth = np.convolve(np.concatenate([filled] * 3), np.ones(wide) / wide, mode="same")[count : 2 * count]
    rest = float(np.median(np.sort(smooth)[: count // 3]))
    low = smooth - rest < CLOSED * (float(smooth.max()) - rest)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.concatenate([low, low]).astype(int), [0]])))
    runs = [(int(last - first), int(first)) for first, last in zip(edges[::2], edges[1::2], strict=True) if last - first < count]
    length, first = max(runs, default=(0, 0))
    step = float(grid[1] - grid[0])
    if length * step < AVERAGED + np.radians(30.0):
        raise InputError("no part of the turn shows the valve closed; give the dwell, such as '170:350 deg'", "dwell")
    start = float(grid[0]) + step * (first % count)
    off = MARGIN * length * step + 0.5 * AVERAGED
    return start + off, start + length * step - off


def segments(cam_angle: Array, number: NDArray[np.int64], dwell: tuple[float, float]) -> list[NDArray[np.int64]]:
    """Frames of every dwell that the film shows whole and without a lost frame."""
    found = []
    first_turn, last_turn = (int(np.floor(angle / TURN)) for angle in (cam_angle[0], cam_angle[-1]))
    step = float(np.median(np.diff(cam_angle)))
    for turn in range(first_turn - 2, last_turn + 1):
        begin, end = (angle + TURN * turn for angle in dwell)
        inside = np.flatnonzero((cam_angle >= begin) & (cam_angle <= end))
        whole = len(inside) and cam_angle[inside[0]] <= begin + 1.01 * step and cam_angle[inside[-1]] >= end - 1.01 * step
        if whole and number[inside[-1]] - number[inside[0]] == len(inside) - 1:
            found.append(inside)
    return found
