"""A spring fitted to the points of a scan: axis, wire, section, ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError
from valvetrain.scan.axis import MIN_TURNS, Frame, find_axis, find_sections, follow
from valvetrain.scan.tube import OnWire, Tube, fit_tube, place, start_tube

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
        return np.asarray(-side * (points[:, 2] - self.height - points[:, :2] @ self.lean))


def find_face(
    tube: Tube, points: Array, tip: float, side: int, reach: tuple[float, float]
) -> Face | None:
    """The ground face of the end whose tip is about at turn ``tip``; None where there is none.

    Nothing but a ground face has points inside the wire, so those alone show it.
    """
    on = place(tube, points, (max(tip - FACED, reach[0]), min(tip + FACED, reach[1])))
    wire, noise = float(tube.section[0]), tube.noise
    chosen = points[on.distance < min(wire - DEEP * noise, SHALLOW * wire)]
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
    near = points[np.abs(face.above(points, side)) < 6 * noise]
    turn = tip - side * np.mod(
        -side * (_angle(tube, near) - tip), 1.0
    )  # one turn from the tip inward
    off, half = _in_section(tube, face, near, turn)
    amid = near[off < 0.75 * half]
    return (_plane(amid, face, 2 * noise, noise) if len(amid) >= FEWEST else None) or face


def _angle(tube: Tube, points: Array) -> Array:
    """Angle (turns, 0 to 1) of points (n, 3) about the axis, rising along the wire."""
    return np.mod(tube.hand * np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi), 1.0)


def _in_section(tube: Tube, face: Face, points: Array, turn: Array) -> tuple[Array, Array]:
    """Radial distance of points (n, 3) from the middle of the ground section at turns (n,), and half its width."""
    radius, height = tube.line(turn)
    level = face.height + points[:, :2] @ face.lean
    half = np.sqrt(np.maximum(tube.section[0] ** 2 - (level - height) ** 2, 0.0))
    return np.abs(np.hypot(points[:, 0], points[:, 1]) - radius), half


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
        heavy = model.T * weight
        matrix = heavy @ model + np.diag([0.0, 1.0, 1.0]) * (scale / TYPICAL_LEAN) ** 2
        values = np.linalg.solve(matrix, heavy @ points[:, 2])
        scale = max(0.7 * scale, noise)
    if float(np.hypot(*values[1:])) > STEEPEST:
        return None
    on = np.abs(left) < WITHIN * scale
    # the faces of a drawing have no scatter of their own
    scatter = max(float(np.std(left[on])), 0.1 * noise) if np.any(on) else noise
    spread = scatter * float(np.sqrt(np.linalg.inv(matrix)[0, 0]))
    return Face(float(values[0]), values[1:], int(np.count_nonzero(on)), spread)


def supported(tube: Tube, points: Array, ends: tuple[float, float]) -> tuple[float, float]:
    """The stretch of turns whose wire has points on its surface: what was followed beyond the tips
    is left out.
    """
    on = place(tube, points, ends)
    surface = (np.abs(on.left) < WITHIN * tube.noise) & (on.gap > 0.1 * tube.section[0])
    edges = np.arange(ends[0], ends[1] + BIN, 2 * BIN)
    counts = np.histogram(on.turn[surface], edges)[0]
    full = np.flatnonzero(counts > max(2.0, 2 * LEFT_OVER * float(np.median(counts))))
    # The bins about the middle up to the first hole on either side.
    middle = len(counts) // 2
    holes = np.flatnonzero(np.diff(full) > GAP / (2 * BIN))
    cut = full[holes], full[holes + 1]
    first = max([*cut[1][cut[1] <= middle], full.min(initial=middle)], default=middle)
    last = min([*cut[0][cut[0] >= middle], full.max(initial=middle)], default=middle)
    return float(edges[min(first, middle)]), float(edges[max(last, middle) + 1])


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
    surface = (np.abs(on.left) < WITHIN * noise) & (on.gap > WITHIN * noise)
    flat = np.zeros(0)
    if face is not None:
        above = face.above(points, side)
        surface &= above > WITHIN * noise
        lying = points[np.abs(above) < min(WITHIN * noise, 0.1 * wire)]
        turn = start + np.mod(_angle(tube, lying) - start + 0.5, 1.0) - 0.5
        off, half = _in_section(tube, face, lying, np.clip(turn, *reach))
        flat = side * (turn[(off < half + noise) & (half > 0)] - start)
    along = side * (on.turn[surface] - start)  # positive beyond the last section
    edges = np.arange(-0.4, BEYOND + BIN / 2, BIN)
    walls, floors = np.histogram(along, edges)[0], np.histogram(flat, edges)[0]
    # Last bin of the wire: faces end at their first gap, for behind it the far end of the face
    # begins; walls may continue after a hole.
    last = 0
    for number, count in enumerate(walls + floors):
        before = (walls + floors)[max(0, last - 15) : last + 1]
        least = max(2.0, LEFT_OVER * float(np.median(before[before > 0]))) if np.any(before) else 2.0  # fmt: skip
        if number - last > 31:
            break
        if (walls[number] if number - last > 4 else count) >= least:
            last = number
    both = np.sort(np.concatenate([along, flat]))
    both = both[(both > edges[0]) & (both <= edges[last + 1])]
    if len(both) < 8:
        return start, BIN
    spacing = float(both[-1] - both[-8]) / 7
    tip = start + side * (float(both[-1]) + spacing / 2)
    if face is not None:  # no tip is where grinding has taken the whole wire
        turns = np.linspace(start, tip, 200)
        gone = np.flatnonzero(-side * (tube.line(turns)[1] - face.height) + wire < 0)
        tip = float(turns[gone[0]]) if len(gone) else tip
    # no wire is cut quite square, so that a tip is not known better than this
    return float(np.clip(tip, *reach)), max(spacing, 0.25 * BIN)


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


def fit_spring(points: Array, corners: Array | None = None) -> FittedSpring:
    """The spring in points (n, 3) of any order of draw, in mm. Of a mesh the points are those of its
    faces, which show tips and ground faces, and its ``corners`` (k, 3) lie on the surface of the wire.

    Raises :class:`InputError` where the points show no spring, with the width of the sector about
    its axis that holds none.
    """
    frame = find_axis(points)
    try:
        return _fit_about(frame, points, corners)
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


def _fit_about(frame: Frame, points: Array, corners: Array | None) -> FittedSpring:
    """The spring in points (n, 3) about nearly the axis of ``frame``."""
    inside = frame.inside(points[:EARLY])
    tube, ends = _first_tube(inside)
    reach = ends[0] - BEYOND, ends[1] + BEYOND
    tube, _, _ = fit_tube(tube, inside, ends, rounds=8)
    ends = supported(tube, inside, ends)
    for _ in range(3):
        frame, tube = _on_better_axis(frame, tube, ends)
        inside = frame.inside(points[:EARLY])
        tube, _, _ = fit_tube(tube, inside, ends, rounds=5)
    inside = frame.inside(points)
    tips, spreads = ends, (0.0, 0.0)

    def faces_at() -> tuple[Face | None, Face | None]:
        return find_face(tube, inside, tips[0], -1, reach), find_face(
            tube, inside, tips[1], 1, reach
        )

    def flats(seen: Array) -> Flags:
        """Which points are on a ground face or beyond it."""
        beyond = np.zeros(len(seen), dtype=bool)
        for side, face in zip((-1, 1), faces, strict=True):
            if face is not None:
                beyond |= face.above(seen, side) < (WITHIN + 0.5) * tube.noise
        return beyond

    for _ in range(2):
        faces = faces_at()
        stretch = max(tips[0] - 0.1, reach[0]), min(tips[1] + 0.1, reach[1])
        tube, _, _ = fit_tube(tube, inside, stretch, flats(inside), rounds=8)
        lower = find_tip(tube, inside, ends[0], reach, faces[0], -1)
        upper = find_tip(tube, inside, ends[1], reach, faces[1], 1)
        tips, spreads = (lower[0], upper[0]), (lower[1], upper[1])
    sag = tube.noise if corners is not None else 0.0
    for _ in range(2):
        frame, tube = _on_better_axis(frame, tube, tips)
        inside = frame.inside(points)
        faces = faces_at()
        inside = inside if corners is None else frame.inside(corners)
        tube, on, weight = fit_tube(tube, inside, tips, flats(inside), rounds=12)
        tube = _no_finer(tube, sag)
    ovate = False
    if seen_around(on, weight) >= ALL_AROUND:
        oval, on_oval, weight_oval = fit_tube(tube, inside, tips, flats(inside), True, rounds=12)
        # Whether an ellipse fits better than a circle by more than chance.
        size = float(np.hypot(*oval.section[1:]))
        chance = OVATE * float(np.sqrt(np.sum(np.diag(oval.cov)[-2:])))
        if size > max(chance, MIN_OVATE):
            ovate, tube, on, weight = True, _no_finer(oval, sag), on_oval, weight_oval
    if corners is not None:  # points of one face share the errors of its corners
        shared = float(np.sqrt(max(1.0, 2 * len(points) / len(corners))))
        lower_face, upper_face = (face and replace(face, spread=shared * face.spread) for face in faces)  # fmt: skip
        faces = lower_face, upper_face
    if tips[1] - tips[0] < MIN_TURNS:
        raise InputError(
            f"the wire is seen over {tips[1] - tips[0]:.2g} turns only; give a scan that shows it all the way around"
        )
    return FittedSpring(frame, tube, tips, spreads, faces, ovate, on, weight, inside)


def _no_finer(tube: Tube, sag: float) -> Tube:
    """The tube through the corners of a mesh, its scatter not below that of the faces about it."""
    noise = max(tube.noise, sag)
    return replace(tube, noise=noise, cov=tube.cov * (noise / tube.noise) ** 2)


def _first_tube(points: Array) -> tuple[Tube, tuple[float, float]]:
    """A tube through sections of the wire, and their first and last turn: of the radii that votes
    propose, that which explains most points.

    Raises :class:`InputError` where none gives a wire.
    """
    tubes = []
    fault = InputError(
        "the points show no wire wound about an axis; give the scan of one spring, cleaned"
    )
    for sections in find_sections(points):
        try:
            trace = follow(sections)
        except InputError as error:
            fault = error
            continue
        ends = float(trace.turn[0]), float(trace.turn[-1])
        reach = ends[0] - BEYOND, ends[1] + BEYOND
        tube = start_tube(
            trace.turn, trace.radius, trace.height, trace.hand, trace.wire_radius, reach
        )
        left = np.abs(place(tube, points[:MAX_POINTS], ends).left)
        share = float(np.mean(left < CLOSE * np.median(trace.radius)))
        tubes.append((share, tube, ends))
    if not tubes:
        raise fault
    _, tube, ends = max(tubes, key=lambda entry: entry[0])
    return tube, ends


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
    reach = float(tube.knots[3]), float(tube.knots[-4])
    wide = np.linspace(*reach, int(60 * (reach[1] - reach[0])))
    radius, height = tube.line(wide)
    angle = 2 * np.pi * tube.hand * wide
    line = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    line = moved.inside(frame.outside(line))
    unwound = wide + np.mod(_angle(tube, line) - wide + 0.5, 1.0) - 0.5
    radius = np.hypot(line[:, 0], line[:, 1])
    again = start_tube(unwound, radius, line[:, 2], tube.hand, 1.0, reach)
    return moved, replace(tube, radius=again.radius, height=again.height)


def _swing(waves: Array, bends: Array) -> Array:
    """Coefficients (2,) of ``waves`` in the second derivatives ``bends``; ramps of pitch and kinks
    of the diameter are left out.
    """
    basis = np.column_stack([np.ones(len(bends)), waves])
    weight = np.ones(len(bends))
    for _ in range(20):
        root = np.sqrt(weight)[:, None]
        shares = np.linalg.lstsq(basis * root, bends * root[:, 0], rcond=1e-10)[0]
        left = np.abs(bends - basis @ shares)
        scale = 1.4826 * float(np.median(left)) + 1e-9
        weight = 1 / (1 + (left / (1.5 * scale)) ** 2)
    return np.asarray(shares[1:])
