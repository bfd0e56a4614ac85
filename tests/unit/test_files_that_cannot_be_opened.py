"""Unit: what every reader of a file says of a name that is none, of nothing there, of a folder, and
of an empty file.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.explore.requests import Identify
from valvetrain.film.frames import open_film
from valvetrain.measured.tables import read_content
from valvetrain.parameters.loading import load_case, read_text
from valvetrain.rig.reader import read_recording
from valvetrain.scan.clouds import open_cloud
from valvetrain.solution.atomic import checked_content

#: Reader -> words about a name that is none, nothing there, a folder, an empty file (None: read as
#: it is).
NO_NAME, GONE = (
    "cannot be read: the name is no file name; check the name",
    "cannot be read: no such file or directory; check the name",
)
READERS = {
    "recording": (
        read_recording,
        NO_NAME,
        GONE,
        "is no regular file",
        "is empty; export the recording again",
    ),
    "scan": (open_cloud, NO_NAME, GONE, "is no regular file", "is empty; export the scan again"),
    "film": (open_film, NO_NAME, GONE, "", "is empty; export the film again"),
    "table": (
        lambda path: read_content(path, 100, "table"),
        NO_NAME,
        GONE,
        "is a folder",
        "is empty; export the table again",
    ),
    "case": (
        load_case,
        "a case is called by the name",
        "there is no file",
        "is a folder",
        "at least one of",
    ),
    "identification": (
        lambda path: Identify.read({"file": path}).plan,
        "(bad path)",
        "there is no file",
        "is a folder",
        "case",
    ),
    "plan": (
        lambda path: read_text(path, "plan"),
        "(bad path)",
        "there is no file",
        "is a folder",
        None,
    ),
    "result": (
        checked_content,
        "",
        "no such file; check the path",
        "no such file; check the path",
        None,
    ),
}


@pytest.mark.parametrize("reader", READERS)
def test_a_file_that_is_none_is_refused_in_one_sentence(reader, tmp_path):
    read, no_name, gone, folder, empty = READERS[reader]
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty.toml").write_bytes(b"")
    for name, words in (
        ("a\0b", no_name),
        ("none.toml", gone),
        ("folder", folder),
        ("empty.toml", empty),
    ):
        if words is None:
            read(tmp_path / name)
            continue
        with pytest.raises(InputError) as refused:
            read(tmp_path / name)
        assert words in str(refused.value) and "\n" not in str(refused.value)
        assert not re.search(r"read: ;|\(\)|None|Errno", str(refused.value)), refused.value


@pytest.mark.skipif(os.name == "nt", reason="modes of files are those of POSIX")
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755, None])
def test_a_file_that_is_replaced_keeps_its_mode(mode, tmp_path):
    path = tmp_path / "case.toml"
    usual = Path(tmp_path / "other")
    usual.write_text("")
    if mode is not None:
        path.write_text("old")
        path.chmod(mode)
    vt.Case("job-t").save(path)
    assert vt.load(path) == vt.Case("job-t")
    assert path.stat().st_mode & 0o777 == (usual.stat().st_mode & 0o777 if mode is None else mode)
