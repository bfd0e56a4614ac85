"""A moving picture as data for the page, and one frame of it as flat shapes in drawing order, for still
pictures.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.parameters.summary import rpm
from valvetrain.units.reader import reader_factor, reader_text, reader_unit
from valvetrain.views.motion.parts import (
    Body,
    Colouring,
    Moving,
    Places,
    Shape,
    SpringDrawing,
    Variant,
    still_frame,
)
from valvetrain.views.style import thinned

MM = 1e3
#: Colour of each part, readable on light and on dark paper.
TONES = {
    "cam": "#7d8aa0", "follower": "#a58b62", "lever": "#9a7f9f", "pivot": "#5f6672", "pushrod": "#a58b62", "valve": "#8a9a8e",
    "retainer": "#9aa6a0", "seat": "#7b7f86",
}  # fmt: skip


def motion_data(moving: Moving) -> dict[str, Any]:
    """The picture as plain values: what ``mount(element, data)`` of motion.js takes."""
    return {
        "version": 1,
        "title": moving.title,
        "notes": list(moving.notes),
        "variants": [_variant(one) for one in moving.variants],
    }


def _variant(one: Variant) -> dict[str, Any]:
    forces = []
    for series in one.forces:
        x, y = thinned(np.degrees(series.cam_angle), series.values * reader_factor("N"))
        curve = {"angle": single(x), "values": single(y)}
        forces.append({"words": series.label, "colour": series.colour, **curve})
    return {
        "label": one.label,
        "words": one.title,
        "rpm": rpm(one.engine_speed),
        "closed": one.closed,
        "notes": [reader_text(note) for note in one.notes],
        "units": {"lift": reader_unit("mm"), "force": reader_unit("N")},
        "start": round(float(np.degrees(one.cam_angle[still_frame(one)])), 4),
        "angle": single(np.degrees(one.cam_angle)),
        "lift": single(MM * reader_factor("mm") * one.valve_lift),  # which is printed alone
        "springs": [_spring(spring) for spring in one.springs],
        "bodies": [_body(body) for body in one.bodies],
        "forces": forces,
        "marks": [
            {
                "angle": round(float(np.degrees(mark.cam_angle)), 3),
                "kind": mark.kind,
                "words": reader_text(mark.label),
            }
            for mark in one.marks
        ],
    }


def _spring(spring: SpringDrawing) -> dict[str, Any]:
    scale = max(float(np.abs(spring.displacement).max(initial=0.0)) * MM / 32767, 1e-9)
    move = np.round(spring.displacement * MM / scale).astype("<i2")
    return {
        "name": spring.name,
        "coil": single(spring.coil),
        "radius": single(MM * spring.radius),
        "wire": single(MM * spring.wire_radius),
        "sign": spring.sign,
        "rest": single(MM * spring.rest),
        "move": {"d": _text(move), "scale": scale},
        "retainer": single(MM * spring.retainer),
        "seat": [MM * value for value in spring.seat],
        "direction": spring.direction,
        "colours": [_colouring(one) for one in spring.colourings],
    }


def _colouring(one: Colouring) -> dict[str, Any]:
    values = one.values if one.around is None else one.around
    share = np.clip((values - one.low) / (one.high - one.low), 0.0, 1.0)
    factor, unit = reader_factor(one.unit), reader_unit(one.unit)
    return {
        "key": one.key,
        "words": reader_text(one.label),
        "unit": unit,
        "low": one.low * factor,
        "high": one.high * factor,
        "stops": list(one.stops),
        "fibres": 1 if one.around is None else one.around.shape[2],
        "d": _text(np.round(share * 255).astype("u1")),
    }


def _body(body: Body) -> dict[str, Any]:
    pose = body.pose * (MM, MM, 1.0)
    fixed = bool(np.all(pose == pose[0]))
    shapes = [
        {
            "kind": one.kind,
            "points": single(MM * one.points),
            "depth": [MM * value for value in one.depth],
        }
        for one in body.shapes
    ]
    return {
        "name": body.name,
        "colour": TONES[body.tone],
        "shapes": shapes,
        "fixed": fixed,
        "pose": single(pose[:1] if fixed else pose),
    }


def single(values: ArrayLike) -> str:
    """Values in single precision as base64."""
    return _text(np.asarray(values, dtype="<f4"))


def _text(values: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


#: Directions of view (rad): a spring alone, a train.
SPRING_VIEW, TRAIN_VIEW = (0.45, 0.3), (0.32, 0.2)
#: Pieces of wire per turn and strips across it, points of a ring and of an outline, slices of a plate.
PER_TURN, STRIPS, RING, OUTLINE, SLICES = 32, 3, 28, 180, 7
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


def flat_shapes(variant: Variant, frame: int) -> list[Flat]:
    """Visible shapes of one frame, far ones first.

    Parameters
    ----------
    variant : the run
    frame : place of the frame

    Returns
    -------
    Polygons in m, the plane's origin at (0, 0)
    """
    view = TRAIN_VIEW if variant.bodies else SPRING_VIEW
    found: list[Flat] = []
    for body in variant.bodies:
        found += _body_project(body, frame, view)
    for spring in variant.springs:
        found += _wire(spring, frame, view)
        if not variant.bodies:
            found += _discs(spring, frame, view)
    return sorted(found, key=lambda one: one.depth)


def _shades(colouring: Colouring, values: Array) -> Array:
    """Colours (..., 3), 0 to 255, of values in the unit of a colouring."""
    stops = np.array(
        [[int(text[place : place + 2], 16) for place in (1, 3, 5)] for text in colouring.stops],
        dtype=float,
    )
    share = np.clip((values - colouring.low) / (colouring.high - colouring.low), 0.0, 1.0) * (
        len(stops) - 1
    )
    return np.stack(
        [np.interp(share, np.arange(len(stops)), stops[:, part]) for part in range(3)], axis=-1
    )


def turned(points: Array, view: tuple[float, float]) -> Array:
    """Points (n, 3) of the plane and its depth as the picture's x, y and distance towards the eye."""
    x, y, z = points.T
    azimuth, elevation = view
    across, near = (
        x * np.cos(azimuth) - z * np.sin(azimuth),
        x * np.sin(azimuth) + z * np.cos(azimuth),
    )
    return np.column_stack(
        [
            across,
            y * np.cos(elevation) - near * np.sin(elevation),
            y * np.sin(elevation) + near * np.cos(elevation),
        ]
    )


