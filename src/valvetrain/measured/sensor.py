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
    >>> time = np.linspace(0.0, 1e-4, 401)
    >>> round(float(gauge.response(time, np.ones(401) * (time > 0))[80]), 2)  # 1 - exp(-2 pi 20 kHz 20 us)
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

    def response(self, time: Array, values: Array, periodic: bool = False) -> Array:
        """The trace filtered by resonance and low-pass.

        ``time`` (s) rising, ``values`` joined by straight lines between; ``periodic``: the trace
        repeats, its last value being its first. Each pole is integrated exactly over straight
        lines. Raises :class:`InputError` for times that do not rise and values that are not finite.
        """
        time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
        grid = self._grid(time, values)
        seen, step = np.interp(grid, time, values), grid[1] - grid[0]
        for poles, twice in self._stages():
            seen = _passed(poles, seen, step, periodic)
            if twice:
                seen = _passed(poles, seen[::-1], step, periodic)[::-1]
        return np.interp(time, grid, seen)

    def _stages(self) -> list[tuple[Complex, bool]]:
        """Poles (rad/s) of each stage of unit static gain, and whether it is passed forward and
        backward.
        """
        stages: list[tuple[Complex, bool]] = []
        if self.natural_frequency is not None:
            omega, damping = 2 * np.pi * self.natural_frequency, self.damping_ratio
            # a double pole is split by a negligible amount
            root = np.sqrt(complex(damping**2 - 1)) or 1e-6
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


def _passed(poles: Complex, values: Array, step: float, periodic: bool) -> Array:
    """Values filtered by prod(-p / (s - p)), begun in equilibrium with the first value, or in the
    periodic state.

    In partial fractions each pole is a recursion, exact for straight lines between the values.
    """
    gain = np.prod(-poles)
    out = np.zeros(len(values))
    for index, pole in enumerate(poles):
        residue = gain / np.prod(pole - np.delete(poles, index))
        exponent = pole * step
        decay = np.exp(exponent)
        rest = (
            np.expm1(exponent) - exponent
            if abs(exponent) > 1e-4
            else exponent**2 * (0.5 + exponent / 6 + exponent**2 / 24)
        )
        late = rest / (pole * exponent)
        early = np.expm1(exponent) / pole - late
        forcing = residue * (early * values[:-1] + late * values[1:])
        begin = -residue * values[0] / pole
        state = signal.lfilter([1.0], [1.0, -decay], forcing, zi=[decay * begin])[0]
        if periodic:  # a cycle begun at zero ends with the state from which every cycle follows
            whole = decay ** len(forcing)
            from_zero = state[-1] - whole * begin
            steady = from_zero / (1 - whole)
            state = state + (steady - begin) * decay ** np.arange(1, len(forcing) + 1)
            begin = steady
        out += np.real(np.concatenate([[begin], state]))
    return out
