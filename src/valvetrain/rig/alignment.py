"""Aligns a measured lift to the lift of a case: the cam angle at the mark of the rig, by both
flanks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.rig.shaft import REVOLUTION

Array = NDArray[np.float64]
Lift = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class LiftAlignment:
    """Cam angle of the case = angle of the rig + ``offset``; rad of cam, m.

    ``uncertainty``: standard uncertainty of the offset, from the residual of the fit and from the
    difference between the flanks; ``opening`` and ``closing``: the offset by either flank alone;
    ``gain``: measured lift over lift of the case; ``base`` (m) added to it. ``cam_angle``,
    ``measured``, ``model``: shape (angles,), both lifts over the angle of the case.

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
        residual: Array = self.measured - self.base - self.gain * self.model
        return residual


def align_lift(rig_angle: Array, measured: Array, case_lift: Lift) -> LiftAlignment:
    """Align a mean measured lift (m) over ``rig_angle`` (rad of cam, even steps over one
    revolution) to ``case_lift`` (m of rad, periodic).

    Least squares in the offset of either flank, gain and base, begun at the best of all shifts by
    whole steps. Raises :class:`InputError` where either lift does not rise.
    """
    finite = np.isfinite(measured)
    if np.count_nonzero(finite) < 16:
        raise InputError("there is no measured lift to align by; give the offset", "offset")
    grid, count = np.asarray(rig_angle, dtype=np.float64), len(rig_angle)
    lift = np.interp(grid, grid[finite], measured[finite], period=REVOLUTION)
    model = np.asarray(case_lift(grid), dtype=np.float64)
    if np.ptp(lift) <= 0 or np.ptp(model) <= 0:
        raise InputError(
            "a lift that never rises aligns nothing; name the channel of the lift, or give the offset",
            "offset",
        )
    correlation = np.fft.irfft(
        np.conj(np.fft.rfft(lift - lift.mean())) * np.fft.rfft(model - model.mean()), count
    )
    flanks, gain, base, deviations = _fit(
        grid, lift, case_lift, float(grid[int(np.argmax(correlation))])
    )
    offset, half = sum(flanks) / 2, (flanks[0] - flanks[1]) / 2
    # flanks that are further apart than noise moves them show that the lift is not that of the case
    excess = np.sqrt(max(half**2 - deviations[1] ** 2, 0.0))
    uncertainty = float(np.hypot(deviations[0], excess))
    order = np.argsort((grid + offset) % REVOLUTION)
    placed: Array = ((grid + offset) % REVOLUTION)[order]
    wrapped = float((offset + np.pi) % REVOLUTION - np.pi)
    return LiftAlignment(
        wrapped,
        uncertainty,
        wrapped + half,
        wrapped - half,
        gain,
        base,
        placed,
        lift[order],
        np.asarray(case_lift(placed), dtype=np.float64),
    )


def _fit(
    grid: Array, measured: Array, lift: Lift, offset: float
) -> tuple[tuple[float, float], float, float, tuple[float, float]]:
    """Offsets of opening and closing flank, gain, base, and standard deviations of half the sum and
    half the difference of the offsets.

    Gauss-Newton steps of least squares in all four; a flank is where the lift of the case rises or
    falls.
    """

    def slope_at(angles: Array) -> Array:
        step = 1e-4
        slope: Array = (np.asarray(lift(angles + step)) - np.asarray(lift(angles - step))) / (
            2 * step
        )
        return slope

    solution = np.array([offset, offset, 1.0, 0.0])
    for _ in range(20):
        rising = slope_at(grid + (solution[0] + solution[1]) / 2) >= 0
        angles = grid + np.where(rising, solution[0], solution[1])
        model, slope = np.asarray(lift(angles)), solution[2] * slope_at(angles)
        columns = np.column_stack([slope * rising, slope * ~rising, model, np.ones(len(model))])
        residual = measured - solution[2] * model - solution[3]
        change, *_ = np.linalg.lstsq(columns, residual, rcond=None)
        solution += np.concatenate([np.clip(change[:2], -0.1, 0.1), change[2:]])
        if np.max(np.abs(change[:2])) < 1e-10:
            break
    square = max(float(np.dot(residual, residual)), 1e-300)
    alike = float(np.clip(np.dot(residual[1:], residual[:-1]) / square, 0.0, 0.999))
    # neighbours that err alike count once
    freedom = max(len(residual) * (1 - alike) / (1 + alike) - 4, 1.0)
    scale = np.mean(residual**2) * len(residual) / freedom
    covariance = np.linalg.pinv(columns.T @ columns) * scale
    variances = covariance[0, 0] + covariance[1, 1]
    of_sum, of_difference = (
        float(np.sqrt(max(variances + sign * 2 * covariance[0, 1], 0.0)) / 2) for sign in (1, -1)
    )
    opening, closing, gain, base = map(float, solution)
    return (opening, closing), gain, base, (of_sum, of_difference)
