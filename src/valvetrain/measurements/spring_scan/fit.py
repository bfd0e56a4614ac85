"""A spring fitted to the points of a scan: axis, wire, section, ends."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.spring_scan.ends import BEYOND, Face, find_face, find_tip, flats_of, supported
from valvetrain.measurements.spring_scan.frame import Frame, find_axis
from valvetrain.measurements.spring_scan.sections import WEDGES, find_sections
from valvetrain.measurements.spring_scan.trace import FEWEST_TURNS, follow
from valvetrain.measurements.spring_scan.tube import OnWire, Tube, fit_tube, place, start_tube

Array = NDArray[np.float64]
#: Spline pieces a turn.
PER_TURN = 12
#: Points that the wire is looked for in; all are fitted in the end.
EARLY = 20_000
#: Points by which a first tube is judged, and distance from it (share of the coil radius) at which it explains one.
TOLD, CLOSE = 4000, 0.024
#: Ellipticity, in standard deviations and as a share, from which a section is no longer taken as round.
OVATE, LEAST_OVATE = 5.0, 2.5e-3
#: Share of the directions about the wire axis that must be seen before a section is taken for anything but round.
ALL_AROUND = 0.75


@dataclass(frozen=True, eq=False)
class FittedSpring:
    """Frame, tube and ends in the unit of the points; ``tips``: turns of the wire's ends, with standard deviations ``tip_spread``."""

    frame: Frame
    tube: Tube
    tips: tuple[float, float]
    tip_spread: tuple[float, float]
    faces: tuple[Face | None, Face | None]
    ovate: bool
    on: OnWire
    weight: Array
    points: Array


