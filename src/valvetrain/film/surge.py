"""Surge of a spring in the dwell: frequencies and damping of its free decay with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Ints

#: Lines that are looked for at most, and frames of a dwell that are enough for a result.
MAX_LINES, FEWEST = 4, 12
#: Another line must lower the misfit (per number) by more than this share of what the numbers it
#: takes would by chance.
WORTH = 1.0
#: Largest damping ratio that is called a decay of surge, and the lowest frequency in parts of the
#: frame rate times frames.
MAX_DAMPING, LOWEST = 0.3, 0.7
#: Logarithm of the growth over all frames that scatter explains, and how often stronger (in power) a line is than
#: scatter alone makes it.
GROWTH, SEEN = 0.1, 4.0
#: Points between frames of the curve that is shown.
FINE = 8
#: Normal quantile of a 95 % interval.
BAND = 1.96


@dataclass(frozen=True, slots=True)
class SurgeLine:
    """A surge line of a decay: ``natural_frequency`` (Hz), ``damping_ratio``, each with its
    standard deviation; ``amplitude`` (m) at
    the beginning of the dwell, root mean square over coils and cycles."""

    natural_frequency: float
    frequency_spread: float
    damping_ratio: float
    damping_spread: float
    amplitude: float

    @property
    def decay_rate(self) -> float:
        """Rate (1/s) at which the amplitude falls: exp(-rate t)."""
        return 2 * np.pi * self.natural_frequency * self.damping_ratio

    def __repr__(self) -> str:
        return (
            f"SurgeLine: {self.natural_frequency:.5g} ± {BAND * self.frequency_spread:.2g} Hz, damping ratio {self.damping_ratio:.3g} ± "
            f"{BAND * self.damping_spread:.2g} (95 %)"
        )


@dataclass(frozen=True, eq=False)
class SurgeFit:
    """``lines`` by frequency; of the decay that is shown: ``time`` (s) and ``measured`` (m), the fitted ``curve`` (m) at
    ``curve_time`` (s), and the ``coil`` it is of.
    """

    lines: tuple[SurgeLine, ...]
    time: Array
    measured: Array
    curve_time: Array
    curve: Array
    coil: int


def fit_surge(moved: Array, decays: Sequence[Ints], frame_rate: float) -> SurgeFit | None:
    """Damped sines fitted to all coils and dwells together: frequencies and damping in common,
    amplitudes and rest of their own.

    ``moved`` (frames, coils) m; ``decays``: frames of each dwell. y = c + sum_m exp(-zeta w t) (a
    cos(w_d t) + b sin(w_d t)) is solved by
    variable projection from poles of the matrix pencil. None where too few frames are enough for a result.
    """
    length = min(map(len, decays), default=0)
    if length < FEWEST:
        return None
    every = np.concatenate([moved[frames[:length]] for frames in decays], axis=1)
    complete = np.flatnonzero(np.isfinite(every).all(axis=0))
    data = every[:, complete]
    if not len(complete) or not np.ptp(data) > 0:
        return None
    best: tuple[float, Array] | None = None
    for count in range(1, MAX_LINES + 1):
        start = _poles(data - data.mean(axis=0), count)
        if 1 + 2 * count > length - 3 or not start.size:
            continue
        lines = _fitted(data, start)
        numbers = lines.size + (1 + lines.size) * data.shape[1]
        misfit = max(float(np.sum(_left(data, lines) ** 2)), 1e-300)
        criterion = data.size * np.log(misfit / data.size) + WORTH * numbers * np.log(data.size)
        if (best is None or criterion < best[0]) and _sound(data, lines):
            best = criterion, lines
    if best is None:
        return None
    decay, coil = np.divmod(complete, moved.shape[1])
    return _described(data, decay, best[1], frame_rate, coil + 1)


def _basis(time: Array, lines: Array) -> Array:
    """Columns of the model at times in frames: one, and a damped cosine and sine per line (angle a
    frame, decay a frame).
    """
    angle, decay = lines.reshape(-1, 2).T
    fall = np.exp(np.clip(-decay * time[:, None], -600.0, 60.0))
    turned = angle * time[:, None]
    swings = np.stack([fall * np.cos(turned), fall * np.sin(turned)], axis=2)
    return np.hstack([np.ones((len(time), 1)), swings.reshape(len(time), -1)])


def _left(data: Array, lines: Array) -> Array:
    """What the best amplitudes leave of the data."""
    basis, _ = np.linalg.qr(_basis(np.arange(float(len(data))), lines))
    return np.asarray(data - basis @ (basis.T @ data))


def _fitted(data: Array, start: Array) -> Array:
    """Lines (lines, 2) by least squares, again without those that grow over the frames."""
    from scipy.optimize import least_squares

    size = float(np.sqrt(np.mean(data**2))) or 1.0
    result = least_squares(
        lambda x: _left(data, x).ravel() / size, start.ravel(), x_scale=0.01, max_nfev=60
    )
    lines: Array = result.x.reshape(-1, 2)
    falls = lines[:, 1] * len(data) > -GROWTH
    return _fitted(data, lines[falls]) if falls.any() and not falls.all() else lines[falls]


def _poles(data: Array, count: int) -> Array:
    """Angles and decays a frame (lines, 2) of the ``count`` strongest swings, by the shift of the
    signal space (matrix pencil).
    """
    rows = len(data) // 2
    hankel = np.lib.stride_tricks.sliding_window_view(data, rows, axis=0).reshape(-1, rows).T
    space = np.linalg.svd(hankel, full_matrices=False)[0][:, : 2 * count]
    pole = np.linalg.eigvals(np.linalg.lstsq(space[:-1], space[1:], rcond=None)[0])
    lines = np.column_stack([np.angle(pole), np.clip(-np.log(np.abs(pole)), -0.02, 1.0)])
    seen = (pole.imag > 1e-6) & (lines[:, 0] > LOWEST * 2 * np.pi / len(data))
    return lines[seen][np.argsort(lines[seen, 0])]


def _sound(data: Array, lines: Array) -> bool:
    """Whether all lines are within what a film shows, apart from each other and stronger than the scatter alone makes
    them.
    """
    angle, decay = lines.T
    inverse = np.linalg.pinv(_basis(np.arange(float(len(data))), lines))[1:]
    chance = np.mean(_left(data, lines) ** 2) * np.sum(inverse**2, axis=1)
    size = np.mean((inverse @ data) ** 2, axis=1)
    stronger = (size - SEEN * chance).reshape(-1, 2).sum(axis=1) > 0
    shown = stronger & (angle > 0) & (angle < np.pi) & (np.abs(decay) < MAX_DAMPING * angle)
    return bool(len(lines) and shown.all() and np.all(np.diff(np.sort(angle)) > 1e-3))


def _described(
    data: Array,
    decay_of: Ints,
    lines: Array,
    frame_rate: float,
    coils: Ints,
) -> SurgeFit:
    """Lines with their intervals: the larger of what the misfit leaves and of what leaving out one
    dwell after the other changes.
    """
    from scipy.optimize import approx_fprime

    left = _left(data, lines)
    free = max(data.size - lines.size - (1 + lines.size) * data.shape[1], 1)
    variance = float(np.sum(left**2)) / free
    slopes = approx_fprime(lines.ravel(), lambda x: _left(data, x).ravel(), 1e-7)
    # Neighbouring frames that err alike tell less than as many that err by chance.
    alike = float(np.sum(left[1:] * left[:-1])) / max(float(np.sum(left**2)), 1e-300)
    alike = (1 + max(alike, 0.0)) / (1 - min(max(alike, 0.0), 0.9))
    covariance = variance * alike * np.linalg.pinv(slopes.T @ slopes)
    dwells = np.unique(decay_of)
    if len(dwells) > 2:
        others = [_fitted(data[:, decay_of != dwell], lines) for dwell in dwells]
        same = np.array([other.ravel() for other in others if len(other) == len(lines)])
        jack = np.cov(same.T, ddof=0) * (len(dwells) - 1) if len(same) else 0 * covariance
        grown = np.maximum(np.diag(jack) / np.maximum(np.diag(covariance), 1e-300), 1.0)
        covariance = covariance * np.sqrt(np.outer(grown, grown))
    shares = np.linalg.lstsq(_basis(np.arange(float(len(data))), lines), data, rcond=None)[0]
    surge = []
    for place, (angle, decay) in enumerate(lines):
        natural, columns = float(np.hypot(angle, decay)), slice(2 * place, 2 * place + 2)
        # Slopes of natural frequency and damping ratio by angle and decay.
        by_natural = np.array([angle, decay]) / natural
        by_ratio = np.array([-decay, angle]) * angle / natural**3
        slope = np.array([by_natural, by_ratio])
        deviation = np.sqrt(np.diag(slope @ covariance[columns, columns] @ slope.T))
        per_second = frame_rate / (2 * np.pi)
        size = np.sqrt(np.mean(np.sum(shares[1:][columns] ** 2, axis=0)))
        surge.append(
            SurgeLine(
                natural * per_second,
                float(deviation[0] * per_second),
                max(float(decay / natural), 0.0),
                float(deviation[1]),
                float(size),
            )
        )
    strongest = int(np.argmax(np.var(data, axis=0)))
    fine = np.arange((len(data) - 1) * FINE + 1) / FINE
    return SurgeFit(
        tuple(sorted(surge, key=lambda line: line.natural_frequency)),
        np.arange(float(len(data))) / frame_rate,
        data[:, strongest] - shares[0, strongest],
        fine / frame_rate,
        _basis(fine, lines)[:, 1:] @ shares[1:, strongest],
        int(coils[strongest]),
    )


def alias_of(natural_frequency: float, frame_rate: float) -> float:
    """Frequency (Hz) at which a film of ``frame_rate`` shows a motion of ``natural_frequency``."""
    return float(abs(natural_frequency - frame_rate * np.round(natural_frequency / frame_rate)))
