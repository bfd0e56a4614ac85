"""Drawing of a train: every part whose geometry the case holds, to scale, at the coordinates of the
solution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from valvetrain.arrays import Array
from valvetrain.integrate.train_channels import position_name
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.gap_kinds import CAM_FLAT
from valvetrain.mechanism.parts import AssembledMechanism, Interaction
from valvetrain.mechanism.planar import unit
from valvetrain.parameters.train import TrainParameters
from valvetrain.parameters.train_parts import FollowerParameters
from valvetrain.quantities.cycle import Cycle
from valvetrain.springs.spec import spring_model
from valvetrain.system.problem import Member
from valvetrain.system.rigid_pose import rigid_poses
from valvetrain.system.train_system import TrainSystem
from valvetrain.views.motion import parts as outlines
from valvetrain.views.motion.parts import Body, Places, Shape
from valvetrain.views.motion.springs import wire_of

#: Room (m, rad) beyond the travel of the contact, thickness (m) of a pad, height of a tappet over
#: its half width.
MARGIN, ARC_MARGIN, PAD, TAPPET_SHARE = 1.5e-3, 0.12, 4e-3, 0.9


@dataclass(frozen=True, eq=False)
class Contact:
    """The contact of a cam: its interaction, its contour table and the follower's shape."""

    interaction: Interaction
    table: Array
    follower: FollowerParameters

    @property
    def row(self) -> Array:
        """Geometry row."""
        return self.interaction.geometry_row()

    @property
    def turning(self) -> bool:
        """Whether the follower turns about a pivot."""
        return bool(self.row[0])

    @property
    def flat(self) -> bool:
        """Whether a flat face touches."""
        return self.interaction.kind == CAM_FLAT

    @property
    def driven(self) -> str:
        """Coordinate of the follower."""
        return self.interaction.coordinates[0]

    @property
    def sense(self) -> float:
        """+1 of a cam that turns counter-clockwise."""
        return float(self.row[10])

    @property
    def home(self) -> Array:
        """Arc centre, or point of the face, at zero lift (x, y in m)."""
        row = self.row
        return np.array(row[1:3] + (row[3:5] if self.turning else 0.0))

    @property
    def axis(self) -> Array:
        """Direction in which a sliding follower moves."""
        return np.array(self.row[3:5])

    def lobe(self) -> Array:
        """Outline (point, 2) of the cam in its own frame."""
        return outlines.lobe_outline(
            self.interaction.kind, self.row, self.table, self.follower.radius
        )

    @cached_property
    def slopes(self) -> tuple[float, float]:
        """Minimum and maximum slope of the contour by the cam angle: the position of the contact
        (m) on a flat face, its tangent on an arc.
        """
        slope = self.table[:, 1] if self.flat else self.table[:, 1] / self.table[:, 0]
        return float(np.min(self.sense * slope)), float(np.max(self.sense * slope))

    def half_width(self) -> float:
        """Half width (m) that a sliding follower needs."""
        if self.flat:
            tangent = np.array([-self.axis[1], self.axis[0]])
            offset = float(self.home @ tangent)
            return max(abs(-low - offset) for low in self.slopes) + MARGIN
        sine = np.sin(np.arctan(max(abs(low) for low in self.slopes)))
        return (
            float(min(self.follower.radius * 0.98, self.follower.radius * sine + MARGIN))
            if self.follower.radius
            else 4e-3
        )

    def tappet_height(self) -> float:
        """Height (m) of a tappet from its contact to the valve, which no case holds."""
        return TAPPET_SHARE * self.half_width() + 6e-3


