"""A saved run answers from its files.

Evidence: Hooke's law, and a test synthesised from a known curve.
"""

from __future__ import annotations

from dataclasses import replace
from html import escape

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles, write_cycles
from valvetrain.parameters.loading import parse_case
from valvetrain.runs.saved_runs import Inputs, save_run
from valvetrain.views.json import study_json
from valvetrain.views.page import data_of, unpacked
from valvetrain.views.results import answer_of
from valvetrain.workbench.answers import against, saved_study
from valvetrain.workbench.pages.parts import run_part
from valvetrain.workbench.pages.parts import test_part as shown_test
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL


@pytest.fixture(scope="module")
def study():
    return vt.simulate(
        parse_case(SMALL, "small"), "3000, 4000 rpm", models=["massless", "multi-mass"]
    )


@pytest.fixture(scope="module")
def runs(study, tmp_path_factory):
    """A workspace with the study kept twice, the second with a stiffer spring."""
    workspace = Workspace(tmp_path_factory.mktemp("bench"))
    other = vt.simulate(
        parse_case(SMALL.replace("32 N/mm", "40 N/mm"), "small"),
        "4000 rpm",
        models=["massless"],
    )
    found = []
    for name, one, text in (("a", study, SMALL), ("b", other, SMALL.replace("32 N/mm", "40 N/mm"))):
        folder = workspace.runs_folder / "small" / name
        written = vt.write_study(one, folder)
        answer = study_json(one) | {
            "command": "run",
            "created_at": "2026-01-01T00:00:00+00:00",
            "files": [path.name for path in (*written.data, written.page)],
        }
        save_run(folder, Inputs("small", f'name = "small"\n{text}'), answer)
        found.append(workspace.run(f"small/{name}"))
    return found


def test_the_part_of_a_run_says_and_draws_what_its_page_does(runs, study):
    part, answer = run_part(runs[0]), answer_of(study)
    assert escape(answer.verdict.text[1:]) in part["html"]
    for line in answer.lines:
        assert escape(line.label) in part["html"]
    assert unpacked(part["data"]) == data_of(runs[0].page.read_text("utf-8"))


def test_a_run_without_a_page_of_this_kind_is_named(runs, tmp_path):
    (tmp_path / "report.html").write_text("<html>")
    for folder in (tmp_path, tmp_path / "none"):
        with pytest.raises(InputError, match="run it again"):
            run_part(replace(runs[0], folder=folder))


def test_a_test_made_from_a_run_is_not_refuted_and_one_shifted_is(runs, tmp_path):
    study, _ = saved_study(runs[0])
    run = next(
        one
        for one in study.solutions
        if one.label == "multi-mass" and round(one.engine_speed * 30 / np.pi) == 4000
    )
    angle = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    curve = np.interp(angle + run.cam_angle[0], run.cam_angle, run.channel("seat_force"))
    drawn = curve + np.random.default_rng(1).normal(0.0, 5.0, (6, 90))

    def content(values: np.ndarray, cam_speed: float = run.engine_speed / 2) -> bytes:
        cycles = MeasuredCycles(
            "spring_force", "N", angle, values, cam_speed=cam_speed, synthetic=True
        )
        return write_cycles(tmp_path / "test.csv", cycles).read_bytes()

    same, shifted = (against(runs[0], "test.csv", content(one)) for one in (drawn, drawn + 40.0))
    assert [answer_of(one).verdict.code for one in (same, shifted)] == ["T204", "T203"]
    assert escape(answer_of(shifted).verdict.text[1:]) in shown_test(shifted)["html"]
    with pytest.raises(InputError, match="none of the runs is"):
        against(runs[1], "test.csv", content(drawn, 100.0))


@pytest.mark.parametrize("content", [b"", b"\0" * 40, b"hello", b"1,2,3\n", b"x" * 20_000_001])
def test_what_is_no_test_is_refused_by_the_readers_sentence(runs, content):
    with pytest.raises(InputError) as refused:
        against(runs[0], "../../my test.csv", content)
    assert "tmp" not in str(refused.value)
