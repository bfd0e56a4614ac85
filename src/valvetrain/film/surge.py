"""Surge of a spring in the dwell: frequencies and damping of its free decay with their intervals,
and the spectrum of a film.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
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

    @property
    def logarithmic_decrement(self) -> float:
        """Logarithm of the ratio of one swing to the next."""
        return float(2 * np.pi * self.damping_ratio / np.sqrt(1 - self.damping_ratio**2))

    def __repr__(self) -> str:
        return (
            f"SurgeLine: {self.natural_frequency:.5g} ± {BAND * self.frequency_spread:.2g} Hz, damping ratio {self.damping_ratio:.3g} ± "
            f"{BAND * self.damping_spread:.2g} (95 %)"
        )


@dataclass(frozen=True, eq=False)
class SurgeFit:
    """``lines`` by frequency; of one decay that is shown: ``time`` (s) and ``measured`` (m), the
    fitted curve
    ``curve`` (m) at ``curve_time`` (s); ``coil`` it is of; ``scatter``
    (m) of a place about the fit; ``decays`` fitted."""

    lines: tuple[SurgeLine, ...]
    time: Array
    measured: Array
    curve_time: Array
    curve: Array
    coil: int
    scatter: float
    decays: int


def fit_surge(
    moved: Array, decays: Sequence[NDArray[np.int64]], frame_rate: float, first_coil: int = 1
) -> SurgeFit | None:
    """Damped sines fitted to all coils and dwells together: frequencies and damping in common,
    amplitudes and rest of their own.

    ``moved`` (frames, coils) m; ``decays``: frames of each dwell. y = c + sum_m exp(-zeta w t) (a
    cos(w_d t) + b sin(w_d t)) is solved by
    variable projection from poles of the matrix pencil. None where too few frames are enough for a result.
    """
    length = min((len(one) for one in decays), default=0)
    if length < FEWEST:
        return None
    blocks = [moved[one[:length]] for one in decays]
    whole = np.concatenate(blocks, axis=1)
    group = np.repeat(np.arange(len(blocks)), moved.shape[1])
    complete = np.isfinite(whole).all(axis=0)
    data, group = whole[:, complete], group[complete]
    if data.shape[1] == 0 or not np.ptp(data) > 0:
        return None
    best: tuple[float, Array] | None = None
    for count in range(1, MAX_LINES + 1):
        if 1 + 2 * count > length - 3:
            break
        start = _poles(data - data.mean(axis=0), count, length)
        if not len(start):
            continue
        found = _without_growth(data, _refined(data, start))
        numbers = found.size + (1 + found.size) * data.shape[1]
        misfit = float(np.sum(_left(data, found) ** 2))
        criterion = data.size * np.log(max(misfit, 1e-300) / data.size) + WORTH * numbers * np.log(
            data.size
        )
        if (best is None or criterion < best[0]) and _sound(data, found):
            best = criterion, found
    if best is None:
        return None
    return _described(
        data, group, best[1], frame_rate, np.flatnonzero(complete) % moved.shape[1], first_coil
    )


def _basis(time: Array, numbers: Array) -> Array:
    """Columns of the model at times in frames: one, and a damped cosine and sine per pair (angle a
    frame, decay a frame).
    """
    columns = [np.ones(len(time))]
    for angle, decay in numbers.reshape(-1, 2):
        fall = np.exp(np.clip(-decay * time, -600.0, 60.0))
        columns += [fall * np.cos(angle * time), fall * np.sin(angle * time)]
    return np.column_stack(columns)


def _left(data: Array, numbers: Array) -> Array:
    basis, _ = np.linalg.qr(_basis(np.arange(len(data), dtype=float), numbers))
    return np.asarray(data - basis @ (basis.T @ data))


def _refined(data: Array, start: Array) -> Array:
    from scipy.optimize import least_squares

    size = float(np.sqrt(np.mean(data**2))) or 1.0
    return np.asarray(
        least_squares(lambda x: _left(data, x).ravel() / size, start, x_scale=0.01, max_nfev=60).x
    )


def _without_growth(data: Array, numbers: Array) -> Array:
    """The lines that do not grow over the frames, fitted again where others are dropped."""
    lines = numbers.reshape(-1, 2)
    falls = lines[:, 1] * len(data) > -GROWTH
    if falls.all() or not falls.any():
        return numbers[np.repeat(falls, 2)]
    return _without_growth(data, _refined(data, lines[falls].ravel()))


def _poles(data: Array, count: int, length: int) -> Array:
    """Angles and decays a frame of the ``count`` strongest swings, by the shift of the signal space
    (matrix pencil).
    """
    rows = length // 2
    hankel = np.concatenate(
        [np.stack([one[k : k + rows] for k in range(length - rows + 1)], axis=1) for one in data.T],
        axis=1,
    )
    space = np.linalg.svd(hankel, full_matrices=False)[0][:, : 2 * count]
    values = np.linalg.eigvals(np.linalg.lstsq(space[:-1], space[1:], rcond=None)[0])
    upper = values[np.imag(values) > 1e-6]
    pairs = [(float(np.angle(one)), float(np.clip(-np.log(abs(one)), -0.02, 1.0))) for one in upper]
    return np.array(
        [value for pair in sorted(pairs) if pair[0] > LOWEST * 2 * np.pi / length for value in pair]
    )


def _sound(data: Array, numbers: Array) -> bool:
    """Whether all lines are within what a film shows, apart from each other and stronger than the scatter alone makes
    them.
    """
    if not numbers.size:
        return False
    angle, decay = numbers.reshape(-1, 2).T
    apart = np.diff(np.sort(angle))
    inverse = np.linalg.pinv(_basis(np.arange(len(data), dtype=float), numbers))
    chance = np.mean(_left(data, numbers) ** 2) * np.sum(inverse[1:] ** 2, axis=1)
    size = np.mean((inverse[1:] @ data) ** 2, axis=1)
    return bool(
        np.all((size - SEEN * chance).reshape(-1, 2).sum(axis=1) > 0)
        and np.all((angle > 0) & (angle < np.pi))
        and np.all(np.abs(decay) < MAX_DAMPING * angle)
        and np.all(apart > 1e-3)
    )


def _described(
    data: Array,
    group: NDArray[np.int64],
    numbers: Array,
    frame_rate: float,
    coils: NDArray[np.int64],
    first_coil: int,
) -> SurgeFit:
    """Lines with their intervals: the larger of what the misfit leaves and of what leaving out one
    dwell after the other changes.
    """
    left = _left(data, numbers)
    free = max(data.size - numbers.size - (1 + numbers.size) * data.shape[1], 1)
    variance = float(np.sum(left**2)) / free
    steps = 1e-6 * np.maximum(np.abs(numbers), 1e-3)
    slopes = np.column_stack(
        [
            ((_left(data, numbers + step) - _left(data, numbers - step)) / (2 * size)).ravel()
            for step, size in zip(np.diag(steps), steps, strict=True)
        ]
    )
    covariance = variance * np.linalg.pinv(slopes.T @ slopes) * _memory(left)
    dwells = np.unique(group)
    if len(dwells) > 2:
        others = np.array([_refined(data[:, group != one], numbers) for one in dwells])
        off = others - others.mean(axis=0)
        jack = (len(dwells) - 1) / len(dwells) * off.T @ off
        grown = np.sqrt(np.maximum(np.diag(jack) / np.maximum(np.diag(covariance), 1e-300), 1.0))
        covariance = covariance * np.outer(grown, grown)
    basis = _basis(np.arange(len(data), dtype=float), numbers)
    shares = np.linalg.lstsq(basis, data, rcond=None)[0]
    lines = []
    for place, (angle, decay) in enumerate(numbers.reshape(-1, 2)):
        natural = float(np.hypot(angle, decay))
        part = covariance[2 * place : 2 * place + 2, 2 * place : 2 * place + 2]
        along = np.array([angle, decay]) / natural
        ratio = np.array([-decay * angle, angle**2]) / natural**3
        amplitude = np.sqrt(np.mean(np.sum(shares[1 + 2 * place : 3 + 2 * place] ** 2, axis=0)))
        lines.append(
            SurgeLine(
                natural * frame_rate / (2 * np.pi),
                float(np.sqrt(along @ part @ along)) * frame_rate / (2 * np.pi),
                max(float(decay / natural), 0.0),
                float(np.sqrt(ratio @ part @ ratio)),
                float(amplitude),
            )
        )
    shown = int(np.argmax(np.sum((data - data.mean(axis=0)) ** 2, axis=0)))
    time = np.arange(len(data)) / frame_rate
    fine = np.arange((len(data) - 1) * FINE + 1) / FINE
    ordered = tuple(sorted(lines, key=lambda one: one.natural_frequency))
    return SurgeFit(
        ordered,
        time,
        data[:, shown] - shares[0, shown],
        fine / frame_rate,
        _basis(fine, numbers)[:, 1:] @ shares[1:, shown],
        first_coil + int(coils[shown]),
        float(np.sqrt(variance)),
        len(dwells),
    )


def _memory(left: Array) -> float:
    """Factor by which what one frame leaves resembles the next one's: neighbours that err alike
    give less.
    """
    size = float(np.sum(left**2))
    alike = float(np.sum(left[1:] * left[:-1])) / size if size > 0 else 0.0
    return float((1 + max(alike, 0.0)) / (1 - min(max(alike, 0.0), 0.9)))


def spectrum(moved: Array, number: NDArray[np.int64], frame_rate: float) -> tuple[Array, Array]:
    """Frequencies (Hz) and amplitudes (m) of the motion, root mean square over coils; Hann window,
    lost frames filled evenly.
    """
    even = np.arange(number[-1] + 1)
    window = np.hanning(len(even) + 2)[1:-1]
    power = np.zeros(len(even) // 2 + 1)
    counted = 0
    for one in moved.T:
        good = np.isfinite(one)
        if good.sum() < 4:
            continue
        signal = np.interp(even, number[good], one[good])
        signal = signal - np.polyval(np.polyfit(even, signal, 1), even)
        power += np.abs(np.fft.rfft(signal * window) * 2 / window.sum()) ** 2
        counted += 1
    return np.asarray(np.fft.rfftfreq(len(even), 1 / frame_rate), dtype=float), np.asarray(
        np.sqrt(power / max(counted, 1))
    )


def alias_of(natural_frequency: float, frame_rate: float) -> float:
    """Frequency (Hz) at which a film of ``frame_rate`` shows a motion of ``natural_frequency``."""
    return float(abs(natural_frequency - frame_rate * np.round(natural_frequency / frame_rate)))
