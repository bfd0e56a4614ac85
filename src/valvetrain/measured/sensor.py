"""Sensor model: filters and samples a computed force as a gauge of finite bandwidth would record it.

Its parts are the resonance of the mounting, an analog low-pass, sampling and resolution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from valvetrain.errors import InputError
from valvetrain.units import Given, si

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Filter = Literal["butterworth", "bessel"]
#: Order of the low-pass at most, steps in the shortest period of the gauge, sampling phases that are
#: tried, steps of a trace at most.
MAX_ORDER, STEPS, PHASES, MAX_STEPS = 8, 40, 32, 20_000_000
_DIMENSIONS = {
    "bandwidth": "frequency", "sampling_rate": "frequency", "natural_frequency": "frequency", "mounting_stiffness": "stiffness",
    "moved_mass": "mass"
}  # fmt: skip


@dataclass(frozen=True)
class SensorResponse:
    """A trace as a gauge records it: ``time`` (s) and ``values`` (unit of the trace) of its samples,
    the largest value of the true trace, and the smallest and largest peak over all sampling phases.

    >>> SensorResponse(np.array([0.0, 1.0]), np.array([2.0, 5.0]), 9.0, (4.0, 5.0)).peak
    5.0
    """

    time: Array
    values: Array
    true_peak: float
    peaks: tuple[float, float]

    @property
    def peak(self) -> float:
        """Largest value of this record."""
        return float(np.max(self.values))


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """Sensor model of a gauge; every part that is left out is ideal.

    Parameters
    ----------
    bandwidth : -3 dB frequency of the analog low-pass (Hz, or text)
    order : of the low-pass, 1 to 8
    filter : ``butterworth`` or ``bessel``
    zero_phase : the rig filters forward and backward, as in ``filtfilt``: no delay, -6 dB at the
        bandwidth
    natural_frequency : of the gauge on its mounting (Hz, or text); or
    mounting_stiffness, moved_mass : N/m and kg, from which it follows: sqrt(k / m) / (2 pi)
    damping_ratio : of that resonance, above 0 to 2; needed with it, such as 0.02 for a bare quartz
    sampling_rate : 1/s, or text
    resolution : step of the recorded values, in the unit of the trace; 0 for none

    >>> gauge = Sensor(bandwidth="20 kHz", order=1)
    >>> time = np.linspace(0.0, 1e-4, 401)
    >>> round(float(gauge.response(time, np.ones(401) * (time > 0))[80]), 2)  # 1 - exp(-2 pi 20 kHz 20 us)
    0.92
    """

    bandwidth: Given | None = None
    order: int = 4
    filter: Filter = "butterworth"
    zero_phase: bool = False
    natural_frequency: Given | None = None
    mounting_stiffness: Given | None = None
    moved_mass: Given | None = None
    damping_ratio: float = 0.0
    sampling_rate: Given | None = None
    resolution: float = 0.0

    def __post_init__(self) -> None:
        for name, dimension in _DIMENSIONS.items():
            if (value := getattr(self, name)) is not None:
                si_value = si(value, dimension, f"{name} of the gauge")
                if not 0 < si_value < 1e15:
                    raise InputError(
                        f"{name} of {si_value:g} is none of a gauge; give it above zero", name
                    )
                object.__setattr__(self, name, si_value)
        if (
            isinstance(self.order, bool)
            or not isinstance(self.order, int)
            or not 1 <= self.order <= MAX_ORDER
        ):
            raise InputError(
                f"order is a whole number from 1 to {MAX_ORDER}, not {str(self.order)[:20]}; correct it",
                "order",
            )
        if self.filter not in ("butterworth", "bessel"):
            raise InputError(
                f"filter is butterworth or bessel, not '{str(self.filter)[:20]}'; give one of them",
                "filter",
            )
        for name, most in (("damping_ratio", 2.0), ("resolution", 1e15)):
            value = getattr(self, name)
            if (
                not isinstance(value, (int, float))
                or isinstance(value, bool)
                or not 0 <= value <= most
            ):
                raise InputError(
                    f"{name} is a number from 0 to {most:g}, not {str(value)[:20]}; correct it",
                    name,
                )
        if (self.mounting_stiffness is None) != (self.moved_mass is None):
            raise InputError(
                "mounting_stiffness and moved_mass belong together; give both, or the natural frequency",
                "moved_mass",
            )
        if self.natural_frequency is not None and self.mounting_stiffness is not None:
            raise InputError(
                "give the natural frequency, or stiffness and mass of the mounting, not both",
                "natural_frequency",
            )
        if self.resonance is not None and not self.damping_ratio > 0:
            raise InputError(
                "a resonance without damping rings for ever; give its damping_ratio, such as 0.02",
                "damping_ratio",
            )

    @property
    def resonance(self) -> float | None:
        """Natural frequency (Hz) of the gauge on its mounting, None where it is ideal."""
        if self.mounting_stiffness is not None and self.moved_mass is not None:
            return float(
                np.sqrt(float(self.mounting_stiffness) / float(self.moved_mass)) / (2 * np.pi)
            )
        return None if self.natural_frequency is None else float(self.natural_frequency)

    @property
    def highest_frequency(self) -> float:
        """Highest frequency (Hz) that matters to the gauge; 0 for an ideal one."""
        return max(
            (float(one) for one in (self.bandwidth, self.resonance) if one is not None), default=0.0
        )

    def gain(self, signal_frequencies: Array) -> Array:
        """Recorded amplitude over the true one at ``signal_frequencies`` (Hz), by the transfer
        function.
        """
        frequencies = 2 * np.pi * np.asarray(signal_frequencies, dtype=float)
        gain: Array = np.ones(len(frequencies))
        for poles, twice in self._stages():
            once = np.abs(signal.freqs_zpk([], poles, np.prod(-poles).real, frequencies)[1])
            gain = gain * (once**2 if twice else once)
        return gain

    def response(self, time: Array, values: Array, periodic: bool = False) -> Array:
        """The trace filtered by resonance and low-pass, before it is sampled.

        ``time`` (s) rising, ``values`` joined by straight lines between; ``periodic``: the trace
        repeats, its last value being its first. Each pole is integrated exactly over straight
        lines. Raises :class:`InputError` for times that do not rise and values that are not finite.
        """
        grid, filtered = self._filtered(time, values, periodic)
        return np.interp(time, grid, filtered)

    def record(
        self, time: Array, values: Array, phase: float = 0.0, periodic: bool = False
    ) -> SensorResponse:
        """The trace as recorded; ``phase`` (0 to 1, in samples): where the first sample falls.
        Arguments and errors as :meth:`response`.
        """
        grid, filtered = self._filtered(time, values, periodic)
        true_peak = float(np.max(np.asarray(values, dtype=float)))
        if self.sampling_rate is None:
            top = float(np.max(filtered))
            return SensorResponse(grid, self._rounded(filtered), true_peak, (top, top))
        step = 1 / float(self.sampling_rate)

        def sampled(first: float) -> tuple[Array, Array]:
            at = np.arange(grid[0] + first * step, grid[-1], step)
            return at, self._rounded(np.interp(at, grid, filtered))

        tops = [
            float(np.max(sampled(count / PHASES)[1], initial=-np.inf)) for count in range(PHASES)
        ]
        at, recorded = sampled(phase % 1.0)
        if not len(at):
            raise InputError(
                "the trace is shorter than one sample of the gauge; give a higher sampling rate",
                "sampling_rate",
            )
        return SensorResponse(at, recorded, true_peak, (min(tops), max(tops)))

    def _rounded(self, values: Array) -> Array:
        return np.round(values / self.resolution) * self.resolution if self.resolution else values

    def _stages(self) -> list[tuple[Complex, bool]]:
        """Poles (rad/s) of each stage of unit static gain, and whether it is passed forward and
        backward.
        """
        stages: list[tuple[Complex, bool]] = []
        if self.resonance is not None:
            omega, damping = 2 * np.pi * self.resonance, float(self.damping_ratio)
            # a double pole is split by a negligible amount
            root = np.sqrt(complex(damping**2 - 1)) or 1e-6
            pair = [omega * (root - damping), -omega * (root + damping)]
            stages.append((np.array(pair, dtype=np.complex128), False))
        if self.bandwidth is not None:
            edge = 2 * np.pi * float(self.bandwidth)
            if self.filter == "bessel":
                poles = signal.bessel(self.order, edge, analog=True, norm="mag", output="zpk")[1]
            else:
                poles = signal.butter(self.order, edge, analog=True, output="zpk")[1]
            stages.append((np.asarray(poles, dtype=np.complex128), self.zero_phase))
        return stages

    def _filtered(self, time: Array, values: Array, periodic: bool) -> tuple[Array, Array]:
        """Times and filtered values on an even grid that is fine enough for the gauge and holds
        every given point of an even trace.
        """
        time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
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
        span, highest = float(time[-1] - time[0]), self.highest_frequency
        finest = min(float(np.min(steps)), 1 / (STEPS * highest) if highest else np.inf)
        even = float(np.max(np.abs(steps * (len(time) - 1) / span - 1))) < 1e-6
        share = int(np.ceil(span / (len(time) - 1) / finest - 1e-9))
        parts = (len(time) - 1) * share if even else int(np.ceil(span / max(finest, 1e-300)))
        if parts > MAX_STEPS:
            raise InputError(
                f"the trace would need {parts:.2g} steps for this gauge; cut it, or lower its frequencies",
                "time",
            )
        grid = np.linspace(time[0], time[-1], parts + 1)
        values, step = np.interp(grid, time, values), grid[1] - grid[0]
        for poles, twice in self._stages():
            values = _passed(poles, values, step, periodic)
            if twice:
                values = _passed(poles, values[::-1], step, periodic)[::-1]
        return grid, values


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
