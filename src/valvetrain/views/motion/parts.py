"""Parts of a moving picture: springs, rigid bodies, forces and marks over selected samples of one
cam revolution; SI units, angles in rad.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.mechanism.gap_kinds import CAM_FLAT
from valvetrain.parameters.summary import number
from valvetrain.quantities.cycle import Cycle
from valvetrain.solution.critical import places_text
from valvetrain.solution.definition import angle_name, label_of, shown
from valvetrain.solution.display import value_text as shown_text
from valvetrain.solution.result import Solution

Places = Ints


@dataclass(frozen=True, eq=False)
class Colouring:
    """A channel along the wire as colours: ``values`` (frame, node) in ``unit``, from ``low`` to
    ``high`` over ``stops`` (``#rrggbb``). ``around`` (frame, node, fibre): the same around the section,
    evenly upward from the outward direction, of which ``values`` are the largest.
    """

    key: str
    label: str
    unit: str
    values: Array
    low: float
    high: float
    stops: tuple[str, ...]
    around: Array | None = None


@dataclass(frozen=True, eq=False)
class SpringDrawing:
    """One spring: nodes at ``coil`` numbers (node,) on a helix of ``radius`` (node,) and wire of
    ``wire_radius`` (node,), in m.

    The axis of node n is ``rest`` + ``displacement`` (m; (node,) and (frame, node)) above the
    lower seat. ``seat`` (x, y in m) and ``direction`` (rad): foot and direction of the spring's
    axis in the plane of the train. ``retainer`` (frame,): height (m) of the retainer's plane.
    ``sign``: +1 of a right-hand helix, -1 of a left-hand one.
    """

    name: str
    coil: Array
    radius: Array
    wire_radius: Array
    sign: float
    rest: Array
    displacement: Array
    retainer: Array
    colourings: tuple[Colouring, ...]
    seat: tuple[float, float] = (0.0, 0.0)
    direction: float = np.pi / 2

    @property
    def height(self) -> Array:
        """Height (m) of every node above the lower seat, (frame, node)."""
        return self.rest + self.displacement


@dataclass(frozen=True, eq=False)
class Shape:
    """A part of a body in its own frame (m): ``extrude`` is a closed outline (point, 2) between two
    depths, ``lathe`` a profile of radius and height (point, 2) turned about the body's y axis.
    """

    kind: str
    points: Array
    depth: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body: ``pose`` (frame, 3) holds x, y (m) and the angle (rad, counter-clockwise);
    ``tone``: name of its colour.
    """

    name: str
    tone: str
    shapes: tuple[Shape, ...]
    pose: Array


@dataclass(frozen=True, eq=False)
class Series:
    """A force (N) over every sample of the cycle (``cam_angle``, rad), whatever frames are drawn."""

    label: str
    colour: str
    cam_angle: Array
    values: Array


@dataclass(frozen=True, slots=True)
class Mark:
    """A place to jump to: cam angle (rad, 0 to 2 pi), kind (``peak``, ``clash``, ``other``) and
    label.
    """

    cam_angle: float
    kind: str
    label: str


@dataclass(frozen=True, eq=False)
class Variant:
    """One run in motion. ``sample``: places (frame,) of the frames in the reported cycle;
    ``cam_angle`` (frame,) rad, ascending; ``valve_lift`` (frame,) m; ``closed``: whether the last
    frame leads into the first. ``notes``: what is reconstructed or not given.
    """

    label: str
    title: str
    engine_speed: float
    sample: Places
    cam_angle: Array
    valve_lift: Array
    springs: tuple[SpringDrawing, ...]
    bodies: tuple[Body, ...] = ()
    forces: tuple[Series, ...] = ()
    marks: tuple[Mark, ...] = ()
    notes: tuple[str, ...] = ()
    closed: bool = False


@dataclass(frozen=True, eq=False)
class Moving:
    """A moving picture: its variants, and a sentence where some runs are left out."""

    title: str
    variants: tuple[Variant, ...] = ()
    notes: tuple[str, ...] = field(default_factory=tuple)


_TURN = 2 * np.pi
#: Clashes and other events in the list.
MAX_CLASHES, MAX_OTHERS = 12, 12
#: Peaks on every step of the integration, whose angles are quantities too.
_PEAKS = ("peak_spring_force", "minimum_spring_force")


def marks_of(run: Solution, cycle: Cycle) -> tuple[Mark, ...]:
    """Marks of a run by cam angle: largest and least spring force (on every step where the run
    gives it), the hardest clashes at their peaks, the first of its other events.
    """
    found = _peaks(run, cycle)
    clashes = sorted(
        (event for event in run.events if event.kind == "clash"), key=lambda event: -event.size
    )[:MAX_CLASHES]
    for event in clashes:
        at = float(event.details.get("peak_cam_angle", event.cam_angle))
        label = f"clash {shown_text(event.size, event.unit, 3)}" + (
            f", {event.where}" if event.where else ""
        )
        found.append(Mark(at % _TURN, "clash", label))
    for event in [event for event in run.events if event.kind != "clash"][:MAX_OTHERS]:
        size = f" {shown_text(event.size, event.unit, 3)}" if event.unit else ""
        where = f", {places_text(event.where)}" if event.where else ""
        found.append(
            Mark(
                event.cam_angle % _TURN,
                "other",
                f"{event.kind.replace('_', ' ').replace('-', ' ')}{where}:{size}",
            )
        )
    return tuple(sorted(found, key=lambda mark: mark.cam_angle))


def still_frame(variant: Variant) -> int:
    """Frame of the printed picture: at the mark of the largest spring force, else at full lift."""
    peak = next(
        (
            mark
            for mark in variant.marks
            if mark.kind == "peak" and not mark.label.startswith("minimum")
        ),
        None,
    )
    if peak is None:
        return int(np.argmax(variant.valve_lift))
    return int(np.argmin(np.abs(variant.cam_angle - peak.cam_angle)))


def _peaks(run: Solution, cycle: Cycle) -> list[Mark]:
    found = []
    for name in _PEAKS:
        angle = run.quantities.get(angle_name(name))
        if name in run.quantities and angle is not None and np.isfinite(angle):
            value, unit = shown(name, run.quantities[name])
            found.append(
                Mark(
                    float(angle) % _TURN, "peak", f"{label_of(name)} {number(float(value))} {unit}"
                )
            )
    if not found and run.has("seat_force"):
        force = cycle.channel("seat_force")
        for place, label in (
            (int(np.argmax(force)), "largest"),
            (int(np.argmin(force)), "minimum"),
        ):
            found.append(
                Mark(
                    float(cycle.cam_angle[place]),
                    "peak",
                    f"{label} force on the seat {number(float(force[place]))} N",
                )
            )
    return found


#: Points of a lobe and of a full circle.
LOBE_POINTS, CIRCLE_POINTS = 720, 40


def lobe_outline(kind: int, row: Array, table: Array, follower_radius: float) -> Array:
    """Outline (point, 2) of a cam in its own frame, which coincides with the plane's at cam angle zero.

    Parameters
    ----------
    kind : ``CAM_FLAT`` (the table is a support function) or ``CAM_ROUND`` (a pitch curve)
    row : geometry row of the cam contact
    table : (nodes, 3) contour table, m and its derivatives by the cam angle
    follower_radius : arc (m) of a round follower

    Returns
    -------
    The closed outline, counter-clockwise for a cam that turns clockwise: material under a follower
    at polar direction
    ``reference - sense chi``. A flat face touches it at h n + h' t; a round one at the pitch curve
    less its radius along the normal.
    """
    step = max(1, len(table) // LOBE_POINTS)
    value, slope = table[::step, 0], table[::step, 1]
    reference, sense = float(row[9]), float(row[10])
    polar = reference - sense * np.arange(0, len(table), step) * 2 * np.pi / len(table)
    radial, around = (
        np.column_stack([np.cos(polar), np.sin(polar)]),
        np.column_stack([-np.sin(polar), np.cos(polar)]),
    )
    by_polar = (-sense * slope)[:, None]
    normal = (value[:, None] * radial - by_polar * around) / np.hypot(value, slope)[:, None]
    found: Array = value[:, None] * radial + (
        by_polar * around if kind == CAM_FLAT else -follower_radius * normal
    )
    return found


def circle(radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Outline of a circle."""
    turn = np.arange(CIRCLE_POINTS) * 2 * np.pi / CIRCLE_POINTS
    return np.column_stack([centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn)])


def bar(first: Array, first_radius: float, second: Array, second_radius: float) -> Array:
    """Outline of a bar with round ends: the hull of two circles."""
    along = second - first
    distance = float(np.hypot(*along))
    if distance <= abs(first_radius - second_radius):
        return circle(
            max(first_radius, second_radius),
            tuple(first if first_radius > second_radius else second),
        )
    direction = float(np.arctan2(along[1], along[0]))
    open_angle = float(np.arccos((first_radius - second_radius) / distance))
    near = np.linspace(open_angle, 2 * np.pi - open_angle, 20) + direction
    far = np.linspace(-open_angle, open_angle, 20) + direction
    ends = [
        centre + radius * np.column_stack([np.cos(turn), np.sin(turn)])
        for centre, radius, turn in ((first, first_radius, near), (second, second_radius, far))
    ]
    return np.concatenate(ends)


def crescent(centre: Array, radius: float, first: float, last: float, thickness: float) -> Array:
    """Outline of a pad: the arc of ``radius`` from ``first`` to ``last`` (rad), ``thickness`` deep
    towards its centre.
    """
    turn = np.linspace(first, last, 32)
    inner = max(radius - thickness, 0.0)
    outside = centre + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    inside = centre + inner * np.column_stack([np.cos(turn[::-1]), np.sin(turn[::-1])])
    return np.concatenate([outside, inside])


def face(point: Array, normal: float, first: float, last: float, thickness: float) -> Array:
    """Outline of a flat pad whose face passes ``point`` across ``normal`` (rad), from ``first`` to
    ``last`` (m) along it.
    """
    n, t = np.array([np.cos(normal), np.sin(normal)]), np.array([-np.sin(normal), np.cos(normal)])
    corners = [
        point + first * t,
        point + last * t,
        point + last * t + thickness * n,
        point + first * t + thickness * n,
    ]
    return np.array(corners)


def plate(outline: Array, half_depth: float) -> Shape:
    """An outline between two planes at even distances from the plane of motion."""
    return Shape("extrude", outline, (-half_depth, half_depth))


def turned(*profile: tuple[float, float]) -> Shape:
    """A profile of (radius, height) points turned about the body's y axis."""
    return Shape("lathe", np.array(profile, dtype=float))


def disc(radius: float, bottom: float, top: float, bore: float = 0.0) -> Shape:
    """A disc about the body's y axis between two heights, with a bore where one is given."""
    return turned((bore, bottom), (radius, bottom), (radius, top), (bore, top), (bore, bottom))
