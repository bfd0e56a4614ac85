"""Motion of a solid wire under a prescribed retainer, with raw records that others turn into
channels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import law_address, law_numbers
from valvetrain.coil_contact.record import contact_spacing
from valvetrain.continuum import brick_kernels, time_kernels
from valvetrain.continuum.statics import SolidEquilibrium, SolidStatics

#: Target spacing (s) of the record of the end forces (250 kHz).
DENSE_INTERVAL = 4e-6
#: Share of the stable step that is used, and how much the power iteration may have missed.
SAFETY, MISSED = 0.94, 1.01
POWER_ITERATIONS = 300
#: Steps between two searches for contact points nearer than a margin (m) to touching: with the
#: largest speed of two coils (m/s) no point can cross the margin between them.
MARGIN, MAX_CLOSING, ENERGY_STEPS = 2e-4, 40.0, 32
#: Columns of the energies that are stored, not yet heat.
STORED_ENERGIES = ("KINETIC", "SCALED", "ELASTIC", "BRANCH", "CONTACT")
#: Steps of one call of the kernel, between which a run can be stopped.
BLOCK = 4096


@dataclass(frozen=True)
class SolidDynamics:
    """Damping and step of a solid in motion.

    ``mass_damping`` (1/s) and ``stiffness_damping`` (s) as the rod's; the latter acts through a
    Maxwell branch on all strains with the relaxation time ``branch_time`` (s). ``mass_scaling``: mass
    that the deformation of a section has in excess, over its own.
    """

    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    branch_time: float = 8e-6
    mass_scaling: float = 5.0

    @property
    def branch_stiffness(self) -> float:
        """Stiffness of the branch over that of the material."""
        return self.stiffness_damping / self.branch_time


class SolidArrays(NamedTuple):
    """State and constants of a run for :func:`time_kernels.integrate_solid`."""

    x: Array
    v: Array
    force: Array
    momentum: Array
    mass: Array
    weights: Array
    centre: Array
    rate: Array
    push: Array
    spin: Array
    inverse: Array
    couple: Array
    constants: Array
    branch: Array
    scratch: Array
    corners: NDArray[np.uint64]
    shape: NDArray[np.uint64]
    section: Array
    stations: int
    first: int
    last: int


class SolidMotionNumbers(NamedTuple):
    """Numbers of a run for the kernel: step (s), damping, mass scaling, material, law of contact,
    coefficients of friction.
    """

    step: float
    mass_damping: float
    scaling: float
    branch_time: float
    lame: Array
    damper: Array
    law: int
    law_numbers: Array
    damping_time: float
    coil_friction: float
    seat_friction: float


class SolidClock(NamedTuple):
    """Steps per dense record, dense records per sample, samples not stored, steps between records of
    contact, between searches of it and between energies at most; margin (m) of the search.
    """

    substeps: int
    dense: int
    discard: int
    pair_steps: int
    search: int
    energy_steps: int
    margin: float


class SolidRecords(NamedTuple):
    """What the kernel fills; see :class:`SolidTransient`."""

    ends: Array
    extremes: Array
    energy: Array
    contact: Array
    pairs: Array
    position: Array
    centre_rate: Array
    impulse: Array
    peak: Array
    carried: Array
    point_peak: Array
    plane_peak: Array


@dataclass(frozen=True, eq=False)
class SolidTransient:
    """Raw records of a run: ns samples, nd dense records, np pairs of coils; SI units.

    ``position`` (ns, nodes, 3, stations), ``centre_rate`` (ns, 3, stations); ``contact_force`` and
    ``contact_peak`` (ns, np) mean and peak since the last sample, ``point_peak`` and ``plane_peak``
    (N; ns, points) peak of each contact point and each station at a seat plane; ``extremes`` (ns, 8) of all steps
    up to the next sample: largest seat force, its time, least, its time, and the same of the retainer
    force; ``energy`` (ns, 8) by the columns of :mod:`time_kernels`; ``dense_*`` (nd,); ``pair_force``
    (N) and ``pair_energy`` (J) at ``pair_time``, (nc, np). ``steps_done`` < ``steps`` when the run
    diverged or was ``stopped``.
    """

    time: Array
    displacement: Array
    position: Array
    centre_rate: Array
    contact_force: Array
    contact_peak: Array
    point_peak: Array
    plane_peak: Array
    extremes: Array
    energy: Array
    dense_time: Array
    dense_retainer_force: Array
    dense_seat_force: Array
    pair_time: Array
    pair_force: Array
    pair_energy: Array
    time_step: float
    steps: int
    steps_done: int
    fastest: float
    stopped: bool = False

    @property
    def completed(self) -> bool:
        """Whether the run reached its end."""
        return self.steps_done > self.steps

    @property
    def energy_gap(self) -> Array:
        """Work done less energy stored since the first stored sample and heat (J), of each sample."""
        found = self.energy
        parts = [getattr(time_kernels, name) for name in STORED_ENERGIES]
        stored = found[:, parts].sum(axis=1) + found[:, time_kernels.HEAT]
        gap = found[:, time_kernels.WORK_DONE] - stored
        relative: Array = gap - gap[0]
        return relative


def stable_time_step(
    statics: SolidStatics, dynamics: SolidDynamics, state: SolidEquilibrium | None = None
) -> float:
    """Largest stable step (s) of the leapfrog: 2 over the highest frequency of the bricks, with their
    scaled masses and the branch at full stiffness, and a bound for every contact closed.

    The frequency is found by power iteration about ``state`` (None: free).
    """
    wire, (first, last) = statics.wire, statics.wire.ends
    near = state or statics.start()
    stiffness = statics.tangent(near.position, 0.0, None) * (1 + dynamics.branch_stiffness)
    shape, inner = near.position.shape, np.zeros(near.position.shape, dtype=bool)
    inner[:, :, first + 1 : last] = True
    outside = ~inner.ravel()
    vector = np.random.default_rng(1).standard_normal(inner.size)
    vector[outside] = 0.0
    x = np.ascontiguousarray(near.position).ravel()
    scratch = np.zeros(time_kernels.SECTION_ROWS * time_kernels.STRIDE)
    square = 0.0
    for _ in range(POWER_ITERATIONS):
        force = stiffness @ vector
        force[outside] = 0.0
        moved = force.copy()
        time_kernels.accelerate(
            x, moved, wire.bricks.mass.ravel(), scratch, shape[0], shape[2], first + 1, last,
            dynamics.mass_scaling,
        )  # fmt: skip
        square = float(force @ moved) / float(force @ vector)
        vector = moved / np.abs(moved).max()
    contact = wire.contact
    section = wire.bricks.mass.sum(axis=0)[first + 1 : last]
    length = (np.asarray(wire.spring.line_speed(wire.coil)) * np.gradient(wire.coil))[
        first + 1 : last
    ]
    closed = contact.stiffness * contact.law.steepest * float(np.max(length / section))
    # a station meets the turns above and below: twice its stiffness, moved against each other
    omega = math.sqrt(MISSED * square + 4 * closed)
    # a damping ratio d lowers the step of the leapfrog to (sqrt(1 + d^2) - d) of it
    damping = 0.5 * contact.damping_time * 4 * closed / omega
    return 2 / omega * (math.sqrt(1 + damping**2) - damping)


def simulate_solid(
    statics: SolidStatics,
    start: SolidEquilibrium,
    motion: Callable[[Array], ArrayLike],
    sample_interval: float,
    samples: int,
    dynamics: SolidDynamics,
    time_step: float | None = None,
    discard: int = 0,
    watch: Callable[[float], bool] | None = None,
    pair_interval: float = 0.0,
) -> SolidTransient:
    """Integrate ``samples`` intervals of ``sample_interval`` (s) under ``motion(time) -> retainer
    displacement`` (m from the free state).

    ``start`` is the equilibrium at ``motion(0)``; ``discard`` samples at the beginning are not
    stored. ``watch`` is called with the share that is done and stops the run by False. The contacts of
    coils are recorded every ``pair_interval`` (s), at most every step.
    """
    wire, (first, last) = statics.wire, statics.wire.ends
    limit = time_step or SAFETY * stable_time_step(statics, dynamics, start)
    dense = max(1, round(sample_interval / DENSE_INTERVAL))
    substeps = max(1, math.ceil(sample_interval / dense / limit * (1 - 1e-9)))
    step, steps = sample_interval / (dense * substeps), samples * dense * substeps
    bricks, law, points = wire.bricks, wire.contact.law, start.points.copy()
    fresh = {name: np.zeros_like(getattr(wire.seat_planes, name)) for name in ("peak", "held")}
    planes = wire.seat_planes._replace(**fresh)
    points.peak[:] = 0.0
    branch_step = step / dynamics.branch_time
    decay = math.exp(-branch_step)
    mean = (1 - decay) / branch_step
    damper = np.array([dynamics.branch_stiffness, decay, mean - decay, 1 - mean])
    x = np.ascontiguousarray(start.position).ravel().copy()
    stations, pairs = wire.stations, points.pressed.shape[1]
    arrays = SolidArrays(
        x=x, v=np.zeros_like(x), force=np.zeros_like(x), momentum=np.zeros_like(x), mass=bricks.mass.ravel(), weights=wire.weights,
        centre=np.zeros(3 * stations), rate=np.zeros(3 * stations), push=np.zeros(3 * stations),
        spin=np.zeros(3 * stations), inverse=np.zeros(6 * stations), couple=np.zeros(3 * stations),
        constants=bricks.constants, branch=bricks.branch_states(), scratch=np.zeros(brick_kernels.SCRATCH),
        corners=bricks.corners, shape=bricks.shape,
        section=np.zeros(time_kernels.SECTION_ROWS * time_kernels.STRIDE),
        stations=stations, first=first, last=last,
    )  # fmt: skip
    if dynamics.branch_stiffness > 0:
        brick_kernels.settle_branch(
            x, bricks.constants, arrays.branch, arrays.scratch, bricks.corners, bricks.shape, damper
        )
    numbers = SolidMotionNumbers(
        step, dynamics.mass_damping, dynamics.mass_scaling, dynamics.branch_time, bricks.lame, damper,
        law_address(law), law_numbers(law), wire.contact.damping_time,
        wire.contact.coil_friction, wire.contact.seat_friction,
    )  # fmt: skip
    recorded = (samples - discard) * dense * substeps
    spacing = contact_spacing(pair_interval, step, recorded, 2 * pairs)
    search = max(1, int(MARGIN / MAX_CLOSING / step))
    clock = SolidClock(substeps, dense, discard, spacing, search, ENERGY_STEPS, MARGIN)
    stored, extremes = samples + 1 - discard, np.zeros((samples + 1, 8))
    extremes[:, (0, 4)], extremes[:, (2, 6)] = -np.inf, np.inf
    records = SolidRecords(
        ends=np.zeros((samples * dense + 1, 2)), extremes=extremes, energy=np.zeros((samples + 1, 8)),
        contact=np.zeros((samples + 1, 2, pairs)), pairs=np.zeros((recorded // spacing + 1, 2, pairs)),
        position=np.zeros((stored, x.size)), centre_rate=np.zeros((stored, 3 * stations)),
        impulse=np.zeros(pairs), peak=np.zeros(pairs), carried=np.zeros(6),
        point_peak=np.zeros((stored, len(points.peak))), plane_peak=np.zeros((stored, len(planes.peak))),
    )  # fmt: skip
    done, stopped = 0, False
    for begin in range(0, steps + 1, BLOCK):
        end = min(begin + BLOCK, steps + 1)
        times = np.maximum(step * np.arange(begin - 1.0, end + 1.0), 0.0)
        travel = np.ascontiguousarray(motion(times), dtype=float)
        done = time_kernels.integrate_solid(
            begin, end, travel, numbers, arrays, points, planes, clock, records
        )
        stopped = watch is not None and not watch(end / (steps + 1)) and end <= steps
        if done < end or stopped:
            break
    reached = samples if done > steps else max(0, (done - 1) // (dense * substeps))
    keep = slice(min(discard, reached), reached + 1)
    count = max(0, reached + 1 - discard)
    dense_keep = slice(keep.start * dense, reached * dense + 1)
    time = sample_interval * np.arange(samples + 1.0)
    pressed = records.pairs[: max(0, (reached - discard) * dense * substeps // spacing) + 1]
    return SolidTransient(
        time=time[keep][:count],
        displacement=np.asarray(motion(time))[keep][:count],
        position=records.position[:count].reshape(count, *start.position.shape),
        centre_rate=records.centre_rate[:count].reshape(count, 3, stations),
        contact_force=records.contact[keep, 0][:count],
        contact_peak=records.contact[keep, 1][:count],
        point_peak=records.point_peak[:count],
        plane_peak=records.plane_peak[:count],
        extremes=extremes[keep][:count],
        energy=records.energy[keep][:count],
        dense_time=step * substeps * np.arange(float(len(records.ends)))[dense_keep],
        dense_retainer_force=records.ends[dense_keep, 0],
        dense_seat_force=records.ends[dense_keep, 1],
        pair_time=time[discard] + step * spacing * np.arange(float(len(pressed))),
        pair_force=pressed[:, 0],
        pair_energy=pressed[:, 1],
        time_step=step,
        steps=steps,
        steps_done=done,
        fastest=float(records.carried[time_kernels.FASTEST]),
        stopped=stopped and done <= steps,
    )
