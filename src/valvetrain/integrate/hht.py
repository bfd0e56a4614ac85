"""Implicit time integration of Hilber, Hughes and Taylor (hilber1977) for the chain of masses under prescribed motion.

M a' + (1 + alpha) f(x', v') - alpha f(x, v) = 0 with Newmark's x' and v' (equations 5 to 8 of the paper), beta = (1 - alpha)**2 / 4 and
gamma = 1/2 - alpha; f holds elements, dampers and coil contacts. Each step is solved by Newton's method with the consistent tangent, the
coils in contact found on the way. Unconditionally stable, so the step may be as coarse as a solid finite-element study takes it: half a
cam degree without another choice. Asked for by name; the leapfrog is the usual way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.integrate.clash import RECORDED, PairSeries, find_clashes
from valvetrain.integrate.contract import Cycles, Periodic, RunOptions, RunUp, Until
from valvetrain.integrate.leapfrog import MOST_CYCLES, SAMPLES, TOLERANCE, TURN, run_channels, run_status, turn_change
from valvetrain.solution.event import Event
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.springs import chain_statics
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

Array = NDArray[np.float64]
#: Share of the largest force by which a step's balance may be missed, rounds of Newton's method, and rounds after which steps are halved.
BALANCE, ROUNDS, HALVED = 1e-10, 60, 12


@dataclass(frozen=True, eq=False)
class ChainForces:
    """What resists the motion of the inner nodes of a chain, and its tangents; nodes 0 = seat ... N + 1 = retainer."""

    model: MultiMassSpring

    @cached_property
    def rows(self) -> Array:
        """Gradient of the contact depths (p, N + 2)."""
        return chain_statics.contact_rows(self.model.layout)

    @cached_property
    def steps(self) -> Array:
        """Differences of neighbouring nodes (N + 1, N + 2)."""
        count = len(self.model.layout.coil_number)
        return np.diff(np.eye(count), axis=0)

    def __call__(self, nodes: Array, velocities: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Resisting forces (N,), stiffness and damping matrices of the inner nodes, overlap (m) and damping force (N) of the contacts."""
        model, layout = self.model, self.model.layout
        stretch, rate = np.diff(nodes), np.diff(velocities)
        carried = layout.stiffness * (stretch + model.stiffness_damping * rate)
        held = np.ones(len(stretch))
        if not model.pulls:
            for end in (0, -1):
                held[end] = float(stretch[end] > 0 and carried[end] > 0)
        depth = chain_statics.contact_depths(layout, nodes)
        push = layout.contacts.stiffness * (depth + model.contact_damping_time * (self.rows @ velocities))
        closed = push > 0  # not from zero overlap on: there the damper would jump, and a coarse step finds no balance at a jump
        pushed = np.where(closed, push, 0.0)
        inner = slice(1, -1)
        force = ((held * carried) @ self.steps + pushed @ self.rows)[inner] + model.mass_damping * layout.masses * velocities[inner]
        steps, rows = self.steps[:, inner], self.rows[closed][:, inner]
        elements = steps.T @ ((held * layout.stiffness)[:, None] * steps)
        contacts = rows.T @ (layout.contacts.stiffness[closed][:, None] * rows)
        damping = model.stiffness_damping * elements + model.contact_damping_time * contacts
        damping[np.diag_indices_from(damping)] += model.mass_damping * layout.masses
        return force, elements + contacts, damping, depth, pushed - layout.contacts.stiffness * np.maximum(depth, 0.0)

    def loss(self, velocities: Array, damping: Array, bounded: Array) -> float:
        """Power (W) that the dampers take."""
        inner = velocities[1:-1]
        ends = self.model.stiffness_damping * self.model.layout.stiffness * np.diff(velocities) ** 2
        moved = self.model.mass_damping * self.model.layout.masses @ inner**2
        return float(ends.sum() + moved + bounded @ (self.rows @ velocities))


