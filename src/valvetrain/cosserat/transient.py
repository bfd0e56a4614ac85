"""Transient response of the rod to a prescribed retainer motion, with raw records that others turn
into channels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.arrays import Array
from valvetrain.coil_contact.record import contact_spacing
from valvetrain.cosserat.buffer import RodDynamics, fill_buffer, stable_time_step, stepping_numbers
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.time_stepping import STRETCHES, integrate_in_time
from valvetrain.errors import InputError

#: Target spacing of the dense force record (s): 250 kHz resolves spikes filtered at 20 kHz.
DENSE_INTERVAL = 4e-6
#: Most force records that are stored, however slow the revolution; slower ones are further apart.
MAX_DENSE = 2**20
#: Even places between two samples at which the seat force is stored too: a spike lasts a few of them.
FINEST = 50
#: Steps whose motion is computed at a time.
BLOCK = 2**20


def dense_records(sample_interval: float, samples: int) -> int:
    """Force records per sample, of which ``samples`` of ``sample_interval`` (s) are stored."""
    records = max(1, round(sample_interval / DENSE_INTERVAL))
    return min(records, max(1, MAX_DENSE // max(1, samples)))


@dataclass(frozen=True)
class RodTransient:
    """Raw records of a run: ns samples, nd dense records, nv vertices; SI units.

    ``position``, ``velocity`` (ns, nv, 3); ``frame`` (ns, nv + 1, 4); ``spin`` (ns, nv + 1, 3, body
    frame);
    ``contact_force`` and ``contact_peak`` (ns, groups, nv) mean and peak since the last sample;
    ``contact_loss`` (ns,);
    ``dense_*`` (nd,); ``finest_seat_force`` (ns - 1, :data:`FINEST`) from each sample on;
    ``extremes`` (ns, 8) of all steps up to the next sample: largest seat force,
    its time, least, its time, and the
    same of the retainer force; ``pair_force`` (N) and ``pair_energy`` (J, stored in the contact)
    (nc, pairs) at ``pair_time`` (nc,).
    ``steps_done`` < ``steps`` when the run diverged.
    """

    time: Array
    displacement: Array
    position: Array
    velocity: Array
    frame: Array
    spin: Array
    contact_force: Array
    contact_peak: Array
    contact_loss: Array
    retainer_force: Array
    seat_force: Array
    work_done: Array
    energy_dissipated: Array
    dense_time: Array
    dense_retainer_force: Array
    dense_seat_force: Array
    finest_seat_force: Array
    extremes: Array
    pair_time: Array
    pair_force: Array
    pair_energy: Array
    time_step: float
    steps: int
    steps_done: int
    fastest: float

    @property
    def completed(self) -> bool:
        """Whether the run reached its end."""
        return self.steps_done > self.steps


def simulate(
    mesh: RodMesh,
    start: RodState,
    motion: Callable[[Array], ArrayLike],
    sample_interval: float,
    samples: int,
    dynamics: RodDynamics,
    time_step: float | None = None,
    discard: int = 0,
    pair_of: NDArray[np.int64] | None = None,
    pair_interval: float = 0.0,
) -> RodTransient:
    """Integrate ``samples`` intervals of ``sample_interval`` (s) under ``motion(time) -> retainer
    displacement`` (m).

    The displacement counts from the free state; ``start`` is the equilibrium at ``motion(0)``.
    ``discard`` samples at
    the beginning are not stored. ``pair_of`` (nv,): coil pair to which the contact points of a vertex
    count, -1 for none, recorded every ``pair_interval`` (s), at most every step. Raises
    :class:`InputError` when a given ``time_step`` is not positive.
    """
    if time_step is not None and not time_step > 0:
        raise InputError(f"the time step must be positive; it is {time_step}")
    limit = stable_time_step(mesh, dynamics) if time_step is None else time_step
    discard = min(discard, samples)
    dense = dense_records(sample_interval, samples - discard)
    sub = max(1, int(np.ceil(sample_interval / dense / limit * (1 - 1e-9))))
    step = sample_interval / (dense * sub)
    integers, numbers, places = stepping_numbers(mesh, dynamics, step)
    buffer = fill_buffer(mesh, start, dynamics, step)
    steps = samples * dense * sub
    snapshots = np.empty((samples + 1 - discard, 13, mesh.vertices + 1))
    contacts = np.zeros((samples + 1, 3, mesh.contact.groups, mesh.vertices))
    records, extremes = np.empty((samples * dense + 1, 4)), np.zeros((samples + 1, 8))
    bins = np.full(mesh.vertices, -1, dtype=np.int64) if pair_of is None else pair_of
    pairs, recorded = int(bins.max()) + 1, (samples - discard) * dense * sub
    spacing = contact_spacing(pair_interval, step, recorded, 2 * pairs)
    most = max(1, dense * sub // (2 * FINEST))
    apart = next(n for n in range(most, 0, -1) if dense * sub % n == 0)
    finest = np.full(recorded // apart + 1, np.nan)
    clock, stretches = np.array([sub, dense, discard, spacing, apart]), np.zeros((STRETCHES, 2))
    pressed = np.zeros((recorded // spacing + 1, 2, pairs))
    block, carried = max(1, BLOCK // (dense * sub)) * dense * sub, np.zeros(6)
    for begin in range(0, steps + 1, block):
        end = begin + block if begin + block < steps else steps + 1
        times = step * np.arange(float(begin), float(min(end, steps) + 1))
        done, fastest = integrate_in_time(
            buffer,
            integers,
            numbers,
            places,
            np.ascontiguousarray(motion(times), dtype=float),
            clock,
            stretches,
            snapshots,
            contacts,
            records,
            extremes,
            bins,
            pressed,
            finest,
            begin,
            end,
            carried,
        )
        if done < end or end > steps:
            break
    reached = min(samples, (done - 1) // (dense * sub)) if done <= steps else samples
    if (
        reached < discard
    ):  # diverged among the samples not stored: run again and keep the last one before
        return simulate(
            mesh, start, motion, sample_interval, samples, dynamics, time_step, reached, pair_of
        )
    keep, stored = slice(discard, reached + 1), slice(0, reached + 1 - discard)
    dense_keep = slice(keep.start * dense, reached * dense + 1)
    time = sample_interval * np.arange(samples + 1.0)
    pressed = pressed[: (reached - discard) * dense * sub // spacing + 1]
    extremes[:, 1::2] *= step
    at = np.arange((reached - discard) * FINEST) * (dense * sub / FINEST / apart)
    vertices = snapshots[stored, :, : mesh.vertices]
    return RodTransient(
        time=time[keep],
        displacement=np.asarray(motion(step * (dense * sub * np.arange(samples + 1.0))))[keep],
        position=np.moveaxis(vertices[:, 0:3], 1, 2),
        velocity=np.moveaxis(vertices[:, 7:10], 1, 2),
        frame=np.moveaxis(snapshots[stored, 3:7], 1, 2),
        spin=np.moveaxis(snapshots[stored, 10:13], 1, 2),
        contact_force=contacts[keep, 0],
        contact_peak=contacts[keep, 1],
        contact_loss=np.cumsum(contacts[:, 2].sum(axis=(1, 2)))[keep],
        retainer_force=records[::dense, 0][keep],
        seat_force=records[::dense, 1][keep],
        work_done=records[::dense, 2][keep],
        energy_dissipated=records[::dense, 3][keep],
        dense_time=step * sub * np.arange(float(len(records)))[dense_keep],
        dense_retainer_force=records[dense_keep, 0],
        dense_seat_force=records[dense_keep, 1],
        finest_seat_force=np.interp(at, np.arange(len(finest)), finest).reshape(-1, FINEST),
        extremes=extremes[keep],
        pair_force=pressed[:, 0],
        pair_energy=pressed[:, 1],
        pair_time=time[discard] + step * spacing * np.arange(float(len(pressed))),
        time_step=step,
        steps=steps,
        steps_done=done,
        fastest=fastest,
    )
