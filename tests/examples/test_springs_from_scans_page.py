"""Examples: the clouds that docs/springs-from-scans.md names are those the script writes, and its
table is what the script measures.
"""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

import numpy as np

from valvetrain.scan.clouds import open_cloud

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
import sample_scan
from measure_scans import SEEN

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "springs-from-scans.md").read_text(encoding="utf-8")


def test_the_script_writes_the_clouds_that_the_page_names(tmp_path):
    sample_scan.main(tmp_path, 1500)
    named = {
        word.removeprefix("FOLDER/")
        for line in PAGE.splitlines()
        if line.startswith("    valvetrain ")
        for word in shlex.split(line)
        if word.startswith("FOLDER/")
    } | set(re.findall(r"`([\w-]+\.ply)`", PAGE))
    assert named == {"beehive-as-made.ply", "beehive.ply"}
    for name in (*named, "progressive.xyz"):
        cloud = open_cloud(tmp_path / name)
        points = cloud.points
        assert cloud.unit == "mm" and points.shape[1] == 3 and len(points) > 1000
        truth = np.loadtxt(tmp_path / f"{Path(name).stem}-truth.csv", delimiter=",", skiprows=1)
        # most points lie half a wire from the wire axis, which an even look at some of them shows
        near = np.sqrt(np.min(np.sum((points[::40, None] - truth[None]) ** 2, axis=2), axis=1))
        assert 1.8 < np.median(near) < 2.1


def test_the_table_of_the_page_has_every_spring_and_scanner_within_the_target():
    rows = [
        line.strip("| ").split(" | ")
        for line in PAGE.splitlines()
        if re.match(r"\| (beehive|cyl|prog|con)", line)
    ]
    assert {row[0] for row in rows} <= set(sample_scan.springs()) and {
        row[1] for row in rows
    } == set(SEEN)
    assert len(rows) == 20 and all(float(row[3]) < 20 for row in rows)
    assert all(float(row[2]) < 20 for row in rows if "as-made" not in row[0])
