"""Branches of a train's motion: a march up and down in engine speed, each speed from the motion of the one before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.integrate.contract import Orbit
from valvetrain.integrate.multipliers import (
    DIRECTIONS,
    DISTURBANCE,
    loss_of_stability,
    lyapunov_exponent,
)
from valvetrain.integrate.steady import FAST, repeat_cycles
from valvetrain.integrate.train_record import TrainOptions, TrainState
from valvetrain.integrate.train_run import TrainRunner, runner
from valvetrain.integrate.train_steady import (
    SteadyTrain,
    scaled_cycle,
    steady_train,
    train_multipliers,
    unscaled,
)
from valvetrain.parameters.loading import AnyCase
from valvetrain.quantities.train_numbers import OpenWindow, turn_quantities
from valvetrain.runs.prepared import PreparedRun
from valvetrain.runs.refusals import refuse_implausible, refuse_speeds
from valvetrain.runs.requests import MARCHED
from valvetrain.runs.train_runs import prepare_trains
from valvetrain.runs.workers import Progress
from valvetrain.solution.branches import UNRESOLVED, Branches, BranchPoint
from valvetrain.solution.status import PartialFailures
from valvetrain.springs.own_spring import model_names
from valvetrain.system.build import build
from valvetrain.system.train_system import TrainSystem
from valvetrain.units import Given, as_names, known_arguments, si_speeds

#: Sizes of the disturbances by which an orbit's stability is judged. It is resolved where twice the difference of their
#: multipliers is less than what the nearer one lacks to 1: where an impact is gained or lost, they differ by up to 0.6.
DISTURBANCES = DISTURBANCE, 3 * DISTURBANCE
#: Samples of a revolution; the search of an orbit: change of a cycle, and most cycles.
SAMPLES, ORBIT_TOLERANCE, ORBIT_CYCLES = 720, 1e-6, 40
#: Plain revolutions in which a motion settles that no orbit attracts, and the change of a cycle at which it repeats.
SETTLING, REPEATS = 120, 1e-5
#: Revolutions of a motion that never repeats whose values are kept, and over which a disturbance grows.
SHOWN, GROWTH = 24, 60


@dataclass
class _March:
    """A march of a prepared train in one direction, with the revolutions that it took so far."""

    ready: PreparedRun
    quantity: str
    rising: bool
    window: OpenWindow
    revolutions: int = 0
    points: list[BranchPoint] = field(default_factory=list)

    def step(self, engine_speed: float, before: Orbit | None) -> Orbit:
        """Add what the train does at a speed (rad/s), from the motion of the speed before; the motion there."""
        assert isinstance(self.ready.system, TrainSystem)
        options = TrainOptions(
            SAMPLES, window=self.ready.window or (0.0, math.tau), nose=self.ready.nose or 0.0
        )
        train = runner(self.ready.system, engine_speed / 2, options, rest=self.ready.rest)
        settled = self._orbit(train, before)
        if self._attracts(engine_speed, settled):
            return settled.orbit
        start = train.initial_state() if before is None else before.at(train)
        cycle, scaled, _ = scaled_cycle(train, start)
        rest = repeat_cycles(cycle, scaled, np.ones(len(scaled)), REPEATS, SETTLING)
        self.revolutions += rest.cycles
        state = unscaled(train, start, rest.state)
        ended = Orbit(state, train.springs, train.cam_speed)
        if (
            not settled.search.converged
        ):  # plain revolutions may have led near an orbit that attracts slowly
            again = self._orbit(train, ended)
            if self._attracts(engine_speed, again):
                return again.orbit
        self._plain(engine_speed, train, ended, rest.period)
        return ended

    def _orbit(self, train: TrainRunner, before: Orbit | None) -> SteadyTrain:
        """The orbit of one revolution that corrected cycles approach, whether it attracts or not."""
        settled = steady_train(
            train, "anderson", ORBIT_TOLERANCE, ORBIT_CYCLES, before, compared=False, probed=False
        )
        self.revolutions += settled.search.cycles
        return settled

    def _attracts(self, engine_speed: float, settled: SteadyTrain) -> bool:
        """Add an orbit where one was found; whether it attracts, by its multipliers unless its cycles approach it fast."""
        if not settled.search.converged:
            return False
        size, repels = math.nan, ""
        if settled.search.contraction > FAST:
            largest = [train_multipliers(settled, one)[0] for one in DISTURBANCES]
            self.revolutions += 4 * DIRECTIONS  # two cycles each, by both sizes
            sizes, repels = np.abs(largest), UNRESOLVED
            if 2 * np.ptp(sizes) < np.abs(sizes - 1).min():
                size, repels = float(sizes[0]), loss_of_stability(largest[0])
        value, landings, _ = self._value(settled.runner, settled.start)
        point = BranchPoint(engine_speed, self.rising, 1, (value,), landings, repels, size)
        self.points.append(point)
        return not repels

    def _plain(self, engine_speed: float, train: TrainRunner, motion: Orbit, period: int) -> None:
        """Add the motion that plain revolutions end on, which repeats after ``period`` of them or never."""
        values, landings, exponent, state = list[float](), 0, math.nan, motion.state
        for _ in range(period or SHOWN):
            value, landings, state = self._value(train, state)
            values.append(value)
        self.revolutions += len(values)
        if not period:
            cycle, scaled, _ = scaled_cycle(train, state)
            exponent = lyapunov_exponent(cycle, scaled, GROWTH)
            self.revolutions += 2 * GROWTH
        point = BranchPoint(
            engine_speed, self.rising, period, tuple(values), landings, exponent=exponent
        )
        self.points.append(point)

    def _value(self, train: TrainRunner, start: TrainState) -> tuple[float, int, TrainState]:
        """The quantity (SI) in a revolution from a state, NaN where it has none, its landings, and the state after it."""
        end, record = train.cycle(start)
        value = turn_quantities(train.system, record, self.window).get(self.quantity, math.nan)
        return value, int(np.sum(record.transitions.closes)), replace(end, cam_angle=0.0)


@known_arguments
def branches(
    case: AnyCase,
    engine_speeds: Given | Sequence[Given],
    models: Sequence[str] | str = (),
    *,
    spring_sets: Sequence[str] | str = (),
    quantity: str = "loft_gap",
    revolutions: int = MARCHED,
    progress: Progress | None = None,
    implausible: bool = False,
) -> Branches:
    """Motions of a train over engine speed: a march up through the speeds and down again, each from the motion before.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file; it holds a train
    engine_speeds : of the crank, "7000:9700:25 rpm" (first:last:step), rad/s or pint quantities; the step shows
        what is narrower not at all
    models, spring_sets : as for :func:`valvetrain.simulate`; the first of several is marched
    quantity : number of a revolution: loft_gap, seating_velocity, float_excess_lift, peak_valve_lift, peak forces
    revolutions : most that the march takes; it then ends with what it has
    progress : called with the share done and a text
    implausible : whether values outside the plausible ranges pass

    Returns
    -------
    Branches: points with period, multiplier, Lyapunov exponent; ranges of hysteresis and of chaos

    Raises
    ------
    InputError : a case without a train, springs whose runs take minutes, a quantity that a revolution does not have

    Examples
    --------
    >>> import valvetrain as vt
    >>> found = vt.runs.branches("tdi-pushrod", "8000:8100:50 rpm", spring_sets="stock")
    >>> [(point.motion, round(1e3 * point.values[0], 2)) for point in found.attracting(rising=True)]
    [('period 1', 0.16), ('period 1', 0.15), ('period 1', 0.19)]
    """
    problem = build(
        case, spring_models=model_names(models), spring_set=as_names(spring_sets)
    ).settled()
    speeds = tuple(sorted(si_speeds(engine_speeds, "engine_speed", "engine_speeds")))
    refuse_speeds(problem, speeds)
    if not implausible:
        refuse_implausible(problem, speeds)
    ready = prepare_trains(problem, speeds, PartialFailures())[0][0]
    if ready.refusal:
        raise InputError(ready.refusal)
    if ready.motion is None or not isinstance(ready.system, TrainSystem):
        raise InputError(
            f"case '{problem.record.name}' holds no train, whose motion has branches; give one with a cam and a valve"
        )
    if ready.system.has_large_springs:
        raise InputError(
            "branches are marched for springs whose revolution takes milliseconds; choose another spring model, such as multi-mass"
        )
    window = OpenWindow.of(ready.motion.kinematics)
    known = _quantities(ready, speeds[0], window)
    if quantity not in known:
        raise InputError(f"a revolution has no '{quantity}'; choose {', '.join(sorted(known))}", "quantity")  # fmt: skip
    points, spent, orbit = list[BranchPoint](), 0, None
    for rising in (True, False):
        march = _March(ready, quantity, rising, window)
        for place, speed in enumerate(speeds if rising else speeds[::-1]):
            if spent + march.revolutions >= revolutions:
                break
            orbit = march.step(speed, orbit)
            if progress is not None:
                share = (place + 1) / len(speeds) / 2
                progress(share if rising else 0.5 + share, f"{speed * 30 / math.pi:.6g} rpm")
        points += march.points
        spent += march.revolutions
    marched = {(one.rising, one.engine_speed) for one in points}
    return Branches(
        ready.member.label, quantity, tuple(points), spent, len(marched) == 2 * len(speeds)
    )


def _quantities(ready: PreparedRun, engine_speed: float, window: OpenWindow) -> set[str]:
    """Names of the numbers of a revolution."""
    assert isinstance(ready.system, TrainSystem)
    train = runner(ready.system, engine_speed / 2, TrainOptions(SAMPLES), rest=ready.rest)
    _, record = train.cycle(train.initial_state())
    return {*turn_quantities(train.system, record, window), "seating_velocity"}
