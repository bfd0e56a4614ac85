"""Tables of a spring reduced from its rod: equilibria over lift, a small basis carried from lift to
lift, and all contact points of the rod in its coordinates.

The basis is made about one lift and carried to each other by (K + lambda M) phi(y) = lambda M phi:
stretching of the wire, which would lock positions of one lift at another, is filtered off.
Coordinates count as z with dz = phi^T M du along the path of equilibria, so that |dz/dt|^2 / 2 is
the kinetic energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh

from valvetrain.arrays import Array
from valvetrain.cosserat.condensed import (
    CondensedRod,
    condensed,
    elastic_statics,
    turning_of_contacts,
)
from valvetrain.cosserat.contact_points import ContactPoints
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import Equilibrium, RodStatics, compress
from valvetrain.springs.reduced_rod_kernel import LANES
from valvetrain.springs.reduced_rod_sections import WireTables, wire_tables

#: Spacing (m) of the lifts about which the wire is condensed, and equilibria from one to the next.
SPACING, PARTS = 0.45e-3, 4
#: The basis: modes without contact, modes with the contacts of each of some lifts; above which frequency
#: (Hz) shapes are dropped.
FREE_MODES, CONTACT_LIFTS, CONTACT_MODES, HIGHEST_FREQUENCY = 24, 6, 4, 30e3
#: Static shapes under the forces of contacts that close at rest at some lift, then under those of all:
#: what the basis lacks there makes contacts soft one by one, and swings about them too slow.
CLOSING_SHAPES, SHAPES = 8, 3
#: Frequency (Hz) below which a shape is carried from lift to lift as it is.
CARRIED = 15e3
#: A vector adds to the basis from this share of it on that the basis does not hold; a tangent of
#: the path from this share of the largest.
NEW_SHARE, PATH_SHARE = 0.05, 1e-3


@dataclass(frozen=True, eq=False)
class ReducedTables:
    """Tables over evenly spaced retainer displacements: f fine ones ``spacing`` (m) apart from
    ``start`` (m) on, c coarse ones, each ``parts`` fine ones apart; m coordinates, p points.

    Fine: ``rest`` (f, m) coordinates at rest, ``rest_load`` (f, m) what the wire then pushes
    against its contacts, ``overlap`` (f, p), ``wire_force`` (f,) of the rod at rest without contacts,
    ``height`` (f, n) and ``section_load`` (f, 6, n) at n points of the wire. Coarse: ``stiffness`` (c,
    m, m), ``gradient`` (c, p, m) of the overlaps, ``momentum`` (c, m) along the axis, ``axial_shape``
    (c, n, m) and ``section_shape`` (c, 6, n, m).
    ``contact_stiffness`` (p,) in N/m; ``retainer_mass`` (kg): what the coordinates do not hold of
    the wire that follows the retainer.
    """

    start: float
    spacing: float
    parts: int
    rest: Array
    rest_load: Array
    overlap: Array
    wire_force: Array
    stiffness: Array
    gradient: Array
    momentum: Array
    contact_stiffness: Array
    height: Array
    section_load: Array
    axial_shape: Array
    section_shape: Array
    retainer_mass: float

    @property
    def coordinates(self) -> int:
        """Number of coordinates."""
        return int(self.rest.shape[1])

    @property
    def points(self) -> int:
        """Number of contact points."""
        return int(self.overlap.shape[1])

    @property
    def displacements(self) -> Array:
        """Retainer displacements (f,) of the fine tables (m)."""
        return np.asarray(self.start + self.spacing * np.arange(len(self.rest)), dtype=float)


class _Lift(NamedTuple):
    """The rod at one coarse lift."""

    state: RodState
    wire: CondensedRod
    overlap: Array
    gradient: Array
    turning: Array


def path_of_equilibria(
    statics: RodStatics, installed: Equilibrium, below: int, above: int, spacing: float
) -> list[Equilibrium]:
    """Equilibria every ``spacing`` (m) of travel, ``below`` and ``above`` the installed one; it ends
    where none is found.
    """
    start = installed.state.compression

    def way(count: int, sign: int) -> list[Equilibrium]:
        found = compress(
            statics,
            [start + sign * spacing * (place + 1) for place in range(count)],
            installed.state,
        )
        return [point for point in found if point.converged]

    return [*way(below, -1)[::-1], installed, *way(above, 1)]


def reduce_rod(
    statics: RodStatics,
    path: Sequence[Equilibrium],
    start: float,
    spacing: float,
    total_coils: float,
) -> ReducedTables:
    """Tables from a ``path`` of equilibria ``spacing`` (m) of retainer travel apart, the first at
    the displacement ``start`` (m), of a wire of ``total_coils``; over two coarse lifts at least.
    """
    path = path[: (len(path) - 1) // PARTS * PARTS + 1]
    points = ContactPoints.of(statics.mesh)
    stiffness = statics.contact_stiffness * points.length
    free = slice(statics.mesh.first + 1, statics.mesh.last)

    def overlaps(state: RodState) -> tuple[Array, Array]:
        overlap, gradient = points.overlaps(state)
        return overlap, gradient[:, free].reshape(points.count, 3 * (free.stop - free.start))

    bare = elastic_statics(statics.mesh)
    lifts = []
    for point in path[::PARTS]:
        overlap, gradient = overlaps(point.state)
        closed = (gradient.T * (stiffness * (overlap > 0))) @ gradient
        lifts.append(
            _Lift(
                point.state,
                condensed(statics, bare, point.state),
                overlap,
                gradient,
                turning_of_contacts(statics, bare, point.state, closed),
            )
        )
    positions = np.array([point.state.position[free].ravel() for point in path])
    installed = int(np.argmin(np.abs(start + spacing * PARTS * np.arange(len(lifts)))))
    shapes = _carried(lifts, _basis(lifts, positions[::PARTS], stiffness, installed))
    states = [(lift.state, lift.wire) for lift in lifts]
    wire = wire_tables(bare, [point.state for point in path], states, shapes, total_coils)
    return _tables(statics, points, path, positions, lifts, shapes, stiffness, start, spacing, wire)


def _middle(lifts: Sequence[_Lift], installed: int) -> int:
    return (installed + len(lifts) - 1) // 2


def _basis(
    lifts: Sequence[_Lift], positions: Array, stiffness: Array, installed: int
) -> tuple[Array, int]:
    """Shapes (n, m), orthonormal by mass, about a lift in the middle, whose place is the second."""
    middle = _middle(lifts, installed)
    wire, gradient = lifts[middle].wire, lifts[middle].gradient
    factor = np.linalg.cholesky(wire.mass)
    tangents = np.gradient(positions, axis=0).T
    vectors, sizes, _ = np.linalg.svd(factor.T @ _low_pass(wire, tangents), full_matrices=False)
    basis = vectors[:, sizes > PATH_SHARE * sizes[0]]
    places = np.linspace(installed, len(lifts) - 1, CONTACT_LIFTS).round().astype(int)
    families = []
    for place in np.unique(places):
        on = lifts[place].overlap > 0
        closed = (gradient[on].T * stiffness[on]) @ gradient[on]
        families.append(_modes(wire.stiffness + closed, wire.mass, CONTACT_MODES))
    families.append(_modes(wire.stiffness, wire.mass, FREE_MODES))
    for family in families:
        basis = _extended(basis, factor.T @ family, NEW_SHARE)
    shapes = np.linalg.solve(factor.T, basis)
    closing = np.max([lift.overlap for lift in lifts], axis=0, initial=-np.inf) > 0
    for some, count in ((gradient[closing], CLOSING_SHAPES), (gradient, SHAPES)):
        if len(some):
            if some is gradient and (shapes.shape[1] + count) % LANES == 1:
                count -= 1  # one coordinate beyond whole groups costs a step as much as a group
            local = factor.T @ _under_forces(wire, shapes, some, count)
            basis = _extended(basis, local, 0.0)
            shapes = np.linalg.solve(factor.T, basis)
    squares, turn = np.linalg.eigh(shapes.T @ wire.stiffness @ shapes)
    return (shapes @ turn)[:, squares < (2 * np.pi * HIGHEST_FREQUENCY) ** 2], middle


def _under_forces(wire: CondensedRod, shapes: Array, gradient: Array, count: int) -> Array:
    """What forces on contacts do at rest beyond the ``shapes``: the ``count`` most energetic shapes."""
    softness = np.linalg.solve(wire.stiffness, gradient.T)
    held = shapes.T @ wire.stiffness
    softness -= shapes @ np.linalg.solve(held @ shapes, held @ softness)
    energy, mix = np.linalg.eigh(softness.T @ wire.stiffness @ softness)
    chosen = slice(-1, -1 - min(count, int(np.sum(energy > 1e-9 * energy[-1]))), -1)
    return np.asarray(softness @ (mix[:, chosen] / np.sqrt(energy[chosen])))


def _modes(stiffness: Array, mass: Array, count: int) -> Array:
    last = min(count, len(mass)) - 1
    return np.asarray(eigh(stiffness, mass, subset_by_index=[0, last])[1])


def _extended(basis: Array, more: Array, share: float) -> Array:
    """An orthonormal basis with the directions of ``more`` that it lacks by more than ``share``."""
    for _ in range(2):  # once loses digits
        more = more - basis @ (basis.T @ more)
    vectors, sizes, _ = np.linalg.svd(more, full_matrices=False)
    return np.hstack((basis, vectors[:, sizes > share]))


def _low_pass(wire: CondensedRod, shapes: Array) -> Array:
    stiff = (2 * np.pi * CARRIED) ** 2
    factor = cho_factor(wire.stiffness + stiff * wire.mass)
    return np.asarray(cho_solve(factor, stiff * (wire.mass @ shapes)))


def _carried(lifts: Sequence[_Lift], made: tuple[Array, int]) -> list[Array]:
    """The shapes at every lift, orthonormal by its mass, each as near to the carried one as all
    allow.
    """
    found = []
    for lift in lifts:
        shapes = _low_pass(lift.wire, made[0])
        sizes, turn = np.linalg.eigh(shapes.T @ lift.wire.mass @ shapes)
        found.append(shapes @ (turn / np.sqrt(sizes)) @ turn.T)
    return found


def _lengthened(
    lifts: Sequence[_Lift], shapes: Sequence[Array], stiffness: Array, sharing: int
) -> Array:
    """Travel of each contact (p,) over its own, in series with what the shapes lack of the wire's
    compliance there, which the ``sharing`` points of an element feel together.
    """
    if not len(stiffness):
        return np.ones(0)
    middle = len(lifts) // 2
    wire, gradient, shape = lifts[middle].wire, lifts[middle].gradient, shapes[middle]
    whole = cho_solve(cho_factor(wire.stiffness), gradient.T)
    moved = gradient @ shape
    held = np.linalg.solve(shape.T @ wire.stiffness @ shape, moved.T)
    lacking = np.einsum("pn,np->p", gradient, whole) - np.einsum("pm,mp->p", moved, held)
    return np.asarray(1 + sharing * stiffness * np.maximum(lacking, 0.0))


def _tables(
    statics: RodStatics,
    points: ContactPoints,
    path: Sequence[Equilibrium],
    positions: Array,
    lifts: Sequence[_Lift],
    shapes: Sequence[Array],
    stiffness: Array,
    start: float,
    spacing: float,
    on_wire: WireTables,
) -> ReducedTables:
    fine, count = len(path), shapes[0].shape[1]
    weighted = np.array([lift.wire.mass @ one for lift, one in zip(lifts, shapes, strict=True)])
    rest, load = np.zeros((fine, count)), np.zeros((fine, count))
    overlap = np.zeros((fine, len(stiffness)))
    longer = _lengthened(lifts, shapes, stiffness, statics.mesh.contact.groups)
    soft = stiffness / longer
    between = np.arange(fine) / PARTS
    lower = np.minimum(between.astype(int), len(lifts) - 2)
    share = between - lower

    def mixed(table: Array, place: int) -> Array:
        k, t = lower[place], share[place]
        return np.asarray((1 - t) * table[k] + t * table[k + 1])

    gradients = np.array([lift.gradient @ one for lift, one in zip(lifts, shapes, strict=True)])
    for place, point in enumerate(path):
        if place:
            mean = 0.5 * (mixed(weighted, place - 1) + mixed(weighted, place))
            rest[place] = rest[place - 1] + mean.T @ (positions[place] - positions[place - 1])
        found, _ = points.overlaps(point.state)
        pressed = stiffness * np.maximum(found, 0.0)
        overlap[place] = np.where(found > 0, found * longer, found)
        load[place] = -pressed @ mixed(gradients, place)
    force = np.array([point.retainer_force for point in path])
    tangents = np.gradient(positions, spacing, axis=0)[::PARTS]
    left = [
        tangent @ lift.wire.mass @ tangent - float(np.sum((w.T @ tangent) ** 2))
        for tangent, lift, w in zip(tangents, lifts, weighted, strict=True)
    ]
    return ReducedTables(
        start=start,
        spacing=spacing,
        parts=PARTS,
        rest=rest,
        rest_load=load,
        overlap=overlap,
        wire_force=force - _contact_share(soft, overlap, spacing),
        stiffness=np.array(
            [
                one.T @ (lift.wire.stiffness + lift.turning) @ one
                for lift, one in zip(lifts, shapes, strict=True)
            ]
        ),
        gradient=gradients,
        momentum=weighted[:, 2::3].sum(axis=1),
        contact_stiffness=soft,
        height=on_wire.height,
        section_load=on_wire.load,
        axial_shape=on_wire.axial_shape,
        section_shape=on_wire.load_shape,
        retainer_mass=float(np.mean(left)),
    )


def _contact_share(stiffness: Array, overlap: Array, spacing: float) -> Array:
    """Force on the retainer (f,) by which resting contacts are pressed further along the path: of
    those that stay closed to a neighbouring lift, the mean of its slopes.
    """
    slope = np.diff(overlap, axis=0) / spacing
    stays = (overlap[1:] > 0) & (overlap[:-1] > 0)
    total, count = np.zeros_like(overlap), np.zeros_like(overlap)
    for cut in (slice(1, None), slice(None, -1)):
        total[cut] += np.where(stays, slope, 0.0)
        count[cut] += stays
    pressed = stiffness * np.maximum(overlap, 0.0)
    return np.asarray(np.sum(pressed * total / np.maximum(count, 1), axis=1))
