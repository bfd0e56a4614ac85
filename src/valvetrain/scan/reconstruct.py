"""A spring out of the file of a scanner."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.parameters.material import Material, material_by_name
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.scan.axis import WEDGES
from valvetrain.scan.clouds import open_cloud
from valvetrain.scan.definition import Wire, define, round_wire, wire_of
from valvetrain.scan.fit import (
    PER_TURN,
    FittedSpring,
    fit_spring,
    seen_around,
    unseen_sector,
)
from valvetrain.scan.result import Coverage, ScanCurves, ScannedEnd, ScannedSpring, WireSection
from valvetrain.scan.tube import TUKEY
from valvetrain.units import dimension_of, unit_factor

Array = NDArray[np.float64]
#: Points that are drawn, fewest that define a spring, and share of rows without numbers from which a
#: file is taken to be damaged.
DRAWN, MIN_POINTS, DAMAGED = 100_000, 1500, 0.1


@dataclass(frozen=True, eq=False)
class Drawn:
    """Points (n, 3) in an order that their coordinates decide, how many were ``read``, and how many
    of those held no numbers.
    """

    points: Array
    read: int
    broken: int


def draw_points(blocks: Iterable[Array], most: int, name: str) -> Drawn:
    """At most ``most`` different points of all ``blocks``: those whose coordinates, mixed to one
    number each, come first.

    Raises :class:`InputError` for fewer than :data:`FEWEST`, and where many rows hold no numbers.
    """
    chosen, marks = np.zeros((0, 3)), np.zeros(0, dtype=np.uint64)
    limit = np.uint64(2**64 - 1)
    read = broken = 0
    for block in blocks:
        read += len(block)
        finite = block[np.all(np.isfinite(block) & (np.abs(block) < 1e12), axis=1)]
        broken += len(block) - len(finite)
        own = _mixed(finite)
        low = own <= limit
        chosen, marks = np.concatenate([chosen, finite[low]]), np.concatenate([marks, own[low]])
        if len(marks) > 2 * most:
            chosen, marks = _first(chosen, marks, most)
            limit = marks[-1] if len(marks) == most else limit
    chosen, _ = _first(chosen, marks, most)
    if broken > DAMAGED * max(read, 1):
        raise InputError(
            f"{broken} of the {read} points of '{name}' are no numbers; export the scan again"
        )
    if len(chosen) < MIN_POINTS:
        raise InputError(
            f"'{name}' holds {len(chosen)} different points; {MIN_POINTS} or more are needed, so scan it finer"
        )
    return Drawn(chosen, read, broken)


def _first(points: Array, marks: NDArray[np.uint64], most: int) -> tuple[Array, NDArray[np.uint64]]:
    """Different points by rising mark, ``most`` of them."""
    marks, place = np.unique(marks, return_index=True)
    return points[place[:most]], marks[:most]


def _mixed(points: Array) -> NDArray[np.uint64]:
    """One number a point from the bits of its coordinates (the finaliser of splitmix64 after each)."""
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64).reshape(-1, 3)
    found = np.full(len(bits), 0x9E3779B97F4A7C15, dtype=np.uint64)
    with np.errstate(over="ignore"):
        for column in range(3):
            found = found ^ bits[:, column]
            found = (found ^ (found >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            found = (found ^ (found >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            found = found ^ (found >> np.uint64(31))
    return found


#: Extents (mm) that the cloud of a valve spring can have.
SMALLEST, LARGEST = 4.0, 500.0
#: Material where none is given, and the maximum of points that figures show.
DEFAULT_MATERIAL, SHOWN = "EN 10270-2 VDSiCr", 4000


def spring_from_scan(
    file: str | Path,
    *,
    unit: str = "",
    material: Material | None = None,
    name: str = "spring",
    turn_over: bool = False,
    points: int = DRAWN,
    slices_per_turn: int = WEDGES,
    stations_per_turn: int = PER_TURN,
) -> ScannedSpring:
    """The spring behind a point cloud or mesh, in any position, with the scatter of all its curves.

    The axis is that about which the radii scatter least; sections of the wire are found in half
    planes through it by votes and joined to
    the wire; the surface of a tube whose axis is a smooth curve is then fitted to the points by
    robust least squares, its smoothness found
    from them. Ground faces are planes, tips the places where the wire's surface ends. Of a mesh
    points drawn evenly by area show faces and tips, and the tube is fitted to the corners.

    Parameters
    ----------
    file : PLY, STL, OBJ or text with x, y and z in columns, of any size
    unit : of the coordinates, "mm", "m" or "inch"; where the file does not give it
    material : of the wire; EN 10270-2 VDSiCr where none is given
    name : word for the spring
    turn_over : take the other end for the lower one: that is the wider one, else the one with the
        closer coils, else as scanned
    points : most points that are fitted, an even draw from the file that does not depend on their
        order
    slices_per_turn : half planes in which sections are looked for at first; the fit does not depend
        on them
    stations_per_turn : pieces a turn of the smooth curves; beyond 8 the fit does not depend on them
        either

    Returns
    -------
    ScannedSpring

    Raises
    ------
    InputError : a file that is damaged, empty, without unit, or shows no spring, in one sentence

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> draw = np.random.default_rng(1)
    >>> turn, around = draw.uniform(0, 4, 3000), draw.uniform(0, 6.2832, 3000)  # 4 turns of 3 mm wire, 20 mm, 6 mm per turn
    >>> radius = 10 + 1.5 * np.cos(around)
    >>> spring = np.column_stack([radius * np.cos(6.2832 * turn), radius * np.sin(6.2832 * turn), 6 * turn + 1.5 * np.sin(around)])
    >>> file = pathlib.Path(tempfile.mkdtemp(), "scan.xyz")
    >>> np.savetxt(file, spring + draw.normal(0, 0.03, spring.shape), fmt="%.4f")
    >>> found = spring_from_scan(file, unit="mm")
    >>> found.hand, round(found.total_coils[0], 1), round(1e3 * float(found.definition.mean_diameter.value(2.0)), 1)
    ('right', 4.0, 20.0)
    """
    cloud = open_cloud(file)
    unit_name = unit or cloud.unit
    factor = 1e3 * _length_unit(unit_name, cloud.name)
    if not MIN_POINTS <= points <= 2_000_000:
        raise InputError(
            f"{points} points cannot be fitted; choose {MIN_POINTS} to 2000000", "points"
        )
    if not (16 <= slices_per_turn <= 512 and 6 <= stations_per_turn <= 60):
        raise InputError(
            "16 to 512 slices and 6 to 60 stations a turn can be had; choose numbers between",
            "slices_per_turn",
        )
    drawn = draw_points(cloud.blocks, points, cloud.name)
    across = float(np.max(np.ptp(np.quantile(drawn.points, (0.02, 0.98), axis=0), axis=0))) * factor
    if not SMALLEST <= across <= LARGEST:
        raise InputError(
            f"'{cloud.name}' is {across:.3g} mm large in {unit_name}, which no valve spring is; correct the unit",
            "unit",
        )
    seen, corners = drawn.points * factor, None
    if len(cloud.surface):
        seen, corners = draw_points([cloud.surface], points, cloud.name).points * factor, seen
    fitted = fit_spring(seen, corners, slices_per_turn, stations_per_turn)
    wire = wire_of(fitted, turn_over)
    turns = _turn_diameters(fitted, wire)
    try:
        definition = define(
            fitted, wire, turns, material or material_by_name(DEFAULT_MATERIAL), name
        )
    except InputError as error:
        raise InputError(
            f"what the points of '{cloud.name}' show is no spring: {str(error).partition(';')[0]}; give a cloud that shows the wire on all "
            "sides of the spring"
        ) from error
    broken = [f"{drawn.broken} points left out that are no numbers"] if drawn.broken else []
    near = TUKEY * fitted.tube.noise
    on_wire = np.abs(fitted.on.left) < near
    for side, face in zip((-1, 1), fitted.faces, strict=True):
        if face is not None:
            on_wire |= np.abs(face.above(fitted.points, side)) < near
    left = 1e-3 * fitted.on.left[np.abs(fitted.on.left) < 8 * fitted.tube.noise]
    ends = [_end(fitted, definition, place, wire.turned_over) for place in (0, 1)]
    across_tips = float(np.hypot(*fitted.tip_spread))
    frame = fitted.frame.turned_over() if wire.turned_over else fitted.frame
    step = max(1, len(fitted.points) // SHOWN)
    return ScannedSpring(
        cloud.name,
        cloud.form,
        unit_name,
        definition,
        _curves(fitted, wire),
        _section(fitted, turns, wire.turned_over),
        ends[0],
        ends[1],
        (float(definition.total_coils), across_tips),
        _free_length(fitted, wire),
        1e-3 * frame.origin,
        frame.base[2],
        1e-3 * fitted.tube.noise,
        left,
        drawn.read,
        len(drawn.points),
        int(np.count_nonzero(on_wire)),
        _coverage(fitted, wire),
        1e-3 * fitted.frame.outside(fitted.points[::step]),
        (*broken, *_assumed(material, definition)),
    )


def _length_unit(unit: str, name: str) -> float:
    if not unit:
        raise InputError(
            f"'{name}' does not give the unit of its points; state it, such as mm, m or inch",
            "unit",
        )
    try:
        fits = dimension_of(unit) == "length"
    except InputError:
        fits = False
    if not fits:
        raise InputError(f"'{unit[:40]}' is no unit of length; use mm, m or inch", "unit")
    return float(unit_factor(unit))


def _turn_diameters(fitted: FittedSpring, wire: Wire) -> Array:
    """Coil, wire diameter (mm), its standard deviation and points of every turn, (k, 4)."""
    on, weight = fitted.on, fitted.weight
    coil = on.turn - fitted.tips[0]
    coil = wire.coil[-1] - coil if wire.turned_over else coil
    rows = []
    for turn in range(int(np.floor(wire.coil[-1]))):
        held = (coil >= turn) & (coil < turn + 1) & (weight > 0)
        total = float(np.sum(weight[held]))
        if np.count_nonzero(held) > 50:
            away = float(np.sum(weight[held] * on.left[held])) / total
            rows.append(
                (
                    turn + 0.5,
                    2 * (fitted.tube.section[0] + away),
                    2 * fitted.tube.noise / np.sqrt(total),
                    np.count_nonzero(held),
                )
            )
    return np.array(rows).reshape(-1, 4)


def _section(fitted: FittedSpring, turns: Array, over: bool) -> WireSection:
    mean, along, across = fitted.tube.section
    size, spread = (
        float(np.hypot(along, across)) if fitted.ovate else 0.0,
        np.sqrt(np.diag(fitted.tube.cov)[-3:]),
    )
    sd = float(np.hypot(spread[0], mean * np.hypot(spread[1], spread[2]) if fitted.ovate else 0.0))
    chosen = np.flatnonzero(np.abs(fitted.on.left) < 0.3 * mean)
    chosen = chosen[:: max(1, len(chosen) // SHOWN)]
    distance, around = fitted.on.distance[chosen], fitted.on.around[chosen] * (-1 if over else 1)
    inclination = (
        (-0.5 if over else 0.5) * float(np.arctan2(across, along)) if fitted.ovate else 0.0
    )
    return WireSection(
        (1e-3 * round_wire(float(mean), size), 2e-3 * float(spread[0])),
        (2e-3 * float(mean) * (1 + size), 2e-3 * sd),
        (2e-3 * float(mean) * (1 - size), 2e-3 * sd),
        inclination,
        turns * np.array([1.0, 1e-3, 1e-3, 1.0]),
        1e-3 * np.column_stack([distance * np.cos(around), distance * np.sin(around)]),
    )


def _curves(fitted: FittedSpring, wire: Wire) -> ScanCurves:
    """Curves in m; heights above the lower seat plane."""
    below = (
        wire.faces[0]
        if wire.faces[0] is not None
        else float(np.min(wire.height)) - float(fitted.tube.section[0])
    )
    turn = fitted.tips[0] + (wire.coil[::-1][0] - wire.coil if wire.turned_over else wire.coil)
    angle = 2 * np.pi * fitted.tube.hand * turn
    height = -wire.height if wire.turned_over else wire.height
    line = fitted.frame.outside(
        np.column_stack([wire.radius * np.cos(angle), wire.radius * np.sin(angle), height])
    )
    return ScanCurves(
        wire.coil,
        2e-3 * wire.radius,
        2e-3 * wire.radius_spread,
        1e-3 * (wire.height - below),
        1e-3 * wire.height_spread,
        1e-3 * wire.pitch,
        1e-3 * wire.pitch_spread,
        1e-3 * line,
    )


def _free_length(fitted: FittedSpring, wire: Wire) -> tuple[float, float]:
    """Distance of the seat planes (m) and its standard deviation: ground faces, else the outermost
    wire.
    """
    half = float(fitted.tube.section[0])
    low = wire.faces[0] if wire.faces[0] is not None else float(np.min(wire.height)) - half
    high = wire.faces[1] if wire.faces[1] is not None else float(np.max(wire.height)) + half
    faces = fitted.faces[::-1] if wire.turned_over else fitted.faces
    spreads = [
        float(wire.height_spread[-place]) if face is None else face.spread
        for place, face in enumerate(faces)
    ]
    return 1e-3 * (high - low), 1e-3 * float(np.hypot(spreads[0], spreads[1]))


def _end(fitted: FittedSpring, definition: SpringDefinition, place: int, over: bool) -> ScannedEnd:
    face = fitted.faces[1 - place if over else place]
    end = definition.upper_end if place else definition.lower_end
    lean = 0.0 if face is None else float(np.arctan(np.hypot(*face.lean)))
    return ScannedEnd(
        end.kind,
        0 if face is None else face.points,
        lean,
        fitted.tip_spread[1 - place if over else place],
    )


def _coverage(fitted: FittedSpring, wire: Wire) -> Coverage:
    """The widest sector about the axis without points, and the tips in it."""
    begin, width = unseen_sector(fitted.points[fitted.weight > 0])
    names = ("upper", "lower") if wire.turned_over else ("lower", "upper")
    hidden = tuple(
        name
        for name, tip, side in zip(names, fitted.tips, (-1, 1), strict=True)
        if np.mod(fitted.tube.hand * (tip + 0.5 * side * width) - begin, 1.0) < width
    )
    return Coverage(seen_around(fitted.on, fitted.weight), 2 * np.pi * width, hidden)


def _assumed(material: Material | None, definition: SpringDefinition) -> list[str]:
    notes = [] if material else [f"material {definition.material.name}, which a scan does not show"]
    for word, end in (("lower", definition.lower_end), ("upper", definition.upper_end)):
        ground = f"ground turns of the {word} end ({end.inactive_coils:.3f}) inactive"
        other = (
            f"{word} end {end.kind}, without a ground face, {end.inactive_coils:g} turns inactive"
        )
        notes.append(ground if "ground" in end.kind else other)
    return notes
