"""Displacements over the cam angle, cycle by cycle, their peaks, and the window in which the valve
is closed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: Points between frames at which a peak is looked for, and the longest gap (frames) across which a
#: motion is drawn.
FINE, MAX_GAP_LENGTH = 16, 2.5
#: Share of the largest motion below which the valve is taken for closed, and the angle (rad) over
#: which surge is averaged for it.
CLOSED, AVERAGED = 0.06, np.radians(24.0)
#: Share of the closed window that is left out at either end for ramps, in addition to what the averaging
#: reaches.
MARGIN = 0.06


@dataclass(frozen=True, slots=True)
class CoilPeak:
    """Largest displacement (m, towards the seat) of one coil section a cycle: ``mean`` over
    ``cycles`` of them, ``scatter`` (standard
    deviation of a cycle, NaN of a single one), ``spread`` of the mean (its standard deviation, the
    place of the highlight included)."""

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
    first, last = (
        int(np.ceil((cam_angle[0] - step) / TURN - 1e-9)),
        int(np.floor((cam_angle[-1] + step) / TURN + 1e-9)),
    )
    return list(range(first, last)) or [int(np.floor(0.5 * (cam_angle[0] + cam_angle[-1]) / TURN))]


def on_grid(cam_angle: Array, moved: Array, turns: list[int], grid: Array) -> Array:
    """Displacement of one coil (frames,) on a grid of cam angles: (turns, angles); NaN where frames
    are missing or lost.
    """
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
        bridged = angle[after] - angle[after - 1] <= MAX_GAP_LENGTH * step
        values[row] = np.where(inside & near & bridged, curve(at), np.nan)
    return values


def peaks(cam_angle: Array, moved: Array, spread: Array, turns: list[int]) -> tuple[CoilPeak, ...]:
    """Largest displacement of every coil (frames, coils) in every whole turn, between frames by a
    cubic spline.
    """
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
            fine = np.interp(
                np.arange(0, len(inside) - 1 + 1e-9, 1 / FINE),
                np.arange(len(inside)),
                angle[inside],
            )
            tops.append(float(curve(fine).max()))
        if not tops:
            raise InputError(
                "the film shows no cam revolution with a motion; film a whole revolution or more",
                "film",
            )
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
    """First and last cam angle (rad, the last one may exceed one revolution) between which the valve is
    closed, by the uppermost coil's mean.

    Raises :class:`InputError` where nothing like a dwell is there.
    """
    count = len(grid)
    known = np.isfinite(mean)
    if known.sum() < 8:
        raise InputError(
            "the upper coil is hardly seen, so the closed valve is not found; give the dwell",
            "dwell",
        )
    filled = np.interp(np.arange(count), np.flatnonzero(known), mean[known], period=count)
    wide = max(1, round(float(AVERAGED / (grid[1] - grid[0]))))
    smooth = np.convolve(np.concatenate([filled] * 3), np.ones(wide) / wide, mode="same")[
        count : 2 * count
    ]
    rest = float(np.median(np.sort(smooth)[: count // 3]))
    low = smooth - rest < CLOSED * (float(smooth.max()) - rest)
    edges = np.flatnonzero(
        np.diff(np.concatenate([[0], np.concatenate([low, low]).astype(int), [0]]))
    )
    runs = [
        (int(last - first), int(first))
        for first, last in zip(edges[::2], edges[1::2], strict=True)
        if last - first < count
    ]
    length, first = max(runs, default=(0, 0))
    step = float(grid[1] - grid[0])
    if length * step < AVERAGED + np.radians(30.0):
        raise InputError(
            "no part of the turn shows the valve closed; give the dwell, such as '170:350 deg'",
            "dwell",
        )
    start = float(grid[0]) + step * (first % count)
    off = MARGIN * length * step + 0.5 * AVERAGED
    return start + off, start + length * step - off


def segments(
    cam_angle: Array, number: NDArray[np.int64], dwell: tuple[float, float]
) -> list[NDArray[np.int64]]:
    """Frames of every dwell that the film shows whole and without a lost frame."""
    found = []
    first_turn, last_turn = (int(np.floor(angle / TURN)) for angle in (cam_angle[0], cam_angle[-1]))
    step = float(np.median(np.diff(cam_angle)))
    for turn in range(first_turn - 2, last_turn + 1):
        begin, end = (angle + TURN * turn for angle in dwell)
        inside = np.flatnonzero((cam_angle >= begin) & (cam_angle <= end))
        whole = (
            len(inside)
            and cam_angle[inside[0]] <= begin + 1.01 * step
            and cam_angle[inside[-1]] >= end - 1.01 * step
        )
        if whole and number[inside[-1]] - number[inside[0]] == len(inside) - 1:
            found.append(inside)
    return found


#: A coil counts as fixed if it moves less than this share of the largest motion; harmonics of the cam
#: that are distinguished from a drift.
STILL, HARMONICS = 0.15, 8
#: Highest power of time in a drift, and the smallest one (px) that is spoken of.
MAX_POWERS, SPOKEN_OF = 5, 0.05


def camera_drift(places: Array, time: Array, cam_angle: Array | None) -> tuple[Array, int | None]:
    """Drift (frames,) px by the stillest coil, and which it is (None, with zeros, where none is
    still).

    Powers of time, fitted together with harmonics of the cam so that a coil that moves a little
    with the cam shows no drift.
    """
    size = np.array([_motion(one, time) for one in places.T])
    still = int(np.argmin(size))
    if len(size) < 2 or not size[still] < STILL * size.max():
        return np.zeros(len(time)), None
    one, good = places[:, still], np.isfinite(places[:, still])
    turns = 0.0 if cam_angle is None else float(cam_angle[-1] - cam_angle[0]) / (2 * np.pi)
    powers = int(np.clip(1 + turns, 1, MAX_POWERS)) if cam_angle is not None else 3
    scaled = 2 * (time - time[0]) / (time[-1] - time[0]) - 1
    slow = np.polynomial.legendre.legvander(scaled, powers)[:, 1:]
    waves = [np.ones((len(time), 1))]
    if cam_angle is not None and turns >= 1.0:
        phase = cam_angle[:, None] * np.arange(1, HARMONICS + 1)
        waves += [np.cos(phase), np.sin(phase)]
    basis = np.concatenate([slow, *waves], axis=1)
    shares = np.linalg.lstsq(basis[good], one[good], rcond=None)[0]
    return np.asarray(slow @ shares[:powers]), still


def _motion(place: Array, time: Array) -> float:
    """Size of a motion (standard deviation) about a slow trend."""
    good = np.isfinite(place)
    if good.sum() < 8:
        return np.inf
    trend = np.polyval(np.polyfit(time[good] - time[0], place[good], 3), time[good] - time[0])
    return float(np.std(place[good] - trend))


#: Lift (m) at cam angles (rad).
Lift = Callable[[Array], Array]
#: Scatter (frames) of a mark about an even speed that the frames themselves explain.
MARK_SCATTER = 0.35


@dataclass(frozen=True, eq=False)
class CamPhase:
    """``cam_angle`` (frames,) rad, unwrapped; ``cam_speed`` rad/s, mean, with its standard
    deviation; ``by`` marker, speed or lift;
    ``metres_per_pixel`` by the lift, 0 without; ``notes``; ``zero_by`` which source sets where the cam
    angle is zero: ``told`` (given), ``lift`` or ``nobody`` (unknown); ``given_speed`` (rad/s) next to a measured one, else 0."""

    cam_angle: Array
    cam_speed: float
    spread: float
    by: str
    metres_per_pixel: float = 0.0
    notes: tuple[str, ...] = ()
    zero_by: str = "told"
    given_speed: float = 0.0


def by_speed(time: Array, cam_speed: float, first_angle: float) -> CamPhase:
    """An even speed that is given; ``first_angle`` (rad) of the first frame."""
    if not cam_speed > 0:
        raise InputError("the cam speed must be positive; correct it", "cam_speed")
    return CamPhase(first_angle + cam_speed * time, cam_speed, 0.0, "speed")


def by_marker(
    time: Array, brightness: Array, mark_angle: float, given_speed: float | None
) -> CamPhase:
    """Pulses of brightness once a turn, each at its centre of brightness; ``mark_angle`` (rad) of
    the cam when the mark passes.

    Raises :class:`InputError` for a spot that does not flash, or flashes once while no speed is
    given.
    """
    pulses, frame = _pulses(time, brightness), float(np.median(np.diff(time)))
    if len(pulses) < 2:
        if given_speed is None or not len(pulses):
            raise InputError(
                f"the marker flashes {len(pulses)} times; twice or more are needed for the speed, so check its place or give the cam speed",
                "marker",
            )
        return CamPhase(
            mark_angle + given_speed * (time - pulses[0]),
            given_speed,
            0.0,
            "marker",
            0.0,
            ("the marker passes once, so the speed is the one given",),
        )
    steps = np.diff(pulses)
    turns = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(steps / np.median(steps))))])
    slope, start = np.polyfit(turns, pulses, 1)
    left = pulses - start - slope * turns
    notes = []
    missed = int(turns[-1]) + 1 - len(pulses)
    if missed:
        notes.append(
            f"the marker was not seen in {missed} turns, which are counted from the turns about them"
        )
    even = len(pulses) < 4 or float(np.std(left)) < MARK_SCATTER * frame
    if even:
        turned = (time - start) / slope
    else:
        notes.append(
            "the speed changes over the film, so the cam angle is taken evenly from mark to mark"
        )
        turned = np.interp(time, pulses, turns)
        turned = np.where(time < pulses[0], (time - pulses[0]) / steps[0], turned)
        turned = np.where(
            time > pulses[-1],
            turns[-1] + (time - pulses[-1]) / steps[-1] * (turns[-1] - turns[-2]),
            turned,
        )
    spread_of_mark = max(float(np.std(left)), 0.1 * frame)
    spread = (
        TURN / slope**2 * spread_of_mark / np.sqrt(max(np.sum((turns - turns.mean()) ** 2), 0.5))
    )
    speed = TURN / slope
    return CamPhase(
        mark_angle + TURN * turned, float(speed), float(spread), "marker", 0.0, tuple(notes), given_speed=given_speed or 0.0
    )  # fmt: skip


def _pulses(time: Array, brightness: Array) -> Array:
    """Times at the centre of brightness of every flash, bright or dark, that is entirely within the
    film.
    """
    typical = float(np.median(brightness))
    up = float(np.percentile(brightness, 99.8)) - typical
    down = typical - float(np.percentile(brightness, 0.2))
    signal = (brightness - typical) * (1.0 if up >= down else -1.0)
    top = max(up, down)
    noise = 1.5 * float(np.median(np.abs(brightness - typical)))
    if not top > max(6 * noise, 2.0):
        return np.zeros(0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (signal > 0.5 * top).astype(int), [0]])))
    found = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if first == 0 or last == len(signal):
            continue  # a flash that the film cuts has no centre
        part = slice(max(first - 2, 0), last + 2)
        weight = np.clip(signal[part], 0.0, None)
        found.append(float(np.sum(weight * time[part]) / np.sum(weight)))
    return np.array(found)


def by_lift(time: Array, moved: Array, valve_lift: Lift, given_speed: float | None) -> CamPhase:
    """The highlight that moves with the retainer laid on the lift: ``moved`` (frames,) px towards
    the seat.

    Least squares of moved = c + k lift(speed t + angle) over the four. Raises :class:`InputError`
    where the film shows no whole turn and
    no speed is given, or where the motion is not that of the lift.
    """
    from scipy.optimize import least_squares

    good = np.isfinite(moved)
    t, y = time[good], moved[good]
    speed = given_speed if given_speed is not None else _turn_speed(time, moved)
    grid = np.linspace(0.0, TURN, 721)[:-1]
    table = np.asarray(valve_lift(grid), dtype=float)
    if not np.ptp(table) > 0:
        raise InputError(
            "the lift is the same at all cam angles, so it gives no phase; use another", "lift"
        )

    def lifted(speed: float, start: float) -> Array:
        return np.asarray(
            np.interp(
                np.mod(speed * t + start, TURN), np.append(grid, TURN), np.append(table, table[0])
            )
        )

    def shape(one: Array) -> tuple[Array, Array]:
        basis = np.column_stack([np.ones_like(t), one])
        share = np.linalg.lstsq(basis, y, rcond=None)[0]
        return np.asarray(y - basis @ share, dtype=float), np.asarray(share)

    best = min(
        (float(np.sum(shape(lifted(speed * (1 + off), start))[0] ** 2)), speed * (1 + off), start)
        for off in ((0.0,) if given_speed is not None else (-0.01, -0.005, 0.0, 0.005, 0.01))
        for start in grid[::10]
    )
    span = t[-1] - t[0]
    # Two numbers alike in size: the angle in the middle of the film, and how far the speed turns it
    # by its end.
    middle = t[0] + 0.5 * span

    def residual(x: Array) -> Array:
        return shape(lifted(best[1] + x[1] / span, best[2] + x[0] - x[1] / span * middle))[0]

    found = least_squares(residual, np.zeros(2), x_scale=0.01, diff_step=1e-4)
    left, (_, factor) = shape(
        lifted(best[1] + found.x[1] / span, best[2] + found.x[0] - found.x[1] / span * middle)
    )
    explained = 1 - float(np.var(left) / np.var(y))
    if explained < 0.8 or factor <= 0:
        raise InputError(
            "the motion of the upper coil is not that of the lift; check the line, the seat's end and the lift, or use a marker",
            "lift",
        )
    variance = float(np.sum(left**2)) / max(len(t) - 4, 1)
    spread = float(np.sqrt(variance * np.linalg.pinv(found.jac.T @ found.jac)[1, 1])) / span
    speed = float(best[1] + found.x[1] / span)
    sentence = f"the cam angle is that at which the upper coil moves as the lift does ({100 * explained:.1f} % of its motion)"
    start = best[2] + float(found.x[0]) - float(found.x[1]) / span * middle
    return CamPhase(
        speed * time + start, speed, spread, "lift", 1.0 / float(factor), (sentence,), "lift", given_speed or 0.0
    )  # fmt: skip


def _turn_speed(time: Array, moved: Array) -> float:
    """Cam speed (rad/s) from the time after which the motion repeats."""
    frame = float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1], frame)
    good = np.isfinite(moved)
    signal = np.interp(even, time[good], moved[good])
    signal = signal - signal.mean()
    count = len(signal)
    power = np.abs(np.fft.rfft(signal, 2 * count)) ** 2
    alike = np.fft.irfft(power)[:count] / (count - np.arange(count))
    alike = alike[: int(0.8 * count)] / max(alike[0], 1e-300)
    below = np.flatnonzero(alike < 0.2)
    if len(below) and len(later := alike[below[0] :]):
        peak = int(np.argmax(later)) + int(below[0])
        # The first of peaks that are nearly as high: later ones are two turns and more.
        tops = [
            k
            for k in range(int(below[0]) + 1, len(alike) - 1)
            if alike[k] >= alike[k - 1] and alike[k] >= alike[k + 1]
        ]
        first = next((k for k in tops if alike[k] > 0.8 * alike[peak]), peak)
        if alike[first] > 0.5:
            return float(TURN / (first * frame))
    raise InputError(
        "the film shows no motion that repeats, so the lift alone does not give the speed; give the cam speed too",
        "cam_speed",
    )
