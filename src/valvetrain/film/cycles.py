"""Displacements over the cam angle, cycle by cycle, their peaks, and the window in which the valve
is closed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Flags, Ints
from valvetrain.errors import InputError
from valvetrain.measured.stations import runs_of

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
    fine = np.arange(0.0, TURN, float(np.median(np.diff(cam_angle))) / FINE)
    tops_of_coils = []
    for coil, place in enumerate(moved.T):
        curves = on_grid(cam_angle, place, turns, fine)
        tops = np.nanmax(curves[np.isfinite(curves).sum(axis=1) >= 3 * FINE], axis=1)
        if not len(tops):
            raise InputError(
                "the film shows no cam revolution with a motion; film a whole revolution or more",
                "film",
            )
        scatter = float(np.std(tops, ddof=1)) if len(tops) > 1 else float("nan")
        of_mean = np.fmax(np.nanmedian(spread[:, coil]), scatter) / np.sqrt(len(tops))
        peak = CoilPeak(coil + 1, float(np.mean(tops)), scatter, float(of_mean), len(tops))
        tops_of_coils.append(peak)
    return tuple(tops_of_coils)


def mean_of(values: Array) -> Array:
    """Mean over the rows that know a column, NaN where none does."""
    count = np.isfinite(values).sum(axis=0)
    return np.asarray(np.where(count > 0, np.nansum(values, axis=0) / np.maximum(count, 1), np.nan))


def closed_window(grid: Array, mean: Array) -> tuple[float, float]:
    """First and last cam angle (rad, the last one may exceed one revolution) between which the valve is
    closed, by the uppermost coil's mean.

    Raises :class:`InputError` where nothing like a dwell is there.
    """
    from scipy.ndimage import uniform_filter1d

    count, step = len(grid), float(grid[1] - grid[0])
    seen = np.flatnonzero(np.isfinite(mean))
    if len(seen) < 8:
        raise InputError(
            "the upper coil is hardly seen, so the closed valve is not found; give the dwell",
            "dwell",
        )
    filled = np.interp(np.arange(count), seen, mean[seen], period=count)
    smooth = uniform_filter1d(filled, max(1, round(AVERAGED / step)), mode="wrap")
    rest = float(np.median(np.sort(smooth)[: count // 3]))
    low = smooth - rest < CLOSED * (smooth.max() - rest)
    # The longest run of low stations, counted on into a second turn.
    starts, ends = runs_of(np.tile(low, 2)).T
    lengths = ends - starts
    lengths = np.where(lengths < count, lengths, 0)
    best = int(np.argmax(lengths)) if len(lengths) else 0
    length = step * lengths[best] if len(lengths) else 0.0
    if length < AVERAGED + np.radians(30.0):
        raise InputError(
            "no part of the turn shows the valve closed; give the dwell, such as '170:350 deg'",
            "dwell",
        )
    start = float(grid[0]) + step * int(starts[best] % count)
    off = MARGIN * length + 0.5 * AVERAGED
    return float(start + off), float(start + length - off)


def is_closed(cam_angle: Array, dwell: tuple[float, float]) -> Flags:
    """Whether the valve is closed at cam angles (rad) of any turn."""
    return np.asarray(np.mod(cam_angle - dwell[0], TURN) <= dwell[1] - dwell[0])


def segments(cam_angle: Array, number: Ints, dwell: tuple[float, float]) -> list[Ints]:
    """Frames of every dwell that the film shows whole and without a lost frame."""
    step = 1.01 * float(np.median(np.diff(cam_angle)))
    closed = is_closed(cam_angle, dwell)
    turn = np.floor((cam_angle - dwell[0]) / TURN)
    whole = []
    for count in np.unique(turn[closed]):
        inside = np.flatnonzero(closed & (turn == count))
        begin, end = dwell[0] + TURN * count, dwell[1] + TURN * count
        reaches = cam_angle[inside[0]] <= begin + step and cam_angle[inside[-1]] >= end - step
        if reaches and number[inside[-1]] - number[inside[0]] == len(inside) - 1:
            whole.append(inside)
    return whole


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
    seconds, size = time - time[0], []
    for place in places.T:  # size of a motion about a slow trend
        good = np.isfinite(place)
        trend = np.polyfit(seconds[good], place[good], 3) if good.sum() >= 8 else [np.inf]
        size.append(np.std(place[good] - np.polyval(trend, seconds[good])))
    still = int(np.nanargmin(size)) if np.isfinite(size).any() else 0
    if len(size) < 2 or not size[still] < STILL * np.nanmax(size):
        return np.zeros(len(time)), None
    turns = 0.0 if cam_angle is None else float(cam_angle[-1] - cam_angle[0]) / TURN
    powers = 3 if cam_angle is None else int(np.clip(1 + turns, 1, MAX_POWERS))
    slow = np.polynomial.legendre.legvander(2 * seconds / seconds[-1] - 1, powers)
    waves = np.zeros((len(time), 0))
    if cam_angle is not None and turns >= 1.0:
        phase = cam_angle[:, None] * np.arange(1, HARMONICS + 1)
        waves = np.hstack([np.cos(phase), np.sin(phase)])
    place, good = places[:, still], np.isfinite(places[:, still])
    shares = np.linalg.lstsq(np.hstack([slow, waves])[good], place[good], rcond=None)[0]
    return np.asarray(slow[:, 1:] @ shares[1 : powers + 1]), still


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


def by_marker(
    time: Array, brightness: Array, mark_angle: float, given_speed: float | None
) -> CamPhase:
    """Pulses of brightness once a turn, each at its centre of brightness; ``mark_angle`` (rad) of
    the cam when the mark passes.

    Raises :class:`InputError` for a spot that does not flash, or flashes once while no speed is
    given.
    """
    from scipy.interpolate import make_interp_spline

    pulses, frame = _pulses(time, brightness), float(np.median(np.diff(time)))
    if len(pulses) < 2:
        if given_speed is None or not len(pulses):
            raise InputError(
                f"the marker flashes {len(pulses)} times; twice or more are needed for the speed, so check its place or give the cam speed",
                "marker",
            )
        angle = mark_angle + given_speed * (time - pulses[0])
        sentence = "the marker passes once, so the speed is the one given"
        return CamPhase(angle, given_speed, 0.0, "marker", notes=(sentence,))
    steps = np.diff(pulses)
    turns = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(steps / np.median(steps))))])
    slope, start = np.polyfit(turns, pulses, 1)
    scatter = float(np.std(pulses - start - slope * turns))
    notes = []
    missed = int(turns[-1]) + 1 - len(pulses)
    if missed:
        notes.append(
            f"the marker was not seen in {missed} turns, which are counted from the turns about them"
        )
    turned = (time - start) / slope
    if len(pulses) >= 4 and scatter >= MARK_SCATTER * frame:
        notes.append(
            "the speed changes over the film, so the cam angle is taken evenly from mark to mark"
        )
        turned = make_interp_spline(pulses, turns, k=1)(time)
    speed, reach = TURN / slope, max(np.sum((turns - turns.mean()) ** 2), 0.5)
    spread = speed / slope * max(scatter, 0.1 * frame) / np.sqrt(reach)
    return CamPhase(
        mark_angle + TURN * turned, float(speed), float(spread), "marker", notes=tuple(notes), given_speed=given_speed or 0.0
    )  # fmt: skip


def _pulses(time: Array, brightness: Array) -> Array:
    """Times at the centre of brightness of every flash, bright or dark, that is entirely within the
    film.
    """
    signal = brightness - np.median(brightness)
    down, up = np.percentile(signal, (0.2, 99.8))
    top = float(max(up, -down))
    signal = signal if up >= -down else -signal
    if not top > max(9 * float(np.median(np.abs(signal))), 2.0):
        return np.zeros(0)
    centres = []
    for first, last in runs_of(signal > 0.5 * top):
        if first > 0 and last < len(signal):  # a flash that the film cuts has no centre
            part = slice(max(first - 2, 0), last + 2)
            centres.append(np.average(time[part], weights=np.clip(signal[part], 0.0, None)))
    return np.array(centres)


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
    grid = np.linspace(0.0, TURN, 721)
    table = np.asarray(valve_lift(np.mod(grid, TURN)), dtype=float)
    if not np.ptp(table) > 0:
        raise InputError(
            "the lift is the same at all cam angles, so it gives no phase; use another", "lift"
        )
    # Two numbers alike in size: the angle in the middle of the film, and how far another speed turns
    # the cam over the film.
    span, since = t[-1] - t[0], t - 0.5 * (t[0] + t[-1])

    def fitted(x: Array) -> tuple[Array, float]:
        """What is left of the motion, and px a metre of lift."""
        lift = np.interp(np.mod((speed + x[1] / span) * since + x[0], TURN), grid, table)
        factor, rest = np.polyfit(lift, y, 1) if np.ptp(lift) > 0 else (0.0, y.mean())
        return y - rest - factor * lift, float(factor)

    offs = (0.0,) if given_speed is not None else (-0.01, -0.005, 0.0, 0.005, 0.01)
    starts = [np.array([start, off * speed * span]) for off in offs for start in grid[:-1:10]]
    start = min(starts, key=lambda x: float(np.sum(fitted(x)[0] ** 2)))
    result = least_squares(lambda x: fitted(x)[0], start, x_scale=0.01, diff_step=1e-4)
    left, factor = fitted(result.x)
    explained = 1 - float(np.var(left) / np.var(y))
    if explained < 0.8 or factor <= 0:
        raise InputError(
            "the motion of the upper coil is not that of the lift; check the line, the seat's end and the lift, or use a marker",
            "lift",
        )
    variance = float(np.sum(left**2)) / max(len(t) - 4, 1)
    spread = float(np.sqrt(variance * np.linalg.pinv(result.jac.T @ result.jac)[1, 1])) / span
    speed = float(speed + result.x[1] / span)
    angle = speed * (time - 0.5 * (t[0] + t[-1])) + result.x[0]
    sentence = f"the cam angle is that at which the upper coil moves as the lift does ({100 * explained:.1f} % of its motion)"
    return CamPhase(angle, speed, spread, "lift", 1.0 / factor, (sentence,), "lift", given_speed or 0.0)  # fmt: skip


def _turn_speed(time: Array, moved: Array) -> float:
    """Cam speed (rad/s) from the time after which the motion repeats."""
    from scipy.signal import correlate, find_peaks

    frame = float(np.median(np.diff(time)))
    even, good = np.arange(time[0], time[-1], frame), np.isfinite(moved)
    signal = np.interp(even, time[good], moved[good])
    signal, count = signal - signal.mean(), len(even)
    alike = correlate(signal, signal)[count - 1 :] / (count - np.arange(count))
    alike = alike[: int(0.8 * count)] / max(alike[0], 1e-300)
    tops, _ = find_peaks(alike, height=0.5)
    # The first of peaks that are nearly as high: later ones are two turns and more.
    begins = np.argmax(alike < 0.2)
    high = tops[(tops > begins) & (alike[tops] > 0.8 * alike[begins:].max())] if begins else []
    if not len(high):
        raise InputError(
            "the film shows no motion that repeats, so the lift alone does not give the speed; give the cam speed too",
            "cam_speed",
        )
    return float(TURN / (high[0] * frame))
