"""Forces of a run as a gauge records them: so that a spike of the model and a gauge of limited band
are compared fairly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measured.sensor import Sensor, SensorResponse
from valvetrain.parameters.loading import AnyCase
from valvetrain.runs.prepared import (
    Plan,
    PreparedRun,
    integrate_point,
    prepare,
    provenance_of,
)
from valvetrain.runs.train_runs import member_statics, prepare_trains
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.solution.result import Solution
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Problem

Array = NDArray[np.float64]
#: Channels that a gauge may stand in for, in this order.
CHANNELS = (
    "retainer_force",
    "seat_force",
    "cam_contact_force",
    "seat_contact_force",
    "valve_tip_contact_force",
    "valve_acceleration",
)
#: Points of a trace in the shortest period of the gauge, and samples of a cam turn at least and at
#: most; points a sample is stored in.
POINTS, FEWEST, MOST, STORED = 40, 720, 40_000, 8


@dataclass(frozen=True, eq=False)
class SeenChannel:
    """One channel of one run: the true trace (``time`` s, ``values`` SI, its step ``spacing`` s)
    and what the gauge records (``seen``).

    >>> [name for name in SeenChannel.__dataclass_fields__ if name in ("true_peak", "seen")]
    ['seen']
    """

    label: str
    engine_speed: float
    channel: str
    unit: str
    time: Array
    values: Array
    spacing: float
    seen: SensorResponse
    #: The trace is too coarse for this gauge, so its spikes may lie between the points.
    coarse: bool

    @property
    def true_peak(self) -> float:
        """Largest value of the trace (SI)."""
        return float(np.max(self.values))

    @property
    def share(self) -> tuple[float, float]:
        """Least and largest recorded peak over the true one, over all phases of the sampling."""
        low, high = self.seen.peaks
        return (low / self.true_peak, high / self.true_peak) if self.true_peak else (1.0, 1.0)


def sensor_response(
    solution: Solution, sensor: Sensor, channels: Sequence[str] = ()
) -> tuple[SeenChannel, ...]:
    """Channels of a run as a gauge records them.

    Parameters
    ----------
    solution : one run; its finest traces are used, not its output samples
    sensor : the gauge
    channels : names of channels, such as "retainer_force"; forces and valve acceleration by default

    Returns
    -------
    One SeenChannel a channel: true trace, recorded trace, both peaks

    Raises
    ------
    InputError : a channel that the run does not have, a run without channels

    Examples
    --------
    >>> import valvetrain as vt
    >>> (run,) = vt.simulate("job-t", "3000 rpm", spring_models=["multi-mass"]).solutions
    >>> (one,) = sensor_response(run, Sensor(bandwidth="200 Hz"), ["retainer_force"])
    >>> one.seen.peak < one.true_peak
    True
    """
    arrays = solution.arrays
    known = arrays.variables
    chosen = tuple(channels) or tuple(name for name in CHANNELS if name in known)
    for name in chosen:
        if name not in known or known[name].values.ndim != 1:
            listed = ", ".join(one for one in CHANNELS if one in known)
            raise InputError(
                f"the run has no channel '{str(name)[:40]}' over time; it has {listed or 'none'}",
                "channels",
            )
    if not chosen or len(solution.time) < 8:
        raise InputError(
            "the run keeps no forces, so no gauge can see them; run it with its channels",
            "channels",
        )
    origin = solution.provenance
    found = []
    for name in chosen:
        time, values, spacing = finest_trace(solution, name)
        seen = sensor.seen(time, values, periodic=True)
        coarse = sensor.highest_frequency * spacing * POINTS > 4
        unit = str(known[name].attrs.get("units", ""))
        label, speed = getattr(solution, "label", "") or "", origin.engine_speed if origin else 0.0
        found.append(SeenChannel(label, speed, name, unit, time, values, spacing, seen, coarse))
    return tuple(found)


def finest_trace(solution: Solution, name: str) -> tuple[Array, Array, float]:
    """Times (s), values and step (s) of the finest trace of a channel that a run keeps: points
    between samples, extremes of steps.
    """
    known = solution.arrays.variables
    time, values = (
        np.asarray(solution.time, dtype=float),
        np.asarray(known[name].values, dtype=float),
    )
    if f"{name}_fine" in known:
        fine = np.asarray(known[f"{name}_fine"].values, dtype=float)
        share = np.arange(fine.shape[1]) / fine.shape[1]
        step = float(time[1] - time[0])
        dense = (time[:-1, np.newaxis] + step * share).ravel()
        time, values = np.append(dense, time[-1]), np.append(fine[:-1].ravel(), values[-1])
    spacing = float(np.max(np.diff(time)))
    for kind in ("highest", "lowest"):
        if f"{name}_{kind}" in known:
            more, at = (
                np.asarray(known[f"{name}_{kind}{word}"].values, dtype=float)
                for word in ("", "_time")
            )
            inside = np.isfinite(at) & np.isfinite(more) & (at > time[0]) & (at < time[-1])
            time, values = (
                np.concatenate([time, at[inside]]),
                np.concatenate([values, more[inside]]),
            )
    time, first = np.unique(time, return_index=True)
    far = np.concatenate(
        [[True], np.diff(time) > 1e-3 * spacing]
    )  # an extreme that falls on a point is that point
    return time[far], values[first][far], spacing


def seen_in_case(
    case: AnyCase,
    sensor: Sensor,
    engine_speeds: Sequence[float] = (),
    spring_models: Sequence[str] = (),
) -> tuple[SeenChannel, ...]:
    """Every run of a case with traces as fine as the gauge needs, as the gauge records them.

    ``engine_speeds`` in rad/s of the crank (empty: the case's own). Raises :class:`InputError` for
    a case that cannot run; a run that
    fails gives no channels.
    """
    problem = build(case, spring_models=tuple(spring_models))
    problem.must_run()
    speeds = tuple(engine_speeds) or problem.engine_speeds
    if not speeds:
        raise InputError("the case names no engine speed; give one", "--engine-speed")
    if problem.kind == TRAIN:
        ready = prepare_trains(problem, speeds, PartialFailures())[0]
    else:
        ready = tuple(
            prepare(problem, member, member_statics(problem, member), problem.record.study)
            for member in problem.members
        )
    found: list[SeenChannel] = []
    why = ""
    for speed in speeds:
        need = 4 * np.pi / speed * sensor.highest_frequency * POINTS
        for one in ready:
            solution = _run(problem, one, speed, need / (1 if problem.kind == TRAIN else STORED))
            if solution.status.code in ("completed", "not-converged"):
                seen = sensor_response(solution, sensor)
                if any(
                    channel.coarse for channel in seen
                ):  # a model that keeps nothing between its samples
                    seen = sensor_response(_run(problem, one, speed, need), sensor)
                found += [channel for channel in seen if np.any(channel.values)]
            else:
                why = why or solution.status.message
    if not found:
        raise InputError(
            f"no run of the case was completed ({why}); look at it with 'valvetrain run'", "case"
        )
    return tuple(found)


def _run(problem: Problem, ready: PreparedRun, engine_speed: float, samples: float) -> Solution:
    plan = Plan(
        "ends", int(np.clip(samples, FEWEST, MOST)), True, problem.cycles, problem.cycles_to_settle
    )
    return integrate_point(
        ready, engine_speed, plan, provenance_of(problem, ready.member, engine_speed, "")
    )
