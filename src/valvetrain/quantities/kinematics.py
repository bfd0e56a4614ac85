"""Kinematics and quasi-statics of a train: rigid parts, closed contacts, springs in static
equilibrium.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from valvetrain.arrays import Array
from valvetrain.mechanism.contour import curvature_radius_flat, curvature_radius_round
from valvetrain.mechanism.gap_kinds import CAM_FLAT, CAM_ROUND
from valvetrain.mechanism.rigid import RigidKinematics
from valvetrain.parameters.train import TrainParameters
from valvetrain.quantities.contact_loss import ContactLoss, ContactShares, RigidForces
from valvetrain.system.rigid_pose import RigidPoses, rigid_poses
from valvetrain.system.train_system import TrainSystem


@dataclass(frozen=True)
class RigidTable:
    """Rigid motion and quasi-static forces over ``cam_angle`` (S,) at one ``cam_speed`` (rad/s); SI
    units.

    ``columns``: name -> (S,): valve_lift, valve_velocity, valve_acceleration, valve_jerk,
    motion_ratio (valve per follower travel along the cam normal), reduced_mass, inertia_force,
    spring_force, spring_margin (spring and inertia less weight and gas, at the valve),
    contact_force (on the cam) and that of every other contact of the drive, such as
    valve_tip_contact_force, cam_torque, contact_radius (of the cam, infinite where straight),
    contact_offset, sliding_velocity, hertz_pressure and pressure_root (Pa per sqrt N; none of a
    knife edge). ``open_spans``: begin and end (cam rad) of
    every stretch in which the valve is off its seat; none: unknown, the column
    decides. ``loss_share``: the cam speed over that at which rigid parts lose contact; 0 where they never do,
    infinite where they do at rest.
    """

    cam_angle: Array
    cam_speed: float
    columns: Mapping[str, Array]
    open_spans: tuple[tuple[float, float], ...] = ()
    loss_share: float = 0.0

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    @property
    def drive(self) -> tuple[str, ...]:
        """Its contacts from cam to valve (``cam``, ``valve_tip``)."""
        ending = "_contact_force"
        others = (name.removesuffix(ending) for name in self.columns if name.endswith(ending))
        return "cam", *others


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """Rigid motion of one train over ``cam_angle`` (S,): all that is independent of the cam speed;
    SI units.

    ``derivatives`` (4, S): valve lift with all contacts closed and its derivatives by the cam angle. ``spring_force``,
    ``weight`` (N): of the springs at rest and of gravity, at the valve. ``inertia``: inertia force at the valve per cam
    speed squared. ``gas`` (N): its force on the valve, opening positive. ``forces``: of every contact, ``shares`` at
    the cam angles. ``geometry``: columns of the cam contact, with ``sliding_velocity`` per cam speed and
    ``pressure_root`` (Pa per sqrt N). ``kinematics``: the rigid chain itself.
    """

    cam_angle: Array
    derivatives: Array
    reduced_mass: Array
    spring_force: Array
    weight: Array
    gas: Array
    inertia: Array
    forces: RigidForces
    shares: ContactShares
    geometry: Mapping[str, Array]
    kinematics: RigidKinematics

    def table(self, cam_speed: float) -> RigidTable:
        """Kinematics and quasi-statics at ``cam_speed`` (rad/s)."""
        lift, velocity, acceleration, jerk = (self.derivatives[n] * cam_speed**n for n in range(4))
        inertia, moving = self.inertia * cam_speed**2, lift > 0
        held = np.where(
            moving[:, None], self.shares.static + self.shares.inertia * cam_speed**2, 0.0
        )
        at = {place: held[:, number] for number, place in enumerate(self.forces.places)}
        contact = at.pop("cam")
        columns = {
            "valve_lift": lift, "valve_velocity": velocity, "valve_acceleration": acceleration, "valve_jerk": jerk,
            "motion_ratio": 1 / self.shares.per_lift, "reduced_mass": self.reduced_mass, "inertia_force": inertia,
            "spring_force": self.spring_force,
            "spring_margin": np.where(moving, self.spring_force - self.weight - self.gas + inertia, self.spring_force),
            "contact_force": contact, "cam_torque": contact * self.shares.per_angle,
        }  # fmt: skip
        columns |= {f"{place}_contact_force": force for place, force in at.items()}
        columns |= {
            name: self.geometry[name]
            for name in ("contact_radius", "contact_offset")
            if name in self.geometry
        }
        if "sliding_velocity" in self.geometry:
            columns["sliding_velocity"] = self.geometry["sliding_velocity"] * cam_speed
        if "pressure_root" in self.geometry:
            columns["pressure_root"] = self.geometry["pressure_root"]
            columns["hertz_pressure"] = columns["pressure_root"] * np.sqrt(np.maximum(contact, 0.0))
        lost = self.contact_loss()[0]
        share = cam_speed / lost if lost > 0 else np.inf
        return RigidTable(self.cam_angle, cam_speed, columns, self.open_spans, share)

    @cached_property
    def open_spans(self) -> tuple[tuple[float, float], ...]:
        """Begin and end (cam rad) of every stretch in which the rigid valve is off its seat, its
        ends found by bisection.
        """
        edges = np.sort(self.forces.openings(self.cam_angle))
        pairs = zip(
            edges.tolist(), np.append(edges[1:], edges[:1] + 2 * np.pi).tolist(), strict=True
        )
        return tuple(
            pair for pair in pairs if float(self.kinematics.valve_lift(np.array(sum(pair) / 2))) > 0
        )

    def contact_loss(self) -> tuple[float, float]:
        """Cam speed (rad/s) at which a contact of the drive is first lost with rigid parts, and the
        cam angle (rad) where; infinite when none is.
        """
        return self.first_loss[:2]

    @cached_property
    def first_loss(self) -> ContactLoss:
        """The first contact that is lost, where and at which cam speed."""
        return self.forces.first_loss(self.cam_angle)


def rigid_motion(
    system: TrainSystem,
    train: TrainParameters | None = None,
    samples: int = 720,
) -> RigidMotion:
    """Rigid motion of a train on ``samples`` cam angles, computed once for all speeds; ``train`` adds
    the geometry of a planar cam contact.
    """
    angle = np.arange(samples) * 2 * np.pi / samples
    motion, poses = system.mechanism.kinematics, rigid_poses(system)
    derivatives = np.stack([motion.valve_lift(angle, n) for n in range(4)])
    lift = derivatives[0]
    grid = np.linspace(0.0, max(float(lift.max()), 1e-6), 33)
    static = partial(_between, grid, system.spring_forces(grid))
    forces = RigidForces(system, poses, static)
    tight = forces.poses_at(lift)
    geometry = (
        {}
        if train is None
        else _contact_geometry(system, train, poses, angle, lift, derivatives[1])
    )
    # m a + (dm/dlift) v**2 / 2, from the kinetic energy m(lift) v**2 / 2
    inertia = np.where(
        tight > 0,
        poses.mass(tight) * derivatives[2] + poses.mass(tight, 1) * derivatives[1] ** 2 / 2,
        0.0,
    )
    return RigidMotion(
        angle,
        derivatives,
        poses.mass(tight),
        static(lift),
        poses.weight(tight),
        forces.gas(angle),
        inertia,
        forces,
        forces.shares(angle),
        geometry,
        motion,
    )


def rigid_quantities(motion: RigidMotion) -> dict[str, float]:
    """Quantities of the train with rigid parts that belong to no run: maximum lift, and cam angle
    and engine speed (rad/s) of the first loss of contact.
    """
    cam_speed, angle = motion.contact_loss()
    values = {
        "rigid_contact_loss_engine_speed": 2 * cam_speed, "rigid_contact_loss_cam_angle": angle,
        "rigid_maximum_valve_lift": float(np.max(motion.derivatives[0])),
    }  # fmt: skip
    return {name: value for name, value in values.items() if np.isfinite(value)}


def rigid_table(
    system: TrainSystem, train: TrainParameters, cam_speed: float, samples: int = 720
) -> RigidTable:
    """Kinematics and quasi-statics at one cam speed (rad/s); for several speeds of one train see
    :func:`rigid_motion`.
    """
    return rigid_motion(system, train, samples).table(cam_speed)


def _between(lifts: Array, spring_forces: Array, valve_lift: Array) -> Array:
    return np.asarray(np.interp(valve_lift, lifts, spring_forces))


def _contact_geometry(
    system: TrainSystem,
    train: TrainParameters,
    poses: RigidPoses,
    angle: Array,
    lift: Array,
    slope_of_lift: Array,
) -> dict[str, Array]:
    """Cam radius at the contact, offset from the follower's axis, sliding velocity per cam speed
    (m) and Hertz pressure per sqrt(N).
    """
    interaction = system.mechanism.interactions[system.mechanism.interaction_index("cam")]
    if interaction.kind not in (CAM_FLAT, CAM_ROUND):
        return {}
    row, table = interaction.geometry_row(), system.mechanism.tables[interaction.table]
    body = poses.positions(lift)[:, system.mechanism.index(interaction.coordinates[0])]
    rate = poses.mode(lift)[:, system.mechanism.index(interaction.coordinates[0])] * slope_of_lift
    x, y, turn = _points(row, body)
    sense = row[10]
    direction = row[8] + turn if interaction.kind == CAM_FLAT else np.arctan2(y, x)
    chi = angle - sense * (np.unwrap(direction) - row[9])
    value, slope, radius = _on_contour(
        table, chi, interaction.kind == CAM_FLAT, train.follower.radius
    )
    radial, around = (
        np.stack([np.cos(direction), np.sin(direction)]),
        np.stack([-np.sin(direction), np.cos(direction)]),
    )
    if interaction.kind == CAM_FLAT:
        normal, point = radial, value * radial - sense * slope * around
    else:
        normal = (value * radial + sense * slope * around) / np.hypot(value, slope)
        point = np.stack([x, y]) - train.follower.radius * normal
    tangent = np.stack([-normal[1], normal[0]])
    cam_surface = sense * (point[0] * tangent[1] - point[1] * tangent[0])
    body_surface = _body_velocity(row, rate, point, tangent)
    sliding = (
        np.zeros_like(angle) if train.follower.shape == "roller" else cam_surface - body_surface
    )
    found = {
        "contact_radius": radius,
        "contact_offset": -sense * slope
        if interaction.kind == CAM_FLAT
        else np.arctan2(slope, value),
        "sliding_velocity": sliding,
    }
    if train.follower.shape != "knife":  # an edge has no area
        found["pressure_root"] = _pressure_root(train, radius)
    return found


def _points(row: Array, body: Array) -> tuple[Array, Array, Array]:
    if row[0] == 0.0:
        return row[1] + row[3] * body, row[2] + row[4] * body, np.zeros_like(body)
    turn = row[5] * body
    c, s = np.cos(turn), np.sin(turn)
    return row[1] + c * row[3] - s * row[4], row[2] + s * row[3] + c * row[4], turn


def _on_contour(
    table: Array, chi: Array, flat: bool, follower_radius: float
) -> tuple[Array, Array, Array]:
    """Contour value, slope and cam radius of curvature at ``chi`` (linear between nodes, a quarter
    degree apart).
    """
    nodes = np.arange(len(table) + 1) * 2 * np.pi / len(table)
    closed = np.vstack([table, table[:1]])
    value, slope, bend = (np.interp(np.mod(chi, 2 * np.pi), nodes, closed[:, n]) for n in range(3))
    rows = np.column_stack([value, slope, bend])
    return (
        value,
        slope,
        curvature_radius_flat(rows) if flat else curvature_radius_round(rows, follower_radius),
    )


def _body_velocity(row: Array, rate: Array, point: Array, tangent: Array) -> Array:
    """Tangential velocity (m/s) of the follower's material at the contact point."""
    if row[0] == 0.0:
        return np.asarray(rate * (row[3] * tangent[0] + row[4] * tangent[1]))
    spin = row[5] * rate
    return np.asarray(spin * (-(point[1] - row[2]) * tangent[0] + (point[0] - row[1]) * tangent[1]))


def _pressure_root(train: TrainParameters, radius: Array) -> Array:
    """Peak line pressure per root of force, p0 = sqrt(F E* / (pi L R)) with 1/R = 1/R_cam +
    1/R_follower (Johnson 1985, chapter 4).
    """
    modulus = train.cam.youngs_modulus / (2 * (1 - train.cam.poisson_ratio**2))
    curvature = 1 / radius + (1 / train.follower.radius if train.follower.radius > 0 else 0.0)
    return np.sqrt(np.maximum(curvature, 0.0) * modulus / (np.pi * train.cam.width))