@dataclass(frozen=True)
class HilberHughesTaylor:
    """Second order; ``alpha`` from -1/3 (most numerical damping) to 0 (none: the trapezoidal rule)."""

    alpha: float = -0.05
    word: str = "hht"
    order: int = 2

    def __post_init__(self) -> None:
        if not -1 / 3 - 1e-12 <= self.alpha <= 0:
            raise InputError(f"alpha of the integrator 'hht' is {self.alpha:g}; give one from -1/3 to 0")

    def serves(self, system: System, until: Until) -> bool:
        alone = isinstance(system, PrescribedSpring) and len(system.springs) == 1
        return alone and isinstance(system.springs[0], MultiMassSpring) and not isinstance(until, RunUp)

    def run(self, system: System, cam_speed: float, until: Until, options: RunOptions, provenance: Provenance) -> Solution:
        """See :class:`valvetrain.integrate.contract.Integrator`."""
        assert isinstance(system, PrescribedSpring)
        model = system.springs[0]
        assert isinstance(model, MultiMassSpring)
        samples = options.samples or SAMPLES
        interval = TURN / cam_speed / samples
        sub = max(1, int(np.ceil(interval / (options.time_step or interval) * (1 - 1e-9))))
        step, count = interval / sub, samples * sub
        turns, tolerance = until.count if isinstance(until, Cycles) else MOST_CYCLES, 0.0
        if isinstance(until, Periodic):
            turns, tolerance = until.cycles or MOST_CYCLES, until.tolerance or TOLERANCE
        stepping = _Stepping(self.alpha, ChainForces(model), step)
        state = model.initial_state(float(system.displacement(0.0, cam_speed)))
        motion = np.zeros(len(model.layout.masses))
        forces, before, change, done, turn = np.zeros((count + 1, 2)), np.zeros(0), np.inf, 0, 0
        for turn in range(turns):
            time = step * np.arange(count + 1.0) + turn * samples * interval
            place, rate = (np.asarray(system.displacement(time, cam_speed, order)) for order in (0, 1))
            states = np.zeros((samples + 1 if options.keep != "ends" else 0, len(state)))
            forces, pressed = np.zeros((count + 1, 2)), np.zeros((count, 2 * model.layout.contacts.count))
            done, motion = stepping.turn(state, motion, place, rate, sub, forces, states, pressed)
            if done <= count:
                break
            change, before = turn_change(before, forces[:, 1]), forces[:, 1]
            if change <= tolerance:
                break
        status = run_status(system, until, done > count, change, tolerance, turn, time[min(done, count)], cam_speed)
        statistics: dict[str, float | int | str | bool] = {
            "time_step_duration": step, "steps_per_cycle_count": count, "steady_cycles_count": turn + 1, "integrator": self.word,
            "hht_alpha": self.alpha,
        }  # fmt: skip
        if isinstance(until, Periodic):
            statistics |= {"steady_residual_ratio": change, "steady_tolerance_ratio": tolerance}
        whole = min(done, count) // sub * sub
        kept = time[: whole + 1], forces[: whole + 1], states[: whole // sub + 1]
        channels = run_channels(system, model, cam_speed, 0.0, [kept], sub, options.keep == "all")
        events: tuple[Event, ...] = ()
        watch = model.contact_watch()
        if watch is not None and whole:
            statistics[RECORDED] = step
            events = find_clashes(PairSeries(time[:whole], cam_speed * time[:whole], *watch.read(pressed[:whole], step, step)))
        return Solution(channels, events, status, statistics, provenance)


@dataclass(frozen=True, eq=False)
class _Stepping:
    """The steps themselves: ``step`` (s)."""

    alpha: float
    forces: ChainForces
    step: float

    def turn(
        self, state: Array, motion: Array, place: Array, rate: Array, every: int, ends: Array, states: Array, pressed: Array
    ) -> tuple[int, Array]:
        """One cam turn from ``state`` (changed) and its accelerations ``motion``; returns the last step whose forces are known, plus one
        where that is the last of all, and the accelerations.

        Kept states hold the velocity half a step earlier, as the leapfrog's do.
        """
        model, masses, h = self.forces.model, self.forces.model.layout.masses, self.step
        n, beta, gamma = len(masses), (1 - self.alpha) ** 2 / 4, 0.5 - self.alpha
        x, v, a = state[:n].copy(), state[n : 2 * n].copy(), motion
        now = self.forces(*self._all(x, v, place[0], rate[0]))
        for step in range(len(place)):
            state[:n], state[n : 2 * n] = x, v
            ends[step] = model.force(state, place[step], rate[step])
            if step % every == 0 and len(states):
                states[step // every] = state
                states[step // every, n : 2 * n] -= h / 2 * a
            if step == len(place) - 1:
                break
            pressed[step] = np.concatenate((now[3], h * now[4]))
            lost = self.forces.loss(self._all(x, v, place[step], rate[step])[1], now[2], now[4])
            found = self._solve(x + h * v + h * h * (0.5 - beta) * a, v + h * (1 - gamma) * a, a, now[0], place[step + 1], rate[step + 1])
            if found is None:
                return step, a
            x, v, a, now = found
            after = self.forces.loss(self._all(x, v, place[step + 1], rate[step + 1])[1], now[2], now[4])
            state[2 * n] += h * (lost + after) / 2
        return len(place), a

    def _all(self, x: Array, v: Array, place: float, rate: float) -> tuple[Array, Array]:
        """Positions and velocities of all nodes, seat and retainer included."""
        top = self.forces.model.precompression + place
        return np.concatenate(([0.0], x, [top])), np.concatenate(([0.0], v, [rate]))

    def _solve(
        self, x0: Array, v0: Array, a: Array, old: Array, place: float, rate: float
    ) -> tuple[Array, Array, Array, tuple[Array, Array, Array, Array, Array]] | None:
        """Positions, velocities, accelerations and forces at the end of a step; None where no balance is found."""
        h, beta, gamma, share = self.step, (1 - self.alpha) ** 2 / 4, 0.5 - self.alpha, 1 + self.alpha
        masses = self.forces.model.layout.masses
        for round_ in range(ROUNDS):
            x, v = x0 + beta * h * h * a, v0 + gamma * h * a
            now = self.forces(*self._all(x, v, place, rate))
            miss = masses * a + share * now[0] - self.alpha * old
            if np.max(np.abs(miss)) <= BALANCE * (1.0 + np.max(np.abs(now[3] * self.forces.model.layout.contacts.stiffness), initial=0.0)):
                return x, v, a, now
            tangent = share * (beta * h * h * now[1] + gamma * h * now[2])
            tangent[np.diag_indices_from(tangent)] += masses
            change = np.linalg.solve(tangent, -miss)
            a = a + (change if round_ < HALVED else 0.5 * change)
            if not np.all(np.isfinite(a)):
                return None
        return None


SPEC = HilberHughesTaylor()
