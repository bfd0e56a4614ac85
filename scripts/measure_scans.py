"""Measures how well springs are found in scans of known springs, and what a large cloud takes;
prints the tables of the docs.

Use: python scripts/measure_scans.py [picture FILE | FOLDER POINTS]
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parent))
from sample_scan import Scanner, Truth, blocks, cloud, ply, springs

from valvetrain.scan.reconstruct import spring_from_scan
from valvetrain.scan.result import ScannedSpring

Array = NDArray[np.float64]
#: What a scanner sees, in words, and how it is drawn.
SEEN = {
    "all": Scanner(), "all, holes": Scanner(holes=8, seed=2), "outside": Scanner(outside=True, seed=3),
    "outside, holes": Scanner(outside=True, holes=8, seed=4),
}  # fmt: skip


def distances(points: Array, line: Array) -> Array:
    """Distance (n,) of points (n, 3) from a polygon (m, 3), perpendicular to its sides."""
    sides = np.diff(line, axis=0)
    lengths = np.sum(sides**2, axis=1)
    found = []
    for point in points:
        away = point - line[:-1]
        share = np.clip(np.sum(away * sides, axis=1) / lengths, 0.0, 1.0)
        found.append(np.sqrt(np.min(np.sum((away - share[:, None] * sides) ** 2, axis=1))))
    return np.array(found)


def fitted_line(scan: ScannedSpring, between: int = 4) -> Array:
    """The wire axis of a scan (n, 3) in the frame of the file, with points ``between`` its stations
    on the coil, in m.
    """
    curves, axis = scan.curves, scan.axis_direction
    away = curves.centre_line - scan.axis_point
    along = away @ axis
    radial = away - along[:, None] * axis
    first = radial[0] / np.linalg.norm(radial[0])
    second = np.cross(axis, first)
    turned = np.unwrap(np.arctan2(radial @ second, radial @ first))
    fine = np.linspace(0.0, curves.coil[-1], between * (len(curves.coil) - 1) + 1)
    angle, height, radius = (
        np.interp(fine, curves.coil, one) for one in (turned, along, curves.mean_diameter / 2)
    )
    radial = radius[:, None] * (np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second)
    return np.asarray(scan.axis_point + radial + height[:, None] * axis)


def rms(scan: ScannedSpring, truth: Truth, off: float = 0.0) -> float:
    """Root mean square distance (m) of the fitted wire axis from the true one, tip to tip but for
    ``off`` turns at either end.
    """
    line = fitted_line(scan)
    skip = round(off / scan.total_coils[0] * len(line))
    return float(np.sqrt(np.mean(distances(line[skip : len(line) - skip], truth.wire_axis) ** 2)))


def accuracy(folder: Path, count: int = 30_000) -> None:
    """One row a spring and scanner: what was found beside what is true."""
    print(
        "spring           seen            axis um  inner um  wire um  free um  turns    hand   noise um   s"
    )
    for name, spring in springs().items():
        for words, scanner in SEEN.items():
            point, truth = cloud(spring, count, scanner)
            file = folder / "cloud.ply"
            file.write_bytes(ply(point))
            begun = time.process_time()
            scan = spring_from_scan(file)
            seconds = time.process_time() - begun
            wire = float(spring.wire_diameter.value(0.0))
            print(
                f"{name:16s} {words:15s} {1e6 * rms(scan, truth):7.1f}  {1e6 * rms(scan, truth, 0.25):7.1f}  "
                f"{1e6 * (scan.section.diameter[0] - wire):+7.1f}  "
                f"{1e6 * (scan.free_length[0] - spring.free_length):+7.1f}  {scan.total_coils[0]:.4f}  {scan.hand:5s}  "
                f"{1e6 * scan.noise:7.1f}  {seconds:.1f}"
            )


def large(folder: Path, count: int) -> None:
    """A cloud of ``count`` points written in blocks and read: memory of the process and its time."""
    spring = springs()["progressive"]
    file = folder / "large.ply"
    head = f"ply\nformat binary_little_endian 1.0\ncomment units mm\nelement vertex {count}\n"
    with file.open("wb") as stream:
        stream.write(
            (head + "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n").encode()
        )
        for block in blocks(spring, count, Scanner(outliers=0.0)):
            stream.write((1e3 * block).astype("<f4").tobytes())
    before, begun = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    scan = spring_from_scan(file)
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(
        f"{count} points, {file.stat().st_size / 1e6:.0f} MB: {time.process_time() - begun:.1f} s of processor time, ",
        end="",
    )
    print(f"largest memory {before / 1024:.0f} MB before and {after / 1024:.0f} MB after; {scan!r}")
    file.unlink()


def picture(folder: Path, file: Path) -> None:
    """The curves of the beehive as made less those of its design."""
    from plotly_pictures import save

    from valvetrain.scan.compare import compare_scan

    point, _ = cloud(springs()["beehive-as-made"], 30_000, Scanner(outside=True, seed=3))
    (folder / "cloud.ply").write_bytes(ply(point))
    compared = compare_scan(spring_from_scan(folder / "cloud.ply"), "gu2021-beehive-blind")
    save(compared.plot(), file)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as there:
        if sys.argv[1:2] == ["picture"]:
            picture(Path(there), Path(sys.argv[2]))
        elif len(sys.argv) > 2:
            large(Path(sys.argv[1]), int(sys.argv[2]))
        else:
            accuracy(Path(there))
