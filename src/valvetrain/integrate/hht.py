"""Implicit time integration of Hilber, Hughes and Taylor (hilber1977) for the chain of masses under
prescribed motion.

M a' + (1 + alpha) f(x', v') - alpha f(x, v) = 0 with Newmark's x' and v' (equations 5 to 8 of the
paper), beta = (1 - alpha)**2 / 4 and gamma = 1/2 - alpha; f holds elements, dampers and coil
contacts. Each step is solved by Newton's method with the consistent tangent, the coils in contact
found on the way. Unconditionally stable, so the step may be as coarse as a solid finite-element
study takes it: half a cam degree without another choice. Chosen by name; the leapfrog is the
default.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.integrate.chain_forces import ChainForces, Resistance
from valvetrain.integrate.clash import RECORDED, PairSeries, find_clashes, steps_between
from valvetrain.integrate.contract import Cycles, Periodic, RunOptions, RunUp, Until
from valvetrain.integrate.leapfrog import (
    MAX_CYCLES,
    MAX_RECORD,
    SAMPLES,
    TOLERANCE,
    TURN,
    run_channels,
    run_status,
    turn_change,
)
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

#: Share of the largest term by which a step's balance may be missed, rounds of Newton's method, and
#: rounds after which steps are halved.
BALANCE, ROUNDS, HALVED = 1e-12, 60, 12


@dataclass(frozen=True)
class HilberHughesTaylor:
    """Second order; ``alpha`` from -1/3 (most numerical damping) to 0 (none: the trapezoidal rule)."""

    alpha: float = -0.05
    word: str = "hht"
    order: int = 2

    def __post_init__(self) -> None:
        if not -1 / 3 - 1e-12 <= self.alpha <= 0:
            raise InputError(
                f"alpha of the integrator 'hht' is {self.alpha:g}; give one from -1/3 to 0"
            )

    def serves(self, system: System, until: Until) -> bool:
        alone = isinstance(system, PrescribedSpring) and len(system.springs) == 1
        return (
            alone
            and isinstance(system.springs[0], MultiMassSpring)
            and not isinstance(until, RunUp)
        )

    def run(
        self,
        system: System,
        cam_speed: float,
        until: Until,
        options: RunOptions,
        provenance: Provenance,
    ) -> Solution:
        """See :class:`valvetrain.integrate.contract.Integrator`."""
        assert isinstance(system, PrescribedSpring)
        model = system.springs[0]
        assert isinstance(model, MultiMassSpring)
        samples = options.samples or SAMPLES
        interval = TURN / cam_speed / samples
        sub = max(1, int(np.ceil(interval / (options.time_step or interval) * (1 - 1e-9))))
        step, count = interval / sub, samples * sub
        turns, tolerance = until.count if isinstance(until, Cycles) else MAX_CYCLES, 0.0
        if isinstance(until, Periodic):
            turns, tolerance = until.cycles or MAX_CYCLES, until.tolerance or TOLERANCE
        watch = model.contact_watch()
        stepping = _Stepping(self.alpha, ChainForces(model), step, sub, steps_between(watch, step))
        state = model.initial_state(float(system.displacement(0.0, cam_speed)))
        motion = np.zeros(len(model.layout.masses))
        keep = options.keep != "ends" and 8.0 * len(state) * (samples + 1) < MAX_RECORD
        record, before, change, done, turn = stepping.record(count, 0), np.zeros(0), np.inf, 0, 0
        for turn in range(turns):
            time = step * np.arange(count + 1.0) + turn * samples * interval
            place, rate = (
                np.asarray(system.displacement(time, cam_speed, order)) for order in (0, 1)
            )
            record = stepping.record(count, len(state) if keep else 0)
            done, motion = stepping.turn(state, motion, place, rate, record)
            if done <= count:
                break
            change, before = turn_change(before, record.ends[:, 1]), record.ends[:, 1]
            if change <= tolerance and not isinstance(until, Cycles):
                break
        status = run_status(
            system, until, done > count, change, tolerance, turn, time[min(done, count)], cam_speed
        )
        if done <= count:
            where = np.degrees(cam_speed * time[done] % TURN)
            message = f"{ROUNDS} rounds of Newton's method found no balance of forces after {where:.1f} cam degrees of turn {turn + 1}"
            status = replace(
                status,
                message=message,
                remedy="give a smaller time step, a softer coil contact or one that is damped less",
            )
        statistics: dict[str, float | int | str | bool] = {
            "time_step_duration": step, "steps_per_cycle_count": count, "steady_cycles_count": turn + 1, "integrator": self.word,
            "hht_alpha": self.alpha,
        }  # fmt: skip
        if isinstance(until, Periodic):
            statistics |= {"steady_residual_ratio": change, "steady_tolerance_ratio": tolerance}
        whole = min(done, count) // sub * sub
        record_parts = (
            time[: whole + 1],
            record.ends[: whole + 1],
            record.states[: whole // sub + 1],
        )
        channels = run_channels(
            system,
            model,
            cam_speed,
            0.0,
            [record_parts],
            sub,
            options.keep == "all",
            half_behind=False,
        )
        events: tuple[Event, ...] = ()
        if watch is not None and whole:
            spacing = stepping.spacing
            rows = (whole + spacing - 1) // spacing
            at, statistics[RECORDED] = time[:whole:spacing], spacing * step
            events = find_clashes(
                PairSeries(
                    at,
                    cam_speed * at,
                    *watch.read(record.pressed[:rows], spacing * step, step),
                    watch.first_period,
                ),
                closed=turn > 0,
            )
        return Solution(channels, events, status, statistics, provenance)


@dataclass(frozen=True, eq=False)
class _Record:
    """What a turn writes down: end forces of every step, states at the times of their places,
    overlap and damping impulse of contacts.
    """

    ends: Array
    states: Array
    pressed: Array


@dataclass(frozen=True, eq=False)
class _Stepping:
    """The steps themselves: ``step`` (s), every ``every``-th state is stored, every ``spacing`` the
    coil contacts.
    """

    alpha: float
    forces: ChainForces
    step: float
    every: int
    spacing: int

    @property
    def beta(self) -> float:
        """Newmark's share of the new acceleration in the places."""
        return (1 - self.alpha) ** 2 / 4

    @property
    def gamma(self) -> float:
        """Newmark's share of the new acceleration in the velocities."""
        return 0.5 - self.alpha

    def record(self, count: int, length: int) -> _Record:
        """Memory for a turn of ``count`` steps, with states of ``length`` numbers (0: none)."""
        contacts = 2 * self.forces.model.layout.contacts.count
        states = np.zeros((count // self.every + 1 if length else 0, length))
        return _Record(
            np.zeros((count + 1, 2)), states, np.zeros(((count - 1) // self.spacing + 1, contacts))
        )

    def turn(
        self, state: Array, motion: Array, place: Array, rate: Array, record: _Record
    ) -> tuple[int, Array]:
        """One cam revolution from ``state`` (changed) and its accelerations ``motion``, written into
        ``record``; returns the last step whose forces are known, plus one where that is the last of
        all, and the accelerations.
        """
        h, n = self.step, len(motion)
        x, v, a = state[:n].copy(), state[n : 2 * n].copy(), motion
        now = self.forces(*self._all(x, v, place[0], rate[0]))
        for step in range(len(place)):
            state[:n], state[n : 2 * n] = x, v
            record.ends[step] = now.ends
            if step % self.every == 0 and len(record.states):
                record.states[step // self.every] = state
            if step == len(place) - 1:
                break
            if step % self.spacing == 0:
                record.pressed[step // self.spacing] = np.concatenate(
                    (now.overlap, h * now.contact_damping)
                )
            ahead = x + h * v + h * h * (0.5 - self.beta) * a, v + h * (1 - self.gamma) * a
            found = self._solve(*ahead, a, now.inner, place[step + 1], rate[step + 1])
            if found is None:
                return step, a
            moved = np.concatenate(([0.0], found[0] - x, [place[step + 1] - place[step]]))
            state[2 * n] += (now.dampers + found[3].dampers) @ moved / 2
            x, v, a, now = found
        return len(place), a

    def _all(self, x: Array, v: Array, place: float, rate: float) -> tuple[Array, Array]:
        """Positions and velocities of all nodes, seat and retainer included."""
        top = self.forces.model.precompression + place
        return np.concatenate(([0.0], x, [top])), np.concatenate(([0.0], v, [rate]))

    def _solve(
        self, x0: Array, v0: Array, a: Array, old: Array, place: float, rate: float
    ) -> tuple[Array, Array, Array, Resistance] | None:
        """Positions, velocities, accelerations and forces at the end of a step; None where no
        balance is found.
        """
        h, share, masses = self.step, 1 + self.alpha, self.forces.model.layout.masses
        for round_ in range(ROUNDS):
            x, v = x0 + self.beta * h * h * a, v0 + self.gamma * h * a
            now = self.forces(*self._all(x, v, place, rate))
            miss = masses * a + share * now.inner - self.alpha * old
            if np.max(np.abs(miss)) <= BALANCE * max(
                now.largest, float(np.max(masses * np.abs(a)))
            ):
                return x, v, a, now
            tangent = share * (self.beta * h * h * now.stiffness + self.gamma * h * now.damping)
            tangent[np.diag_indices_from(tangent)] += masses
            change = np.linalg.solve(tangent, -miss)
            a = a + (change if round_ < HALVED else 0.5 * change)
            if not np.all(np.isfinite(a)):
                return None
        return None


SPEC = HilberHughesTaylor()
