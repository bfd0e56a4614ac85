"""Unit: points of a scan out of PLY, STL, OBJ and text, whole, and refused in one
sentence where they are damaged.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.scan.clouds import open_cloud
from valvetrain.scan.reconstruct import draw_points

POINTS = np.random.default_rng(3).uniform(-30, 30, (1800, 3)).round(3)
HEAD = "ply\nformat {form} 1.0\n{comment}element vertex {count}\nproperty float x\nproperty float y\nproperty float z\n{more}end_header\n"


def head(form="binary_little_endian", count=len(POINTS), more="", comment=""):
    return HEAD.format(form=form, count=count, more=more, comment=comment).encode()


def read(tmp_path, content, name="scan.ply"):
    file = tmp_path / name
    file.write_bytes(content)
    cloud = open_cloud(file)
    return cloud, cloud.points


def rows(mark=" ", form="{:.3f}", comma="."):
    return (
        "\n".join(
            mark.join(form.format(value).replace(".", comma) for value in row) for row in POINTS
        )
        + "\n"
    )


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ply", head() + POINTS.astype("<f4").tobytes()),
        ("b.ply", head("binary_big_endian") + POINTS.astype(">f4").tobytes()),
        ("c.ply", head("ascii") + rows().encode()),
        (
            "d.ply",
            head("ascii", more="element face 1\nproperty list uchar int vertex_indices\n")
            + rows().encode()
            + b"3 0 1 2\n",
        ),
        ("e.xyz", rows().encode()),
        ("f.csv", ("x,y,z\n" + rows(",")).encode()),
        ("g.txt", ("x;y;z\n" + rows(";", comma=",")).encode()),
        ("h.txt", ("# made by a scanner\n" + rows("\t")).encode()),
        ("i.xyz", (f"{len(POINTS)}\n" + rows()).replace("\n", "\r\n").encode()),
        (
            "j.obj",
            ("# cloud\n" + "\n".join("v " + line for line in rows().splitlines()) + "\n").encode(),
        ),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_every_form_gives_its_points(tmp_path, name, content):
    _, points = read(tmp_path, content, name)
    assert points == pytest.approx(POINTS, abs=1e-5)


@pytest.mark.parametrize("kind", ["ply", "ply text", "stl", "stl text", "obj"])
def test_meshes_of_another_library_are_read(tmp_path, kind):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(POINTS, np.arange(len(POINTS)).reshape(-1, 3), process=False)
    word, _, _ = kind.partition(" ")
    more = {"ply text": {"encoding": "ascii"}, "stl text": {"file_type": "stl_ascii"}}.get(kind, {})
    mesh.export(tmp_path / f"mesh.{word}", **more)
    points = open_cloud(tmp_path / f"mesh.{word}").points
    assert np.sort(points, axis=0) == pytest.approx(np.sort(POINTS, axis=0), abs=1e-4)


def test_columns_are_found_by_their_names_and_the_unit_in_brackets(tmp_path):
    text = "nr;z [mm];x [mm];y [mm]\n" + "\n".join(
        f"{k};{z};{x};{y}" for k, (x, y, z) in enumerate(POINTS)
    )
    cloud, points = read(tmp_path, text.encode(), "scan.csv")
    assert cloud.unit == "mm" and points == pytest.approx(POINTS)


@pytest.mark.parametrize(
    ("words", "unit"),
    [("comment units mm\n", "mm"), ("comment unit: in\n", "inch"), ("comment by a scanner\n", "")],
)
def test_the_unit_of_a_ply_file_stands_in_its_comments(tmp_path, words, unit):
    assert read(tmp_path, head(comment=words) + POINTS.astype("<f4").tobytes())[0].unit == unit


def test_other_properties_of_points_are_passed_by(tmp_path):
    more = "property uchar red\nproperty double quality\n"
    rows_ = np.zeros(len(POINTS), [("p", "<f4", 3), ("red", "u1"), ("quality", "<f8")])
    rows_["p"], rows_["quality"] = POINTS, np.nan
    assert read(tmp_path, head(more=more) + rows_.tobytes())[1] == pytest.approx(POINTS, abs=1e-5)


STL = b"\0" * 80 + (2).to_bytes(4, "little")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ply", b""), ("a.ply", b"  \n "), ("a.ply", head(count=10**9) + POINTS.astype("<f4").tobytes()),
        ("a.ply", head("ascii", count=10**14) + rows().encode()), ("a.ply", head("ascii", count=len(POINTS) + 5) + rows().encode()),
        ("a.ply", head(count=0)), ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n"), ("a.ply", b"ply\nformat ascii 1.0\nend_header\n"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float u\nend_header\n1\n"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int x\nend_header\n"),
        ("a.ply", head("ascii").replace(b"float z", b"float z\nproperty float w") + rows().encode() * 2),
        ("a.stl", STL + b"\0" * 60), ("a.stl", b"\0" * 50), ("a.obj", b"v 1 2 3\nv 1 2\n"), ("a.obj", b"# nothing\n"),
        ("a.xyz", b"hello\nworld\n"), ("a.xyz", b"1 2\n3 4\n"), ("a.xyz", b"1 2 3\n4 5 six\n"), ("a.xyz", b"1 2 3\n4 5\n6 7 8 9\n"),
        ("a.xyz", b"\0\1\2\3" * 40), ("a.xyz", b"1 2 3\n" + b"7" * 200_000),
    ],
)  # fmt: skip
def test_damaged_files_are_refused_in_one_sentence(tmp_path, name, content):
    with pytest.raises(InputError) as refused:
        read(tmp_path, content, name)
    assert str(refused.value).count(". ") == 0


def test_what_is_no_file_and_what_is_too_large_are_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="cannot be read: no such file"):
        open_cloud(tmp_path / "none.ply")
    with pytest.raises(InputError, match="no regular file"):
        open_cloud(tmp_path)
    monkeypatch.setattr("valvetrain.scan.clouds.MAX_BYTES", 100)
    with pytest.raises(InputError, match="thin the scan out"):
        read(tmp_path, rows().encode(), "scan.xyz")


def test_a_draw_is_bounded_even_and_the_same_in_any_order():
    points = np.random.default_rng(4).normal(size=(40_000, 3))
    once = draw_points(points, 5000, "scan")
    again = draw_points(points[::-1], 5000, "scan")
    assert (
        np.array_equal(once.points, again.points)
        and len(once.points) == 5000
        and once.read == 40_000
    )
    assert np.abs(once.points.mean(axis=0)).max() < 4 / np.sqrt(5000)
    assert np.abs(once.points.std(axis=0) - 1).max() < 0.05


def test_a_point_that_stands_often_is_drawn_once():
    points = np.random.default_rng(4).normal(size=(2000, 3))
    assert len(draw_points(np.tile(points, (3, 1)), 10_000, "scan").points) == 2000


def test_points_without_numbers_are_counted_and_many_of_them_refused():
    points = np.random.default_rng(4).normal(size=(4000, 3))
    points[::20] = np.nan
    drawn = draw_points(points, 10_000, "scan")
    assert (drawn.broken, len(drawn.points)) == (200, 3800)
    points[::4] = np.inf
    with pytest.raises(InputError, match="of the 4000 points of 'scan' are no numbers"):
        draw_points(points, 10_000, "scan")
    with pytest.raises(InputError, match="holds 100 different points"):
        draw_points(POINTS[:100], 10_000, "scan")
