"""Writes point clouds as a scanner makes them, from known springs: ``beehive.ply``, the same as
made, ``progressive.xyz``;
and what is true of them.

Use: python scripts/sample_scan.py FOLDER [POINTS]

The surface is swept from the law of the wire alone: a tube about the wire axis, cut by the planes
of the ground ends. Nothing here
knows how a scan is fitted.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.material import material_by_name
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import EndCoil
from valvetrain.solution.atomic import write_bytes, write_text

Array = NDArray[np.float64]
#: Steps per turn of the table of the wire axis.
FINE = 4096


@dataclass(frozen=True)
class Scanner:
    """How a spring is seen: ``noise`` (m) per coordinate, share of ``outliers``, ``holes`` of
    ``hole_radius`` (m), the ``outside`` only.

    ``facing``: least cosine between the normal of the surface and the outward radius that such a
    scanner sees.
    """

    noise: float = 0.05e-3
    outliers: float = 0.02
    holes: int = 0
    hole_radius: float = 2.5e-3
    outside: bool = False
    facing: float = 0.2
    seed: int = 1


@dataclass(frozen=True)
class Truth:
    """What is known of a cloud: the spring, its ``wire_axis`` (n, 3) as far as it still stands, and
    its axis, as they lie there (m).
    """

    spring: SpringDefinition
    wire_axis: Array
    axis_point: Array
    axis_direction: Array


def wire_axis(spring: SpringDefinition) -> tuple[Array, Array, Array]:
    """Turns (n,), points (n, 3) and unit tangents (n, 3) of the wire axis: the rise is summed up
    step by step, tangents are differences.
    """
    turns = np.linspace(0.0, spring.total_coils, int(FINE * spring.total_coils) + 1)
    middle = (turns[1:] + turns[:-1]) / 2
    rise = np.concatenate([[0.0], np.cumsum(spring.pitch.value(middle) * np.diff(turns))])
    radius, turned = (
        spring.mean_diameter.value(turns) / 2,
        2 * np.pi * turns * (1 if spring.hand == "right" else -1),
    )
    points = np.column_stack([radius * np.cos(turned), radius * np.sin(turned), rise])
    tangents = np.gradient(points, turns, axis=0)
    return turns, points, tangents / np.linalg.norm(tangents, axis=1, keepdims=True)


def surface(
    spring: SpringDefinition,
    count: int,
    scanner: Scanner,
    draw: np.random.Generator,
    ovality: float = 0.0,
) -> Array:
    """Points (about ``count``, 3) spread evenly over the surface of the spring that the scanner
    sees, in the spring's own frame.

    ``ovality``: (width - height) / (width + height) of the section, width along the radius.
    """
    turns, points, tangents = wire_axis(spring)
    found: list[Array] = []
    kept = 0
    while kept < count:
        some = max(2 * (count - kept), 1000)
        place = draw.uniform(0.0, len(turns) - 1.0, some)
        below = np.minimum(place.astype(int), len(turns) - 2)
        share = (place - below)[:, None]
        centre = points[below] * (1 - share) + points[below + 1] * share
        tangent = tangents[below] * (1 - share) + tangents[below + 1] * share
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        coil = np.interp(place, np.arange(len(turns)), turns)
        outward = np.column_stack([centre[:, 0], centre[:, 1], np.zeros(some)])
        outward -= np.sum(outward * tangent, axis=1, keepdims=True) * tangent
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        across = np.cross(tangent, outward)
        half = spring.wire_diameter.value(coil) / 2
        around = draw.uniform(0, 2 * np.pi, some)
        offset = (half * (1 + ovality) * np.cos(around))[:, None] * outward + (
            half * (1 - ovality) * np.sin(around)
        )[:, None] * across
        point = centre + offset
        # more of the surface lies on the outside of the coil than on its inside
        wide = np.hypot(point[:, 0], point[:, 1]) / (
            np.hypot(centre[:, 0], centre[:, 1]) + half * (1 + ovality)
        )
        keep = draw.uniform(0, 1, some) < wide
        if scanner.outside:
            keep &= np.sum(offset * outward, axis=1) > scanner.facing * half
        keep &= _ground(spring, point, centre, half)
        point = point[keep]
        found.append(point[: count - kept])
        kept += len(found[-1])
    return np.concatenate(found)


def _ground(
    spring: SpringDefinition, point: Array, centre: Array, half: Array
) -> NDArray[np.bool_]:
    """Grind the ends: what stands beyond a seat plane falls onto it, straight along the axis. Which
    points still lie on or in the wire.
    """
    left = np.ones(len(point), dtype=bool)
    for end, level, side in (
        (spring.lower_end, spring.lower_seat_height, -1),
        (spring.upper_end, spring.upper_seat_height, 1),
    ):
        if "ground" in end.kind:
            beyond = side * (point[:, 2] - level) > 0
            point[beyond, 2] = level
            left &= ~beyond | (np.linalg.norm(point - centre, axis=1) < half)
    return left


def _standing(spring: SpringDefinition, axis: Array) -> Array:
    """The wire axis (n, 3) as far as grinding has left some of the wire."""
    half = float(spring.wire_diameter.value(0.0)) / 2
    keep = np.ones(len(axis), dtype=bool)
    if "ground" in spring.lower_end.kind:
        keep &= axis[:, 2] > spring.lower_seat_height - half
    if "ground" in spring.upper_end.kind:
        keep &= axis[:, 2] < spring.upper_seat_height + half
    return axis[keep]


def cloud(
    spring: SpringDefinition,
    count: int = 30_000,
    scanner: Scanner | None = None,
    ovality: float = 0.0,
) -> tuple[Array, Truth]:
    """Points (n, 3) of a scanned spring in m, in any position, and the truth about them."""
    scanner = scanner or Scanner()
    draw = np.random.default_rng(scanner.seed)
    point = surface(spring, count, scanner, draw, ovality)
    _, axis, _ = wire_axis(spring)
    for centre in point[draw.integers(0, len(point), scanner.holes)]:
        point = point[np.linalg.norm(point - centre, axis=1) > scanner.hole_radius]
    point = point + draw.normal(0.0, scanner.noise, point.shape)
    low, high = point.min(axis=0), point.max(axis=0)
    stray = draw.uniform(
        low - 0.1 * (high - low), high + 0.1 * (high - low), (int(scanner.outliers * len(point)), 3)
    )
    point = np.concatenate([point, stray])
    turned, _ = np.linalg.qr(draw.normal(size=(3, 3)))
    turned *= np.sign(np.linalg.det(turned))
    moved = draw.uniform(-0.1, 0.1, 3)
    truth = Truth(spring, _standing(spring, axis)[::16] @ turned.T + moved, moved, turned[:, 2])
    return draw.permutation(point @ turned.T + moved), truth


def blocks(
    spring: SpringDefinition, count: int, scanner: Scanner, size: int = 200_000
) -> Iterator[Array]:
    """A large cloud in blocks, each seen anew (no holes), unmoved."""
    draw = np.random.default_rng(scanner.seed)
    for first in range(0, count, size):
        point = surface(spring, min(size, count - first), scanner, draw)
        yield point + draw.normal(0.0, scanner.noise, point.shape)


def springs() -> dict[str, SpringDefinition]:
    """Springs to look at: the shipped beehive and three of one's own."""
    steel, ends = material_by_name("EN 10270-2 VDSiCr"), EndCoil("closed-ground", 0.75, 0.75)
    beehive = load_case("gu2021-beehive-blind").springs[0].wire
    assert beehive is not None

    def law(knots: str, values: str) -> PiecewiseLinear:
        return PiecewiseLinear(
            tuple(map(float, knots.split())), tuple(1e-3 * float(one) for one in values.split())
        )

    even = law("0 0.8 1.3 5.7 6.2 7", "3.6 3.6 7.4 7.4 3.6 3.6")
    rising = law("0 0.75 1.25 2.5 4.5 6.75 7.25 8", "4 4 5.2 6.2 9 9 4 4")
    tapered = law("0 0.8 1.3 4.7 5.2 6", "3 3 6.5 6.5 3.05 3.05")
    return {
        "beehive": beehive,
        "beehive-as-made": as_made(beehive),
        "cylindrical": SpringDefinition(
            3.6e-3,
            24e-3,
            even,
            total_coils=7.0,
            material=steel,
            lower_end=ends,
            upper_end=ends,
            hand="left",
            name="cylindrical",
        ),
        "progressive": SpringDefinition(
            4e-3,
            24e-3,
            rising,
            total_coils=8.0,
            material=steel,
            lower_end=ends,
            upper_end=ends,
            hand="right",
            name="progressive",
        ),
        "conical": SpringDefinition(
            3e-3,
            law("0 6", "26 18"),
            tapered,
            total_coils=6.0,
            material=steel,
            lower_end=ends,
            upper_end=ends,
            hand="left",
            name="conical",
        ),
    }


