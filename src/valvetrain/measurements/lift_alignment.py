"""Where the zero of a rig lies on the cam of a case: the measured lift laid over the lift of the case."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: Angles at which both lifts are compared, and the most that flanks may lie apart (rad of cam) before it is told.
ANGLES, APART = 3600, np.radians(0.5)


@dataclass(frozen=True, eq=False)
class LiftAlignment:
    """Cam angle of the case = angle of the rig + ``offset``; rad of cam, m.

    ``uncertainty``: standard uncertainty of the offset, from what the fit leaves and from the difference between the flanks; ``opening``
    and ``closing``: the offset that either flank tells alone; ``gain``: measured lift over lift of the case; ``base`` (m) added to it.
    ``cam_angle``, ``measured``, ``model``: shape (angles,), both lifts over the angle of the case. ``residual``: measured minus fitted.

    >>> lift = lambda angle: 8e-3 * np.clip(np.cos(angle), 0.0, None) ** 2
    >>> grid = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    >>> round(float(np.degrees(align_lift(grid, lift(grid + 0.5), lift).offset)), 3)
    28.648
    """

    offset: float
    uncertainty: float
    opening: float
    closing: float
    gain: float
    base: float
    cam_angle: Array
    measured: Array
    model: Array

    @property
    def residual(self) -> Array:
        """Measured lift minus the lift of the case with gain and base (m)."""
        found: Array = self.measured - self.base - self.gain * self.model
        return found


def align_lift(rig_angle: Array, measured: Array, lift: Callable[[Array], Array]) -> LiftAlignment:
    """Lay a mean measured lift (m) over ``rig_angle`` (rad of cam, rising over one turn) over ``lift`` (m of rad, periodic).

    Least squares in offset, gain and base, begun at the best of all shifts by whole steps. Raises :class:`InputError` where either lift
    does not rise.
    """
    grid = np.arange(ANGLES) * (TURN / ANGLES)
    known = np.isfinite(measured)
    if np.count_nonzero(known) < 16:
        raise InputError("there is no measured lift to align by; give the offset", "offset")
    one = np.interp(grid, rig_angle[known], measured[known], period=TURN)
    two = np.asarray(lift(grid), dtype=float)
    if np.ptp(one) <= 0 or np.ptp(two) <= 0:
        raise InputError("a lift that never rises aligns nothing; name the channel of the lift, or give the offset", "offset")
    likeness = np.fft.irfft(np.conj(np.fft.rfft(one - one.mean())) * np.fft.rfft(two - two.mean()), ANGLES)
    offset = float(grid[int(np.argmax(likeness))])
    offset, gain, base, spread = _fitted(grid, one, lift, offset, np.ones(ANGLES, dtype=bool))
    slope = _slope(lift, grid + offset)
    steep = np.abs(slope) > 0.05 * np.max(np.abs(slope))
    flanks = [_flank(grid, one - base, lift, offset, gain, steep & (sign * slope > 0)) for sign in (1.0, -1.0)]
    uncertainty = float(np.hypot(spread, (flanks[0] - flanks[1]) / 2))
    order = np.argsort((grid + offset) % TURN)
    placed = ((grid + offset) % TURN)[order]
    wrapped = float((offset + np.pi) % TURN - np.pi)
    return LiftAlignment(
        wrapped, uncertainty, wrapped + flanks[0] - offset, wrapped + flanks[1] - offset, gain, base, placed, one[order],
        np.asarray(lift(placed), dtype=float),
    )  # fmt: skip


def _slope(lift: Callable[[Array], Array], angles: Array) -> Array:
    step = 1e-4
    slope: Array = (np.asarray(lift(angles + step)) - np.asarray(lift(angles - step))) / (2 * step)
    return slope


def _fitted(
    grid: Array, one: Array, lift: Callable[[Array], Array], offset: float, used: NDArray[np.bool_]
) -> tuple[float, float, float, float]:
    """Offset, gain, base and the offset's standard deviation, by Gauss-Newton steps."""
    gain, base = 1.0, 0.0
    for _ in range(12):
        model, slope = np.asarray(lift(grid[used] + offset)), _slope(lift, grid[used] + offset)
        columns = np.column_stack([gain * slope, model, np.ones(len(model))])
        change, *_ = np.linalg.lstsq(columns, one[used] - gain * model - base, rcond=None)
        offset, gain, base = offset + float(np.clip(change[0], -0.1, 0.1)), gain + float(change[1]), base + float(change[2])
        if abs(change[0]) < 1e-10:
            break
    left = one[used] - gain * np.asarray(lift(grid[used] + offset)) - base
    alike = float(np.clip(np.dot(left[1:], left[:-1]) / max(float(np.dot(left, left)), 1e-300), 0.0, 0.999))
    free = max(len(left) * (1 - alike) / (1 + alike) - 3, 1.0)  # neighbours that err alike count once
    inverse = np.linalg.pinv(columns.T @ columns) * len(left)
    return offset, gain, base, float(np.sqrt(max(inverse[0, 0], 0.0) * np.mean(left**2) / free))


def _flank(grid: Array, one: Array, lift: Callable[[Array], Array], offset: float, gain: float, used: NDArray[np.bool_]) -> float:
    """Offset by one flank alone, gain and base known."""
    if np.count_nonzero(used) < 4:
        return offset
    for _ in range(12):
        slope = gain * _slope(lift, grid[used] + offset)
        change = float(np.dot(slope, one[used] - gain * np.asarray(lift(grid[used] + offset))) / max(float(np.dot(slope, slope)), 1e-300))
        offset += float(np.clip(change, -0.05, 0.05))
        if abs(change) < 1e-10:
            break
    return offset
