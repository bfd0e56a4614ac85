"""Sensor model: filters a computed force as a gauge of finite bandwidth would show it.

Its parts are the resonance of the mounting and an analog low-pass.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy import signal

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.schema_types import Table, problem, quantity, table

Complex = NDArray[np.complex128]
GaugeFrequency = Annotated[float, quantity("frequency", low=0.0, high=1e15, open_low=True)]
#: Steps in the shortest period of the gauge, steps of a trace at most.
STEPS, MAX_STEPS = 40, 20_000_000


@table("the gauge")
class Sensor(Table):
    """Sensor model of a gauge; every part that is left out is ideal.

    Parameters
    ----------
    bandwidth : -3 dB frequency of the analog low-pass (Hz, or text)
    order : of the low-pass, 1 to 8
    filter : ``butterworth`` or ``bessel``
    zero_phase : the rig filters forward and backward, as in ``filtfilt``: no delay, -6 dB at the
        bandwidth
    natural_frequency : of the gauge on its mounting (Hz, or text)
    damping_ratio : of that resonance, above 0 to 2; needed with it, such as 0.02 for a bare quartz

    >>> gauge = Sensor(bandwidth="20 kHz", order=1)
    >>> time = np.linspace(0.0, 2e-4, 801)
    >>> round(float(gauge.response(time, 1.0 * (time > 1e-4))[480]), 2)  # 1 - exp(-2 pi 20 kHz 20 us)
    0.92
    """

    bandwidth: GaugeFrequency | None = None
    order: Annotated[int, Field(ge=1, le=8)] = 4
    filter: Literal["butterworth", "bessel"] = "butterworth"
    zero_phase: bool = False
    natural_frequency: GaugeFrequency | None = None
    damping_ratio: Annotated[float, quantity("ratio", low=0.0, high=2.0)] = 0.0

    def __post_init__(self) -> None:
        if self.natural_frequency is not None and not self.damping_ratio > 0:
            raise problem(
                "a resonance without damping rings for ever; give its damping_ratio, such as 0.02"
            )

    def response(self, time: Array, values: Array) -> Array:
        """A cycle as the gauge shows it turn after turn: filtered by resonance and low-pass.

        ``time`` (s) rising, ``values`` joined by straight lines between, the last being the first of the next cycle.
        Raises :class:`InputError` for times that do not rise and values that are not finite.
        """
        time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
        grid, stages = self._grid(time, values), self._stages()
        if not stages:
            return values
        count, order = len(grid) - 1, np.arange((len(grid) + 1) // 2)
        omega = 2j * np.pi * order / (grid[-1] - grid[0])
        # harmonics of a curve that is straight between its values
        gain = np.sinc(order / count) ** 2 + 0j
        for poles, twice in stages:
            passed = np.prod([pole / (pole - omega) for pole in poles], axis=0)
            gain *= np.abs(passed) ** 2 if twice else passed
        seen = np.fft.irfft(np.fft.rfft(np.interp(grid[:-1], time, values)) * gain, count)
        return np.asarray(np.interp(time, grid, np.append(seen, seen[0])))

    def _stages(self) -> list[tuple[Complex, bool]]:
        """Poles (rad/s) of each stage of unit static gain, and whether it is passed forward and
        backward.
        """
        stages: list[tuple[Complex, bool]] = []
        if self.natural_frequency is not None:
            omega, damping = 2 * np.pi * self.natural_frequency, self.damping_ratio
            root = np.sqrt(complex(damping**2 - 1))
            pair = [omega * (root - damping), -omega * (root + damping)]
            stages.append((np.array(pair, dtype=np.complex128), False))
        if self.bandwidth is not None:
            edge = 2 * np.pi * self.bandwidth
            if self.filter == "bessel":
                poles = signal.bessel(self.order, edge, analog=True, norm="mag", output="zpk")[1]
            else:
                poles = signal.butter(self.order, edge, analog=True, output="zpk")[1]
            stages.append((np.asarray(poles, dtype=np.complex128), self.zero_phase))
        return stages

    def _grid(self, time: Array, values: Array) -> Array:
        """Even times (s) that are fine enough for the gauge and hold every given point of an even trace."""
        steps = np.diff(time)
        if (
            len(time) < 2
            or time.shape != values.shape
            or not np.isfinite(values).all()
            or not (steps > 0).all()
        ):
            raise InputError(
                "a trace needs two points at least, its times rising and its values finite; correct it",
                "time",
            )
        span = float(time[-1] - time[0])
        highest = max(self.bandwidth or 0.0, self.natural_frequency or 0.0)
        finest = min(float(np.min(steps)), 1 / (STEPS * highest) if highest else np.inf)
        even = float(np.max(np.abs(steps * (len(time) - 1) / span - 1))) < 1e-6
        share = int(np.ceil(span / (len(time) - 1) / finest - 1e-9))
        parts = (len(time) - 1) * share if even else int(np.ceil(span / max(finest, 1e-300)))
        if parts > MAX_STEPS:
            raise InputError(
                f"the trace would need {parts:.2g} steps for this gauge; cut it, or lower its frequencies",
                "time",
            )
        return np.linspace(time[0], time[-1], parts + 1)
