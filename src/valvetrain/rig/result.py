"""What becomes of a recording: cycles of every channel, where they were cut, what was found on the
way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.rig.channels import RigQuantity
from valvetrain.rig.cutting import CycleGrid
from valvetrain.rig.shaft import ShaftAngle

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: The most that flanks may lie apart (rad of cam) before it is told.
APART = np.radians(0.5)


@dataclass(frozen=True, eq=False)
class LiftAlignment:
    """Cam angle of the case = angle of the rig + ``offset``; rad of cam, m.

    ``uncertainty``: standard uncertainty of the offset, from what the fit leaves and from the
    difference between the flanks; ``opening``
    and ``closing``: the offset that either flank tells alone; ``gain``: measured lift over lift of
    the case; ``base`` (m) added to it.
    ``cam_angle``, ``measured``, ``model``: shape (angles,), both lifts over the angle of the case.
    ``residual``: measured minus fitted.

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


def align_lift(
    rig_angle: Array, measured: Array, case_lift: Callable[[Array], Array]
) -> LiftAlignment:
    """Lay a mean measured lift (m) over ``rig_angle`` (rad of cam, even steps over one turn) over
    ``case_lift`` (m of rad, periodic).

    Least squares in the offset of either flank, gain and base, begun at the best of all shifts by
    whole steps. Raises
    :class:`InputError` where either lift does not rise.
    """
    known = np.isfinite(measured)
    if np.count_nonzero(known) < 16:
        raise InputError("there is no measured lift to align by; give the offset", "offset")
    grid, count = np.asarray(rig_angle, dtype=np.float64), len(rig_angle)
    one = np.interp(grid, grid[known], measured[known], period=TURN)
    two = np.asarray(case_lift(grid), dtype=np.float64)
    if np.ptp(one) <= 0 or np.ptp(two) <= 0:
        raise InputError(
            "a lift that never rises aligns nothing; name the channel of the lift, or give the offset",
            "offset",
        )
    likeness = np.fft.irfft(
        np.conj(np.fft.rfft(one - one.mean())) * np.fft.rfft(two - two.mean()), count
    )
    flanks, gain, base, spreads = _fitted(
        grid, one, case_lift, float(grid[int(np.argmax(likeness))])
    )
    offset, half = sum(flanks) / 2, (flanks[0] - flanks[1]) / 2
    # flanks that lie further apart than noise moves them say that the lift is not that of the case
    uncertainty = float(np.hypot(spreads[0], np.sqrt(max(half**2 - spreads[1] ** 2, 0.0))))
    order = np.argsort((grid + offset) % TURN)
    placed: Array = ((grid + offset) % TURN)[order]
    wrapped = float((offset + np.pi) % TURN - np.pi)
    return LiftAlignment(
        wrapped,
        uncertainty,
        wrapped + half,
        wrapped - half,
        gain,
        base,
        placed,
        one[order],
        np.asarray(case_lift(placed), dtype=np.float64),
    )


def _slope(lift: Callable[[Array], Array], angles: Array) -> Array:
    step = 1e-4
    slope: Array = (np.asarray(lift(angles + step)) - np.asarray(lift(angles - step))) / (2 * step)
    return slope


def _fitted(
    grid: Array, one: Array, lift: Callable[[Array], Array], offset: float
) -> tuple[tuple[float, float], float, float, tuple[float, float]]:
    """Offsets of opening and closing flank, gain, base, and standard deviations of half the sum and
    half the difference of the offsets.

    Gauss-Newton steps of least squares in all four; a flank is where the lift of the case rises or
    falls.
    """
    found = np.array([offset, offset, 1.0, 0.0])
    for _ in range(20):
        rising = _slope(lift, grid + (found[0] + found[1]) / 2) >= 0
        at = grid + np.where(rising, found[0], found[1])
        model, slope = np.asarray(lift(at)), found[2] * _slope(lift, at)
        columns = np.column_stack([slope * rising, slope * ~rising, model, np.ones(len(model))])
        left = one - found[2] * model - found[3]
        change, *_ = np.linalg.lstsq(columns, left, rcond=None)
        found += np.concatenate([np.clip(change[:2], -0.1, 0.1), change[2:]])
        if np.max(np.abs(change[:2])) < 1e-10:
            break
    alike = float(
        np.clip(np.dot(left[1:], left[:-1]) / max(float(np.dot(left, left)), 1e-300), 0.0, 0.999)
    )
    free = max(
        len(left) * (1 - alike) / (1 + alike) - 4, 1.0
    )  # neighbours that err alike count once
    scale = np.mean(left**2) * len(left) / free
    covariance = np.linalg.pinv(columns.T @ columns) * scale
    both = [
        float(
            np.sqrt(max(covariance[0, 0] + covariance[1, 1] + sign * 2 * covariance[0, 1], 0.0)) / 2
        )
        for sign in (1, -1)
    ]
    return (float(found[0]), float(found[1])), float(found[2]), float(found[3]), (both[0], both[1])