def sliding_follower(
    contact: Contact, moved: Array, name: str, cam_width: float, height: float | None
) -> Body:
    """A tappet: flat face, dome, roller in a fork or knife edge; the body's y axis leads away from
    the cam.
    """
    follower, half = contact.follower, contact.half_width()
    tall = contact.tappet_height() if height is None else height
    axis = contact.axis
    pose = np.column_stack(
        [
            contact.home + moved[:, None] * axis,
            np.full(len(moved), np.arctan2(axis[1], axis[0]) - np.pi / 2),
        ]
    )
    shapes: tuple[Shape, ...]
    if contact.flat and follower.tilt == 0:
        shapes = (outlines.disc(half, 0.0, tall),)
    elif contact.flat:
        lean = np.tan(follower.tilt)
        # The face leans in the body's frame, where the y axis is the axis of the tappet.
        shapes = (
            outlines.plate(
                np.array([[-half, -half * lean], [half, half * lean], [half, tall], [-half, tall]]),
                half,
            ),
        )
    elif follower.shape == "roller":
        fork = np.array(
            [
                [-0.6 * half, 0.0],
                [0.6 * half, 0.0],
                [half, follower.radius + tall],
                [-half, follower.radius + tall],
            ]
        )
        shapes = (
            outlines.plate(outlines.circle(follower.radius), 0.4 * cam_width),
            outlines.plate(fork, 0.5 * cam_width),
        )
    elif follower.radius:
        turn = np.linspace(0.0, np.arcsin(min(half / follower.radius, 1.0)), 16)
        dome = [
            (float(follower.radius * np.sin(one)), float(-follower.radius * np.cos(one)))
            for one in turn
        ]
        top = max(tall, dome[-1][1] + 1e-3) if height is not None else tall
        shapes = (outlines.turned(*dome, (half, top), (0.0, top)),)
    else:
        shapes = (
            outlines.turned(
                (0.0, 0.0),
                (half, 1.5 * half),
                (half, max(tall, 2 * half)),
                (0.0, max(tall, 2 * half)),
            ),
        )
    return Body(name, "follower", shapes, pose)


def turning_pad(
    contact: Contact, turned: Array, cam_angle: Array, depth: float, hub: float
) -> tuple[Shape, ...]:
    """Pad or roller of a lever in the lever's frame (origin at the pivot), and the bar that carries
    it.
    """
    row, follower = contact.row, contact.follower
    arm, none = np.array(row[3:5]), np.zeros(2)
    if follower.shape == "roller":
        rim = outlines.circle(follower.radius, (float(arm[0]), float(arm[1])))
        return outlines.plate(rim, 1.3 * depth), outlines.plate(
            outlines.bar(none, hub, arm, 0.6 * follower.radius), depth
        )
    if contact.flat:
        low, high = sorted(-value for value in contact.slopes)
        normal = float(row[8])
        tangent = np.array([-np.sin(normal), np.cos(normal)])
        offset = float(contact.home @ tangent)
        pad = outlines.face(arm, normal, low - offset - MARGIN, high - offset + MARGIN, PAD)
        return outlines.plate(pad, 1.2 * depth), outlines.plate(
            outlines.bar(none, hub, pad.mean(axis=0), PAD / 2), depth
        )
    where = contact_direction(contact, turned, cam_angle)
    middle, reach = float(where.min() + where.max()) / 2, float(np.ptp(where)) / 2 + ARC_MARGIN
    pad = outlines.crescent(arm, follower.radius, middle - reach, middle + reach, PAD)
    foot = arm + (follower.radius - PAD / 2) * np.array([np.cos(middle), np.sin(middle)])
    return outlines.plate(pad, 1.2 * depth), outlines.plate(
        outlines.bar(none, hub, foot, PAD / 2), depth
    )


def contact_direction(contact: Contact, turned: Array, cam_angle: Array) -> Array:
    """Direction (frame,) in a lever's frame, unwrapped, from the arc's centre to the cam."""
    row = contact.row
    turn = row[5] * turned
    x = row[1] + np.cos(turn) * row[3] - np.sin(turn) * row[4]
    y = row[2] + np.sin(turn) * row[3] + np.cos(turn) * row[4]
    polar = np.arctan2(y, x)
    away = np.mod(polar - row[9] + np.pi, 2 * np.pi) - np.pi
    chi = np.mod(cam_angle - contact.sense * away, 2 * np.pi)
    nodes = np.arange(len(contact.table)) * 2 * np.pi / len(contact.table)
    pitch, slope = (
        np.interp(chi, nodes, contact.table[:, column], period=2 * np.pi) for column in (0, 1)
    )
    # The pitch curve's normal leads from the cam to the centre; the contact is on the other side.
    normal = polar - np.arctan2(-contact.sense * slope, pitch)
    found: Array = np.unwrap(normal + np.pi - turn)
    return found


