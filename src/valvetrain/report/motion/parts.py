"""What a moving picture is made of: springs, rigid bodies, forces and marks over chosen samples of one cam turn. SI, angles in rad."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Colouring:
    """A channel along the wire as colours: ``values`` (frame, node) in ``unit``, from ``low`` to ``high`` over ``stops`` (``#rrggbb``)."""

    key: str
    words: str
    unit: str
    values: Array
    low: float
    high: float
    stops: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class SpringDrawing:
    """One spring: nodes at ``coil`` numbers (node,) on a helix of ``radius`` (node,) and wire of ``wire_radius`` (node,), in m.

    The axis of node n stands ``rest`` + ``displacement`` (m; (node,) and (frame, node)) above the lower seat. ``seat`` (x, y in m) and
    ``direction`` (rad): foot and direction of the spring's axis in the plane of the train. ``retainer`` (frame,): height (m) of the
    retainer's plane. ``sign``: +1 of a right-hand helix, -1 of a left-hand one.
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
    """A part of a body in its own frame (m): ``extrude`` is a closed outline (point, 2) between two depths, ``lathe`` a profile of
    radius and height (point, 2) turned about the body's y axis."""

    kind: str
    points: Array
    depth: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body: ``pose`` (frame, 3) holds x, y (m) and the angle (rad, counter-clockwise); ``tone``: word of its colour."""

    name: str
    tone: str
    shapes: tuple[Shape, ...]
    pose: Array


@dataclass(frozen=True, eq=False)
class Series:
    """A force (N) over every sample of the cycle (``cam_angle``, rad), whatever frames are drawn."""

    words: str
    colour: str
    cam_angle: Array
    values: Array


@dataclass(frozen=True, slots=True)
class Mark:
    """A place to jump to: cam angle (rad, 0 to 2 pi), kind (``peak``, ``clash``, ``other``) and words."""

    cam_angle: float
    kind: str
    words: str


@dataclass(frozen=True, eq=False)
class Variant:
    """One run in motion. ``sample``: places (frame,) of the frames in the reported cycle; ``cam_angle`` (frame,) rad, ascending;
    ``valve_lift`` (frame,) m; ``closed``: whether the last frame goes on into the first. ``notes``: what is reconstructed or not told."""

    label: str
    words: str
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
    """All that one moving picture shows: its variants, and a sentence where there are more runs than are drawn."""

    title: str
    variants: tuple[Variant, ...] = ()
    notes: tuple[str, ...] = field(default_factory=tuple)
