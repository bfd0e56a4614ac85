"""A gauge between a trace and what is recorded of it: resonance of its mounting, analog low-pass,
sampling, resolution.
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
#: Highest order of the low-pass, steps in the shortest period of the gauge, sampling phases that
#: are tried, most steps of a trace.
HIGHEST_ORDER, STEPS, PHASES, MAX_STEPS = 8, 40, 32, 20_000_000
_GIVEN = {
    "bandwidth": "frequency", "sampling_rate": "frequency", "natural_frequency": "frequency", "mounting_stiffness": "stiffness",
    "moved_mass": "mass",
}  # fmt: skip


@dataclass(frozen=True)
class SensorResponse:
    """What a gauge makes of a trace: ``time`` (s) and ``values`` (unit of the trace), sampled where
    the gauge samples.

    >>> SensorResponse(np.array([0.0, 1.0]), np.array([2.0, 5.0]), 9.0, (4.0, 5.0)).peak
    5.0
    """

    time: Array
    values: Array
    true_peak: float
    #: Least and largest peak over the phases of the sampling, which nobody chooses.
    peaks: tuple[float, float]

    @property
    def peak(self) -> float:
        """Largest value of this record."""
        return float(np.max(self.values))


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A gauge; every part that is left out is ideal.

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
        for name, dimension in _GIVEN.items():
            if (given := getattr(self, name)) is not None:
                value = si(given, dimension, f"{name} of the gauge")
                if not 0 < value < 1e15:
                    raise InputError(
                        f"{name} of {value:g} is none of a gauge; give it above zero", name
                    )
                object.__setattr__(self, name, value)
        if (
            isinstance(self.order, bool)
            or not isinstance(self.order, int)
            or not 1 <= self.order <= HIGHEST_ORDER
        ):
            raise InputError(
                f"order is a whole number from 1 to {HIGHEST_ORDER}, not {str(self.order)[:20]}; correct it",
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
        """Amplitude seen over true one at ``signal_frequencies`` (Hz), by the transfer function."""
        points, out = (
            2j * np.pi * np.asarray(signal_frequencies, dtype=float),
            np.ones(len(signal_frequencies)),
        )
        for poles, twice in self._stages():
            one = np.abs(np.prod([-pole / (points - pole) for pole in poles], axis=0))
            out = out * (one**2 if twice else one)
        return out

    def response(self, time: Array, values: Array, periodic: bool = False) -> Array:
        """The trace behind resonance and low-pass, before it is sampled.

        ``time`` (s) rising, ``values`` joined by straight lines between; ``periodic``: the trace
        repeats, its last value being its first.
        Each pole is integrated exactly over straight lines. Raises :class:`InputError` for a trace
        that is none.
        """
        grid, fine = self._even(np.asarray(time, dtype=float), np.asarray(values, dtype=float))
        found: Array = np.interp(time, grid, self._through(fine, grid[1] - grid[0], periodic))
        return found

    def seen(
        self, time: Array, values: Array, phase: float = 0.0, periodic: bool = False
    ) -> SensorResponse:
        """The trace as recorded; ``phase`` (0 to 1, in samples): where the first sample falls.
        Arguments and errors as :meth:`response`.
        """
        given = np.asarray(values, dtype=float)
        grid, fine = self._even(np.asarray(time, dtype=float), given)
        smooth = self._through(fine, grid[1] - grid[0], periodic)
        if self.sampling_rate is None:
            top = float(np.max(smooth))
            return SensorResponse(grid, self._rounded(smooth), float(np.max(given)), (top, top))
        step = 1 / float(self.sampling_rate)

        def sampled(first: float) -> tuple[Array, Array]:
            at = np.arange(grid[0] + first * step, grid[-1], step)
            return at, self._rounded(np.interp(at, grid, smooth))

        tops = [
            float(np.max(sampled(place / PHASES)[1], initial=-np.inf)) for place in range(PHASES)
        ]
        at, out = sampled(phase % 1.0)
        if not len(at):
            raise InputError(
                "the trace is shorter than one sample of the gauge; give a higher sampling rate",
                "sampling_rate",
            )
        return SensorResponse(at, out, float(np.max(given)), (min(tops), max(tops)))

    def _rounded(self, values: Array) -> Array:
        return np.round(values / self.resolution) * self.resolution if self.resolution else values

    def _stages(self) -> list[tuple[Complex, bool]]:
        """Poles (rad/s) of each stage of unit gain at rest, and whether it is passed forward and
        backward.
        """
        stages: list[tuple[Complex, bool]] = []
        if self.resonance is not None:
            turn, damping = 2 * np.pi * self.resonance, float(self.damping_ratio)
            root = (
                np.sqrt(complex(damping**2 - 1)) or 1e-6
            )  # twin poles are drawn apart by what nobody sees
            stages.append(
                (
                    np.array(
                        [turn * (root - damping), -turn * (root + damping)], dtype=np.complex128
                    ),
                    False,
                )
            )
        if self.bandwidth is not None:
            edge = 2 * np.pi * float(self.bandwidth)
            if self.filter == "bessel":
                poles = signal.bessel(self.order, edge, analog=True, norm="mag", output="zpk")[1]
            else:
                poles = signal.butter(self.order, edge, analog=True, output="zpk")[1]
            stages.append((np.asarray(poles, dtype=np.complex128), self.zero_phase))
        return stages

    def _even(self, time: Array, values: Array) -> tuple[Array, Array]:
        """The trace on an even grid that is fine enough for the gauge and holds every given point
        of an even trace.
        """
        if (
            len(time) < 2
            or time.shape != values.shape
            or not np.isfinite(values).all()
            or not (np.diff(time) > 0).all()
        ):
            raise InputError(
                "a trace needs two points at least, its times rising and its values finite; correct it",
                "time",
            )
        span = float(time[-1] - time[0])
        finest = min(
            float(np.min(np.diff(time))),
            1 / (STEPS * self.highest_frequency) if self.highest_frequency else np.inf,
        )
        even = float(np.max(np.abs(np.diff(time) * (len(time) - 1) / span - 1))) < 1e-6
        share = int(np.ceil(span / (len(time) - 1) / finest - 1e-9))
        parts = (len(time) - 1) * share if even else int(np.ceil(span / max(finest, 1e-300)))
        if parts > MAX_STEPS:
            raise InputError(
                f"the trace would need {parts:.2g} steps for this gauge; cut it, or lower its frequencies",
                "time",
            )
        grid = np.linspace(time[0], time[-1], parts + 1)
        return grid, np.interp(grid, time, values)

    def _through(self, values: Array, step: float, periodic: bool) -> Array:
        for poles, twice in self._stages():
            values = _passed(poles, values, step, periodic)
            if twice:
                values = _passed(poles, values[::-1], step, periodic)[::-1]
        return values


def _passed(poles: Complex, values: Array, step: float, periodic: bool) -> Array:
    """Values behind prod(-p / (s - p)), begun at rest at the first value, or in the periodic state.

    In partial fractions each pole is a recursion, exact for straight lines between the values.
    """
    gain = np.prod(-poles)
    out = np.zeros(len(values))
    for place, pole in enumerate(poles):
        residue = gain / np.prod(pole - np.delete(poles, place))
        grown = pole * step
        decay = np.exp(grown)
        rest = (
            np.expm1(grown) - grown
            if abs(grown) > 1e-4
            else grown**2 * (0.5 + grown / 6 + grown**2 / 24)
        )
        late = rest / (pole * grown)
        early = np.expm1(grown) / pole - late
        pushed = residue * (early * values[:-1] + late * values[1:])
        begin = -residue * values[0] / pole
        state = signal.lfilter([1.0], [1.0, -decay], pushed, zi=[decay * begin])[0]
        if periodic:  # what a turn begun at nothing ends with tells what every turn begins with
            whole = decay ** len(pushed)
            nothing = state[-1] - whole * begin
            state = state + (nothing / (1 - whole) - begin) * decay ** np.arange(1, len(pushed) + 1)
            begin = nothing / (1 - whole)
        out += np.real(np.concatenate([[begin], state]))
    return out