def as_made(design: SpringDefinition) -> SpringDefinition:
    """A beehive as springs are made: above coil 4 its diameter falls in steps, and its pitch comes
    and goes by 0.25 mm.
    """
    coil = np.linspace(0.0, design.total_coils, 32 * int(design.total_coils) + 1)
    away = np.where((coil > 4.0) & (coil < 6.9), 0.25e-3 * np.sin(4 * np.pi * coil), 0.0)
    pitch = np.where(
        (coil > 2.0) & (coil < 6.25), 0.25e-3 * np.sin(2.6 * np.pi * (coil - 2.0)), 0.0
    )
    laws = [
        PiecewiseLinear(tuple(coil.tolist()), tuple((law.value(coil) + more).tolist()))
        for law, more in ((design.mean_diameter, away), (design.pitch, pitch))
    ]
    return design.replace(mean_diameter=laws[0], pitch=laws[1])


def ply(point: Array) -> bytes:
    """Binary PLY of single precision in mm."""
    head = f"ply\nformat binary_little_endian 1.0\ncomment units mm\nelement vertex {len(point)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    return head.encode() + (1e3 * point).astype("<f4").tobytes()


def main(folder: Path, count: int) -> None:
    """Write the clouds and their truth."""
    folder.mkdir(parents=True, exist_ok=True)
    known = springs()
    point, truth = cloud(known["beehive"], count, Scanner(holes=6))
    write_bytes(folder / "beehive.ply", ply(point))
    _write_truth(folder / "beehive-truth.csv", truth)
    point, truth = cloud(known["beehive-as-made"], count, Scanner(outside=True, seed=3))
    write_bytes(folder / "beehive-as-made.ply", ply(point))
    _write_truth(folder / "beehive-as-made-truth.csv", truth)
    point, truth = cloud(known["progressive"], count, Scanner(outside=True, seed=2))
    rows = "\n".join(" ".join(f"{1e3 * value:.4f}" for value in row) for row in point)
    write_text(folder / "progressive.xyz", f"# x [mm] y [mm] z [mm]\n{rows}\n")
    _write_truth(folder / "progressive-truth.csv", truth)


def _write_truth(path: Path, truth: Truth) -> None:
    rows = "\n".join(",".join(f"{1e3 * value:.5f}" for value in row) for row in truth.wire_axis)
    write_text(path, f"x [mm],y [mm],z [mm]\n{rows}\n")


if __name__ == "__main__":
    main(
        Path(sys.argv[1] if len(sys.argv) > 1 else "."),
        int(sys.argv[2]) if len(sys.argv) > 2 else 30_000,
    )
