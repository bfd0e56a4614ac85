"""Reduced trains from a planar one: lumped masses with the ratios of one pose, and a single mass at
the valve.

The planar gaps are replaced by their gradients, so both reductions inherit every mass, stiffness
and gap of the planar train and differ from it by nothing but the missing geometry.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.mechanism.contour import lift_table
from valvetrain.mechanism.gap_kinds import CAM_KINDS, CAM_LIFT, DISTANCE, LINEAR, POINT_PLANE
from valvetrain.mechanism.gaps import penetration_and_gradient
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, Interaction
from valvetrain.mechanism.rigid import RigidKinematics


def closed_gradients(mechanism: AssembledMechanism) -> Array:
    """Gap gradients (n, N) at zero lift, every body at home."""
    count, total = len(mechanism.interactions), len(mechanism.coordinates)
    names, tables = list(mechanism.tables), np.stack(list(mechanism.tables.values()))
    kinds, table_of, index = (
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.full((count, 4), -1, dtype=np.int64),
    )
    geometry = np.stack([interaction.geometry_row() for interaction in mechanism.interactions])
    gradients, rows, home = np.zeros((count, total)), np.zeros((count, 4)), np.zeros(total)
    for k, interaction in enumerate(mechanism.interactions):
        kinds[k], table_of[k] = (
            interaction.kind,
            names.index(interaction.table) if interaction.table else 0,
        )
        for slot, name in enumerate(interaction.coordinates):
            index[k, slot] = mechanism.index(name) if name else -1
        penetration_and_gradient(k, kinds, index, geometry, tables, table_of, home, 0.0, rows)
        for slot in range(4):
            if index[k, slot] >= 0:
                gradients[k, index[k, slot]] += rows[k, slot]
    return gradients


class _Scaled:
    """A lift law times a factor; what a lumped cam contact reads."""

    def __init__(self, kinematics: RigidKinematics, scale: float) -> None:
        self.kinematics, self.scale = kinematics, scale
        self.joints = getattr(kinematics.law, "joints", ())
        self.continuity = getattr(kinematics.law, "continuity", 2)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Drive travel (m) along the cam contact's normal at zero lift."""
        tight = replace(self.kinematics, lash=0.0)
        return np.asarray(tight._tight(cam_angle, derivative)) * self.scale


def build_lumped(planar: AssembledMechanism) -> AssembledMechanism:
    """The same masses and springs with constant ratios: every gap linear in the coordinates, the
    cam a lift over its angle.

    The drive lift is the rigid valve lift over the closed-pose ratio, so the rigid valve lift is
    that of the planar train.
    """
    gradients = closed_gradients(planar)
    mode = rigid_mode(planar, gradients)
    drive = -float(gradients[planar.cam] @ mode)
    tables = {"cam lift": lift_table(_Scaled(planar.kinematics, drive))}
    changed = []
    for k, interaction in enumerate(planar.interactions):
        names = tuple(name for name in interaction.coordinates if name)
        row = [float(gradients[k, planar.index(name)]) for name in names]
        if interaction.kind in CAM_KINDS:
            kind, table = CAM_LIFT, "cam lift"
            geometry = (0.0, *[-value for value in row], *[0.0] * (4 - len(row)), 1.0)
        else:
            kind, table, geometry = LINEAR, "", (_offset(interaction), *row)
        made = replace(interaction, kind=kind, coordinates=names, geometry=geometry, table=table)
        changed.append(replace(made, unit=interaction.unit or "m"))
    return AssembledMechanism(
        f"{planar.name}, lumped",
        planar.coordinates,
        tuple(changed),
        tables,
        planar.valve,
        planar.retainer,
        planar.kinematics,
    )


def _offset(interaction: Interaction) -> float:
    """Constant part of a gap (m): minus the lash."""
    row = interaction.geometry_row()
    return float({LINEAR: row[0], POINT_PLANE: -row[10], DISTANCE: -row[13]}[interaction.kind])


def rigid_mode(mechanism: AssembledMechanism, gradients: Array) -> Array:
    """Travel of every coordinate per travel of the valve (N,), links rigid and gaps between bodies
    closed.
    """
    total, valve = len(mechanism.coordinates), mechanism.index(mechanism.valve)
    matrix = np.array([*gradients[mechanism.held], np.eye(total)[valve]])
    target = np.zeros(len(matrix))
    target[-1] = 1.0
    mode, _, rank, _ = np.linalg.lstsq(matrix, target, rcond=None)
    if rank < total or np.max(np.abs(matrix @ mode - target)) > 1e-9:
        raise InputError(
            f"mechanism '{mechanism.name}' does not tie every body to the valve; check its interactions"
        )
    return np.asarray(mode)


def equivalent_mass(mechanism: AssembledMechanism) -> float:
    """Mass (kg) of the whole train reduced to the valve at zero lift (springs not counted)."""
    mode = rigid_mode(mechanism, closed_gradients(mechanism))
    return float(
        sum(part.mass * travel**2 for part, travel in zip(mechanism.coordinates, mode, strict=True))
    )


def build_single_mass(planar: AssembledMechanism) -> AssembledMechanism:
    """One mass at the valve under the valve-side lift; the cam contact's law acts at the valve,
    every other part is rigid.
    """
    gradients = closed_gradients(planar)
    mode = rigid_mode(planar, gradients)
    force = float(
        sum(part.force * travel for part, travel in zip(planar.coordinates, mode, strict=True))
    )
    damping = float(
        sum(part.damping * travel**2 for part, travel in zip(planar.coordinates, mode, strict=True))
    )
    friction = float(
        sum(
            part.friction * abs(travel)
            for part, travel in zip(planar.coordinates, mode, strict=True)
        )
    )
    valve = Coordinate(
        "valve", equivalent_mass(planar), force=force, damping=damping, friction=friction
    )
    kinematics = planar.kinematics
    scaled = lift_table(_Scaled(kinematics, 1.0))
    cam = replace(
        planar.interactions[planar.interaction_index("cam")],
        kind=CAM_LIFT,
        coordinates=("valve",),
        geometry=(kinematics.lash, 1.0, 0.0, 0.0, 0.0, 1.0),
        table="cam lift",
    )
    seat = [] if planar.seat is None else [planar.interactions[planar.seat]]
    soft = [
        replace(
            item := planar.interactions[k],
            kind=LINEAR,
            coordinates=("valve",),
            geometry=(_offset(item), float(gradients[k] @ mode)),
            unit=item.unit or "m",
        )
        for k in planar.soft
    ]
    return AssembledMechanism(
        f"{planar.name}, single mass",
        (valve,),
        (cam, *seat, *soft),
        {"cam lift": scaled},
        "valve",
        "valve",
        kinematics,
    )
