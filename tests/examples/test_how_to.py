"""The guides of docs/how-to: each has one command that runs, one picture of the package's own, and
numbers that the command gives.
"""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from how_to_parts import FOLDER, PAGES, ROOT, Guide, holds, number_of, rows_of_study
from valvetrain import study
from valvetrain.explore.requests import Identify, Optimise, Study
from valvetrain.measured import read_lift
from valvetrain.system.build import build
from valvetrain.views.results import answer_of

#: Guides whose command takes seconds: asked by make test-long.
LONG = ("01", "02", "03", "05", "06", "07", "08", "15", "16")


CASES = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.long] if path.name[:2] in LONG else [])
    for path in PAGES
]


@pytest.mark.parametrize("path", CASES)
def test_a_guide_prints_what_its_command_gives(path, tmp_path, monkeypatch):
    guide = Guide(path)
    monkeypatch.chdir(tmp_path)
    guide.write_files()
    whole = os.environ.get("VALVETRAIN_LONG") == "1"
    # Of a study the points that the page prints are enough; the whole command runs with the long
    # ones.
    answer = (
        rows_of_study(guide) if guide.words[0] == "study" and not whole else guide.answer(tmp_path)
    )
    missed = [
        f"{row.quantity} {row.place}: {row.value} {row.unit}, computed {number_of(answer, row):.6g}"
        for row in guide.rows
        if not holds(answer, row)
    ]
    assert not missed and len(guide.rows) >= 3


def test_the_guide_on_nested_springs_prints_what_the_study_of_detuning_gives():
    """Each row of the page within its digits, and the sentence that the page quotes."""
    text = (FOLDER / "06-nested-springs.md").read_text(encoding="utf-8")
    table = study(ROOT / "examples" / "how-to" / "detuning.toml", workers=1)
    mass = 1e3 * table.column("train.springs.nested-cards.1.mass")
    names = ("inner_surge_frequency", "surge_amplitude_force", "minimum_spring_force")
    rows = re.findall(r"^\| ([\d.]+) g[^|]*\| (\d+) Hz \|[^|]*\| (\d+) N \| (\d+) N \|$", text, re.MULTILINE)  # fmt: skip
    assert len(rows) == 5
    for given, *printed in rows:
        place = int(np.argmin(np.abs(mass - float(given))))
        found = [table.column(name)[place] for name in names]
        assert [f"{value:.0f}" for value in found] == printed
    verdict = answer_of(table).verdict
    assert verdict.code == "J112"
    assert f"up to {verdict.fields['point']}: {verdict.value:.1f} N" in text


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_what_is_copied_from_a_guide_runs_in_an_empty_folder(path, tmp_path, monkeypatch):
    """Contract: the files named cases by a path of the repository. Searches and studies are read and
    laid out, cases are built; the numbers are those of the test above."""
    guide = Guide(path)
    monkeypatch.chdir(tmp_path)
    for name, text in guide.files.items():
        Path(name).write_text(text, encoding="utf-8")
        (example,) = (ROOT / "examples").rglob(name)
        known = example.read_text(encoding="utf-8")
        assert text == known or tomllib.loads(text) == tomllib.loads(known)
    kind, file, *_ = guide.words
    if kind == "study":
        plan = Study.read({"file": file}).plan
        assert len(plan.draws()) > 1 and plan.runs
    elif kind == "optimise":
        assert Optimise.read({"file": file}).plan.measures
    elif kind == "identify":
        assert Identify.read({"file": file}).plan.fitted.targets
    elif kind == "lift":
        assert read_lift(Path(file))
    else:
        assert build(file).members