#: Sizes (m) that no case holds: stem end to retainer, thickness of retainer and seats, radius of
#: pushrod, hub, arm and stem.
TIP_TO_RETAINER, PLATE, ROD_RADIUS, HUB_RADIUS, ARM_RADIUS, STEM_RADIUS = (
    4e-3,
    3e-3,
    4e-3,
    6e-3,
    3.5e-3,
    3.5e-3,
)
#: Radius (m) of a tip that the case takes for a point.
POINTED = 1e-6
#: Where no spring is drawn: outer radius and installed height (m) of the space for one.
NO_SPRING = (14e-3, 40e-3)
TO_SCALE = "To scale: lobe, follower arc or face, lever arms and pivot, pushrod length, springs, lash, lift and every gap."
TYPICAL_SIZES = "Typical sizes, not in the case: tappet and pushrod diameters, stem, head, hub, arms, the place of the spring on the stem."


@dataclass(frozen=True, eq=False)
class TrainDrawing:
    """Bodies over the frames; ``travel`` (frame,): retainer displacement (m) towards the seat;
    ``axis`` (rad): from seat to retainer; ``retainer``: the closed valve's retainer plane on the
    axis of the stem (x, y in m).
    """

    bodies: tuple[Body, ...]
    travel: Array
    axis: float
    retainer: tuple[float, float]
    notes: tuple[str, ...] = ()

    def seat_of(self, installed_height: float) -> tuple[float, float]:
        """Foot (x, y in m) of a spring of that height (m) with the valve closed."""
        x, y = unit(self.axis)
        return self.retainer[0] - installed_height * x, self.retainer[1] - installed_height * y


def draw_train(member: Member, cycle: Cycle, sample: Places) -> TrainDrawing:
    """Cam, follower, lever, pushrod and valve of a train over the frames.

    Parameters
    ----------
    member : the variant of the case that ran, a train
    cycle : the reported cycle of its run
    sample : (frame,) samples drawn

    Returns
    -------
    The bodies with their poses; coordinates come from the channels of the run, those that it does
    not hold from rigid kinematics
    """
    assert member.gear is not None
    train = member.gear.parameters
    mechanism = member.gear.mechanism if train.model == "planar" else _planar(train, member)
    q, notes = coordinates(member, mechanism, cycle, sample)
    if train.model != "planar":
        notes += (
            f"a {train.model} train knows no geometry: its parts are drawn as those of the planar train at the same coordinates",
        )
    angle = cycle.cam_angle[sample]
    still = np.zeros((len(angle), 3))
    cam = mechanism.interactions[mechanism.interaction_index("cam")]
    contact = Contact(cam, mechanism.tables[cam.table], train.follower)
    pose = still.copy()
    pose[:, 2] = contact.sense * angle
    bodies = [Body("cam", "cam", (outlines.plate(contact.lobe(), train.cam.width / 2),), pose)]
    bodies += _levers(train, mechanism, contact, q, angle)
    bodies += _followers(train, contact, q)
    bodies += _pushrod(mechanism, q)
    stem, tip = unit(train.valve.opening_direction), stem_end(train, mechanism, contact)
    travel, lift = q[mechanism.retainer], q[mechanism.valve]
    bodies += _valve(train, member, tip, travel, lift)
    retainer = (tip[0] + TIP_TO_RETAINER * stem[0], tip[1] + TIP_TO_RETAINER * stem[1])
    return TrainDrawing(
        tuple(bodies),
        travel,
        train.valve.opening_direction + math.pi,
        retainer,
        (TO_SCALE, TYPICAL_SIZES, *notes),
    )


