"""Order spectrum: amplitude of a channel per cam revolution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.quantities.cycle import Cycle

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OrderSpectrum:
    """``order`` (order): oscillations per cam revolution, from 0; ``amplitude`` (order): zero to peak, in the channel's unit."""

    order: Array
    amplitude: Array
    unit: str


def order_spectrum(cycle: Cycle, channel: str = "seat_force", largest_order: int | None = None) -> OrderSpectrum:
    """Amplitudes by cam order over one whole cycle; order 0 is the mean.

    The cycle is resampled to even cam angles first. A jump between its ends (a run not yet periodic) leaks into all orders.
    """
    values, count = cycle.channel(channel), len(cycle.cam_angle)
    even = np.arange(count) * 2 * np.pi / count
    resampled = np.interp(even, cycle.cam_angle, values, period=2 * np.pi)
    amplitude = np.abs(np.fft.rfft(resampled)) / count
    amplitude[1 : (count + 1) // 2] *= 2
    keep = len(amplitude) if largest_order is None else min(largest_order + 1, len(amplitude))
    unit = str(cycle.solution.channels[channel].attrs.get("units", "1"))
    return OrderSpectrum(np.arange(keep, dtype=float), amplitude[:keep], unit)


def surge_order(natural_frequency: float, engine_speed: float) -> float:
    """Cam order of a natural frequency (Hz) at ``engine_speed`` (rad/s of the crank)."""
    return natural_frequency * 2 * np.pi / (engine_speed / 2)
