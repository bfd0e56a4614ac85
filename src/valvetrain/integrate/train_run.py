"""Advance a train by whole cam cycles: step choice and flat buffers. The compiled loop does the work."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.integrate.clash import steps_between
from valvetrain.integrate.train_record import TURN, CycleRecord, TrainOptions, TrainState
from valvetrain.integrate.train_tuples import (
    HIGHEST,
    LOADS,
    LOWEST,
    MIN_FORCE,
    MIN_FORCE_ANGLE,
    NOSE_FORCE,
    OPEN_FORCE,
    PEAK_FORCE,
    PEAK_FORCE_ANGLE,
    PEAK_PENETRATION,
    PEAK_PLACE,
    TRANSITIONS,
    Motion,
    Records,
    Slot,
)
from valvetrain.integrate.transitions import Transitions
from valvetrain.solution.force_peak import steps_per_bin
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.springs.contract import SpringModel, contact_watch_of
from valvetrain.system.train_forces import highest_frequency, springs_time_step
from valvetrain.system.train_rest import TrainRest, rest_of
from valvetrain.system.train_system import TrainSystem

LARGE_SPRING = 2000
"""Unknowns beyond which a record stores positions only."""
SPRING_FRACTION = 0.8
"""Share of a spring's own stable step that is used where the springs decide."""
SHORTEST_STEP = 2e-8
"""Step (s) below which contacts and bodies are refused: a mode beyond some 5 MHz is a slip of
units, and a cycle would take minutes.
"""
OFF_CAM = "run slower, or fit a spring that holds the train on its cam; the model has no stop for its parts"
"""Remedy for a train that lost its cam for good."""


MIN_IMPACT = 0.02
"""Share of the reference force below which a touch is no impact."""