def coordinates(
    member: Member, mechanism: AssembledMechanism, cycle: Cycle, sample: Places
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Every coordinate (m or rad) of a planar mechanism over the frames by name, and a note where
    rigid kinematics replace it.
    """
    found = {
        part.name: cycle.channel(name)[sample]
        for part in mechanism.coordinates
        if cycle.solution.has(name := position_name(part, mechanism.valve))
    }
    missing = [part.name for part in mechanism.coordinates if part.name not in found]
    if not missing:
        return found, ()
    rigid = rigid_positions(member, mechanism, cycle.cam_angle[sample])
    lift = cycle.channel("valve_lift")[sample]
    for name in missing:
        moves = rigid[:, mechanism.index(name)]
        found[name] = lift if name.startswith("valve") else moves
    return found, (
        f"the run does not hold the motion of {', '.join(missing)}, drawn as rigid parts move",
    )


def rigid_positions(member: Member, mechanism: AssembledMechanism, cam_angle: Array) -> Array:
    """Coordinates (frame, coordinate) of a train whose rigid parts the cam drives, the lash taken up."""
    assert member.gear is not None
    massless = replace(
        member, model=spring_model("massless"), gear=replace(member.gear, mechanism=mechanism)
    )
    system = massless.system()
    assert isinstance(system, TrainSystem)
    driven = mechanism.kinematics.ratio.splines[0](mechanism.kinematics.drive(cam_angle))
    return rigid_poses(system).positions(driven)


def stem_end(
    train: TrainParameters, mechanism: AssembledMechanism, contact: Contact
) -> tuple[float, float]:
    """End of the closed valve's stem (x, y in m): below the lever's tip by its radius and the lash,
    or below the tappet.
    """
    nx, ny = unit(train.valve.opening_direction)
    tip = mechanism.interactions[mechanism.interaction_index("valve tip")]
    row = tip.geometry_row()
    if train.lever is None:
        reach = contact.tappet_height() + train.lash
        return contact.home[0] + reach * nx, contact.home[1] + reach * ny
    reach = train.lever.tip_radius + train.lash
    return float(row[1] + row[3] + reach * nx), float(row[2] + row[4] + reach * ny)


def _planar(train: TrainParameters, member: Member) -> AssembledMechanism:
    assert member.gear is not None
    lift_of = "valve" if member.gear.mechanism.kinematics.law_of == "valve" else "tappet"
    return build_mechanism(train.replace(model="planar"), member.valve_lift, lift_of)


def _support(interaction: Interaction, q: Mapping[str, Array], frames: int) -> Array:
    name = interaction.coordinates[1] if len(interaction.coordinates) > 1 else ""
    return q[name] if name else np.zeros(frames)


def _levers(
    train: TrainParameters,
    mechanism: AssembledMechanism,
    contact: Contact,
    q: Mapping[str, Array],
    angle: Array,
) -> list[Body]:
    """The lever as one body, or its two halves where it bends."""
    if train.lever is None:
        return []
    tip = mechanism.interactions[mechanism.interaction_index("valve tip")]
    row, depth, none = tip.geometry_row(), 0.3 * train.cam.width, np.zeros(2)
    support = _support(tip, q, len(angle))
    end, tip_radius = np.array(row[3:5]), max(train.lever.tip_radius, POINTED)
    hub = outlines.plate(outlines.circle(HUB_RADIUS), 0.9 * depth)
    tip_shapes = (outlines.plate(outlines.bar(none, ARM_RADIUS, end, tip_radius), depth), hub)
    drive_shapes: tuple[Shape, ...]
    if "pushrod" in q:
        ball = mechanism.interactions[mechanism.interaction_index("rocker")].geometry_row()[3:5]
        drive_shapes = (outlines.plate(outlines.bar(none, ARM_RADIUS, ball, ROD_RADIUS), depth),)
    else:
        drive_shapes = turning_pad(contact, q[contact.driven], angle, depth, ARM_RADIUS)
    driving, driven = tip.coordinates[0], next(name for name in ("lever",) if name in q)

    def pose(name: str) -> Array:
        return np.column_stack(
            [row[1] + row[6] * support, row[2] + row[7] * support, row[5] * q[name]]
        )

    pin = outlines.plate(outlines.circle(0.45 * HUB_RADIUS), 1.6 * depth)
    pivot = Body("pivot", "pivot", (pin,), pose(driven))
    if driving == driven:
        return [Body("lever", "lever", (*drive_shapes, *tip_shapes), pose(driven)), pivot]
    return [
        Body("lever", "lever", drive_shapes, pose(driven)),
        Body("lever tip", "lever", tip_shapes, pose(driving)),
        pivot,
    ]


def _followers(train: TrainParameters, contact: Contact, q: Mapping[str, Array]) -> list[Body]:
    if contact.turning:
        return []
    height = None
    if train.pushrod is not None:
        height = max(
            float(np.dot(np.array(train.pushrod.lower_end) - contact.home, contact.axis)),
            2 * ROD_RADIUS,
        )
    name = "tappet" if contact.driven == "tappet" else "pushrod foot"
    return [sliding_follower(contact, q[contact.driven], name, train.cam.width, height)]


def _pushrod(mechanism: AssembledMechanism, q: Mapping[str, Array]) -> list[Body]:
    """The rod between its ball in the tappet and that of the rocker; its own compression shortens
    it.
    """
    if "pushrod" not in q:
        return []
    joint = mechanism.interactions[mechanism.interaction_index("rocker")]
    row, lower = joint.geometry_row(), q["pushrod"]
    support, turn = _support(joint, q, len(lower)), row[5] * q[joint.coordinates[0]]
    foot = np.column_stack([row[8] + row[10] * lower, row[9] + row[11] * lower])
    ball = np.column_stack([
        row[1] + row[6] * support + np.cos(turn) * row[3] - np.sin(turn) * row[4],
        row[2] + row[7] * support + np.sin(turn) * row[3] + np.cos(turn) * row[4],
    ])  # fmt: skip
    along = ball - foot
    direction = np.arctan2(along[:, 1], along[:, 0]) - np.pi / 2
    rod = outlines.disc(ROD_RADIUS, 0.0, float(row[12]))
    return [Body("pushrod", "pushrod", (rod,), np.column_stack([foot, direction]))]


def _valve(
    train: TrainParameters, member: Member, tip: tuple[float, float], travel: Array, lift: Array
) -> list[Body]:
    """Stem with retainer, head, and the seats of springs and valve; the stem is along the body's
    y axis.
    """
    springs = spring_rooms(member, float(np.max(travel, initial=0.0)))
    radius, length = (
        max(one.outer for one in springs),
        TIP_TO_RETAINER + max(one.height for one in springs),
    )
    stem = min(STEM_RADIUS, 0.5 * min(one.inner for one in springs))
    head, crown = length + 0.8 * radius, 0.95 * radius
    nx, ny = unit(train.valve.opening_direction)
    turn = np.full(len(lift), train.valve.opening_direction - np.pi / 2)

    def pose(moved: Array) -> Array:
        return np.column_stack([tip[0] + nx * moved, tip[1] + ny * moved, turn])

    still = pose(np.zeros_like(lift))
    poppet = outlines.turned(
        (0.0, head + 2.5e-3), (crown, head + 2.5e-3), (crown, head + 1e-3), (crown - 2e-3, head - 1e-3), (1.3 * stem, head - 6e-3),
        (stem, head - 9e-3), (0.0, head - 9e-3),
    )  # fmt: skip
    ring = outlines.turned(
        (crown, head + 1e-3), (crown + 3e-3, head + 1e-3), (crown + 3e-3, head - 4e-3), (crown - 2e-3, head - 4e-3),
        (crown - 2e-3, head - 1e-3), (crown, head + 1e-3),
    )  # fmt: skip
    bodies = [
        Body("valve stem", "valve", (outlines.disc(stem, 0.0, head - 4e-3),), pose(travel)),
        Body(
            "retainer",
            "retainer",
            (outlines.disc(radius + 1e-3, TIP_TO_RETAINER - PLATE, TIP_TO_RETAINER, stem),),
            pose(travel),
        ),
        Body("valve head", "valve", (poppet,), pose(lift)),
        Body("valve seat", "seat", (ring,), still),
    ]
    for one in springs:
        bottom = TIP_TO_RETAINER + one.height
        seat = outlines.disc(one.outer + 1e-3, bottom, bottom + PLATE, min(1.6 * stem, one.inner))
        bodies.append(Body(f"{one.name} seat", "seat", (seat,), still))
    return bodies


@dataclass(frozen=True, slots=True)
class SpringRoom:
    """Space of a spring on the stem: largest outer and smallest inner radius, installed height (m)."""

    name: str
    outer: float
    inner: float
    height: float


def spring_rooms(member: Member, valve_lift: float) -> tuple[SpringRoom, ...]:
    """Space of every spring of a member that is drawn, or a typical one; ``valve_lift`` (m) as for
    ``wire_of``.
    """
    found = []
    for spring in member.springs:
        wire, precompression, _ = wire_of(spring, valve_lift)
        if wire is not None:
            coil = np.linspace(0.0, wire.total_coils, 65)
            outer, thick = wire.outer_diameter(coil) / 2, wire.wire_diameter.value(coil)
            room = SpringRoom(
                spring.name,
                float(outer.max()),
                float((outer - thick).min()),
                wire.free_length - precompression,
            )
            found.append(room)
    return tuple(found) or (SpringRoom("spring", NO_SPRING[0], 0.7 * NO_SPRING[0], NO_SPRING[1]),)
