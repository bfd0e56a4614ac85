"""Aligns a measured lift to the lift of a case: the cam angle at the mark of the rig, by both
flanks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import curve_fit

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.rig.shaft import REVOLUTION

Lift = Callable[[Array], Array]
#: Cam angle (rad) to either side by which a lift rises or falls; sizes of the offsets (rad), gain and base (m).
SLOPE_STEP, STEPS = 1e-4, (1e-2, 1e-2, 1.0, 1e-3)


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
        return self.measured - self.base - self.gain * self.model


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
    start = float(grid[int(np.argmax(correlation))])

    def placed_lift(
        angles: Array, opening: float, closing: float, gain: float, base: float
    ) -> Array:
        """The lift of the case with an offset for either flank, which is where it rises or falls."""
        middle = angles + (opening + closing) / 2
        rising = np.asarray(case_lift(middle + SLOPE_STEP) >= case_lift(middle - SLOPE_STEP))
        placed = np.asarray(case_lift(angles + np.where(rising, opening, closing)))
        return np.asarray(gain * placed + base, dtype=np.float64)

    fitted, covariance = curve_fit(
        placed_lift,
        grid,
        lift,
        (start, start, 1.0, 0.0),
        ftol=1e-14,
        xtol=1e-14,
        x_scale=STEPS,
        method="trf",
    )
    residual = lift - placed_lift(grid, *fitted)
    square = max(float(residual @ residual), 1e-300)
    alike = float(np.clip(residual[1:] @ residual[:-1] / square, 0.0, 0.999))
    # neighbours that err alike count once
    covariance *= (count - 4) / max(count * (1 - alike) / (1 + alike) - 4, 1.0)
    half_sum, half_difference = np.array([[0.5, 0.5], [0.5, -0.5]])
    sum_variance, difference_variance = (
        float(row @ covariance[:2, :2] @ row) for row in (half_sum, half_difference)
    )
    opening, closing, gain, base = map(float, fitted)
    offset, half = (opening + closing) / 2, (opening - closing) / 2
    # flanks that are further apart than noise moves them show that the lift is not that of the case
    uncertainty = float(np.sqrt(sum_variance + max(half**2 - difference_variance, 0.0)))
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
