"""Order spectrum: amplitude per cam revolution, and what of it the surge of the spring is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.quantities.cycle import Cycle, Frame
from valvetrain.quantities.forces import fine_of_cycle

Array = NDArray[np.float64]
#: Cam orders whose amplitude is a quantity.
ORDERS = 40
#: Surge shows in the cam orders within this share of its own, below and above.
SURGE_BAND = (0.5, 1.5)


@dataclass(frozen=True, eq=False)
class OrderSpectrum:
    """``order`` (order): oscillations per cam revolution, from 0; ``amplitude`` (order): zero to
    peak, in the channel's unit.
    """

    order: Array
    amplitude: Array
    unit: str


def order_spectrum(
    cycle: Cycle, channel: str = "seat_force", largest_order: int | None = None
) -> OrderSpectrum:
    """Amplitudes by cam order over one whole cycle; order 0 is the mean.

    The cycle is resampled to even cam angles first. A jump between its ends (a run not yet
    periodic) leaks into all orders.
    """
    amplitude = order_amplitudes(cycle.cam_angle, cycle.channel(channel))
    keep = len(amplitude) if largest_order is None else min(largest_order + 1, len(amplitude))
    unit = cycle.solution.unit(channel)
    return OrderSpectrum(np.arange(keep, dtype=float), amplitude[:keep], unit)


def order_amplitudes(cam_angle: Array, values: Array) -> Array:
    """Amplitude (0 to peak) of every order of ``values`` over one turn; ``cam_angle`` (rad)
    ascending.
    """
    count = len(cam_angle)
    even = np.arange(count) * 2 * np.pi / count
    amplitude: Array = (
        np.abs(np.fft.rfft(np.interp(even, cam_angle, values, period=2 * np.pi))) / count
    )
    amplitude[1 : (count + 1) // 2] *= 2
    return amplitude


def surge_order(natural_frequency: float, engine_speed: float) -> float:
    """Cam order of a natural frequency (Hz) at ``engine_speed`` (rad/s of the crank)."""
    return natural_frequency * 2 * np.pi / (engine_speed / 2)


def surge_engine_speeds(
    natural_frequency: float, lowest: float, highest: float
) -> dict[str, float]:
    """Engine speeds (rad/s) from ``lowest`` to ``highest`` at which a cam order, to :data:`ORDERS`,
    meets a natural frequency (Hz).

    By order: 4 pi f / n, where harmonic n of the lift turns n times as fast as the cam.
    """
    met = {n: 4 * np.pi * natural_frequency / n for n in range(1, ORDERS + 1)}
    return {
        f"surge_order_{n}_engine_speed": speed
        for n, speed in met.items()
        if lowest <= speed <= highest
    }


def surge_residual(cycle: Cycle, frame: Frame) -> tuple[Array, Array] | None:
    """Cam angle (rad) and seat force less the static force at the same lift (N) over the cycle, as
    finely as the run holds the force.

    None where either force is not known. Output samples alone would fold the clashes' high
    frequencies into the low orders.
    """
    solution = cycle.solution
    if not solution.has("seat_force", "valve_lift"):
        return None
    known = solution.has("static_retainer_force")
    static = (
        cycle.channel("static_retainer_force")
        if known
        else frame.static_force(cycle.channel("valve_lift"), solution.model)
    )
    if static is None:
        return None
    angle, force = fine_of_cycle(cycle, "seat_force")
    return angle, force - np.interp(angle, cycle.cam_angle, static, period=2 * np.pi)


def surge_quantities(cycle: Cycle, frame: Frame) -> dict[str, float]:
    """Surge frequency, its cam order, the nearest harmonic of the lift, and the surge in the seat
    force by cam order.
    """
    found: dict[str, float] = {}
    residual, highest = surge_residual(cycle, frame), frame.surge_frequency
    amplitude = None if residual is None else order_amplitudes(*residual)
    if amplitude is not None:
        found |= {
            f"surge_order_{order}_force": float(size)
            for order, size in enumerate(amplitude[: ORDERS + 1])
            if order > 0
        }
    if highest is None or not cycle.solution.engine_speed > 0:
        return found
    place = surge_order(highest, cycle.solution.engine_speed)
    found |= {"surge_frequency": highest, "surge_cam_order": place}
    if len(frame.surge_frequencies) == len(cycle.solution.springs) > 1:
        found |= {
            f"{name}_surge_frequency": one
            for name, one in zip(cycle.solution.springs, frame.surge_frequencies, strict=True)
        }
    if frame.valve_lift is not None:
        nearest = max(1, round(place))
        found |= {
            "nearest_lift_harmonic_order": float(nearest),
            "nearest_lift_harmonic_lift": lift_harmonic(frame.valve_lift, nearest),
        }
    first, last = int(np.ceil(SURGE_BAND[0] * place)), int(np.floor(SURGE_BAND[1] * place))
    if amplitude is not None and max(first, 1) <= last < len(amplitude):
        found["surge_amplitude_force"] = float(np.max(amplitude[max(first, 1) : last + 1]))
    return found


def lift_harmonic(valve_lift: Callable[[Array], Array], order: int) -> float:
    """Amplitude (m, 0 to peak) of one cam harmonic of a lift law."""
    count = max(4096, 16 * order)
    return float(
        2 * np.abs(np.fft.rfft(valve_lift(np.arange(count) * 2 * np.pi / count))[order]) / count
    )