def helix(spring: SpringDrawing, frame: int, coil: Array) -> Array:
    """Axis (n, 3) of the wire in the space of the train at coil numbers (n,), in m."""
    # Ground ends reach beyond seat and retainer; the remainder is between the planes.
    room = 0.5 * np.interp(coil, spring.coil, spring.wire_radius)
    height = np.clip(
        np.interp(coil, spring.coil, spring.height[frame]), room, spring.retainer[frame] - room
    )
    radius, turn = np.interp(coil, spring.coil, spring.radius), 2 * np.pi * coil
    u, v = np.cos(spring.direction), np.sin(spring.direction)
    across = radius * np.cos(turn)
    return np.column_stack(
        [
            spring.seat[0] + height * u + across * v,
            spring.seat[1] + height * v - across * u,
            -spring.sign * radius * np.sin(turn),
        ]
    )


def _wire(spring: SpringDrawing, frame: int, view: tuple[float, float]) -> list[Flat]:
    """The wire, in its first colouring, as a ribbon of its own width, in strips across that are lit
    as a round bar is.
    """
    first, last = float(spring.coil[0]), float(spring.coil[-1])
    coil = np.linspace(first, last, max(3, int((last - first) * PER_TURN) + 1))
    seen = turned(helix(spring, frame, coil), view)
    along = np.gradient(seen[:, :2], axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-12)[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    colouring = spring.colourings[0] if spring.colourings else None
    middle = (coil[1:] + coil[:-1]) / 2
    base = (
        np.full((len(middle), 3), 150.0)
        if colouring is None
        else _shades(colouring, np.interp(middle, spring.coil, colouring.values[frame]))
    )
    half = np.interp(coil, spring.coil, spring.wire_radius)[:, None]
    depth = (seen[1:, 2] + seen[:-1, 2]) / 2
    edges, found = np.linspace(-1.0, 1.0, STRIPS + 1), []
    for low, high in pairwise(edges):
        side = (low + high) / 2
        light = side * (across[:-1] @ LIGHT[:2]) + np.sqrt(1 - side**2) * LIGHT[2]
        tones = (
            np.clip(base * (0.42 + 0.68 * np.clip(light, 0.0, 1.0))[:, None], 0, 255)
            .round()
            .astype(int)
            .tolist()
        )
        lower, upper = (seen[:, :2] + edge * half * across for edge in (low - 0.04, high + 0.04))
        quads = np.stack([lower[:-1], lower[1:], upper[1:], upper[:-1]], axis=1)
        found += [
            Flat(quads[k], (tone[0], tone[1], tone[2]), float(depth[k]))
            for k, tone in enumerate(tones)
        ]
    return found


def _discs(spring: SpringDrawing, frame: int, view: tuple[float, float]) -> list[Flat]:
    pose = np.array([[spring.seat[0], spring.seat[1], spring.direction - np.pi / 2]])
    sizes = [1.12 * float(spring.radius[end] + spring.wire_radius[end]) for end in (0, -1)]
    top = float(spring.retainer[frame])
    profiles = [
        np.array([[size, low], [size, low + DISC]])
        for size, low in ((sizes[0], -DISC), (sizes[1], top))
    ]
    found = [
        _body_project(Body("disc", "seat", (Shape("lathe", profile),), pose), 0, view)
        for profile in profiles
    ]
    # Below all else and above all else: the wire is drawn between them.
    return [
        Flat(one.points, one.colour, side * 1e3 + one.depth)
        for side, many in zip((-1, 1), found, strict=True)
        for one in many
    ]


def _body_project(body: Body, frame: int, view: tuple[float, float]) -> list[Flat]:
    x, y, turn = body.pose[min(frame, len(body.pose) - 1)]
    tone = np.array(
        [int(TONES[body.tone][place : place + 2], 16) for place in (1, 3, 5)], dtype=float
    )
    c, s = np.cos(turn), np.sin(turn)
    found: list[Flat] = []
    for shape in body.shapes:
        if shape.kind == "extrude":
            for part, z in enumerate(np.linspace(*shape.depth, SLICES)):
                u, v = shape.points[:: max(1, len(shape.points) // OUTLINE)].T
                seen = turned(
                    np.column_stack([x + c * u - s * v, y + s * u + c * v, np.full(len(u), z)]),
                    view,
                )
                shade = tone * (1.0 if part == SLICES - 1 else 0.72)
                found.append(Flat(seen[:, :2], _rgb(shade), float(seen[:, 2].mean())))
            continue
        rings = [_ring(radius, height, x, y, c, s, view) for radius, height in shape.points]
        # The lit end is the widest ring among those nearest to the eye.
        end = max(
            range(len(rings)),
            key=lambda part: (round(float(rings[part][:, 2].mean()), 9), shape.points[part, 0]),
        )
        found.append(
            Flat(_hull(rings[end][:, :2]), _rgb(1.12 * tone), float(rings[end][:, 2].mean()) + 1e-6)
        )
        for part in range(len(rings) - 1):
            points = np.concatenate([rings[part], rings[part + 1]])
            shade = tone * (0.8 + 0.2 * (part % 2))
            found.append(Flat(_hull(points[:, :2]), _rgb(shade), float(points[:, 2].mean())))
    return found


def _ring(
    radius: float, height: float, x: float, y: float, c: float, s: float, view: tuple[float, float]
) -> Array:
    turn = np.arange(RING) * 2 * np.pi / RING
    u = radius * np.cos(turn)
    return turned(
        np.column_stack([x + c * u - s * height, y + s * u + c * height, radius * np.sin(turn)]),
        view,
    )


def _hull(points: Array) -> Array:
    """Convex hull (n, 2) by Andrew's chain."""
    order: Places = np.lexsort((points[:, 1], points[:, 0]))
    ordered = points[order].tolist()

    def half(run: list[list[float]]) -> list[list[float]]:
        hull: list[list[float]] = []
        for p in run:
            while len(hull) > 1 and _cross(hull[-2], hull[-1], p) <= 0:
                hull.pop()
            hull.append(p)
        return hull[:-1]

    return np.array(half(ordered) + half(ordered[::-1]) or ordered[:1])


def _cross(a: list[float], b: list[float], p: list[float]) -> float:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def _rgb(values: Array) -> Colour:
    red, green, blue = (round(float(value)) for value in np.clip(values, 0, 255))
    return red, green, blue


#: Margin (m) around a still picture.
MARGIN = 1e-3