@dataclass(frozen=True)
class TrainRunner:
    """A train adapted to one cam speed and step: carries the arrays, advances states. Build with
    :func:`runner`.
    """

    system: TrainSystem
    cam_speed: float
    steps: int
    options: TrainOptions
    rest: TrainRest
    cam_acceleration: float = 0.0
    springs: tuple[SpringModel, ...] = ()
    fixed_step: float | None = None

    @property
    def time_step(self) -> float:
        """Step (s): one cycle at the nominal cam speed over a whole number of steps, or the
        ``fixed_step`` of a run-up.
        """
        return self.fixed_step or TURN / self.cam_speed / self.steps

    @cached_property
    def spring_arrays(self) -> tuple[tuple[Array, Ints], ...]:
        """Parameters and integers of every spring's kernel, which only reads them: gathered once,
        not at every cycle.
        """
        return tuple((spring.parameters(), spring.integers()) for spring in self.springs)

    def initial_state(self) -> TrainState:
        """Static equilibrium at cam angle zero."""
        q = self.rest.equilibrium.copy()
        lift = float(q[self.system.arrays.retainer])
        states = tuple(np.asarray(s.initial_state(lift), dtype=float) for s in self.springs)
        memory = np.zeros(self.system.arrays.memory_of[-1])
        return TrainState(q, np.zeros_like(q), states, memory, np.array([0.0, 0.0, 0.0, 0.0, lift]))

    def cycle(self, state: TrainState, judged: bool = True) -> tuple[TrainState, CycleRecord]:
        """Advance one cam cycle; the given state stays as it was. ``judged``: look whether the step
        resolved the contacts' stiffness.
        """
        rows, springs = self.options.samples, len(self.springs)
        end, done, motion, records, spacing = self._advance(state, rows)
        extremes, written, count = records.extremes, records.motion, len(end.q)
        status = self._status(
            done, state.cam_angle, extremes[:, PEAK_FORCE] if judged else np.zeros(0)
        )
        if status.completed:
            status = self.travel_status(np.vstack([written[:, :count], end.q]))
        record = CycleRecord(
            written[:, 3 * count],
            written[:, :count],
            written[:, count : 2 * count],
            written[:, 2 * count : 3 * count],
            records.force,
            records.gap,
            records.spring.reshape(rows, 2, 2)[:, :springs],
            (records.spring_a, records.spring_b)[:springs],
            written[:, -1],
            extremes[:, PEAK_FORCE],
            extremes[:, PEAK_PENETRATION],
            motion.totals[:4],
            self.time_step,
            self.cam_speed,
            status,
            float(motion.totals[4]),
            extremes[:, PEAK_FORCE_ANGLE],
            extremes[:, MIN_FORCE],
            extremes[:, MIN_FORCE_ANGLE],
            Transitions.from_log(records.transitions, int(motion.counters[2])),
            (records.pressed_a, records.pressed_b)[:springs],
            spacing * self.time_step,
            extremes[:, OPEN_FORCE],
            extremes[:, NOSE_FORCE],
            records.loads,
            records.bodies,
            records.ends / motion.counters[6],
            self.time_step * int(motion.counters[6]),
            int(motion.counters[6]),
            self.options.force_bandwidth,
        )
        return end, record

    def after(self, state: TrainState) -> tuple[TrainState, Status]:
        """The state one cam cycle later, bit-identical to :meth:`cycle`, and how it ended;
        nothing is written down on the way.
        """
        end, done, *_ = self._advance(state, 0)
        return end, self._status(done, state.cam_angle, np.zeros(0))

    def _advance(
        self, state: TrainState, rows: int
    ) -> tuple[TrainState, int, Motion, Records, int]:
        """One cam cycle: the state after it, steps done, what moved, ``rows`` of records (0: none
        at all), steps per row of contacts.
        """
        from valvetrain.contact.own_law import law_address
        from valvetrain.integrate.spring_slot import no_spring
        from valvetrain.integrate.train_kernel import ready_train_kernel

        arrays, new = self.system.arrays, state.copy()
        count, interactions = len(new.q), len(arrays.kinds)
        kernels: list[Any] = [no_spring] * 2
        states = [np.zeros((rows, 0))] * 2
        slots = [
            Slot(
                np.zeros(1),
                np.zeros(1, dtype=np.int64),
                np.zeros(1),
                np.zeros((0, 2), dtype=np.int64),
            )
        ] * 2
        watches = [
            contact_watch_of(spring) if self.options.record_contacts and rows else None
            for spring in self.springs
        ]
        spacing = min(
            (steps_between(watch, self.time_step) for watch in watches if watch is not None),
            default=1,
        )
        count_rows = (self.steps - 1) // spacing + 1 if any(watches) else 0
        pressed = [np.zeros((count_rows, 0))] * 2
        for place, (spring, (parameters, integers)) in enumerate(
            zip(self.springs, self.spring_arrays, strict=True)
        ):
            watch = watches[place]
            stretches = slots[place].watched if watch is None else watch.stretches
            pressed[place] = np.zeros((count_rows, 0 if watch is None else watch.entries))
            kernels[place], slots[place] = (
                spring.kernel,
                Slot(parameters, integers, new.springs[place], stretches),
            )
            states[place] = np.zeros(
                (rows, recorded_entries(spring) if self.options.record_springs else 0)
            )
        begin, end = self.options.window
        before, least = state.last_step or self.time_step, MIN_IMPACT * self.rest.reference_force
        turning = (state.cam_angle, self.cam_speed, self.cam_acceleration, self.time_step)
        clock = np.array(
            [*turning, *new.held, begin, end - begin, before, before, least, self.options.nose]
        )
        every = self.steps // self.options.samples
        counters = np.array(
            [
                *(self.steps, every, 0, self.options.exchange, spacing, self.options.impact_steps),
                per_bin := steps_per_bin(self.steps, self.time_step),
            ],
            dtype=np.int64,
        )
        addresses = np.array(
            [law_address(kernel) for kernel in self.system.law_kernels], dtype=np.int64
        )
        motion = Motion(new.q, new.v, new.law_state, addresses, clock, counters, np.zeros(5))
        extremes, loads, bodies = (
            np.zeros((interactions, 7)),
            np.zeros((len(LOADS) if rows else 0, 4)),
            np.zeros((count, 5)),
        )
        extremes[:, MIN_FORCE], extremes[:, OPEN_FORCE], bodies[:, PEAK_PLACE] = (
            np.inf,
            -np.inf,
            -np.inf,
        )
        loads[:, HIGHEST], loads[:, LOWEST] = -np.inf, np.inf
        records = Records(
            np.zeros((rows, 3 * count + 2)),
            np.zeros((rows, interactions)),
            np.zeros((rows, interactions)),
            np.zeros((rows, 4)),
            states[0],
            states[1],
            extremes,
            loads,
            np.zeros((self.steps // per_bin if rows else 0, 4)),
            bodies,
            np.zeros((TRANSITIONS if rows else 0, 7)),
            *pressed,
        )
        done = ready_train_kernel()(*kernels, arrays, *slots, motion, records)
        angle = state.cam_angle + TURN if self.cam_acceleration == 0 else float(clock[0])
        return (
            replace(new, held=clock[4:9].copy(), cam_angle=angle, last_step=float(clock[11])),
            done,
            motion,
            records,
            spacing,
        )

    def _status(self, done: int, cam_angle: float, peaks: Array) -> Status:
        if done < self.steps:
            where = np.degrees((cam_angle + done / self.steps * TURN) % TURN)
            return Status(
                "diverged",
                f"a body exceeded 10 km/s near cam angle {where:.1f} deg",
                done * self.time_step,
                "train",
                "lower the step (time_step or step_fraction) or check masses and stiffnesses",
            )
        worst = float(np.max(peaks, initial=0.0))
        if worst > self.rest.reference_force:
            limit = 2 / highest_frequency(self.system, worst)
            if self.time_step > limit:
                return Status(
                    "diverged",
                    f"a contact reached {worst:.0f} N, whose stiffness the step of {self.time_step:.2e} s cannot resolve",
                    self.steps * self.time_step,
                    "contact",
                    f"use a time step below {limit / 2:.1e} s",
                )
        return COMPLETED

    def travel_status(self, q: Array) -> Status:
        """Of positions (S, N) at the samples of a cycle: whether a body left the range in which its
        geometry is defined.
        """
        mechanism, interval = (
            self.system.mechanism,
            self.time_step * self.steps / self.options.samples,
        )
        for name, (low, high) in mechanism.travel.items():
            values = q[:, mechanism.index(name)]
            outside = (values < low) | (values > high)
            if np.any(outside):
                worst = values[int(np.argmax(np.maximum(low - values, values - high)))]
                return Status(
                    "out-of-range",
                    f"the {name} has turned to {np.degrees(worst):.1f} degrees from the closed valve, beyond its dead point "
                    f"({np.degrees(low):.1f} to {np.degrees(high):.1f}), where it no longer carries the motion of cam and valve",
                    int(np.argmax(outside)) * interval,
                    name,
                    OFF_CAM,
                )
        return COMPLETED


def recorded_entries(spring: SpringModel) -> int:
    """How much of a spring's state a record stores: positions and velocities; of very large models
    the positions alone.
    """
    return int(spring.unknowns if spring.unknowns > LARGE_SPRING else 2 * spring.unknowns)


def runner(
    system: TrainSystem,
    cam_speed: float,
    options: TrainOptions | None = None,
    cam_acceleration: float = 0.0,
    rest: TrainRest | None = None,
) -> TrainRunner:
    """A train ready to run at ``cam_speed`` (rad/s; ``cam_acceleration`` rad/s2 for a run-up);
    ``rest`` where it is known already.

    Raises :class:`InputError` for a speed that is not positive, contacts too stiff for any sensible
    step, or a prescribed step that the contacts or springs cannot resolve.
    """
    chosen, still = options or TrainOptions(), rest or rest_of(system)
    if not (np.isfinite(cam_speed) and cam_speed > 0):
        raise InputError(f"the cam speed must be positive; it is {cam_speed:g} rad/s")
    period = TURN / cam_speed
    if chosen.time_step is None:
        step = chosen.step_fraction * still.own_time_step
        if step < SHORTEST_STEP:
            raise InputError(
                f"the stiffest contact or link of train '{system.name}' needs steps of {step:.1e} s; lower its stiffness (a contact of "
                "steel parts has some 100 kN/mm) or raise the mass of what it moves; check their units"
            )
        carried = springs_time_step(system, step)
        step = step if carried >= step else SPRING_FRACTION * carried
    else:
        step = chosen.time_step
        finer = chosen.step_fraction * still.own_time_step / step
        chosen = replace(chosen, impact_steps=int(np.ceil(chosen.impact_steps * max(1.0, finer))))
    limit = springs_time_step(system, still.own_time_step)
    if step > limit:
        raise InputError(
            f"a time step of {step:.2e} s cannot resolve the stiffest contact of train '{system.name}'; use at most {limit:.2e} s "
            "or soften the contact"
        )
    base = chosen.samples * max(chosen.exchange, 1)
    steps = base * max(1, int(np.ceil(period / step / base)))
    springs = tuple(spring.with_time_step(period / steps) for spring in system.springs)
    return TrainRunner(
        system.with_springs(springs),
        float(cam_speed),
        steps,
        chosen,
        still,
        float(cam_acceleration),
        springs,
    )
