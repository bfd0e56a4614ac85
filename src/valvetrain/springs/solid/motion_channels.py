"""Channels of a solid run: its raw records on even coil numbers, the same that the rod has."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from valvetrain.arrays import Array
from valvetrain.continuum import contact_kernels, time_kernels
from valvetrain.continuum.section_loads import SurfaceStress, section_loads
from valvetrain.continuum.transient import SolidTransient
from valvetrain.continuum.wire import ContactPoints, SolidWire
from valvetrain.solution.channels import EXTREMES, FINE, ChannelArrays, spring_channels
from valvetrain.springs.finite_element_channels import (
    NEAR_GAP,
    SECTION_LOADS,
    SLIDING_VELOCITY,
    wire_points,
)
from valvetrain.springs.solid.model import SolidModel


def solid_channels(
    model: SolidModel,
    run: SolidTransient,
    cam_speed: float,
    retainer_motion: tuple[Array, Array],
    inside: bool = True,
) -> ChannelArrays:
    """Channels of docs/architecture.md for a solid run at ``cam_speed`` (rad/s); ``retainer_motion``:
    velocity (m/s) and acceleration (m/s2) at the samples; ``inside``: sections, energies and contact
    too.
    """
    values: dict[str, Array] = {
        "valve_lift": run.displacement - model.precompression,
        "retainer_velocity": retainer_motion[0],
        "retainer_acceleration": retainer_motion[1],
    }
    dense = (len(run.dense_time) - 1) // max(1, len(run.time) - 1)
    for name, series in (
        ("seat_force", run.dense_seat_force),
        ("retainer_force", run.dense_retainer_force),
    ):
        values[name] = series[::dense]
        padded = np.concatenate([series, np.repeat(series[-1:], dense - 1)])
        values[f"{name}_fine"] = padded[: len(run.time) * dense].reshape(len(run.time), dense)
    for column, name in enumerate(
        f"{end}_force_{kind}" for end in ("seat", "retainer") for kind in EXTREMES
    ):
        values[name] = run.extremes[:, column]
    pairs = len(model.wire.pair_coils)
    if pairs:
        values["coil_contact_force"] = run.contact_force
        values["coil_contact_peak_force"] = run.contact_peak
        values |= _gaps(model.wire, run)
    points: dict[str, Array] = {}
    if inside:
        line, points = _line_forces(model.wire, run)
        values |= _inside(model, run) | line
        surface = SurfaceStress(model.wire)
        values["surface_equivalent_stress"] = np.reshape(
            [surface.equivalent(one) for one in run.position], (len(run.time), -1)
        )
        points["surface_point"] = surface.coil
    return spring_channels(
        run.time,
        cam_speed * run.time,
        values,
        coil_number=wire_points(model.definition.total_coils) if inside else None,
        upper_coil=model.wire.pair_coils if pairs else None,
        extra=FINE,
        point_coils=points,
    )


def _line_forces(wire: SolidWire, run: SolidTransient) -> tuple[dict[str, Array], dict[str, Array]]:
    """Largest force per length (N/m) at every contact point between the samples by channel, and the
    coil numbers of the points by dimension; nothing where no wire can touch.
    """
    number, contact = np.arange(wire.stations, dtype=float), wire.contact_points
    planes, whole = wire.seat_planes, wire.contact.stiffness
    coil = np.interp(contact.station + contact.place, number, wire.coil)
    groups = (
        ("coil", run.point_peak, contact.stiffness, coil, contact.station >= 0),
        ("seat", run.plane_peak, planes.stiffness, wire.coil[planes.station], planes.side > 0),
        ("retainer", run.plane_peak, planes.stiffness, wire.coil[planes.station], planes.side < 0),
    )
    forces, places = dict[str, Array](), dict[str, Array]()
    for name, peak, stiffness, there, own in groups:
        if own.any():
            # stiffness of a point over that per metre is the wire that it represents
            forces[f"{name}_line_force"] = peak[:, own] * whole / stiffness[own]
            places[f"{name}_point"] = there[own]
    return forces, places


def _inside(model: SolidModel, run: SolidTransient) -> dict[str, Array]:
    """Motion and loads along the wire, and energies."""
    wire, coil = model.wire, wire_points(model.definition.total_coils)
    at = make_interp_spline(wire.coil, np.eye(wire.stations), k=3)(coil)
    height = np.einsum("n,tns->ts", wire.weights, run.position[:, :, 2]) @ at.T
    rest = at @ wire.centres(model.installed.position)[2]
    speed = run.centre_rate[:, 2] @ at.T
    interval = run.time[1] - run.time[0] if len(run.time) > 1 else 1.0
    energy = run.energy
    found: dict[str, Array] = {
        "axial_displacement": height - rest,
        "axial_velocity": speed,
        "axial_acceleration": np.diff(speed, axis=0, prepend=speed[:1]) / interval,
        "axial_position": height - model.definition.lower_seat_height,
        "kinetic_energy": energy[:, time_kernels.KINETIC] + energy[:, time_kernels.SCALED],
        "elastic_energy": energy[:, time_kernels.ELASTIC] + energy[:, time_kernels.BRANCH],
        "contact_energy": energy[:, time_kernels.CONTACT],
        "work_done": energy[:, time_kernels.WORK_DONE],
        "energy_dissipated": energy[:, time_kernels.HEAT],
    }
    loads = np.zeros((len(run.time), 5, len(coil)))
    first, last = (wire.coil[end] for end in wire.ends)
    free = (coil >= first - 1e-9) & (coil <= last + 1e-9)
    middles = (
        wire.coil[wire.ends[0] : wire.ends[1]] + wire.coil[wire.ends[0] + 1 : wire.ends[1] + 1]
    ) / 2
    onto = make_interp_spline(middles, np.eye(len(middles)), k=3)(np.clip(coil[free], first, last))
    for sample, position in enumerate(run.position):
        one = section_loads(wire, position)
        # in the order of SECTION_LOADS
        spans = np.stack(
            [
                one.moment[:, 2],
                one.moment[:, 0],
                one.moment[:, 1],
                one.force[:, 2],
                np.hypot(one.force[:, 0], one.force[:, 1]),
            ]
        )
        loads[sample][:, free] = spans @ onto.T
    return found | {name: loads[:, place] for place, name in enumerate(SECTION_LOADS)}


def _gaps(wire: SolidWire, run: SolidTransient) -> dict[str, Array]:
    """Least gap (m) of each pair of coils, and whether it is open, near, touching or sliding."""
    points, count = wire.contact_points.copy(), len(wire.pair_coils)
    gaps, slides = np.full((2, len(run.time), count), np.inf)
    slides *= -1
    for sample, position in enumerate(run.position):
        centre = wire.centres(position).ravel()
        contact_kernels.follow_feet(centre, wire.stations, points, 0.0, 6)
        np.minimum.at(gaps[sample], points.pair, points.apart - points.distance)
        np.maximum.at(
            slides[sample], points.pair, _sliding(wire, points, centre, run.centre_rate[sample])
        )
    status = np.where(gaps < NEAR_GAP, 1, 0)
    touching = (gaps < 0) | (run.contact_force > 0)
    status = np.where(touching, np.where(slides > SLIDING_VELOCITY, 3, 2), status)
    return {"coil_gap": gaps, "contact_status": status}


def _sliding(wire: SolidWire, points: ContactPoints, centre: Array, rate: Array) -> Array:
    """Speed (m/s) at which the two coils slide over one another at each contact point."""
    where, weight = wire.contact_line(points)
    apart = np.einsum("pj,kpj->pk", weight, centre.reshape(3, -1)[:, where])
    moving = np.einsum("pj,kpj->pk", weight, rate[:, where])
    apart /= np.linalg.norm(apart, axis=1, keepdims=True)
    moving -= apart * np.sum(moving * apart, axis=1, keepdims=True)
    found: Array = np.linalg.norm(moving, axis=1)
    return found
