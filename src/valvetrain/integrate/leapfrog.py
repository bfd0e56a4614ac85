"""Explicit leapfrog of any spring model under prescribed motion, through the one contract of
``springs.contract``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw
from valvetrain.integrate.clash import RECORDED, PairSeries, find_clashes, steps_between
from valvetrain.integrate.contract import STEP_FRACTION, Cycles, Periodic, RunOptions, RunUp, Until
from valvetrain.integrate.leapfrog_kernel import advance
from valvetrain.parameters.summary import share_text
from valvetrain.solution.channels import FINE, ChannelArrays, spring_channels
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import COMPLETED, Event, Status
from valvetrain.springs.contract import (
    SpringModel,
    contact_watch_of,
    sampled_entries,
    shown_at,
)
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

TURN = 2 * np.pi
#: Samples per cam revolution, revolutions until a periodic motion is given up, and the change of the
#: end forces per turn, over their span, at which it counts as periodic.
SAMPLES, MAX_CYCLES, TOLERANCE = 720, 40, 1e-3
#: A record of inner states beyond this size (bytes) is not stored.
MAX_RECORD = 400e6
#: Most steps of a revolution whose forces are stored, and that are computed at a time.
MAX_FINE = 2**20


@dataclass(frozen=True)
class Leapfrog:
    """Second order; the step is a share of the model's stable one, so that a cam revolution holds a whole
    number of samples and steps.
    """

    word: str = "leapfrog"
    order: int = 2

    def serves(self, system: System, until: Until) -> bool:
        return isinstance(system, PrescribedSpring) and len(system.springs) == 1

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
        samples, interval = options.samples or SAMPLES, 0.0
        interval = TURN / cam_speed / samples
        limit = options.time_step or STEP_FRACTION * system.springs[0].stable_time_step()
        sub = max(1, int(np.ceil(interval / limit * (1 - 1e-9))))
        # Of a slow revolution every ``stride``-th step is stored, and blocks of steps are computed in turn.
        stride = 1 if isinstance(until, RunUp) else -(-samples * sub // MAX_FINE)
        sub = stride * -(-sub // stride)
        block, fine = (samples if stride == 1 else max(1, MAX_FINE // sub)), sub // stride
        step = interval / sub
        model = system.springs[0].with_time_step(step)
        acceleration, turns, tolerance = 0.0, 1, 0.0
        if isinstance(until, RunUp):
            acceleration = until.cam_acceleration
            turns = max(1, int(np.ceil(until.duration(cam_speed) * cam_speed / TURN)))
        elif isinstance(until, Cycles):
            turns = until.count
        else:
            turns, tolerance = until.cycles or MAX_CYCLES, until.tolerance or TOLERANCE
        state = np.asarray(
            model.initial_state(float(system.displacement(0.0, cam_speed))), dtype=float
        )
        parameters, integers = model.parameters(), model.integers()
        entries = sampled_entries(model, state)
        keep = options.keep != "ends" and 8.0 * entries * (samples + 1) < MAX_RECORD
        watch = contact_watch_of(model)
        bounded = 0 if isinstance(until, RunUp) else samples * sub
        spacing, pressed = steps_between(watch, step, bounded), np.zeros((0, 0))
        rows = (samples * sub - 1) // spacing + 1
        # a run-up's contacts are recorded in all turns, where they fit
        record = watch is not None and (
            not isinstance(until, RunUp) or 8.0 * watch.entries * rows * turns < MAX_RECORD
        )
        stretches = watch.stretches if watch is not None else np.zeros((0, 2), dtype=np.int64)
        impacts: list[tuple[Array, Array]] = []
        before, change, done, turn = np.zeros(0), np.inf, 0, 0
        record_parts: list[tuple[Array, Array, Array]] = []
        # place and rate of the retainer on every step, where all revolutions have the same
        motion: tuple[Array, Array] | None = None
        for turn in range(turns):
            begun = turn * samples * interval
            time = step * (stride * np.arange(samples * fine + 1.0)) + begun
            passed = isinstance(until, Cycles) and turn < turns - 1
            states = np.empty((samples + 1 if keep else 0, entries))
            forces = np.empty((len(time), 2))
            if record and watch is not None and not passed:
                pressed = np.empty((rows, watch.entries))
            for first in range(0, samples * sub, block * sub):
                last = min(first + block * sub, samples * sub)
                if motion is None or acceleration or block < samples:
                    now = step * np.arange(float(first), last + 1.0) + begun
                    motion = _motion(system.valve_lift, now, cam_speed, acceleration)
                place, rate = motion
                done = advance(
                    model.kernel,
                    parameters,
                    integers,
                    state,
                    place,
                    rate,
                    step,
                    sub,
                    forces,
                    states,
                    stretches,
                    spacing,
                    pressed,
                    first,
                    stride,
                )
                if done <= last:
                    break
            if len(pressed):
                whole = min(rows, (done + spacing - 1) // spacing)
                impacts = [
                    *(impacts if isinstance(until, RunUp) else []),
                    (
                        step * np.arange(0.0, samples * sub, spacing)[:whole] + begun,
                        pressed[:whole],
                    ),
                ]
            record_parts = (
                [*record_parts, (time, forces, states)]
                if isinstance(until, RunUp)
                else [(time, forces, states)]
            )
            if done <= samples * sub:
                break
            change, before = turn_change(before, forces[:, 1]), forces[:, 1]
            if change <= tolerance and not isinstance(until, Cycles):
                break
        status = run_status(
            system,
            until,
            done > samples * sub,
            change,
            tolerance,
            turn,
            step * min(done, samples * sub) + turn * samples * interval,
            cam_speed,
        )
        statistics: dict[str, float | int | str | bool] = {
            "time_step_duration": step, "steps_per_cycle_count": samples * sub, "steady_cycles_count": turn + 1, "integrator": self.word,
        }  # fmt: skip
        if isinstance(until, Periodic):
            statistics |= {"steady_residual_ratio": change, "steady_tolerance_ratio": tolerance}
        if done <= samples * sub:  # whole samples of what was computed before it diverged
            whole = done // sub
            record_parts[-1] = (
                record_parts[-1][0][: whole * fine + 1],
                record_parts[-1][1][: whole * fine + 1],
                record_parts[-1][2][: whole + 1],
            )
        channels = run_channels(
            system,
            model,
            cam_speed,
            acceleration,
            record_parts,
            fine,
            options.keep == "all",
            stride=stride,
            place=motion[0][: len(record_parts[0][0])]
            if motion is not None and not acceleration and stride == 1
            else None,
        )
        events: tuple[Event, ...] = ()
        if impacts and watch is not None:
            at, found = (
                impacts[0]
                if len(impacts) == 1
                else (np.concatenate([part[k] for part in impacts]) for k in (0, 1))
            )
            statistics[RECORDED] = spacing * step
            events = find_clashes(
                PairSeries(
                    at,
                    cam_speed * at + 0.5 * acceleration * at**2,
                    *watch.read(found, spacing * step, step),
                    watch.first_period,
                ),
                closed=turn > 0 and not isinstance(until, RunUp),
            )
        return Solution(channels, events, status, statistics, provenance)


def _motion(
    law: LiftLaw, time: Array, cam_speed: float, acceleration: float
) -> tuple[Array, Array]:
    """Place (m) and rate (m/s) of the retainer over ``time`` (s) from a cam speed (rad/s) on."""
    angle = cam_speed * time + 0.5 * acceleration * time**2
    place = np.ascontiguousarray(law.lift(angle), dtype=float)
    return place, np.ascontiguousarray(law.lift(angle, 1)) * (cam_speed + acceleration * time)


def turn_change(before: Array, now: Array) -> float:
    """Largest change of a force between two turns at the same angles, as a share of its span;
    infinite where no turn was before.
    """
    if not len(before):
        return np.inf
    return float(np.max(np.abs(now - before)) / max(float(np.ptp(now)), 1e-12))


def run_status(
    system: PrescribedSpring,
    until: Until,
    reached: bool,
    change: float,
    tolerance: float,
    turn: int,
    time: float,
    cam_speed: float,
) -> Status:
    """How a run of one spring ended: ``reached`` its end or diverged at ``time`` (s), or still
    changing by ``change`` per turn.
    """
    if not reached:
        where = np.degrees(cam_speed * time % TURN)
        return Status(
            "diverged",
            f"the forces grew without bound at {where:.1f} cam degrees of turn {turn + 1}",
            float(time),
            system.springs[0].name,
            "give a smaller time step or a softer coil contact, or check the lift law for jumps",
        )
    if isinstance(until, Periodic) and change > tolerance:
        size, accepted = share_text(change), share_text(tolerance)
        message = f"after {turn + 1} cam revolutions the forces still change by {size} of their span (accepted: {accepted})"
        return Status(
            "not-converged",
            message,
            float(time),
            system.springs[0].name,
            "run more turns, or raise the damping of the spring",
        )
    return COMPLETED


def run_channels(
    system: PrescribedSpring,
    model: SpringModel,
    cam_speed: float,
    acceleration: float,
    record_parts: list[tuple[Array, Array, Array]],
    sub: int,
    whole: bool,
    half_behind: bool = True,
    stride: int = 1,
    place: Array | None = None,
) -> ChannelArrays:
    """Channels over the recorded revolutions: end forces at every sample and step, inner motion where states
    were recorded, energies.

    ``half_behind``: velocities of the states are half a step before their places; ``stride``: steps between two recorded
    forces, of which ``sub`` make a sample; ``place`` (m) of the retainer at each of them (None: by
    the lift law).
    """
    cuts = [
        slice(None) if n == len(record_parts) - 1 else slice(None, -1)
        for n in range(len(record_parts))
    ]
    time, forces, states = (
        record_parts[0]
        if len(record_parts) == 1
        else (
            np.concatenate([part[k][cut] for part, cut in zip(record_parts, cuts, strict=True)])
            for k in range(3)
        )
    )
    at, turned = time[::sub], cam_speed * time + 0.5 * acceleration * time**2
    angle, rate = turned[::sub], cam_speed + acceleration * at
    place = np.asarray(system.valve_lift.lift(turned)) if place is None else place
    lift = place[::sub]
    velocity = np.asarray(system.valve_lift.lift(angle, 1)) * rate
    work = np.concatenate(([0.0], np.cumsum((forces[1:, 0] + forces[:-1, 0]) / 2 * np.diff(place))))
    values: dict[str, Array] = {
        "valve_lift": lift, "retainer_velocity": velocity,
        "retainer_acceleration": np.asarray(system.valve_lift.lift(angle, 2)) * rate**2 + velocity / rate * acceleration,
        "retainer_force": forces[::sub, 0], "seat_force": forces[::sub, 1], "work_done": work[::sub],
    }  # fmt: skip
    for name, series in (("retainer_force_fine", forces[:, 0]), ("seat_force_fine", forces[:, 1])):
        padded = np.concatenate([series, np.repeat(series[-1:], sub - 1)])
        values[name] = padded[: len(at) * sub].reshape(len(at), sub)
    if not len(states):
        return spring_channels(at, angle, values, extra=FINE)
    step = float(time[1] - time[0]) / stride if half_behind and len(time) > 1 else 0.0
    return _with_inner(model, states, (at, angle, values), step, whole)


def _with_inner(
    model: SpringModel,
    states: Array,
    ends: tuple[Array, Array, dict[str, Array]],
    step: float,
    whole: bool,
) -> ChannelArrays:
    """The channels at the ``ends`` (time, cam angle, values by name) with those inside the spring."""
    at, angle, values = ends[0], ends[1], dict(ends[2])
    motion = states, values["valve_lift"], values["retainer_velocity"]
    shown = shown_at(model, *motion, step, energies=whole)
    coil, pairs = None, None
    if whole and shown.energy is not None and not np.isnan(shown.energy[0]).any():
        names = ("kinetic_energy", "elastic_energy", "contact_energy", "energy_dissipated")
        values |= {name: shown.energy[:, column] for column, name in enumerate(names)}
    if whole and shown.coil_number.size:
        coil = shown.coil_number
        values["axial_displacement"] = shown.axial_displacement
        values["axial_velocity"] = shown.axial_velocity
        values |= shown.section_loads
    if shown.upper_coil.size:
        pairs = shown.upper_coil
        values["coil_gap"] = shown.coil_gap
        values["coil_contact_force"] = shown.coil_contact_force
    return spring_channels(at, angle, values, coil_number=coil, upper_coil=pairs, extra=FINE)


SPEC = Leapfrog()