#: 97.5 % point of Student's distribution for 1, 2, ... degrees of freedom; 1.96 beyond.
_STUDENT = (
    12.71,
    4.303,
    3.182,
    2.776,
    2.571,
    2.447,
    2.365,
    2.306,
    2.262,
    2.228,
    2.201,
    2.179,
    2.16,
    2.145,
    2.131,
    2.12,
    2.11,
    2.101,
    2.093,
)


def student(count: int) -> float:
    """Factor of a 95 % interval of the mean of ``count`` values."""
    return (
        float("inf")
        if count < 2
        else _STUDENT[count - 2]
        if count - 2 < len(_STUDENT)
        else 1.96 + 2.4 / (count - 1)
    )


@dataclass(frozen=True, eq=False)
class RigChannelCycles:
    """One channel: its ``cycles``, the ``raw`` samples (SI), the highest frequency ``band`` (Hz)
    that was kept, the spread of its mean.

    ``spread``: half width of the 95 % band of the mean (SI), shape (angles,): scatter of the
    cycles, and what the uncertainty of the cam
    angle makes of the slope. ``taken_off``: zero that was taken off in each dwell, empty where none
    was.
    """

    cycles: MeasuredCycles
    raw: RigQuantity
    band: float
    spread: Array
    taken_off: Array

    def peaks(self, sign: float = 1.0) -> tuple[Array, Array]:
        """Largest value (smallest with ``sign`` -1) of each cycle and its cam angle (rad), both of
        shape (cycles,).
        """
        place = np.argmax(sign * self.cycles.values, axis=1)
        return self.cycles.values[np.arange(len(place)), place], self.cycles.cam_angle[place]


@dataclass(frozen=True, eq=False)
class RigResult:
    """Cycles of a recording.

    Parameters
    ----------
    name, form : of the file
    channels : one RigChannelCycles a quantity, in the order in which they were named
    shaft : cam angle over time
    grid : where the cycles lie, outliers among them
    kept : numbers of the cycles (from 0) that are in ``channels``
    outliers : number of a cycle and why it was left out (or would have been)
    offset : cam angle of the case at the mark, rad; ``offset_uncertainty`` its standard uncertainty
        (rad), 0 where it was stated
    alignment : how the lift told it, None where it did not
    synthetic : the recording was computed
    notes : what was found, assumed and left out, a sentence each

    Made by :func:`valvetrain.rig_cycles`.

    >>> [name for name in RigResult.__dataclass_fields__ if name in ("channels", "offset")]
    ['channels', 'offset']
    """

    name: str
    form: str
    channels: tuple[RigChannelCycles, ...]
    shaft: ShaftAngle
    grid: CycleGrid
    kept: tuple[int, ...]
    outliers: tuple[tuple[int, str], ...]
    offset: float
    offset_uncertainty: float
    alignment: LiftAlignment | None
    synthetic: bool
    notes: tuple[str, ...]

    @property
    def cycles(self) -> tuple[MeasuredCycles, ...]:
        """Cycles of every channel, as a model is compared with them."""
        return tuple(channel.cycles for channel in self.channels)

    def __repr__(self) -> str:
        names = ", ".join(channel.cycles.quantity for channel in self.channels)
        return f"RigResult '{self.name}' ({self.form}): {names}, {len(self.kept)} of {self.grid.cycles} cycles"


def mean_spread(values: Array, step: float, angle_uncertainty: float) -> Array:
    """Half width of the 95 % band of the mean over cycles: scatter over the cycles, and the slope
    times twice the angle's uncertainty.
    """
    count = len(values)
    mean = np.mean(values, axis=0)
    slope = (np.roll(mean, -1) - np.roll(mean, 1)) / (2 * step)
    by_angle = 2 * angle_uncertainty * np.abs(slope)
    if count < 2:
        return np.full(values.shape[1], np.inf)
    scatter = student(count) * np.std(values, axis=0, ddof=1) / np.sqrt(count)
    spread: Array = np.hypot(scatter, by_angle)
    return spread
