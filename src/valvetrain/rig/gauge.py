"""A run as a gauge records it: finest traces of a run through a sensor, both peaks of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measured.sensor import Sensor, SensorResponse
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.quantities.signal import fine_series
from valvetrain.runs.api import simulate
from valvetrain.solution.result import Solution
from valvetrain.system.build import build

Array = NDArray[np.float64]
#: Channels that a gauge may measure, in this order.
CHANNELS = (
    "retainer_force", "seat_force", "cam_contact_force", "seat_contact_force", "valve_tip_contact_force", "valve_acceleration"
)  # fmt: skip
#: Points of a trace in the shortest period of the gauge; bounds of the samples per cam revolution;
#: points that a run stores per sample.
POINTS, MIN_SAMPLES, MAX_SAMPLES, STORED = 40, 720, 40_000, 8


@dataclass(frozen=True, eq=False)
class ChannelResponse:
    """One channel of one run: the true trace (``time`` s, ``values`` SI, its step ``spacing`` s)
    and what the gauge records of it (``recorded``).

    >>> [name for name in ChannelResponse.__dataclass_fields__ if name in ("true_peak", "recorded")]
    ['recorded']
    """

    label: str
    engine_speed: float
    channel: str
    unit: str
    time: Array
    values: Array
    spacing: float
    recorded: SensorResponse
    #: The trace is too coarse for this gauge, so its spikes may be between the points.
    coarse: bool

    @property
    def true_peak(self) -> float:
        """Largest value of the trace (SI)."""
        return float(np.max(self.values))

    @property
    def recorded_peak(self) -> float:
        """Middle of the recorded peaks over all phases of the sampling (SI)."""
        return sum(self.recorded.peaks) / 2

    @property
    def share(self) -> tuple[float, float]:
        """Smallest and largest recorded peak over the true one, over all phases of the sampling."""
        low, high = self.recorded.peaks
        return (low / self.true_peak, high / self.true_peak) if self.true_peak else (1.0, 1.0)


def sensor_response(
    solution: Solution, sensor: Sensor, channels: Sequence[str] = ()
) -> tuple[ChannelResponse, ...]:
    """Channels of a run as a gauge records them.

    Parameters
    ----------
    solution : one run; its finest traces are used, not its output samples
    sensor : the gauge
    channels : names of channels, such as "retainer_force"; forces and valve acceleration by default

    Returns
    -------
    One ChannelResponse per channel: true trace, recorded trace, both peaks

    Raises
    ------
    InputError : a channel that the run does not have, a run without channels

    Examples
    --------
    >>> import valvetrain as vt
    >>> (run,) = vt.simulate("job-t", "6000 rpm", models=["multi-mass"]).solutions
    >>> (one,) = sensor_response(run, Sensor(bandwidth="200 Hz"), ["retainer_force"])
    >>> one.recorded.peak < one.true_peak
    True
    """
    variables = solution.arrays.variables
    available = tuple(name for name in CHANNELS if name in variables)
    chosen = tuple(channels) or available
    for name in chosen:
        if name not in variables or variables[name].values.ndim != 1:
            raise InputError(
                f"the run has no channel '{str(name)[:40]}' over time; it has {', '.join(available) or 'none'}",
                "channels",
            )
    if not chosen or len(solution.time) < 8:
        raise InputError(
            "the run stores no forces, so no gauge can record them; run it with its channels",
            "channels",
        )
    origin = solution.provenance
    label, speed = getattr(solution, "label", "") or "", origin.engine_speed if origin else 0.0
    responses = []
    for name in chosen:
        time, values, spacing = finest_trace(solution, name)
        recorded = sensor.record(time, values, periodic=True)
        coarse = sensor.highest_frequency * spacing * POINTS > 4
        unit = str(variables[name].attrs.get("units", ""))
        responses.append(
            ChannelResponse(label, speed, name, unit, time, values, spacing, recorded, coarse)
        )
    return tuple(responses)


def finest_trace(solution: Solution, name: str) -> tuple[Array, Array, float]:
    """Times (s), values and step (s) of the finest trace of a channel that a run stores: points
    between samples, extremes of steps.
    """
    time, _, values = fine_series(solution, name)
    if time[-1] < solution.time[-1]:
        time = np.append(time, solution.time[-1])
        values = np.append(values, solution.channel(name)[-1])
    spacing = float(np.max(np.diff(time)))
    for kind in ("highest", "lowest"):
        if solution.has(f"{name}_{kind}"):
            extremes, at = (
                solution.channel(word) for word in (f"{name}_{kind}", f"{name}_{kind}_time")
            )
            inside = np.isfinite(at) & np.isfinite(extremes) & (at > time[0]) & (at < time[-1])
            time = np.concatenate([time, at[inside]])
            values = np.concatenate([values, extremes[inside]])
    time, first = np.unique(time, return_index=True)
    # an extreme that falls on a point is that point
    apart = np.concatenate([[True], np.diff(time) > 1e-3 * spacing])
    return time[apart], values[first][apart], spacing


def case_response(
    case: AnyCase,
    sensor: Sensor,
    engine_speeds: Sequence[float] = (),
    models: Sequence[str] = (),
) -> tuple[ChannelResponse, ...]:
    """Every run of a case with traces as fine as the gauge needs, as the gauge records them.

    ``engine_speeds`` in rad/s of the crank (empty: the case's own). Raises :class:`InputError` for
    a case that cannot run; a run that fails gives no channels.
    """
    chosen = case_of(case)
    speeds = tuple(engine_speeds) or build(chosen).engine_speeds
    if not speeds:
        raise InputError("the case names no engine speed; give one", "--rpm")

    def responses_at(speed: float, samples: float) -> list[ChannelResponse]:
        step = 2 * np.pi / float(np.clip(samples, MIN_SAMPLES, MAX_SAMPLES))
        study = simulate(
            chosen.replace(operation=chosen.operation.replace(output_step=step)),
            f"{speed!r} rad/s",
            models=models,
            progress=lambda *_: None,
        )
        channels: list[ChannelResponse] = []
        for run in study.solutions:
            if run.status.code in ("completed", "not-converged"):
                channels += sensor_response(run, sensor)
            else:
                failed.append(run.status.message)
        return [channel for channel in channels if np.any(channel.values)]

    responses: list[ChannelResponse] = []
    failed: list[str] = []
    for speed in speeds:
        need = 4 * np.pi / speed * sensor.highest_frequency * POINTS
        channels = responses_at(speed, need / (STORED if chosen.train is None else 1))
        # a model that stores nothing between its samples
        coarse = chosen.train is None and any(channel.coarse for channel in channels)
        responses += responses_at(speed, need) if coarse else channels
    if not responses:
        raise InputError(
            f"no run of the case was completed ({failed[0]}); examine it with 'valvetrain run'",
            "case",
        )
    return tuple(responses)
