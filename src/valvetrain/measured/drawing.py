"""The outline of a cam in a drawing (DXF), as radius over polar angle about the cam's centre."""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.lift_formats import LiftColumns, LiftFormat
from valvetrain.measured.workbooks import EXTRA

#: Even polar angles at which the radius of an outline is read.
STATIONS = 3600
#: More parts than this are no drawing of one cam.
MAX_PARTS = 20_000
#: Largest distance of a chord from its arc, and largest gap between two parts, as shares of the drawing's size.
SAGITTA, GAP = 1e-7, 1e-5
#: A loop of so few straight lines is a frame or a keyway, and no cam.
STRAIGHT = 12
#: Number of a drawing's unit of length -> its name; other drawings do not say theirs.
UNITS = {1: "inch", 4: "mm", 5: "cm", 6: "m", 9: "thou", 13: "um"}


def recognise_drawing(content: bytes, name: str) -> bool:
    """Whether the content begins as a drawing does, after any comments."""
    begin = rb"\s*(999\r?\n[^\n]*\n\s*)*0\r?\n\s*SECTION\b|AutoCAD Binary DXF"
    return re.match(begin, content) is not None


def read_drawing(content: bytes, name: str) -> LiftColumns:
    """Polar angles and radii of the cam's outline; ``y`` of the drawing points to polar angle 90 degrees.

    The outline is the largest closed loop that holds a curve. A circle inside it, the bore, marks the centre of the cam;
    without one the centre is the origin of the drawing. Raises :class:`InputError` where there is no such outline, where it
    doubles back as seen from its centre, and where the extra is missing.
    """
    parts, unit = _parts(content, name)
    loops, circles = _loops(parts, name)
    if loops:
        outline = max(loops, key=_area)
        bores = [
            centre
            for centre, edge in circles
            if _inside(centre, outline) and _area(edge) < _area(outline)
        ]
        if len({(round(x, 6), round(y, 6)) for x, y in bores}) > 1:
            raise InputError(
                f"'{name[:80]}' has circles about {len(bores)} centres inside the cam, so its own centre is unclear; keep the bore alone"
            )
    elif circles:
        outline, bores = max((edge for _, edge in circles), key=_area), []
    else:
        raise InputError(
            f"'{name[:80]}' holds no closed outline of a cam; join its lines and arcs at their ends, in one drawing of its own"
        )
    centre = bores[0] if bores else np.zeros(2)
    if not _inside(centre, outline):
        raise InputError(
            f"the origin of '{name[:80]}' lies outside the cam; move the cam's centre there, or draw its bore as a circle"
        )
    angles, radii = _polar(outline - centre, name)
    place = "the bore" if bores else "the origin of the drawing"
    return LiftColumns(
        "drawing",
        np.column_stack([np.degrees(angles), radii]),
        ("angle", "radius"),
        ("deg", unit),
        changes=(f"the centre of the cam is that of {place}",),
    )


