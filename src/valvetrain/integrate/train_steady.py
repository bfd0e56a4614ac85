"""Periodic steady state of a train: its cycle map on a scaled state vector, by repetition or
Anderson acceleration.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.integrate.contract import Orbit
from valvetrain.integrate.multipliers import DISTURBANCE, ComplexArray, multipliers
from valvetrain.integrate.spring_return import rigid_motion, spring_basis, spring_return
from valvetrain.integrate.steady import (
    FAST,
    SteadyState,
    accelerate,
    repeat_cycles,
    residual_norm,
)
from valvetrain.integrate.train_channels import COMPARED, LONG_SEARCH, Scatter, scatter_of
from valvetrain.integrate.train_record import CycleRecord, TrainState
from valvetrain.integrate.train_run import OFF_CAM, TrainRunner
from valvetrain.parameters.summary import share_text
from valvetrain.solution.status import COMPLETED, Status

TOLERANCE = 1e-5
"""Largest change per cycle, relative to the lift (positions) and to lift times cam speed
(velocities).
"""

SLOWEST = 0.3
"""Contraction per cycle that is expected at most: beyond, a cycle is recorded once too often."""
FASTEST = 1e4
"""Speed (m/s, rad/s) beyond which a cycle ended early."""


@dataclass(frozen=True)
class SteadyTrain:
    """The last cycle of a train with how it settled; ``record`` follows from ``start``.
    ``scatter``: of a train that did not, if requested.
    """

    runner: TrainRunner
    search: SteadyState
    start: TrainState
    record: CycleRecord
    wall_time_per_cycle: float = field(default=0.0, compare=False)
    tolerance: float = TOLERANCE
    scatter: Scatter | None = None

    @property
    def status(self) -> Status:
        """Completed, also where parts that are loose rattle while the valve repeats; diverged; out
        of range, also where nothing touches the cam any more; not converged with the period found.
        """
        if not self.record.status.completed:
            return self.record.status
        if (lift := self._unread_lift) > 0:
            return Status(
                "out-of-range",
                f"the cam touches nothing in a whole revolution, though its law opens the valve by {1e3 * lift:.4g} mm",
                self.runner.steps * self.runner.time_step,
                "cam",
                OFF_CAM,
            )
        if self.search.converged:
            return self.record.status
        spread = (
            ""
            if self.scatter is None
            else f"{1e6 * self.scatter.valve:.2g} um over {COMPARED} cycles"
        )
        period = self.search.period
        message = (
            f"repeats only every {period} cycles (sub-harmonic)"
            if period > 1
            else "does not repeat, not over up to 8 cycles either"
        )
        if self.scatter is not None and self.scatter.repeats and self.search.cycles >= LONG_SEARCH:
            return Status(
                "completed",
                f"the valve repeats to {spread}; the motion of all parts {message}, see the scatter",
            )
        cycles, last = self.search.cycles, self.search.residuals[-1]
        change = f"after {cycles} cycles it still changes by {share_text(last)} of its size (accepted: {share_text(self.tolerance)})"
        reached = self.search.cycles * self.runner.steps * self.runner.time_step
        return Status(
            "not-converged",
            f"the motion {message}; {change}" + (f", the valve lift by {spread}" if spread else ""),
            reached,
            "",
            f"set cycles in [train] above {cycles} (--set train.cycles=...), or lower the speed if the train floats or bounces there",
        )

    @property
    def orbit(self) -> Orbit:
        """The motion as a start for another speed."""
        record, place = self.record, self.runner.system.arrays.retainer
        motion = np.array([record.q[:, place], record.v[:, place] / record.cam_speed])
        settled, fast = self.search.converged, self.search.contraction
        return Orbit(
            self.start, self.runner.springs, record.cam_speed, motion if settled else None, fast
        )

    @property
    def _unread_lift(self) -> float:
        """Lift (m) of the law where the cam touches nothing, neither in the last cycle nor, of
        motion that does not settle, in those compared: such may fly for one; 0 where it touches.
        """
        system = self.runner.system
        alone = self.search.converged or (self.scatter is not None and not self.scatter.on_cam)
        if self.record.touches_cam(system) or not alone or system.mechanism.kinematics is None:
            return 0.0
        return float(system.mechanism.kinematics.maximum_lift)


@dataclass
class _Cycles:
    """The cycle map of a train on packed states. The cycle that is expected to be the last, by the ``contraction``
    before, is recorded: ``last`` holds its image, its start and its record.
    """

    runner: TrainRunner
    template: TrainState
    weights: Array
    tolerance: float
    contraction: float = FAST
    times: list[float] = field(default_factory=list)
    changes: list[float] = field(default_factory=list)
    last: tuple[Array, TrainState, CycleRecord] | None = None

    def __call__(self, vector: Array) -> Array:
        begun = time.perf_counter()
        start = _unpack(vector, self.template, self.runner)
        recorded = self._expected() <= self.tolerance
        if recorded:
            end, record = self.runner.cycle(start)
            # what its status says of the step or the travel is said of the train, not of the search
            status = COMPLETED if np.all(np.abs(end.v) < FASTEST) else record.status
        else:
            end, status = self.runner.after(start)
        self.times.append(time.perf_counter() - begun)
        if not (status.completed and self.runner.travel_status(end.q[None]).completed):
            return np.full_like(vector, np.nan)
        self.template = replace(end, cam_angle=0.0)
        image = _pack(end, self.runner)
        self.changes.append(residual_norm(image - vector, self.weights))
        if recorded:
            self.last = image, start, record
        return image

    def _expected(self) -> float:
        """Change that the next cycle will bring; infinite before the first."""
        if not self.changes:
            return np.inf
        rate = self.contraction
        if len(self.changes) > 1:
            rate = self.changes[-1] / max(self.changes[-2], 1e-300)
        return self.changes[-1] * min(rate, SLOWEST)


def steady_train(
    runner: TrainRunner,
    method: str = "anderson",
    tolerance: float = TOLERANCE,
    cycles: int = 60,
    start: Orbit | None = None,
    compared: bool = True,
    least: int = 1,
    probed: bool = True,
    rattling: float = np.inf,
) -> SteadyTrain:
    """Search the periodic orbit from ``start`` (static equilibrium by default, the springs in their answer to the
    rigid lift), with the record of its last cycle.

    ``method``: ``repeat`` (the classical one, of ``least`` cycles and more) or ``anderson``, corrected by the springs'
    own return, with a test
    whether the orbit attracts where ``probed`` and in doubt. The record of the last cycle of a
    train that does not settle is given with its status saying so, and, where requested
    (``compared``; the search is less patient without), with the scatter of some more cycles; so is one that settled to no better than
    ``rattling``, unless the next two cycles have the same numbers.
    """
    begin = runner.initial_state() if start is None else start.at(runner)
    weights, correct = _weights(begin, runner), None
    cycle = _Cycles(runner, begin, weights, tolerance, FAST if start is None else start.contraction)
    if method == "anderson":
        springs = spring_return(runner, weights)
        if springs.parts:
            correct = springs.corrected
            motion = rigid_motion(runner) if start is None else start.motion
            if motion is not None:
                cycle.template = springs.answer(begin, motion)
        search = accelerate(
            cycle,
            _pack(cycle.template, runner),
            weights,
            tolerance,
            cycles,
            probed=probed,
            patient=compared,
            correct=correct,
        )
    else:
        cycle.tolerance = 0.0
        vector = _pack(begin, runner)
        search = repeat_cycles(cycle, vector, weights, tolerance, cycles, least=least)
    if not np.isfinite(search.residuals[-1]) and method == "anderson":
        # an extrapolation may have led there: only plain cycles show that the train itself does
        cycle.template = begin
        search = repeat_cycles(cycle, _pack(begin, runner), weights, tolerance, cycles)
    # what is no part of the motion (histories, contact memories) is taken from the last cycle that
    # was completed
    first = _unpack(search.state, cycle.template, runner)
    scatter = None
    last = search.residuals[-1]
    if np.isfinite(last) and (last > rattling if search.converged else compared):
        scatter, first = scatter_of(runner, first, unless_equal=search.converged)
    if cycle.last is not None and search.state is cycle.last[0] and scatter is None:
        _, first, record = cycle.last
    else:
        _, record = runner.cycle(first)
    typical = float(np.median(cycle.times))
    return SteadyTrain(runner, search, first, record, typical, tolerance, scatter)


def scaled_cycle(
    runner: TrainRunner, template: TrainState
) -> tuple[Callable[[Array], Array], Array, Array]:
    """The cycle map of a train on scaled states: lengths over the lift, velocities over lift times cam speed.

    Parameters
    ----------
    runner : the train at one speed
    template : gives what is no part of the motion, and the state in which the map starts

    Returns
    -------
    (map, ``template`` as scaled state (n,), weights (n,) that scale a packed state). The image of a state from
    which the train leaves its range is NaN.
    """
    weights = _weights(template, runner)
    weights = np.where(weights > 0, weights, 1.0)

    def cycle(scaled: Array) -> Array:
        end, status = runner.after(_unpack(scaled / weights, template, runner))
        if not (status.completed and runner.travel_status(end.q[None]).completed):
            return np.full_like(scaled, np.nan)
        return _pack(end, runner) * weights

    return cycle, _pack(template, runner) * weights, weights


def unscaled(runner: TrainRunner, template: TrainState, scaled: Array) -> TrainState:
    """The state that a scaled one (n,) of :func:`scaled_cycle` stands for; ``template`` as there."""
    weights = _weights(template, runner)
    return _unpack(scaled / np.where(weights > 0, weights, 1.0), template, runner)


def train_multipliers(settled: SteadyTrain, disturbance: float = DISTURBANCE) -> ComplexArray:
    """The largest multipliers of the orbit of a train, the largest first; see :func:`multipliers`."""
    cycle, orbit, weights = scaled_cycle(settled.runner, settled.start)
    basis = spring_basis(settled.runner, weights)
    return multipliers(cycle, orbit, basis, disturbance=disturbance)


def _split(state: TrainState, runner: TrainRunner) -> list[tuple[Array, int]]:
    """Spring states with the number of entries that belong to the motion (positions and
    velocities).
    """
    return [
        (values, 2 * spring.unknowns)
        for values, spring in zip(state.springs, runner.springs, strict=True)
    ]


def _pack(state: TrainState, runner: TrainRunner) -> Array:
    memory, _ = runner.system.differential_memory(1.0)
    return np.concatenate(
        [
            state.q,
            state.v,
            state.law_state[memory],
            *[values[:count] for values, count in _split(state, runner)],
        ]
    )


def _unpack(vector: Array, template: TrainState, runner: TrainRunner) -> TrainState:
    state = template.copy()
    place = len(state.q)
    state.q[:], state.v[:] = vector[:place], vector[place : 2 * place]
    memory, _ = runner.system.differential_memory(1.0)
    state.law_state[memory] = vector[2 * place : 2 * place + len(memory)]
    place = 2 * place + len(memory)
    for values, count in _split(state, runner):
        values[:count] = vector[place : place + count]
        place += count
    return state


def _weights(state: TrainState, runner: TrainRunner) -> Array:
    """One over the scale of every unknown: lift for lengths, a quarter radian for levers, times the
    cam speed for velocities.
    """
    kinematics = runner.system.mechanism.kinematics
    lift = max(kinematics.maximum_lift if kinematics is not None else 0.0, 1e-4)
    units = [0.25 if part.unit == "rad" else lift for part in runner.system.mechanism.coordinates]
    scales = [
        np.array(units),
        np.array(units) * runner.cam_speed,
        runner.system.differential_memory(lift)[1],
    ]
    for _, count in _split(state, runner):
        half = count // 2
        scales.append(
            np.concatenate((np.full(half, lift), np.full(count - half, lift * runner.cam_speed)))
        )
    weights = 1 / np.concatenate(scales)
    weights[2 * len(units) + len(scales[2]) :] *= comparable(runner)
    return weights


def comparable(runner: TrainRunner) -> float:
    """1 where the springs' states take part in the periodicity test; 0 for a finite-element rod,
    whose state holds frames, not lengths.
    """
    return 0.0 if any(spring.name == "finite-element" for spring in runner.springs) else 1.0
