"""Springs reduced from their rods at many instants at once: end forces, energies and what they show
along the wire, by products of whole tables.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.springs import reduced_rod_kernel as kernels
from valvetrain.springs.reduced_rod_tables import ReducedTables


class Samples(NamedTuple):
    """Instants (n,) in the tables: fine and coarse table below each and the share of the way to the
    next, departure from rest (n, m) and overlaps of all points (n, p).
    """

    fine: Ints
    share: Array
    coarse: Ints
    coarse_share: Array
    apart: Array
    overlap: Array

    def at_rest_and_beyond(self, rest: Array, shape: Array) -> Array:
        """A fine table ``rest`` (f, k), and what the departure adds by a coarse ``shape`` (c, k, m), at
        every instant (n, k).
        """
        weights = np.column_stack((1 - self.share, self.share))
        return _sums(self, rest, weights, shape, self.apart)

    def rates(self, tables: ReducedTables, velocities: Array, rates: Array) -> Array:
        """Velocities (n, k) of the points of the wire along the axis (m/s), at those of the retainer (n,)
        and ``rates`` (n, m).
        """
        by_travel = velocities / tables.spacing
        beyond = rates - by_travel[:, None] * (tables.rest[self.fine + 1] - tables.rest[self.fine])
        weights = np.column_stack((-by_travel, by_travel))
        return _sums(self, tables.height, weights, tables.axial_shape, beyond)


def _sums(at: Samples, rest: Array, weights: Array, shape: Array, change: Array) -> Array:
    """Fine tables (f, k) at both lifts times ``weights`` (n, 2), and coarse ones (c, k, m) straight
    between theirs times ``change`` (n, m): one product of matrices for each coarse lift.
    """
    count, parts = change.shape[1], (len(rest) - 1) // (len(shape) - 1)
    factors = np.zeros((len(change), 2 * count + parts + 1))
    factors[:, :count] = (1 - at.coarse_share) * change
    factors[:, count : 2 * count] = at.coarse_share * change
    rows, column = np.arange(len(change)), 2 * count + at.fine - parts * at.coarse
    factors[rows, column], factors[rows, column + 1] = weights.T
    found = np.empty((len(change), rest.shape[1]))
    for place in np.unique(at.coarse):
        here = np.flatnonzero(at.coarse == place)
        tables = rest[place * parts : (place + 1) * parts + 1]
        found[here] = factors[here] @ np.hstack((shape[place], shape[place + 1], tables.T)).T
    return found


def samples_of(tables: ReducedTables, positions: Array, displacements: Array) -> Samples:
    """Coordinates (n, m) at the retainer displacements (n,) in m."""
    place = (displacements - tables.start) / tables.spacing
    fine = np.clip(np.floor(place).astype(np.int64), 0, len(tables.rest) - 2)
    coarse, share = fine // tables.parts, (place - fine)[:, None]
    apart = positions - ((1 - share) * tables.rest[fine] + share * tables.rest[fine + 1])
    coarse_share = (place / tables.parts - coarse)[:, None]
    at = Samples(fine, share[:, 0], coarse, coarse_share, apart, np.zeros((len(apart), 0)))
    return at._replace(overlap=at.at_rest_and_beyond(tables.overlap, tables.gradient))


class SampleForces(NamedTuple):
    """End forces (n, 2) in N, retainer's first, and accelerations (n, m) by all but mass damping."""

    ends: Array
    pull: Array


def sample_forces(
    arrays: tuple[Array, Ints],
    states: Array,
    overlaps: Array,
    displacements: Array,
    velocities: Array,
    unknowns: int,
) -> SampleForces:
    """What the kernel with its ``arrays`` finds at every state (n, s), which stay as they are."""
    integers = arrays[1]
    work = np.zeros(kernels.state_size(unknowns, int(integers[1]), int(integers[6])))
    found = SampleForces(np.empty((len(states), 2)), np.empty((len(states), unknowns)))
    kernels.forces_at(
        *arrays, np.ascontiguousarray(states[:, : 2 * unknowns]), overlaps, work,
        np.ascontiguousarray(displacements, dtype=float), np.ascontiguousarray(velocities, dtype=float), *found,
    )  # fmt: skip
    return found


def sample_energies(
    tables: ReducedTables, samples: Samples, velocities: Array, dissipated: Array
) -> Array:
    """Kinetic, elastic (from the lowest table on), contact and dissipated energy (n, 4) in J."""
    force = tables.wire_force
    path = np.concatenate(([0.0], np.cumsum((force[:-1] + force[1:]) / 2)))[samples.fine]
    low, share = force[samples.fine], samples.share
    path = path + share * (low + share / 2 * (force[samples.fine + 1] - low))
    apart = samples.apart
    half = samples.at_rest_and_beyond(tables.rest_load, tables.stiffness / 2)
    pressed = np.maximum(samples.overlap, 0.0) ** 2
    return np.column_stack(
        (
            np.sum(velocities**2, axis=1) / 2,
            tables.spacing * path + np.sum(half * apart, axis=1),
            pressed @ tables.contact_stiffness / 2,
            dissipated,
        )
    )
