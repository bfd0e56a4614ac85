"""Property: whatever bytes a file holds, a scan is read, or refused in one sentence, in bounded
memory and without a traceback.
"""

from __future__ import annotations

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from valvetrain.errors import InputError
from valvetrain.scan.clouds import open_cloud

CALM = settings(
    max_examples=120,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
ROWS = "\n".join(f"{k}.5 {-k} {k % 7}" for k in range(40)).encode()
FORMS = {
    "a.ply": b"ply\nformat ascii 1.0\nelement vertex 40\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    + ROWS,
    "b.ply": b"ply\nformat binary_little_endian 1.0\nelement vertex 20\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    + np.arange(60, dtype="<f4").tobytes(),
    "c.stl": b"\0" * 80 + (3).to_bytes(4, "little") + bytes(range(150)),
    "d.stl": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 1\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n",
    "e.obj": b"v 1 2 3\nv 3 4 5\nf 1 2 1\n",
    "f.csv": b"x [mm];y [mm];z [mm]\n" + ROWS.replace(b" ", b";"),
}


def outcome(folder, name, content):
    """Points, or the sentence that refuses them."""
    file = folder / name
    file.write_bytes(content)
    try:
        points = open_cloud(file).points
    except InputError as error:
        text = str(error)
        assert text and "\n" not in text and len(text) < 400
        return None
    assert points.ndim == 2 and points.shape[1] == 3
    return points


@CALM
@given(content=st.binary(max_size=400), name=st.sampled_from(sorted(FORMS)))
def test_any_bytes_are_read_or_refused(tmp_path, content, name):
    outcome(tmp_path, name, content)


@CALM
@given(
    name=st.sampled_from(sorted(FORMS)),
    cut=st.floats(0, 1),
    place=st.floats(0, 1),
    put=st.binary(min_size=0, max_size=6),
    take=st.integers(0, 6),
)
def test_damaged_and_truncated_files_are_read_or_refused(tmp_path, name, cut, place, put, take):
    content = FORMS[name][: int(np.ceil(cut * len(FORMS[name])))]
    at = int(place * len(content))
    outcome(tmp_path, name, content[:at] + put + content[at + take :])


@CALM
@given(
    count=st.integers(0, 10**17),
    form=st.sampled_from(["ascii", "binary_little_endian", "binary_big_endian"]),
)
def test_a_declared_size_is_never_taken_before_the_file_has_it(tmp_path, count, form):
    """A head of 10^17 points would ask for an exabyte."""
    content = (
        FORMS["b.ply"]
        .replace(b"vertex 20", f"vertex {count}".encode())
        .replace(b"binary_little_endian", form.encode())
    )
    found = outcome(tmp_path, "a.ply", content)
    assert found is None or len(found) == count <= 20


@CALM
@given(count=st.integers(0, 2**32 - 1))
def test_facets_of_an_stl_file_are_counted_by_its_size(tmp_path, count):
    found = outcome(
        tmp_path, "a.stl", FORMS["c.stl"][:80] + count.to_bytes(4, "little") + FORMS["c.stl"][84:]
    )
    assert found is None or len(found) == 3 * count <= 9
