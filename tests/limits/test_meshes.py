"""Known answers: meshes of springs, as a CAD program or a scanner writes them. The truth is inside the printed bands.

Helices of either hand, closed or ground, cylindrical or tapered, in any position, with and without noise of the corners, as STL (binary and
text), PLY and OBJ in mm or inch. A ground face has corners at its edge alone.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree
from scipy.stats import binom

import valvetrain as vt
from valvetrain.scan.answer import BAND, ScanAnswer

trimesh = pytest.importorskip("trimesh")
FORMS = ("stl", "stl_ascii", "ply", "obj")
#: Meshes of `make test`, and of the long family.
FEW, ALL = (0, 2), range(100, 160)


def spring(draw, ground, hand, taper):
    """A mesh (mm), and its wire diameter, length and turns."""
    wire, turns = draw.uniform(2.5, 5.0), draw.uniform(5.5, 9.0)
    mean, pitch = wire * draw.uniform(5, 8), wire * draw.uniform(1.6, 2.4)
    sides, stations = int(draw.integers(14, 26)), int(turns * draw.integers(30, 60))
    fine, coil = np.linspace(0, turns, 20001), np.linspace(0, turns, stations)
    rise = np.interp(
        fine,
        [0, 0.75, 1.25, turns - 1.25, turns - 0.75, turns],
        [wire, wire, pitch, pitch, wire, wire],
    )
    height = np.interp(
        coil, fine, np.concatenate([[0], np.cumsum((rise[1:] + rise[:-1]) / 2 * np.diff(fine))])
    )
    radius, angle = (
        mean / 2 * (1 - taper * np.clip(2 * coil / turns - 1, 0, 1) ** 2),
        2 * np.pi * hand * coil,
    )
    out = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    axis = radius[:, None] * out + np.outer(height, [0, 0, 1])
    along = np.gradient(axis, coil, axis=0, edge_order=2)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    out -= np.sum(out * along, axis=1, keepdims=True) * along
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    around = 2 * np.pi * np.arange(sides) / sides
    ring = (
        np.cos(around)[:, None] * out[:, None]
        + np.sin(around)[:, None] * np.cross(along, out)[:, None]
    )
    first, side = (
        one.ravel()
        for one in np.meshgrid(np.arange(stations - 1) * sides, np.arange(sides), indexing="ij")
    )
    here, after = first + side, first + (side + 1) % sides
    fan, last = np.arange(1, sides - 1), (stations - 1) * sides
    faces = np.vstack([
        np.column_stack([here, here + sides, after]), np.column_stack([after, here + sides, after + sides]),
        np.column_stack([0 * fan, fan + 1, fan]), last + np.column_stack([0 * fan, fan, fan + 1]),
    ])  # fmt: skip
    mesh = trimesh.Trimesh((axis[:, None] + wire / 2 * ring).reshape(-1, 3), faces, process=False)
    for level, up in ((0.0, 1.0), (height[-1], -1.0)) if ground else ():
        corners, faces = trimesh.intersections.slice_faces_plane(
            mesh.vertices, mesh.faces, [0, 0, up], [0, 0, level]
        )[:2]
        rim = corners[np.abs(corners[:, 2] - level) < 1e-7]
        flat = Delaunay(rim[:, :2]).simplices
        flat = flat[cKDTree(axis).query(rim[flat].mean(axis=1))[0] < wire / 2]
        mesh = trimesh.Trimesh(np.vstack([corners, rim]), np.vstack([faces, flat + len(corners)]))
    return mesh, {"wire": wire, "length": height[-1] + (0 if ground else wire), "turns": turns}


def outcomes(folder, seed):
    """(size, error and printed band) of a mesh, the codes of its findings, and whether ends and hand are right."""
    draw = np.random.default_rng(seed)
    ground, hand, taper = bool(seed % 3), 1 if draw.random() < 0.5 else -1, draw.choice([0.0, 0.25])
    mesh, truth = spring(draw, ground, hand, taper)
    noise, inch = draw.choice([0.0, 0.005, 0.02, 0.05]), seed % 5 == 0
    corners = mesh.vertices + (draw.normal(0, noise, mesh.vertices.shape) if noise else 0.0)
    turned = corners @ trimesh.transformations.random_rotation_matrix(draw.random(3))[
        :3, :3
    ].T + draw.normal(0, 30, 3)
    form = FORMS[seed % 4]
    file = folder / f"mesh{seed}.{form[:3]}"
    trimesh.Trimesh(turned / (25.4 if inch else 1.0), mesh.faces, process=False).export(
        file, file_type=form
    )
    scan = vt.scan.spring_from_scan(file, unit="inch" if inch else "mm")
    found = {"wire": scan.section.diameter, "length": scan.free_length, "turns": scan.total_coils}
    scale = {"wire": 1e3, "length": 1e3, "turns": 1.0}
    rows = {
        name: (scale[name] * value - truth[name], BAND * scale[name] * spread)
        for name, (value, spread) in found.items()
    }
    right = scan.hand == ("right" if hand > 0 else "left") and scan.definition.lower_end.kind == (
        "closed-ground" if ground else "closed"
    )
    return rows, ScanAnswer(scan).findings.codes, right


@pytest.mark.parametrize("seed", FEW)
@pytest.mark.slow
def test_a_mesh_gives_its_spring(tmp_path, seed):
    rows, codes, right = outcomes(tmp_path, seed)
    assert right and not {"Y101", "Y102"} & set(codes)
    for name, (error, band) in rows.items():
        assert abs(error) <= 2 * band, name
    assert rows["length"][1] < 0.1 and rows["turns"][1] < 0.02 and rows["wire"][1] < 0.02


@pytest.mark.long
def test_the_truth_is_in_the_bands_of_sixty_meshes(tmp_path):
    """95 % of the bands hold it (binomial test at 1 %), and the median band is at most four times the median error."""
    found = [outcomes(tmp_path, seed) for seed in ALL]
    assert all(right for _, _, right in found)
    for name in ("wire", "length", "turns"):
        error, band = np.abs([rows[name] for rows, _, _ in found]).T
        held = int(np.sum(error <= band))
        assert binom.cdf(held, len(found), 0.95) > 0.01, (name, held)
        assert np.median(band) <= 4 * np.median(error) + 1e-3, name
