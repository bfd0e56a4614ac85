"""A spring fitted to the points of a scan: axis, wire, section, ends."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.scan.axis import MIN_TURNS, WEDGES, Frame, find_axis, find_sections, follow
from valvetrain.scan.tube import OnWire, Tube, fit_tube, place, start_tube

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
#: Turns beyond the sections in which a tip is looked for, and turns of a bin there.
BEYOND, BIN = 0.5, 0.01
#: Points inside the wire are this many standard deviations and at least this share of its radius
#: below the surface; fewest on a face,
#: and share of those inside the wire that are on it.
DEEP, SHALLOW, FEWEST, MOSTLY = 4.0, 0.9, 25, 0.5
#: Standard deviations within which a point belongs to a plane or to the wire.
WITHIN = 3.5
#: A tip is where fewer points a bin are left than this share of those before it.
LEFT_OVER = 0.15
#: Turns without points that a hole may take.
GAP = 0.3
#: Largest lean of a ground face against the axis (rad), the typical one, and turns over which faces
#: are looked for.
STEEPEST, TYPICAL_LEAN, FACED = 0.06, 0.005, 1.3


@dataclass(frozen=True, eq=False)
class Face:
    """A ground face ``height + lean . (x, y)`` in the frame of the axis; ``points`` on it."""

    height: float
    lean: Array
    points: int
    spread: float

    def above(self, points: Array, side: int) -> Array:
        """How far points (n, 3) are inside the face of the end ``side`` (-1 lower, 1 upper)."""
        found: Array = -side * (points[:, 2] - self.height - points[:, :2] @ self.lean)
        return found


def find_face(
    tube: Tube, points: Array, tip: float, side: int, reach: tuple[float, float]
) -> Face | None:
    """The ground face of the end whose tip is about at turn ``tip``; None where there is none.

    Nothing but a ground face has points inside the wire, so those alone show it.
    """
    on = place(tube, points, (max(tip - FACED, reach[0]), min(tip + FACED, reach[1])))
    wire, noise = float(tube.section[0]), tube.noise
    within = on.distance < min(wire - DEEP * noise, SHALLOW * wire)
    chosen = points[within]
    if len(chosen) < FEWEST:
        return None
    band = max(2 * noise, 0.05 * wire)
    levels = np.sort(chosen[:, 2])
    counts = np.searchsorted(levels, levels + 2 * band) - np.arange(len(levels))
    first = Face(float(levels[int(np.argmax(counts))]) + band, np.zeros(2), 0, 0.0)
    face = _plane(chosen, first, 2 * band, noise)
    if face is None or face.points < MOSTLY * len(chosen):
        return None
    # points inside the wire are chosen by their own noise too; those amid the ground section are
    # not
    amid = points[
        (np.abs(face.above(points, side)) < 6 * noise) & _amid(tube, face, points, tip, side)
    ]
    return (_plane(amid, face, 2 * noise, noise) if len(amid) >= FEWEST else None) or face


def _plane(points: Array, face: Face, scale: float, noise: float) -> Face | None:
    """The plane through most of the points (n, 3), robustly, as square to the axis as they allow;
    None for too few or a steep one.
    """
    model = np.column_stack([np.ones(len(points)), points[:, :2]])
    values = np.array([face.height, *face.lean])
    for _ in range(15):
        left = points[:, 2] - model @ values
        weight = np.clip(1 - (left / (4.685 * scale)) ** 2, 0.0, None) ** 2
        if np.count_nonzero(weight) < FEWEST:
            return None
        matrix = (model * weight[:, None]).T @ model + np.diag(
            [0.0, (scale / TYPICAL_LEAN) ** 2, (scale / TYPICAL_LEAN) ** 2]
        )
        values = np.linalg.solve(matrix, (model * weight[:, None]).T @ points[:, 2])
        scale = max(0.7 * scale, noise)
    if float(np.hypot(*values[1:])) > STEEPEST:
        return None
    on = np.abs(left) < WITHIN * scale
    # the faces of a drawing have no scatter of their own
    scatter = max(float(np.std(left[on])), 0.1 * noise) if np.any(on) else noise
    spread = scatter * float(np.sqrt(np.linalg.inv(matrix)[0, 0]))
    return Face(float(values[0]), values[1:], int(np.count_nonzero(on)), spread)


def _amid(tube: Tube, face: Face, points: Array, tip: float, side: int) -> Mask:
    """Which points are above or below the middle of a ground section, away from its edges."""
    own = np.mod(tube.hand * np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi), 1.0)
    turn = tip - side * np.mod(-side * (own - tip), 1.0)  # within one turn from the tip inward
    radius, height = tube.line(turn)
    level = face.height + points[:, :2] @ face.lean
    half = np.sqrt(np.maximum(tube.section[0] ** 2 - (level - height) ** 2, 0.0))
    found: Mask = np.abs(np.hypot(points[:, 0], points[:, 1]) - radius) < 0.75 * half
    return found


def supported(tube: Tube, points: Array, ends: tuple[float, float]) -> tuple[float, float]:
    """The stretch of turns whose wire has points on its surface: what was followed beyond the tips
    is left out.
    """
    on = place(tube, points, ends)
    surface = (np.abs(on.left) < WITHIN * tube.noise) & (on.gap > 0.1 * tube.section[0])
    edges = np.arange(ends[0], ends[1] + BIN, 2 * BIN)
    counts = np.histogram(on.turn[surface], edges)[0]
    full = counts > max(2.0, 2 * LEFT_OVER * float(np.median(counts)))
    middle = len(full) // 2
    found = []
    for side, bins in ((-1, full[: middle + 1][::-1]), (1, full[middle:])):
        last, quiet = 0, 0
        for place_, held in enumerate(bins):
            last, quiet = (place_, 0) if held else (last, quiet + 1)
            if quiet > GAP / (2 * BIN):
                break
        found.append(
            float(
                edges[middle - last] if side < 0 else edges[min(middle + last + 1, len(edges) - 1)]
            )
        )
    return found[0], found[1]


def flats_of(faces: dict[int, Face | None], noise: float, points: Array) -> Mask:
    """Which points are on a ground face or beyond it."""
    found = np.zeros(len(points), dtype=bool)
    for side, face in faces.items():
        if face is not None:
            found |= face.above(points, side) < (WITHIN + 0.5) * noise
    return found


def find_tip(
    tube: Tube,
    points: Array,
    start: float,
    reach: tuple[float, float],
    face: Face | None,
    side: int,
) -> tuple[float, float]:
    """Turn of the tip on ``side`` and its standard deviation; ``start``: the outermost turn at
    which a section was found.
    """
    on = place(tube, points, reach)
    wire, noise = float(tube.section[0]), tube.noise
    inside = (
        np.ones(len(points), dtype=bool)
        if face is None
        else face.above(points, side) > WITHIN * noise
    )
    surface = (np.abs(on.left) < WITHIN * noise) & (on.gap > WITHIN * noise) & inside
    along = side * (on.turn[surface] - start)  # positive beyond the last section
    flat = np.zeros(0)
    if face is not None:
        lies = np.abs(face.above(points, side)) < min(WITHIN * noise, 0.1 * wire)
        own = np.mod(tube.hand * np.arctan2(points[lies, 1], points[lies, 0]) / (2 * np.pi), 1.0)
        turn = start + np.mod(own - start + 0.5, 1.0) - 0.5
        radius, height = tube.line(np.clip(turn, *reach))
        face_height = face.height + points[lies, :2] @ face.lean
        half = np.sqrt(np.maximum(wire**2 - (face_height - height) ** 2, 0.0))
        lies_in = np.abs(np.hypot(points[lies, 0], points[lies, 1]) - radius) < half + noise
        flat = side * (turn[lies_in & (half > 0)] - start)
    edges = np.arange(-0.4, BEYOND + BIN / 2, BIN)
    walls, floors = np.histogram(along, edges)[0], np.histogram(flat, edges)[0]
    last = _last_bin(walls, floors)
    both = np.sort(np.concatenate([along, flat]))
    both = both[(both > edges[0]) & (both <= edges[last + 1])]
    if len(both) < 8:
        return start, BIN
    spacing = float(both[-1] - both[-8]) / 7
    tip = start + side * (float(both[-1]) + spacing / 2)
    if face is not None:
        tip = _no_further(tube, face, tip, start, side, wire)
    # no wire is cut quite square, so that a tip is not known better than this
    return float(np.clip(tip, *reach)), max(spacing, 0.25 * BIN)


def _last_bin(walls: Array, floors: Array) -> int:
    """Last bin of the wire: faces end at their first gap, for behind it the far end of the face
    begins; walls may continue after a hole.
    """
    total = walls + floors
    last, quiet = 0, 0
    for place_ in range(len(total)):
        before = total[max(0, last - 15) : last + 1]
        least = max(
            2.0, LEFT_OVER * float(np.median(before[before > 0])) if np.any(before > 0) else 2.0
        )
        counted = walls[place_] if quiet > 3 else total[place_]
        if counted >= least:
            last, quiet = place_, 0
        else:
            quiet += 1
        if quiet > 30:
            break
    return last


def _no_further(tube: Tube, face: Face, tip: float, start: float, side: int, wire: float) -> float:
    """No tip is where grinding has taken the whole wire."""
    turns = np.linspace(start, tip, 200)
    _, height = tube.line(turns)
    gone = np.flatnonzero(-side * (height - face.height) + wire < 0)
    return float(turns[gone[0]]) if len(gone) else tip


#: Spline pieces a turn.
PER_TURN = 12
#: Points that the wire is looked for in; all are fitted in the end.
EARLY = 20_000
#: Points by which a first tube is judged, and distance from it (share of the coil radius) at which
#: it explains one.
MAX_POINTS, CLOSE = 4000, 0.024
#: Ellipticity, in standard deviations and as a share, from which a section is no longer taken as
#: round.
OVATE, MIN_OVATE = 5.0, 2.5e-3
#: Share of the directions about the wire axis that must be seen before a section is taken for
#: anything but round.
ALL_AROUND = 0.75


@dataclass(frozen=True, eq=False)
class FittedSpring:
    """Frame, tube and ends in the unit of the points; ``tips``: turns of the wire's ends, with
    standard deviations ``tip_spread``.
    """

    frame: Frame
    tube: Tube
    tips: tuple[float, float]
    tip_spread: tuple[float, float]
    faces: tuple[Face | None, Face | None]
    ovate: bool
    on: OnWire
    weight: Array
    points: Array


def fit_spring(
    points: Array, corners: Array | None = None, wedges: int = WEDGES, per_turn: int = PER_TURN
) -> FittedSpring:
    """The spring in points (n, 3) of any order of draw, in mm; ``wedges`` half planes and
    ``per_turn`` pieces of the splines. Of a mesh the points are those of its faces, which show
    tips and ground faces, and its ``corners`` (k, 3) lie on the surface of the wire.

    Raises :class:`InputError` where the points show no spring, with the width of the sector about
    its axis that holds none.
    """
    frame = find_axis(points)
    try:
        return _fit_about(frame, points, corners, wedges, per_turn)
    except InputError as error:
        degrees = 360 * unseen_sector(frame.inside(points))[1]
        if degrees < 15:
            raise
        reason = str(error).partition(";")[0]
        raise InputError(
            f"{reason}: no point is in a sector of {degrees:.0f} degrees about the axis; scan that side too and join both clouds"
        ) from error


#: Parts of the turn by which a sector without points is found, and share of the typical number of
#: points below which a part has none.
SECTORS, EMPTY = 120, 0.05


def unseen_sector(points: Array) -> tuple[float, float]:
    """Begin and width (turns) of the widest sector about the axis without points (n, 3)."""
    turn = np.mod(np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi), 1.0)
    counts = np.histogram(turn, np.linspace(0.0, 1.0, SECTORS + 1))[0]
    seen = np.flatnonzero(counts > EMPTY * np.median(counts[counts > 0]))
    empty = np.diff(np.append(seen, seen[0] + SECTORS)) - 1
    widest = int(np.argmax(empty))
    return float(np.mod((seen[widest] + 1) / SECTORS, 1.0)), float(empty[widest] / SECTORS)


def _fit_about(
    frame: Frame, points: Array, corners: Array | None, wedges: int, per_turn: int
) -> FittedSpring:
    """The spring in points (n, 3) about nearly the axis of ``frame``."""
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
        faces = {
            side: find_face(tube, inside, tips[(side + 1) // 2], side, reach) for side in (-1, 1)
        }
        flats = partial(flats_of, faces, tube.noise)
        tube, _, _ = fit_tube(
            tube,
            inside,
            (max(tips[0] - 0.1, reach[0]), min(tips[1] + 0.1, reach[1])),
            False,
            flats,
            rounds=8,
        )
        found = [
            find_tip(tube, inside, ends[(side + 1) // 2], reach, faces[side], side)
            for side in (-1, 1)
        ]
        tips = found[0][0], found[1][0]
        spreads = found[0][1], found[1][1]
    sag = tube.noise
    for _ in range(2):
        frame, tube = _on_better_axis(frame, tube, tips)
        inside = frame.inside(points)
        faces = {
            side: find_face(tube, inside, tips[(side + 1) // 2], side, reach) for side in (-1, 1)
        }
        flats = partial(flats_of, faces, tube.noise)
        inside = inside if corners is None else frame.inside(corners)
        tube, on, weight = fit_tube(tube, inside, tips, False, flats, rounds=12)
        if corners is not None:
            tube = _no_finer(tube, sag)
    ovate, other = _section(tube, on, weight, inside, tips, faces)
    if ovate:
        tube, on, weight = other
        tube = tube if corners is None else _no_finer(tube, sag)
    if corners is not None:  # points of one face share the errors of its corners
        shared = float(np.sqrt(max(1.0, 2 * len(points) / len(corners))))
        faces = {
            side: face and replace(face, spread=shared * face.spread)
            for side, face in faces.items()
        }
    if tips[1] - tips[0] < MIN_TURNS:
        raise InputError(
            f"the wire is seen over {tips[1] - tips[0]:.2g} turns only; give a scan that shows it all the way around"
        )
    return FittedSpring(
        frame, tube, tips, spreads, (faces[-1], faces[1]), ovate, on, weight, inside
    )


def _no_finer(tube: Tube, sag: float) -> Tube:
    """The tube through the corners of a mesh, its scatter not below that of the faces about it."""
    noise = max(tube.noise, sag)
    return replace(tube, noise=noise, cov=tube.cov * (noise / tube.noise) ** 2)


def _first_tube(points: Array, wedges: int, per_turn: int) -> tuple[Tube, tuple[float, float]]:
    """A tube through sections of the wire, and their first and last turn: of the radii that votes
    propose, that which explains most points.

    Raises :class:`InputError` where none gives a wire.
    """
    some, best, fault = (
        points[:MAX_POINTS],
        None,
        InputError(
            "the points show no wire wound about an axis; give the scan of one spring, cleaned"
        ),
    )
    for sections in find_sections(points, wedges):
        try:
            trace = follow(sections, wedges)
        except InputError as error:
            fault = error
            continue
        ends = float(trace.turn[0]), float(trace.turn[-1])
        reach = ends[0] - BEYOND, ends[1] + BEYOND
        tube = start_tube(
            trace.turn, trace.radius, trace.height, trace.hand, trace.wire_radius, reach, per_turn
        )
        near = CLOSE * float(np.median(trace.radius))
        share = float(np.mean(np.abs(place(tube, some, ends).left) < near))
        if best is None or share > best[0]:
            best = share, tube, ends
    if best is None:
        raise fault
    return best[1], best[2]


def _section(
    tube: Tube,
    on: OnWire,
    weight: Array,
    points: Array,
    tips: tuple[float, float],
    faces: dict[int, Face | None],
) -> tuple[bool, tuple[Tube, OnWire, Array]]:
    """Whether an ellipse fits better than a circle by more than chance, and the tube with it."""
    if seen_around(on, weight) < ALL_AROUND:
        return False, (tube, on, weight)
    found = fit_tube(tube, points, tips, True, partial(flats_of, faces, tube.noise), rounds=12)
    along, across = found[0].section[1:]
    spread = np.sqrt(np.diag(found[0].cov)[-2:])
    size = float(np.hypot(along, across))
    return bool(size > OVATE * float(np.hypot(*spread)) and size > MIN_OVATE), found


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
    tilt = _swing(
        bend[:, None] * waves + 2 * growth[:, None] * slopes - full**2 * radius[:, None] * waves,
        rise,
    )
    # height swings by tilt . (x, y): the axis leans by minus that
    moved = frame.moved(across, -tilt)
    wide = np.linspace(tube.knots[3], tube.knots[-4], int(60 * (tube.knots[-4] - tube.knots[3])))
    radius, height = tube.line(wide)
    angle = 2 * np.pi * tube.hand * wide
    line = moved.inside(
        frame.outside(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height]))
    )
    own = tube.hand * np.arctan2(line[:, 1], line[:, 0]) / (2 * np.pi)
    unwound = wide + np.mod(own - wide + 0.5, 1.0) - 0.5
    per_turn = round(1 / (tube.knots[4] - tube.knots[3]))
    again = start_tube(
        unwound,
        np.hypot(line[:, 0], line[:, 1]),
        line[:, 2],
        tube.hand,
        1.0,
        (tube.knots[3], tube.knots[-4]),
        per_turn,
    )
    return moved, replace(tube, radius=again.radius, height=again.height)


def _swing(waves: Array, bends: Array) -> Array:
    """Coefficients (2,) of ``waves`` in the second derivatives ``bends``; ramps of pitch and kinks
    of the diameter are left out.
    """
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
