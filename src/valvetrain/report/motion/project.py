"""A moment of a moving picture as flat shapes, far ones first: for still pictures and for films."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from valvetrain.report.motion.pack import TONES
from valvetrain.report.motion.parts import Array, Body, Colouring, Places, Shape, SpringDrawing, Variant

#: Directions of view (rad): a spring alone, a train.
SPRING_VIEW, TRAIN_VIEW = (0.45, 0.3), (0.32, 0.2)
#: Pieces of wire per turn, points of a ring and of an outline, slices of a plate.
PER_TURN, RING, OUTLINE, SLICES = 32, 28, 180, 7
#: Direction to the light in the picture: from the left, above and before it.
LIGHT = np.array([-0.35, 0.66, 0.66])
DISC = 2.5e-3
Colour = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Flat:
    """A polygon (n, 2) in the picture (m), x to the right, y up; ``depth`` towards the eye."""

    points: Array
    colour: Colour
    depth: float


def flat_shapes(variant: Variant, frame: int, key: str = "", strips: int = 5) -> list[Flat]:
    """What is seen of one frame, far shapes first.

    Parameters
    ----------
    variant : the run
    frame : place of the frame
    key : colouring of the wire; the first by default
    strips : strips across the wire that are lit on their own

    Returns
    -------
    Polygons in m, the plane's origin at (0, 0)
    """
    view = TRAIN_VIEW if variant.bodies else SPRING_VIEW
    found: list[Flat] = []
    for body in variant.bodies:
        found += _body(body, frame, view)
    for spring in variant.springs:
        found += _wire(spring, frame, key, view, strips)
        if not variant.bodies:
            found += _discs(spring, frame, view)
    return sorted(found, key=lambda one: one.depth)


def colouring_of(variant: Variant, key: str = "") -> Colouring | None:
    """The colouring called ``key``, or the first there is."""
    every = [one for spring in variant.springs for one in spring.colourings]
    return next((one for one in every if one.key == key), None) if key else (every[0] if every else None)


def shades(colouring: Colouring, values: Array) -> Array:
    """Colours (..., 3), 0 to 255, of values in the unit of a colouring."""
    stops = np.array([[int(text[place : place + 2], 16) for place in (1, 3, 5)] for text in colouring.stops], dtype=float)
    share = np.clip((values - colouring.low) / (colouring.high - colouring.low), 0.0, 1.0) * (len(stops) - 1)
    return np.stack([np.interp(share, np.arange(len(stops)), stops[:, part]) for part in range(3)], axis=-1)


def turned(points: Array, view: tuple[float, float]) -> Array:
    """Points (n, 3) of the plane and its depth as the picture's x, y and distance towards the eye."""
    x, y, z = points.T
    azimuth, elevation = view
    across, near = x * np.cos(azimuth) - z * np.sin(azimuth), x * np.sin(azimuth) + z * np.cos(azimuth)
    return np.column_stack([across, y * np.cos(elevation) - near * np.sin(elevation), y * np.sin(elevation) + near * np.cos(elevation)])


def helix(spring: SpringDrawing, frame: int, coil: Array) -> Array:
    """Axis (n, 3) of the wire in the space of the train at coil numbers (n,), in m."""
    # Ground ends reach beyond seat and retainer; what is left of them lies between the planes.
    room = 0.5 * np.interp(coil, spring.coil, spring.wire_radius)
    height = np.clip(np.interp(coil, spring.coil, spring.height[frame]), room, spring.retainer[frame] - room)
    radius, turn = np.interp(coil, spring.coil, spring.radius), 2 * np.pi * coil
    u, v = np.cos(spring.direction), np.sin(spring.direction)
    across = radius * np.cos(turn)
    return np.column_stack([
        spring.seat[0] + height * u + across * v, spring.seat[1] + height * v - across * u, -spring.sign * radius * np.sin(turn),
    ])  # fmt: skip


