"""Channels of a rod run: its raw records on even coil numbers, with labels and units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.coil_contact.law import contact_response
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.transient import RodTransient
from valvetrain.solution.channels import EXTREMES, FINE, ChannelArrays, spring_channels
from valvetrain.springs.finite_element_model import POINTS_PER_COIL, RodModel

#: A gap (m) below which coils count as near, and the sliding speed (m/s) from which touching coils
#: count as sliding.
NEAR_GAP, SLIDING_VELOCITY = 1e-4, 0.01

SECTION_LOADS = (
    "torsional_moment",
    "bending_moment",
    "binormal_moment",
    "normal_force",
    "shear_force",
)


def wire_points(total_coils: float) -> Array:
    """Coil numbers at which wire channels are reported."""
    return np.arange(int(total_coils * POINTS_PER_COIL + 1e-9) + 1) / POINTS_PER_COIL


def interpolation(vertices: Array, coil: Array) -> Array:
    """Cubic interpolation matrix (points, nv) from ``vertices``, which are coil numbers (nv,), to others (points,)."""
    step = vertices[1] - vertices[0]
    place = np.clip((coil - vertices[0]) / step, 0.0, len(vertices) - 1.0)
    base = np.clip(np.floor(place).astype(int) - 1, 0, len(vertices) - 4)
    matrix = np.zeros((len(coil), len(vertices)))
    for k in range(4):
        weight = np.ones(len(coil))
        for other in range(4):
            if other != k:
                weight *= (place - base - other) / (k - other)
        matrix[np.arange(len(coil)), base + k] = weight
    return matrix


def section_interpolation(mesh: RodMesh, coil: Array) -> Array:
    """The same for section loads, which end where the wire becomes inactive: rows of inactive wire
    are zero, stencils stay on free wire.
    """
    step = mesh.coil_number[1] - mesh.coil_number[0]
    free = slice(mesh.first, mesh.last + 1)
    ends = mesh.coil_number[mesh.first], mesh.coil_number[mesh.last]
    inside = (coil >= ends[0] - 1e-9 * step) & (coil <= ends[1] + 1e-9 * step)
    matrix = np.zeros((len(coil), mesh.vertices))
    matrix[np.flatnonzero(inside), free] = interpolation(mesh.coil_number[free], coil[inside])
    return matrix


def static_section_loads(model: RodModel, states: Sequence[RodState]) -> dict[str, Array]:
    """Section loads (N m, N; states, wire points) of equilibria of the rod, by the names of their
    channels.
    """
    mesh = model.mesh
    at = section_interpolation(mesh, wire_points(model.definition.total_coils))
    strains = _strains(
        mesh,
        np.stack([state.position for state in states]),
        np.stack([state.frame for state in states]),
    )
    return {name: strains[name] @ at.T for name in SECTION_LOADS}


def rod_channels(
    model: RodModel, run: RodTransient, cam_speed: float, whole: bool = True
) -> ChannelArrays:
    """All channels of docs/architecture.md for a rod run, or what a sweep needs: end forces and contacts without
    sections and energies; cam angle is cam_speed (rad/s) times time.
    """
    mesh, installed = model.mesh, model.installed.state
    coil = wire_points(model.definition.total_coils)
    height, speed = run.position[..., 2], run.velocity[..., 2]
    upper_coil, pairs, pair_of = _pairs(model)
    gaps = np.stack(
        [model.statics.gaps(position) for position in np.ascontiguousarray(run.position)]
    )
    values = {
        "valve_lift": run.displacement - model.precompression,
        "retainer_velocity": -speed[:, -1]
        if mesh.vertices > mesh.last and model.dynamics.ends is None
        else np.gradient(run.displacement, run.time),
        "seat_force": run.seat_force,
        "retainer_force": run.retainer_force,
        "coil_gap": _least(gaps[:, :, pairs].min(axis=1), pair_of, len(upper_coil)),
        "coil_contact_force": _sum(
            run.contact_force.sum(axis=1)[:, pairs], pair_of, len(upper_coil)
        ),
        "coil_contact_peak_force": _sum(
            run.contact_peak.sum(axis=1)[:, pairs], pair_of, len(upper_coil)
        ),
        "work_done": run.work_done,
        "energy_dissipated": run.energy_dissipated + run.contact_loss,
    }
    if mesh.guide is not None:
        values["guide_force"] = mesh.guide.pressed(run.position, mesh.node_length)
    if whole:
        at, strains = interpolation(mesh.coil_number, coil), _strains(mesh, run.position, run.frame)
        interval = run.time[1] - run.time[0] if len(run.time) > 1 else 1.0
        axial_velocity = speed @ at.T
        elastic, contact = _energies(model, strains, gaps, run)
        kinetic, ends = _kinetic(mesh, run), model.dynamics.ends
        if ends is not None:  # that lift; bonded ones belong to seat and retainer
            kinetic += 0.5 * run.velocity[:, [mesh.first, mesh.last], 2] ** 2 @ ends.masses(mesh)
        values |= {
            "axial_displacement": (height - installed.position[:, 2]) @ at.T,
            "axial_velocity": axial_velocity,
            "axial_acceleration": np.diff(axial_velocity, axis=0, prepend=axial_velocity[:1])
            / interval,
            "axial_position": height @ at.T - model.definition.lower_seat_height,
            "kinetic_energy": kinetic,
            "elastic_energy": elastic,
            "contact_energy": contact,
        }
        values["contact_status"] = _status(values, run, mesh, pairs, pair_of, len(upper_coil))
        on_wire = section_interpolation(mesh, coil)
        values |= {name: strains[name] @ on_wire.T for name in SECTION_LOADS}
    dense = (len(run.dense_time) - 1) // max(1, len(run.time) - 1) if len(run.time) > 1 else 1
    for name, series in (
        ("seat_force_fine", run.dense_seat_force),
        ("retainer_force_fine", run.dense_retainer_force),
    ):
        padded = np.concatenate([series, np.repeat(series[-1:], dense - 1)])
        values[name] = padded[: len(run.time) * dense].reshape(len(run.time), dense)
    last = np.full((1, run.finest_seat_force.shape[1]), run.seat_force[-1])
    values["seat_force_finest"] = np.concatenate([run.finest_seat_force, last])
    for column, name in enumerate(
        f"{end}_force_{kind}" for end in ("seat", "retainer") for kind in EXTREMES
    ):
        values[name] = run.extremes[:, column]
    return spring_channels(
        run.time,
        cam_speed * run.time,
        values,
        coil_number=coil if whole else None,
        upper_coil=upper_coil,
        extra=FINE,
    )


def pair_values(model: RodModel, gaps: Array) -> tuple[Array, Array, Array]:
    """Upper coil numbers (p,), smallest gap (m) and elastic contact force (N), both (steps, p),
    from gaps (steps, groups, nv).
    """
    mesh = model.mesh
    upper_coil, pairs, pair_of = _pairs(model)
    found = contact_response(model.dynamics.contact_law, -gaps)
    pressed = model.dynamics.contact_stiffness * np.sum(mesh.contact.length * found.elastic, axis=1)
    return (
        upper_coil,
        _least(gaps[:, :, pairs].min(axis=1), pair_of, len(upper_coil)),
        _sum(pressed[:, pairs], pair_of, len(upper_coil)),
    )


def _pairs(model: RodModel) -> tuple[Array, Ints, Ints]:
    """Upper coil numbers, vertices with a partner, and the pair of each such vertex."""
    upper_coil, pair_of = model.coil_pairs
    vertices = np.flatnonzero(pair_of >= 0)
    return upper_coil, vertices, pair_of[vertices]


def _sum(values: Array, pair_of: Ints, count: int) -> Array:
    out = np.zeros((len(values), count))
    np.add.at(out.T, pair_of, values.T)
    return out


def _least(values: Array, pair_of: Ints, count: int) -> Array:
    out = np.full((count, len(values)), np.inf)
    np.minimum.at(out, pair_of, values.T)
    return out.T


def section_vectors(mesh: RodMesh, position: Array, frame: Array) -> tuple[Array, Array, Array]:
    """Moments (N m) and forces (N) on the vertices (ns, nv, 3) in the axes of their sections, elastic
    part, and the stored energies (J; ns).
    """
    _, vector = quat.relative_vector(frame[:, :-1], frame[:, 1:])
    bend = 2 * vector - mesh.rest_bend
    moment = mesh.bend_stiffness * bend
    chord = np.diff(position, axis=1) / mesh.edge_length[1:-1, None]
    stretch = quat.turn_back(frame[:, 1:-1], chord) - mesh.rest_stretch[1:-1]
    force = mesh.stretch_stiffness[1:-1] * stretch
    on_vertices = np.zeros(moment.shape)
    on_vertices[:, 1:-1] = 0.5 * (force[:, 1:] + force[:, :-1])
    on_vertices[:, mesh.first], on_vertices[:, mesh.last] = (
        force[:, mesh.first],
        force[:, mesh.last - 1],
    )
    energy = 0.5 * np.sum(moment * bend, axis=(1, 2)) + 0.5 * np.sum(
        force * stretch * mesh.edge_length[1:-1, None], axis=(1, 2)
    )
    return moment, on_vertices, energy


def _strains(mesh: RodMesh, position: Array, frame: Array) -> dict[str, Array]:
    """Section moments (N m) and forces (N) on the vertices (ns, nv), and the stored energies (J)."""
    moment, force, energy = section_vectors(mesh, position, frame)
    return {
        "bending_moment": moment[..., 0],
        "binormal_moment": moment[..., 1],
        "torsional_moment": moment[..., 2],
        "normal_force": force[..., 2],
        "shear_force": np.hypot(force[..., 0], force[..., 1]),
        "energy": energy,
    }


def _energies(
    model: RodModel, strains: dict[str, Array], gaps: Array, run: RodTransient
) -> tuple[Array, Array]:
    mesh, stiffness, law = model.mesh, model.dynamics.contact_stiffness, model.dynamics.contact_law
    pressed = mesh.contact.length * contact_response(law, -gaps).energy
    contact = stiffness * np.sum(pressed, axis=(1, 2))
    height = run.position[..., 2]
    depth = np.maximum(mesh.lower_seat_limit - height, 0.0) + np.maximum(
        height - (mesh.upper_seat_limit - run.displacement[:, None]), 0.0
    )
    if mesh.guide is not None:
        contact = contact + mesh.guide.energy(run.position, mesh.node_length)
    seats = contact_response(law, depth).energy
    return strains["energy"], contact + stiffness * (seats @ mesh.node_length)


def _kinetic(mesh: RodMesh, run: RodTransient) -> Array:
    moving = slice(mesh.first + 1, mesh.last)
    turning = 0.5 * np.sum(mesh.edge_inertia * run.spin**2, axis=(1, 2))
    found: Array = (
        0.5 * np.sum(run.velocity[:, moving] ** 2, axis=2) @ mesh.node_mass[moving] + turning
    )
    return found


def _status(
    values: dict[str, Array],
    run: RodTransient,
    mesh: RodMesh,
    pairs: Ints,
    pair_of: Ints,
    count: int,
) -> Array:
    offset = mesh.contact.offset
    relative = run.velocity[:, pairs] - run.velocity[:, pairs - offset]
    normal = run.position[:, pairs] - run.position[:, pairs - offset]
    normal /= np.linalg.norm(normal, axis=2)[..., None]
    slide = np.linalg.norm(relative - np.sum(relative * normal, axis=2)[..., None] * normal, axis=2)
    fastest = -_least(-slide, pair_of, count)
    status = np.where(values["coil_gap"] < NEAR_GAP, 1, 0)
    touching = (values["coil_gap"] < 0) | (values["coil_contact_force"] > 0)
    return np.where(touching, np.where(fastest > SLIDING_VELOCITY, 3, 2), status)
