"""Fills the flat buffer of the time integration from a mesh, a static state and the damping; finds
the stable step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import diags
from scipy.sparse.linalg import ArpackError, eigsh

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import LINEAR, CoilContactLaw, law_address, law_numbers
from valvetrain.cosserat import end_coils
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.layout import empty_buffer, row
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics
from valvetrain.errors import InputError


@dataclass(frozen=True, slots=True)
class RodDynamics:
    """What the time integration needs in addition to the mesh: ``mass_damping`` (1/s),
    ``stiffness_damping`` (s), contact constants.

    Stiffness damping acts through a Maxwell branch of ``relaxation_time`` (s) on bending and
    torsion, since plain
    Kelvin-Voigt damping would cut the explicit step to a few per cent. ``contact_stiffness`` in N/m
    per m of wire, of a contact by ``contact_law``. ``ends``: end coils that lift off their seats;
    None where they are bonded. ``coil_friction``: Coulomb coefficient where coils touch in motion.
    """

    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    relaxation_time: float = 4e-6
    contact_stiffness: float = 2e10
    contact_damping_time: float = 1e-6
    step_safety: float = 0.94
    contact_law: CoilContactLaw = LINEAR
    ends: end_coils.EndCoils | None = None
    coil_friction: float = 0.0

    @property
    def branch_stiffness(self) -> float:
        """Stiffness of the Maxwell branch over that of the wire."""
        return self.stiffness_damping / self.relaxation_time


def stable_time_step(mesh: RodMesh, dynamics: RodDynamics) -> float:
    """Largest stable step of the leapfrog (s), ``step_safety`` included: 2 / largest natural
    angular frequency.

    The Maxwell branch counts with its full stiffness; contact adds the bound 4 k / m of its
    stiffest vertex. Raises :class:`InputError`
    where stiffness, damping and mass differ so much that the largest frequency cannot be
    computed.
    """
    with np.errstate(invalid="ignore"):  # what is beyond all bounds is refused below
        stiffness = mesh.bend_stiffness * (1 + dynamics.branch_stiffness)
    loaded = RodStatics(
        replace(mesh, bend_stiffness=stiffness),
        dynamics.contact_stiffness,
        contact_law=dynamics.contact_law,
    )
    free = loaded.free
    stiffness = loaded.tangent(RodState(mesh.position, mesh.frame))[free][:, free]
    scale = 1.0 / np.sqrt(inertia_of(mesh)[free])
    scaled = diags(scale) @ stiffness @ diags(scale)
    start = np.linspace(1.0, 2.0, scaled.shape[0])
    try:
        top = float(
            eigsh(scaled, k=1, which="LA", tol=1e-3, v0=start, return_eigenvectors=False)[0]
        )
    except (ArpackError, ValueError) as error:
        raise InputError(
            "the wire has no time step at which it can be integrated: its stiffness, stiffness damping and mass differ too much; "
            "check damping, moduli, density and their units"
        ) from error
    moving = slice(mesh.first + 1, mesh.last)
    contact = (
        4
        * (dynamics.contact_stiffness * dynamics.contact_law.steepest)
        * float(np.max((mesh.contact.length.sum(axis=0) / mesh.node_mass)[moving], initial=0.0))
    )
    # A guide pushes across the coils' own contact and its wall is fixed: it counts where it is
    # stiffer than that.
    if mesh.guide is not None:
        contact = max(
            contact,
            mesh.guide.stiffness * float(np.max((mesh.node_length / mesh.node_mass)[moving])),
        )
    if dynamics.ends is not None:  # a seat is fixed, as a wall does
        seats = dynamics.ends.stiffnesses(mesh, dynamics.contact_stiffness)
        steepest = max(dynamics.contact_law.steepest, 1.0)
        contact = max(contact, steepest * float(np.max(seats / dynamics.ends.masses(mesh))))
    return float(dynamics.step_safety * 2.0 / np.sqrt(1.001 * top + contact))


def inertia_of(mesh: RodMesh) -> Array:
    """Diagonal of the lumped mass matrix (6 nv,) in the order of the unknowns."""
    return np.concatenate(
        [np.repeat(mesh.node_mass[:, None], 3, axis=1), mesh.edge_inertia[1:]], axis=1
    ).ravel()


def fill_buffer(mesh: RodMesh, state: RodState, dynamics: RodDynamics, time_step: float) -> Array:
    """The flat buffer of a rod at rest in ``state``, ready to be integrated with ``time_step`` (s)."""
    b = empty_buffer()
    nv, first, last = mesh.vertices, mesh.first, mesh.last
    for names, values in (("X Y Z", state.position.T), ("Q0 Q1 Q2 Q3", state.frame.T)):
        for name, value in zip(names.split(), values, strict=True):
            row(b, name, len(value))[:] = value
    edges = slice(first + 1, last + 1)
    inverse = np.zeros(nv + 1)
    inverse[edges] = 1.0 / mesh.edge_length[edges]
    _put(
        b,
        INVH=inverse,
        GA=mesh.stretch_stiffness[:, 0],
        EA=mesh.stretch_stiffness[:, 2],
        H=mesh.edge_length,
    )
    _put(b, U1=mesh.rest_stretch[:, 0], U2=mesh.rest_stretch[:, 1], U3=mesh.rest_stretch[:, 2])
    _put(
        b, K1=mesh.bend_stiffness[:, 0], K2=mesh.bend_stiffness[:, 1], K3=mesh.bend_stiffness[:, 2]
    )
    _put(b, R1=mesh.rest_bend[:, 0], R2=mesh.rest_bend[:, 1], R3=mesh.rest_bend[:, 2])
    row(b, "INVH", nv + 4)[: first + 1] = 1.0
    row(b, "INVH", nv + 4)[last + 1 :] = 1.0
    moving = np.zeros(nv)
    moving[first + 1 : last] = 1.0 / mesh.node_mass[first + 1 : last]
    spin = np.zeros((nv + 1, 3))
    spin[edges] = 1.0 / mesh.edge_inertia[edges]
    _put(
        b, IM=moving, IJ1=spin[:, 0], IJ3=spin[:, 2], MASS=np.where(moving > 0, mesh.node_mass, 0.0)
    )
    _put(
        b,
        LOWER=np.maximum(mesh.lower_seat_limit, -1e6),
        UPPER=np.minimum(mesh.upper_seat_limit, 1e6),
    )
    _put(b, SEAT=dynamics.contact_stiffness * mesh.node_length)
    if mesh.guide is not None:
        _put(
            b,
            BORE=mesh.guide.bore,
            ROD=mesh.guide.rod,
            WALL=mesh.guide.stiffness * mesh.node_length,
        )
    _fill_contact(b, mesh, dynamics)
    if dynamics.ends is not None:
        _fill_ends(b, mesh, state, dynamics)
    _, vector = quat.relative_vector(state.frame[:-1], state.frame[1:])
    settled = (1 - branch_gains(dynamics, time_step)[2]) * (2 * vector - mesh.rest_bend)
    settled[:first], settled[last + 1 :] = 0.0, 0.0
    _put(b, L1=settled[:, 0], L2=settled[:, 1], L3=settled[:, 2])
    return b


def _put(b: Array, **rows: Array) -> None:
    for name, values in rows.items():
        row(b, name, len(values))[:] = values


def _fill_ends(b: Array, mesh: RodMesh, state: RodState, dynamics: RodDynamics) -> None:
    """End coils on seats at which they press as the bonded ends of ``state``."""
    assert dynamics.ends is not None
    statics = RodStatics(mesh, dynamics.contact_stiffness, contact_law=dynamics.contact_law)
    axial = statics.assemble(state, with_tangent=False)[1].reshape(-1, 6)[:, 2]
    forces = np.sum(axial[: mesh.first + 1]), -np.sum(axial[mesh.last :])
    stiffness = dynamics.ends.stiffnesses(mesh, dynamics.contact_stiffness)
    depth = [
        end_coils.overlap_of(dynamics.contact_law, float(force), float(each))
        for force, each in zip(forces, stiffness, strict=True)
    ]
    height = state.position[[mesh.first, mesh.last], 2]
    seats = height[0] + depth[0], height[1] + state.compression - depth[1]
    _put(b, END=np.concatenate((dynamics.ends.masses(mesh), stiffness, seats)))


def _fill_contact(b: Array, mesh: RodMesh, dynamics: RodDynamics) -> None:
    line = mesh.contact
    for group in range(line.groups):
        mask, suffix = line.points[group], "b" if group else ""
        index = np.flatnonzero(mask)
        below = index - line.offset
        before, centre, after = (mesh.position[below + k] for k in (-1, 0, 1))
        slope = (after - before) / 2 + line.lower_place[group] * (after - 2 * centre + before)
        values = {name: np.zeros(mesh.vertices) for name in ("D0", "DH", "KC", "IS")}
        values["D0"][index] = 1.0 / line.distance[group, index] ** 2
        values["DH"][index] = line.distance[group, index] / 2
        values["KC"][index] = dynamics.contact_stiffness * line.length[group, index]
        values["IS"][index] = 1.0 / np.sum(slope**2, axis=1)
        _put(b, **{name + suffix: value for name, value in values.items()})


def branch_gains(dynamics: RodDynamics, time_step: float) -> tuple[float, float, float]:
    """Decay and the two gains of the low pass, exact for a strain that is linear over the step."""
    x = time_step / dynamics.relaxation_time
    decay = float(np.exp(-x))
    mean = (1 - decay) / x
    return decay, mean - decay, 1 - mean


def stepping_numbers(
    mesh: RodMesh, dynamics: RodDynamics, time_step: float
) -> tuple[NDArray[np.int64], Array, Array]:
    """Integers, numbers and contact places that travel with a buffer (order: constants in
    ``time_stepping``).
    """
    decay, gain_old, gain_new = branch_gains(dynamics, time_step)
    half = 0.5 * dynamics.mass_damping * time_step
    numbers = np.array([
        time_step, (1 - half) / (1 + half), time_step / (1 + half), decay, gain_old, gain_new, dynamics.branch_stiffness,
        dynamics.contact_damping_time, dynamics.mass_damping, dynamics.relaxation_time, dynamics.coil_friction,
        *law_numbers(dynamics.contact_law),
    ])  # fmt: skip
    low = np.flatnonzero(np.isfinite(mesh.lower_seat_limit))
    high = np.flatnonzero(np.isfinite(mesh.upper_seat_limit))
    integers = np.array([
        mesh.first, mesh.last, mesh.contact.offset, mesh.contact.groups, mesh.vertices,
        low.max(initial=-1) + 1, high.min(initial=mesh.vertices), mesh.guide is not None,
        law_address(dynamics.contact_law), dynamics.ends is not None,
    ], dtype=np.int64)  # fmt: skip
    return integers, numbers, np.stack([mesh.contact.upper_place, mesh.contact.lower_place], axis=1)