def fit_spring(points: Array, wedges: int = WEDGES, per_turn: int = PER_TURN) -> FittedSpring:
    """The spring in points (n, 3) of any order of draw, in mm; ``wedges`` half planes and ``per_turn`` pieces of the splines.

    Raises :class:`InputError` where the points show no spring.
    """
    frame = find_axis(points)
    inside = frame.inside(points[:EARLY])
    tube, ends = _first_tube(inside, wedges, per_turn)
    reach = ends[0] - BEYOND, ends[1] + BEYOND
    tube, _, _ = fit_tube(tube, inside, ends, False, rounds=8)
    ends = supported(tube, inside, ends)
    for _ in range(3):
        frame, tube = _on_better_axis(frame, tube, ends)
        inside = frame.inside(points[:EARLY])
        tube, _, _ = fit_tube(tube, inside, ends, False, rounds=5)
    inside = frame.inside(points)
    faces: dict[int, Face | None] = {}
    tips, spreads = ends, (0.0, 0.0)
    for _ in range(2):
        faces = {side: find_face(tube, inside, tips[(side + 1) // 2], side, reach) for side in (-1, 1)}
        flats = partial(flats_of, faces, tube.noise)
        tube, _, _ = fit_tube(tube, inside, (max(tips[0] - 0.1, reach[0]), min(tips[1] + 0.1, reach[1])), False, flats, rounds=8)
        found = [find_tip(tube, inside, ends[(side + 1) // 2], reach, faces[side], side) for side in (-1, 1)]
        tips = found[0][0], found[1][0]
        spreads = found[0][1], found[1][1]
    for _ in range(2):
        frame, tube = _on_better_axis(frame, tube, tips)
        inside = frame.inside(points)
        faces = {side: find_face(tube, inside, tips[(side + 1) // 2], side, reach) for side in (-1, 1)}
        tube, on, weight = fit_tube(tube, inside, tips, False, partial(flats_of, faces, tube.noise), rounds=12)
    ovate, other = _section(tube, on, weight, inside, tips, faces)
    if ovate:
        tube, on, weight = other
    if tips[1] - tips[0] < FEWEST_TURNS:
        raise InputError(f"the wire is seen over {tips[1] - tips[0]:.2g} turns only; give a scan that shows it all the way around")
    return FittedSpring(frame, tube, tips, spreads, (faces[-1], faces[1]), ovate, on, weight, inside)


def _first_tube(points: Array, wedges: int, per_turn: int) -> tuple[Tube, tuple[float, float]]:
    """A tube through sections of the wire, and their first and last turn: of the radii that votes propose, that which explains most points.

    Raises :class:`InputError` where none gives a wire.
    """
    some, best, fault = points[:TOLD], None, InputError("the points show no wire wound about an axis; give the scan of one spring, cleaned")
    for sections in find_sections(points, wedges):
        try:
            trace = follow(sections, wedges)
        except InputError as error:
            fault = error
            continue
        ends = float(trace.turn[0]), float(trace.turn[-1])
        reach = ends[0] - BEYOND, ends[1] + BEYOND
        tube = start_tube(trace.turn, trace.radius, trace.height, trace.hand, trace.wire_radius, reach, per_turn)
        near = CLOSE * float(np.median(trace.radius))
        share = float(np.mean(np.abs(place(tube, some, ends).left) < near))
        if best is None or share > best[0]:
            best = share, tube, ends
    if best is None:
        raise fault
    return best[1], best[2]


def _section(
    tube: Tube, on: OnWire, weight: Array, points: Array, tips: tuple[float, float], faces: dict[int, Face | None]
) -> tuple[bool, tuple[Tube, OnWire, Array]]:
    """Whether an ellipse fits better than a circle by more than chance, and the tube with it."""
    if seen_around(on, weight) < ALL_AROUND:
        return False, (tube, on, weight)
    found = fit_tube(tube, points, tips, True, partial(flats_of, faces, tube.noise), rounds=12)
    along, across = found[0].section[1:]
    spread = np.sqrt(np.diag(found[0].cov)[-2:])
    size = float(np.hypot(along, across))
    return bool(size > OVATE * float(np.hypot(*spread)) and size > LEAST_OVATE), found


def seen_around(on: OnWire, weight: Array) -> float:
    """Share of the directions about the wire axis in which there are points of the surface."""
    counts = np.histogram(on.around[weight > 0], np.linspace(-np.pi, np.pi, 25))[0]
    return float(np.mean(counts > 0.1 * np.max(counts)))


def _on_better_axis(frame: Frame, tube: Tube, ends: tuple[float, float]) -> tuple[Frame, Tube]:
    """The axis about which radius and height swing least once a turn, and the tube about it."""
    turn = np.linspace(*ends, int(60 * (ends[1] - ends[0])))
    (radius, _), (growth, _), (bend, rise) = (tube.line(turn, order) for order in range(3))
    angle, full = 2 * np.pi * tube.hand * turn, 2 * np.pi * tube.hand
    waves = np.column_stack([np.cos(angle), np.sin(angle)])
    slopes = full * np.column_stack([-waves[:, 1], waves[:, 0]])
    across = _swing(-(full**2) * waves, bend)
    tilt = _swing(bend[:, None] * waves + 2 * growth[:, None] * slopes - full**2 * radius[:, None] * waves, rise)
    # height swings by tilt . (x, y): the axis leans by minus that
    moved = frame.moved(across, -tilt)
    wide = np.linspace(tube.knots[3], tube.knots[-4], int(60 * (tube.knots[-4] - tube.knots[3])))
    radius, height = tube.line(wide)
    angle = 2 * np.pi * tube.hand * wide
    line = moved.inside(frame.outside(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])))
    own = tube.hand * np.arctan2(line[:, 1], line[:, 0]) / (2 * np.pi)
    unwound = wide + np.mod(own - wide + 0.5, 1.0) - 0.5
    per_turn = round(1 / (tube.knots[4] - tube.knots[3]))
    again = start_tube(unwound, np.hypot(line[:, 0], line[:, 1]), line[:, 2], tube.hand, 1.0, (tube.knots[3], tube.knots[-4]), per_turn)
    return moved, replace(tube, radius=again.radius, height=again.height)


def _swing(waves: Array, bends: Array) -> Array:
    """Coefficients (2,) of ``waves`` in the second derivatives ``bends``; ramps of pitch and kinks of the diameter are left out."""
    basis = np.column_stack([np.ones(len(bends)), waves])
    weight = np.ones(len(bends))
    for _ in range(20):
        root = np.sqrt(weight)[:, None]
        found = np.linalg.lstsq(basis * root, bends * root[:, 0], rcond=1e-10)[0]
        left = np.abs(bends - basis @ found)
        scale = 1.4826 * float(np.median(left)) + 1e-9
        weight = 1 / (1 + (left / (1.5 * scale)) ** 2)
    swing: Array = found[1:]
    return swing
