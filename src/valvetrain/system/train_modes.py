"""Modes of a train with its springs: mass and stiffness about a state of rest, and their eigenvalue
problem.

Contacts and links count with their tangents, and with what their forces do as the gaps turn; a
spring adds its own inner motion between a fixed seat and the retainer. No damping; a contact that
does not press has no stiffness.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.mechanism.parts import CONTACT
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.solution.modes import TrainModes
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.linear import SpringMatrices, spring_matrices
from valvetrain.springs.nested import NestedSprings
from valvetrain.system.rigid_pose import rigid_poses
from valvetrain.system.train_forces import gap_state, generalised_forces, law_force, law_tangent
from valvetrain.system.train_rest import static_equilibrium
from valvetrain.system.train_system import TrainSystem

#: Step (m, rad) of the differences of the gaps' gradients, smooth functions of lengths of
#: centimetres.
STEP = 1e-6
#: A stiffness below this share of the largest is what differences leave of zero.
ROUND_OFF = 1e-9
#: Share of the springs' force that may be left over at rest.
UNBALANCED = 1e-3


class Eigen(NamedTuple):
    """Eigenvalues (rad2/s2, ascending) about rest at a cam angle, ``vectors`` (unknown, mode) of unit length
    in displacement times root of mass, positions ``q`` (N,), ``masses`` of the unknowns and matrices of the springs.
    """

    values: Array
    vectors: Array
    q: Array
    masses: Array
    springs: tuple[SpringMatrices, ...]


def eigen_at(system: TrainSystem, installed: Sequence[InstalledSpring], cam_angle: float) -> Eigen:
    """The eigenvalue problem about rest at ``cam_angle`` (rad); ``installed``: the springs behind the system's models, in
    order. Raises :class:`InputError` for a train that comes to no rest.
    """
    lift = float(system.mechanism.kinematics.valve_lift(cam_angle))
    start = rigid_poses(system).positions(np.array([lift]))[0] if lift > 0 else None
    q = static_equilibrium(system, cam_angle, start)
    left = float(np.max(np.abs(generalised_forces(system, q, cam_angle, system.spring_force))))
    if left > UNBALANCED * max(system.spring_force(float(q[system.arrays.retainer])), 1.0):
        raise InputError(
            f"train '{system.name}' comes to no rest ({left:.3g} N or N m are left), so it has no modes; soften its contacts"
        )
    models = _models(system.springs)
    behind = [*installed, *[None] * (len(models) - len(installed))]
    springs = tuple(
        spring_matrices(model, spring, float(q[system.arrays.retainer]))
        for model, spring in zip(models, behind, strict=True)
    )
    masses, stiffness = assembled(system, q, cam_angle, springs)
    root = 1 / np.sqrt(masses)
    values, vectors = np.linalg.eigh(root[:, None] * stiffness * root)
    values[np.abs(values) < ROUND_OFF * values[-1]] = 0.0
    return Eigen(values, vectors, q, masses, springs)


def modes_from(
    system: TrainSystem, eigen: Eigen, cam_angle: float, state: str, label: str = ""
) -> TrainModes:
    """The modes of the eigenvalue problem at ``cam_angle`` (rad), in order of frequency."""
    q, springs = eigen.q, eigen.springs
    count = len(q)
    pens = gap_state(system, q, cam_angle)[0]
    contacts = [
        (one.name, pen > 0)
        for one, pen in zip(system.mechanism.interactions, pens, strict=True)
        if one.role == CONTACT
    ]
    names = (
        ["spring"]
        if len(springs) == 1
        else [f"{word} spring" for word in ("outer", "inner")[: len(springs)]]
    )
    vectors = eigen.vectors / np.sqrt(eigen.masses)[:, None]
    shape, share = _shapes(system, vectors, eigen.masses, springs)
    return TrainModes(
        label or system.name,
        state,
        cam_angle,
        float(q[system.mechanism.index(system.mechanism.valve)]),
        np.sqrt(np.maximum(eigen.values, 0.0)) / (2 * np.pi),
        system.coordinate_names[:count],
        (*system.coordinate_names, *names),
        shape,
        share,
        tuple(name for name, pressed in contacts if pressed),
        tuple(name for name, pressed in contacts if not pressed),
    )


def assembled(
    system: TrainSystem, q: Array, cam_angle: float, springs: Sequence[SpringMatrices]
) -> tuple[Array, Array]:
    """Masses (n,) and stiffness (n, n) of the train's coordinates, then of the inner unknowns of
    every spring.
    """
    count, inner = len(q), [len(one.masses) - 1 for one in springs]
    total = count + sum(inner)
    masses, stiffness = np.zeros(total), np.zeros((total, total))
    masses[:count] = system.masses
    masses[system.arrays.retainer] -= system.spring_mass
    stiffness[:count, :count] = own_stiffness(system, q, cam_angle)
    first = count
    for one, many in zip(springs, inner, strict=True):
        places = np.append(np.arange(first, first + many), system.arrays.retainer)
        masses[places] += one.masses
        stiffness[np.ix_(places, places)] += one.stiffness
        first += many
    return masses, stiffness


def own_stiffness(system: TrainSystem, q: Array, cam_angle: float) -> Array:
    """Stiffness (n, n) of contacts, links and geometry at rest, springs left out: sum of k g g' and
    of the forces times dg/dq.
    """
    pens, gradients, _ = gap_state(system, q, cam_angle)
    acting = [k for k, pen in enumerate(pens) if pen > 0 or system.arrays.laws[k] < 0]
    forces, tangents = np.zeros(len(pens)), np.zeros(len(pens))
    for k in acting:
        forces[k], tangents[k] = (
            law_force(system, k, float(pens[k])),
            law_tangent(system, k, float(pens[k])),
        )
    found = (gradients.T * tangents) @ gradients
    for place, row in enumerate(STEP * np.eye(len(q))):
        ahead, behind = (gap_state(system, q + side * row, cam_angle)[1] for side in (1, -1))
        found[:, place] += forces @ (ahead - behind) / (2 * STEP)
    return np.asarray((found + found.T) / 2)


def _models(springs: Sequence[SpringModel]) -> list[SpringModel]:
    """Every spring of its own: both members of a nested pair."""
    return [
        part
        for one in springs
        for part in (one.members if isinstance(one, NestedSprings) else (one,))
    ]


def _shapes(
    system: TrainSystem, vectors: Array, masses: Array, springs: Sequence[SpringMatrices]
) -> tuple[Array, Array]:
    """Shapes (mode, body) with the largest travel 1, and shares in the kinetic energy (mode, part);
    ``vectors`` (unknown, mode).
    """
    count = len(system.masses)
    energy = masses[:, None] * vectors**2
    parts, first = [*energy[:count]], count
    for one in springs:
        parts.append(energy[first : first + len(one.masses) - 1].sum(axis=0))
        first += len(one.masses) - 1
    turning = np.array([part.unit == "rad" for part in system.mechanism.coordinates])
    radius = np.where(
        turning,
        np.sqrt(np.where(turning, masses[:count], 1.0) / masses[:count][~turning].mean()),
        1.0,
    )
    travel = np.max(np.abs(vectors[:count]) * radius[:, None], axis=0)
    only_springs = travel < 1e-6 * np.max(np.abs(vectors), axis=0)
    shape = np.where(only_springs, 0.0, vectors[:count] / np.where(only_springs, 1.0, travel))
    return shape.T, (np.array(parts) / energy.sum(axis=0)).T