def _parts(content: bytes, name: str) -> tuple[list[Any], str]:
    """Lines, arcs, circles, ellipses and splines of a drawing with its blocks, and its unit."""
    try:
        from ezdxf import disassemble, recover
        from ezdxf.audit import AuditError
    except ImportError as error:
        raise InputError(f"'{name[:80]}' is a drawing, which needs ezdxf; {EXTRA}") from error
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())  # said here, in one sentence
    try:
        document, audit = recover.read(io.BytesIO(content))
        stream = disassemble.recursive_decompose(document.modelspace())
        parts = list(islice(_simple(stream), MAX_PARTS + 1))
    except Exception as error:  # the library raises what it meets in a damaged drawing
        raise InputError(
            f"'{name[:80]}' is no drawing that can be read; save it again as DXF of any year"
        ) from error
    for mended in (*audit.fixes, *audit.errors):
        if mended.code == AuditError.INVALID_FLOATING_POINT_VALUE:
            line = mended.message.partition(" near ")[2].partition(" as ")[0]
            raise InputError(
                f"'{name[:80]}' has a number that cannot be read near {line}; save it again as DXF of any year"
            )
    if len(parts) > MAX_PARTS:
        raise InputError(
            f"'{name[:80]}' has more than {MAX_PARTS} parts; keep the cam's outline alone"
        )
    kinds = ("LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
    return [part for part in parts if part.dxftype() in kinds], UNITS.get(document.units, "")


def _simple(parts: Iterable[Any]) -> Iterator[Any]:
    """Parts of a drawing, a polyline taken apart into its lines and arcs."""
    for part in parts:
        if part.dxftype() in ("LWPOLYLINE", "POLYLINE"):
            yield from part.virtual_entities()
        else:
            yield part


def _loops(parts: list[Any], name: str) -> tuple[list[Array], list[tuple[Array, Array]]]:
    """Closed loops with a curve, as points (points, 2), and circles as their centre and points."""
    from ezdxf import edgeminer

    ends = np.array(
        [list(part.dxf.start)[:2] for part in parts if part.dxftype() == "LINE"] + [[0.0, 0.0]]
    )
    reach = [
        np.ptp(ends, axis=0).max(),
        *(part.dxf.radius for part in parts if part.dxf.hasattr("radius")),
    ]
    size = float(max(reach)) or 1.0
    circles, curves = [], []
    for part in parts:
        points = _points(part, SAGITTA * size)
        if len(points) < 2 or not np.all(np.isfinite(points)):
            continue
        if part.dxftype() == "CIRCLE":
            circles.append((points[:-1].mean(axis=0), points))
        else:
            curves.append(points)
    loops: list[Array] = []
    edges: list[edgeminer.Edge] = []
    for points in curves:
        if len(points) > 2 and np.hypot(*(points[0] - points[-1])) < GAP * size:
            loops.append(points)
        else:
            edges.append(edgeminer.make_edge(points[0], points[-1], payload=points))
    if not edges:
        return loops, circles
    deposit = edgeminer.Deposit(edges, gap_tol=GAP * size)
    try:
        for chain in edgeminer.find_all_loops(deposit, timeout=5):
            if len(chain) > STRAIGHT or any(len(edge.payload) > 2 for edge in chain):
                loops.append(
                    np.concatenate(
                        [edge.payload[:: -1 if edge.is_reverse else 1] for edge in chain]
                    )
                )
    except edgeminer.TimeoutError as error:  # the library's own, no OSError
        raise InputError(
            f"the lines of '{name[:80]}' cross in too many ways; keep the cam's outline alone"
        ) from error
    return loops, circles


def _points(part: Any, sagitta: float) -> Array:
    """Points along a part, at most ``sagitta`` beside it."""
    if part.dxftype() == "LINE":
        along = [part.dxf.start, part.dxf.end]
    else:
        along = list(part.flattening(sagitta))
    return np.array([list(point)[:2] for point in along], dtype=float)


def _area(points: Array) -> float:
    """Area that a closed line of ``points`` encloses."""
    x, y = points.T
    return abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))) / 2


def _inside(place: Array, points: Array) -> bool:
    """Whether a ``place`` lies within a closed line of ``points``."""
    from ezdxf.math import Vec2, is_point_in_polygon_2d

    return bool(is_point_in_polygon_2d(Vec2(place), Vec2.list(points)) > 0)


def _polar(points: Array, name: str) -> tuple[Array, Array]:
    """Radii of a closed line about the origin at even polar angles (rad)."""
    angles = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    if angles[-1] < angles[0]:
        points, angles = points[::-1], angles[::-1]
    moved = np.append(True, np.diff(angles) > 1e-12)
    if np.any(np.diff(angles) < -1e-6):
        raise InputError(
            f"the outline in '{name[:80]}' doubles back as seen from the cam's centre; keep the lobe alone, without keyway or journal"
        )
    points, angles = points[moved], angles[moved]
    first = angles < angles[0] + 2 * np.pi - 1e-9
    points, angles = points[first], angles[first]
    points = np.vstack([points, points[:1]])
    angles = np.append(angles, angles[0] + 2 * np.pi)
    even = 2 * np.pi * np.arange(STATIONS) / STATIONS
    place = angles[0] + np.mod(even - angles[0], 2 * np.pi)
    at = np.clip(np.searchsorted(angles, place, side="right") - 1, 0, len(points) - 2)
    start, along = points[at], points[at + 1] - points[at]
    crossed = start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]
    ahead = np.cos(even) * along[:, 1] - np.sin(even) * along[:, 0]
    return even, crossed / ahead


DRAWING_SPEC = LiftFormat("drawing of a cam (DXF)", recognise_drawing, read_drawing)
