"""Result of a recording: cycles of every channel, where they were cut, what was found on the way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from valvetrain.arrays import Array
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.rig.alignment import LiftAlignment
from valvetrain.rig.channels import RigQuantity
from valvetrain.rig.cutting import CycleGrid
from valvetrain.rig.shaft import ShaftAngle
from valvetrain.solution.display import Reported


def student(count: int) -> float:
    """Factor of a 95 % interval of the mean of ``count`` values."""
    return float(stdtrit(count - 1, 0.975)) if count > 1 else float("inf")


def mean_spread(values: Array, step: float, angle_uncertainty: float) -> Array:
    """Half width of the 95 % band of the mean over cycles: scatter over the cycles, and the slope
    times twice the angle's uncertainty.
    """
    count = len(values)
    if count < 2:
        return np.full(values.shape[1], np.inf)
    mean = np.mean(values, axis=0)
    slope = (np.roll(mean, -1) - np.roll(mean, 1)) / (2 * step)
    scatter = student(count) * np.std(values, axis=0, ddof=1) / np.sqrt(count)
    spread: Array = np.hypot(scatter, 2 * angle_uncertainty * np.abs(slope))
    return spread


@dataclass(frozen=True, eq=False)
class RigChannelCycles:
    """One channel: its ``cycles``, the ``raw`` samples (SI), the highest frequency ``band`` (Hz)
    that was retained, the spread of its mean.

    ``spread``: half width of the 95 % band of the mean (SI), shape (angles,): scatter of the
    cycles, and the slope times the uncertainty of the cam angle. ``taken_off``: zero that was taken
    off in each dwell, empty where none was. ``clipped``: the samples stay at the end of a range.
    ``drift``: change of the mean of a cycle over the recording (SI), 0 where there is no trend.
    """

    cycles: MeasuredCycles
    raw: RigQuantity
    band: float
    spread: Array
    taken_off: Array
    clipped: bool = False
    drift: float = 0.0

    @property
    def top(self) -> tuple[float, float, float]:
        """Largest value of the mean cycle, half width of its band (0 where there is none), and its cam angle (rad)."""
        place = int(np.argmax(self.cycles.mean))
        spread = float(self.spread[place])
        bar = spread if math.isfinite(spread) else 0.0
        return float(self.cycles.mean[place]), bar, float(self.cycles.cam_angle[place])

    def peaks(self, sign: float = 1.0) -> tuple[Array, Array]:
        """Largest value (smallest with ``sign`` -1) of each cycle and its cam angle (rad), both of
        shape (cycles,).
        """
        index = np.argmax(sign * self.cycles.values, axis=1)
        return self.cycles.values[np.arange(len(index)), index], self.cycles.cam_angle[index]


class Peak(NamedTuple):
    """An extreme of the cycles of a channel, in SI units and rad: mean, half width of its 95 % interval, and standard
    deviation over the cycles; its circular mean angle and the scatter of that. NaN: none, as of a single cycle.
    """

    figure: str
    mean: float
    interval: float
    scatter: float
    cam_angle: float
    scatter_of_angle: float


def peaks_of(channel: RigChannelCycles) -> list[Peak]:
    """Largest and smallest value over the cycles."""
    peaks = []
    for name, sign in (("largest", 1.0), ("smallest", -1.0)):
        values, angles = channel.peaks(sign)
        middle = float(np.angle(np.mean(np.exp(1j * angles))) % (2 * np.pi))
        away = (angles - middle + np.pi) % (2 * np.pi) - np.pi
        spread, interval = math.nan, math.nan
        if len(values) > 1:
            spread = float(np.std(values, ddof=1))
            interval = student(len(values)) * spread / math.sqrt(len(values))
        scatter_of_angle = float(np.sqrt(np.mean(away**2)))
        mean = float(np.mean(values))
        peaks.append(Peak(name, mean, interval, spread, middle, scatter_of_angle))
    return peaks


@dataclass(frozen=True, eq=False)
class RigResult(Reported):
    """Cycles of a recording, as :func:`valvetrain.rig.rig_cycles` returns them.

    Parameters
    ----------
    name, form : of the file
    channels : one RigChannelCycles per quantity, in the order in which they were named
    shaft : cam angle over time
    grid : times of the cycles, outliers among them
    retained : numbers of the cycles (from 0) that are in ``channels``
    outliers : number of a cycle and why it was left out (or would have been)
    offset : cam angle of the case at the mark, rad; ``offset_uncertainty`` its standard uncertainty
        (rad), 0 where it was stated
    alignment : fit of the lift that gave the offset, None where it was not fitted
    synthetic : the recording was computed
    notes : what was found, assumed and left out, a sentence each
    placed : a case or an offset says which cam angle the mark is; else angles count from the mark

    >>> [name for name in RigResult.__dataclass_fields__ if name in ("channels", "offset")]
    ['channels', 'offset']
    """

    name: str
    form: str
    channels: tuple[RigChannelCycles, ...]
    shaft: ShaftAngle
    grid: CycleGrid
    retained: tuple[int, ...]
    outliers: tuple[tuple[int, str], ...]
    offset: float
    offset_uncertainty: float
    alignment: LiftAlignment | None
    synthetic: bool
    notes: tuple[str, ...]
    placed: bool = True

    @property
    def cycles(self) -> tuple[MeasuredCycles, ...]:
        """Cycles of every channel, as a model is compared with them."""
        return tuple(channel.cycles for channel in self.channels)

    def __repr__(self) -> str:
        names = ", ".join(channel.cycles.quantity for channel in self.channels)
        return f"RigResult '{self.name}' ({self.form}): {names}, {len(self.retained)} of {self.grid.cycles} cycles"
