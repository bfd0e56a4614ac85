"""``refine`` of a spring: numbers with error bars, as JSON, as a table and as a page, and what it
refuses.
"""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from unit.cli_parts import PUBLISHED, SMALL, call, sentence
from valvetrain.parameters.loading import parse_case
from valvetrain.runs.api import simulate
from valvetrain.runs.error_bars import Uncertainty, UncertaintyStudy
from valvetrain.views.page import data_of
from valvetrain.views.refinement import RefineAnswer
from valvetrain.views.results import figures_of


@pytest.fixture
def small(tmp_path, monkeypatch):
    """The small case in the working folder, on meshes of 8, 12 and 18 elements per coil."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(
        SMALL.replace("elements_per_coil = 6", "elements_per_coil = 8")
    )
    return tmp_path


def test_error_bars_of_the_headline_numbers(small):
    result = call("refine", "small.toml", "--output", "out", "--json", "--workers", "1")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert (
        data["command"] == "refine"
        and data["completed"]
        and data["elements_per_coil"] == [8, 12, 18]
    )
    rows = {
        (row["quantity"], row["engine_speed"] and row["engine_speed"]["value"]): row
        for row in data["uncertainties"]
    }
    assert {("preload", None), ("mode_1_frequency", None), ("peak_spring_force", 9000.0)} <= set(
        rows
    )
    own, fine = (numbers(mesh) for mesh in (8, 36))
    for (name, speed), row in rows.items():
        if name not in ("preload", "peak_spring_force"):
            continue
        # the number is that of the case's own mesh, and what a far finer mesh changes stays within
        # its error bar
        assert row["value"]["value"] == pytest.approx(own[name], rel=1e-9), speed
        assert 0 < abs(fine[name] - own[name]) <= row["numerical_uncertainty"]["value"]
        assert abs(row["extrapolated"]["value"] - fine[name]) < 0.5 * abs(own[name] - fine[name])
        if name != "preload":
            low, high = (row["range"][side]["value"] for side in ("low", "high"))
            assert low <= row["value"]["value"] <= high and row["range"]["by"]
    told = list(
        csv.reader((small / "out" / "uncertainty.csv").read_text(encoding="utf-8").splitlines())
    )
    assert {line[0] for line in told[1:]} >= {
        name for name, _ in rows
    } and "engine speed [rpm]" in " ".join(told[0])
    page = data_of((small / "out" / "report.html").read_text(encoding="utf-8"))
    assert page is not None and set(page) == {"data-bars"}
    known = [row for row in data["uncertainties"] if row["value"]["value"]]
    largest = max(known, key=size)
    assert [one["code"] for one in data["findings"]] == ["X103"]
    assert data["findings"][0]["quantity"] == largest["quantity"]
    assert data["findings"][0]["bar"] == largest["numerical_uncertainty"]


def size(row: dict) -> float:
    """The error bar as a share of the value."""
    return row["numerical_uncertainty"]["value"] / abs(row["value"]["value"])


def refined_with(*rows: Uncertainty, failures: tuple[str, ...] = ()) -> list[str]:
    record = parse_case(SMALL, name="small").record()
    study = UncertaintyStudy(record, (8, 12, 18), rows, {}, failures)
    return [one.code for one in RefineAnswer(study).findings]


def test_each_rule_of_a_refinement_on_rows_that_hit_and_rows_that_do_not():
    still = (300.0, 300.0)
    good = Uncertainty("preload", None, 300.0, 1.5, 2.0, 299.0, 0.0, still, still)
    wild = replace(good, quantity="peak_clash_force", numerical=200.0)
    moved = replace(good, quantity="peak_clash_force", contact_stiffness=(250.0, 310.0))
    assert refined_with(good) == ["X103"] and refined_with() == ["X101"]
    assert refined_with(good, wild) == ["X102"]
    assert refined_with(good, moved) == ["X103"]
    rough = replace(wild, numerical=0.2 * wild.value)
    assert refined_with(good, rough) == ["X104"]
    far = replace(moved, contact_stiffness=(200.0, 310.0))
    assert refined_with(good, far) == ["X105"]
    assert refined_with(rough, far)[0] == "X104"
    assert refined_with(good, failures=("mesh 18: diverged",)) == ["X103", "X110"]


def test_the_share_of_the_verdict_stands_in_the_first_row():
    """Also where contact constants move ten other numbers further."""
    still, wide = (300.0, 300.0), (100.0, 500.0)
    least = Uncertainty("preload", None, 300.0, 27.6, 2.0, 299.0, 0.0, still, still)
    names = [f"mode_{place}_frequency" for place in range(1, 12)]
    more = [replace(least, quantity=one, numerical=1.0, contact_stiffness=wide) for one in names]
    record = parse_case(SMALL, name="small").record()
    answer = RefineAnswer(UncertaintyStudy(record, (8, 12, 18), (*more, least), {}, ()))
    assert answer.verdict.fields["share"] == "9.2 %" and len(answer.lines) == 10
    assert answer.lines[0].cells[1].endswith(" 9.2 %")


def test_labels_of_the_figure_fit_a_phone():
    """One line of "minimum cam contact force while open, 6000 rpm" was cut at 390 px."""
    row = Uncertainty("minimum_cam_contact_force", 6000 * np.pi / 30, 951.0, 130.0, 2.0, 950.0, 0.0, (940.0, 960.0), (741.0, 1169.0))  # fmt: skip
    answer = RefineAnswer(UncertaintyStudy(parse_case(SMALL, name="small").record(), (), (row,), {}, ()))  # fmt: skip
    (label,) = figures_of(answer)["bars"].data[0].y
    assert (
        label.replace("<br>", " ").endswith("6000 rpm") and max(map(len, label.split("<br>"))) <= 24
    )


def numbers(elements_per_coil: int) -> dict[str, float]:
    """Quantities of a run of the small case on another mesh."""
    case = parse_case(
        SMALL.replace("elements_per_coil = 6", f"elements_per_coil = {elements_per_coil}"),
        name="small",
    )
    study = simulate(case, models=("finite-element",), workers=1)
    return {key.name: value for key, value in study.quantities.items()}


def test_what_cannot_be_refined_is_told_in_a_sentence(small):
    (small / "still.toml").write_text(SMALL.split("[lift_law]")[0])
    assert "[lift_law]" in sentence(call("refine", "still.toml", "--output", "out"))
    (small / "out").mkdir()
    (small / "out" / "mine.txt").write_text("mine")
    (small / "told.toml").write_text(SMALL + PUBLISHED)
    refused = call("refine", "told.toml", "--output", "out")
    assert refused.exit_code != 0 and (small / "out" / "mine.txt").read_text() == "mine"