def _wire(spring: SpringDrawing, frame: int, key: str, view: tuple[float, float], strips: int) -> list[Flat]:
    """The wire as a ribbon of its own width, in strips across that are lit as a round bar is."""
    first, last = float(spring.coil[0]), float(spring.coil[-1])
    coil = np.linspace(first, last, max(3, int((last - first) * PER_TURN) + 1))
    seen = turned(helix(spring, frame, coil), view)
    along = np.gradient(seen[:, :2], axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-12)[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    colouring = next((one for one in spring.colourings if one.key == key), spring.colourings[0] if spring.colourings else None)
    middle = (coil[1:] + coil[:-1]) / 2
    base = (
        np.full((len(middle), 3), 150.0)
        if colouring is None
        else shades(colouring, np.interp(middle, spring.coil, colouring.values[frame]))
    )
    half = np.interp(coil, spring.coil, spring.wire_radius)[:, None]
    depth = (seen[1:, 2] + seen[:-1, 2]) / 2
    edges, found = np.linspace(-1.0, 1.0, strips + 1), []
    for low, high in pairwise(edges):
        side = (low + high) / 2
        light = side * (across[:-1] @ LIGHT[:2]) + np.sqrt(1 - side**2) * LIGHT[2]
        tones = np.clip(base * (0.42 + 0.68 * np.clip(light, 0.0, 1.0))[:, None], 0, 255).round().astype(int).tolist()
        lower, upper = (seen[:, :2] + edge * half * across for edge in (low - 0.04, high + 0.04))
        quads = np.stack([lower[:-1], lower[1:], upper[1:], upper[:-1]], axis=1)
        found += [Flat(quads[k], (tone[0], tone[1], tone[2]), float(depth[k])) for k, tone in enumerate(tones)]
    return found


def _discs(spring: SpringDrawing, frame: int, view: tuple[float, float]) -> list[Flat]:
    pose = np.array([[spring.seat[0], spring.seat[1], spring.direction - np.pi / 2]])
    sizes = [1.12 * float(spring.radius[end] + spring.wire_radius[end]) for end in (0, -1)]
    top = float(spring.retainer[frame])
    profiles = [np.array([[size, low], [size, low + DISC]]) for size, low in ((sizes[0], -DISC), (sizes[1], top))]
    found = [_body(Body("disc", "seat", (Shape("lathe", profile),), pose), 0, view) for profile in profiles]
    # Below all else and above all else: the wire stands between them.
    return [Flat(one.points, one.colour, side * 1e3 + one.depth) for side, many in zip((-1, 1), found, strict=True) for one in many]


def _body(body: Body, frame: int, view: tuple[float, float]) -> list[Flat]:
    x, y, turn = body.pose[min(frame, len(body.pose) - 1)]
    tone = np.array([int(TONES[body.tone][place : place + 2], 16) for place in (1, 3, 5)], dtype=float)
    c, s = np.cos(turn), np.sin(turn)
    found: list[Flat] = []
    for shape in body.shapes:
        if shape.kind == "extrude":
            for part, z in enumerate(np.linspace(*shape.depth, SLICES)):
                u, v = shape.points[:: max(1, len(shape.points) // OUTLINE)].T
                seen = turned(np.column_stack([x + c * u - s * v, y + s * u + c * v, np.full(len(u), z)]), view)
                shade = tone * (1.0 if part == SLICES - 1 else 0.72)
                found.append(Flat(seen[:, :2], _rgb(shade), float(seen[:, 2].mean())))
            continue
        rings = [_ring(radius, height, x, y, c, s, view) for radius, height in shape.points]
        # The lit end is the widest ring among those nearest to the eye.
        end = max(range(len(rings)), key=lambda part: (round(float(rings[part][:, 2].mean()), 9), shape.points[part, 0]))
        found.append(Flat(_hull(rings[end][:, :2]), _rgb(1.12 * tone), float(rings[end][:, 2].mean()) + 1e-6))
        for part in range(len(rings) - 1):
            points = np.concatenate([rings[part], rings[part + 1]])
            shade = tone * (0.8 + 0.2 * (part % 2))
            found.append(Flat(_hull(points[:, :2]), _rgb(shade), float(points[:, 2].mean())))
    return found


def _ring(radius: float, height: float, x: float, y: float, c: float, s: float, view: tuple[float, float]) -> Array:
    turn = np.arange(RING) * 2 * np.pi / RING
    u = radius * np.cos(turn)
    return turned(np.column_stack([x + c * u - s * height, y + s * u + c * height, radius * np.sin(turn)]), view)


def _hull(points: Array) -> Array:
    """Convex hull (n, 2) by Andrew's chain."""
    order: Places = np.lexsort((points[:, 1], points[:, 0]))
    ordered = points[order].tolist()

    def half(run: list[list[float]]) -> list[list[float]]:
        kept: list[list[float]] = []
        for p in run:
            while len(kept) > 1 and _cross(kept[-2], kept[-1], p) <= 0:
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array(half(ordered) + half(ordered[::-1]) or ordered[:1])


def _cross(a: list[float], b: list[float], p: list[float]) -> float:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def _rgb(values: Array) -> Colour:
    red, green, blue = (round(float(value)) for value in np.clip(values, 0, 255))
    return red, green, blue
