"""A spring out of the file of a scanner."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.force_height import column_scale
from valvetrain.parameters.material import Material, material_by_name
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.scan.clouds import open_cloud
from valvetrain.scan.definition import curves_of, define, round_wire, upside_down
from valvetrain.scan.fit import FittedSpring, fit_spring, seen_around, unseen_sector
from valvetrain.scan.result import Coverage, ScannedSpring, WireSection
from valvetrain.scan.tube import TUKEY

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


def draw_points(points: Array, most: int, name: str) -> Drawn:
    """At most ``most`` different ``points`` (n, 3): those whose coordinates, mixed to one number each,
    come first.

    Raises :class:`InputError` for fewer than :data:`MIN_POINTS`, and where many rows hold no numbers.
    """
    numbers = points[np.all(np.abs(points) < 1e12, axis=1)]
    read, broken = len(points), len(points) - len(numbers)
    if broken > DAMAGED * max(read, 1):
        raise InputError(
            f"{broken} of the {read} points of '{name}' are no numbers; export the scan again"
        )
    chosen = numbers[np.unique(_mixed(numbers), return_index=True)[1][:most]]
    if len(chosen) < MIN_POINTS:
        raise InputError(
            f"'{name}' holds {len(chosen)} different points; {MIN_POINTS} or more are needed, so scan it finer"
        )
    return Drawn(chosen, read, broken)


def _mixed(points: Array) -> NDArray[np.uint64]:
    """One number a point from the bits of its coordinates (the finaliser of splitmix64 after each)."""
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64).reshape(-1, 3)
    mark = np.full(len(bits), 0x9E3779B97F4A7C15, dtype=np.uint64)
    for column in bits.T:
        mark ^= column
        mark = (mark ^ (mark >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mark = (mark ^ (mark >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        mark ^= mark >> np.uint64(31)
    return mark


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
    file : PLY, STL, OBJ or text with x, y and z in columns
    unit : of the coordinates, "mm", "m" or "inch"; where the file does not give it
    material : of the wire; EN 10270-2 VDSiCr where none is given
    name : word for the spring
    turn_over : take the other end for the lower one: that is the wider one, else the one with the
        closer coils, else as scanned
    points : most points that are fitted, an even draw from the file that does not depend on their
        order

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
    >>> scan = spring_from_scan(file, unit="mm")
    >>> scan.hand, round(scan.total_coils[0], 1), round(1e3 * float(scan.definition.mean_diameter.value(2.0)), 1)
    ('right', 4.0, 20.0)
    """
    cloud = open_cloud(file)
    unit_name = unit or cloud.unit
    factor = 1e3 * column_scale(unit_name, "length", "unit", cloud.name)
    if not MIN_POINTS <= points <= 2_000_000:
        raise InputError(
            f"{points} points cannot be fitted; choose {MIN_POINTS} to 2000000", "points"
        )
    drawn = draw_points(cloud.points, points, cloud.name)
    across = float(np.max(np.ptp(np.quantile(drawn.points, (0.02, 0.98), axis=0), axis=0))) * factor
    if not SMALLEST <= across <= LARGEST:
        raise InputError(
            f"'{cloud.name}' is {across:.3g} mm large in {unit_name}, which no valve spring is; correct the unit",
            "unit",
        )
    seen, corners = drawn.points * factor, None
    if len(cloud.surface):
        seen, corners = draw_points(cloud.surface, points, cloud.name).points * factor, seen
    fitted = fit_spring(seen, corners)
    down = upside_down(fitted) != turn_over
    try:
        parts = _measured(fitted, down, material or material_by_name(DEFAULT_MATERIAL), name)
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
    return ScannedSpring(
        source=cloud.name,
        form=cloud.form,
        unit=unit_name,
        **parts,
        axis_point=1e-3 * fitted.frame.origin,
        noise=1e-3 * fitted.tube.noise,
        points_read=drawn.read,
        points_fitted=len(drawn.points),
        points_on_wire=int(np.count_nonzero(on_wire)),
        shown=1e-3 * fitted.frame.outside(fitted.points[:: max(1, len(fitted.points) // SHOWN)]),
        notes=(*broken, *_assumed(material, parts["definition"])),
        fitted=fitted,
    )


def turned_over(scan: ScannedSpring) -> ScannedSpring:
    """The same spring, turned over."""
    wire = scan.definition
    return replace(scan, **_measured(scan.fitted, not scan.down, wire.material, wire.name))


def _measured(fitted: FittedSpring, down: bool, material: Material, name: str) -> dict[str, Any]:
    """The spring from its lower end, and what is measured of it, by the fields of :class:`ScannedSpring`; ``down``: the
    lower end is above in the scan.
    """
    curves, free_length = curves_of(fitted, down)
    on, weight, tube = fitted.on, fitted.weight, fitted.tube
    coil = fitted.tips[1] - on.turn if down else on.turn - fitted.tips[0]
    rows = []
    for turn in range(int(curves.coil[-1])):
        seen = (coil >= turn) & (coil < turn + 1) & (weight > 0)
        count, total = np.count_nonzero(seen), float(np.sum(weight[seen]))
        if count > 50:
            away = float(np.average(on.left[seen], weights=weight[seen]))
            diameter = 2e-3 * (tube.section[0] + away)
            rows.append((turn + 0.5, diameter, 2e-3 * tube.noise / np.sqrt(total), count))
    turns = np.array(rows).reshape(-1, 4)
    laws = define(fitted, curves, free_length[0], turns, down)
    definition = SpringDefinition(**laws, material=material, name=name)
    mean, along, across = tube.section * (1.0, fitted.ovate, fitted.ovate)
    spread, size = np.sqrt(np.diag(tube.cov)[-3:]), float(np.hypot(along, across))
    axes_spread = 2e-3 * float(np.hypot(spread[0], mean * np.hypot(*spread[1:]) * fitted.ovate))
    # The widest sector about the axis without points, and the tips in it.
    begin, width = unseen_sector(fitted.points[weight > 0])
    hidden = tuple(
        end
        for end, tip, side in zip(("upper", "lower") if down else ("lower", "upper"), fitted.tips, (-1, 1), strict=True)
        if np.mod(tube.hand * (tip + 0.5 * side * width) - begin, 1.0) < width
    )  # fmt: skip
    return {
        "definition": definition,
        "curves": curves,
        "section": WireSection(
            (1e-3 * round_wire(float(mean), size), 2e-3 * float(spread[0])),
            (2e-3 * float(mean * (1 + size)), axes_spread),
            (2e-3 * float(mean * (1 - size)), axes_spread),
            (-0.5 if down else 0.5) * float(np.arctan2(across, along)),
            turns,
        ),
        "total_coils": (float(curves.coil[-1]), float(np.hypot(*fitted.tip_spread))),
        "free_length": free_length,
        "axis_direction": -fitted.frame.base[2] if down else fitted.frame.base[2],
        "coverage": Coverage(seen_around(on, weight), 2 * np.pi * width, hidden),
        "down": down,
    }


def _assumed(material: Material | None, definition: SpringDefinition) -> list[str]:
    notes = [] if material else [f"material {definition.material.name}, which a scan does not show"]
    for word, end in (("lower", definition.lower_end), ("upper", definition.upper_end)):
        ground = f"ground turns of the {word} end ({end.inactive_coils:.3f}) inactive"
        other = (
            f"{word} end {end.kind}, without a ground face, {end.inactive_coils:g} turns inactive"
        )
        notes.append(ground if "ground" in end.kind else other)
    return notes
