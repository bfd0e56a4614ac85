"""Unit: the command ``spring-card``, tables of a spring tester in every form, and the spring it
writes.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

from unit.cli_parts import call as invoke
from unit.cli_parts import typed
from valvetrain.errors import InputError
from valvetrain.measured.force_height import read_force_height
from valvetrain.parameters.loading import load_case
from valvetrain.spring_card.fit import forces_at

CARD = ("spring-card", "--wire-diameter", "4.4 mm", "--outer-diameter", "32 mm")
LOADS = ("--installed", "46 mm, 350 N", "--open-load", "34 mm, 830 N")
HEIGHTS = np.linspace(50.0, 38.0, 13)
FORCES = 40.0 * (55.0 - HEIGHTS)


def table(tmp_path, head="height [mm]; force [N]", rows=None, mark=";"):
    file = tmp_path / "table.txt"
    rows = np.column_stack([HEIGHTS, FORCES]) if rows is None else rows
    file.write_text(
        "\n".join([head, *(mark.join(f"{value:.6g}" for value in row) for row in rows)]) + "\n"
    )
    return file


def test_a_card_gives_a_spring_that_a_case_takes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    data = json.loads(
        invoke(
            *CARD, *LOADS, "--solid-height", "29 mm", "--name", "outer", "--json", "--output", "out"
        ).stdout
    )
    assert data["card"]["installed_load"] == pytest.approx({"asked": 350, "found": 350}, rel=1e-3)
    assert data["card"]["solid_height"] == {
        "asked": 29e-3,
        "found": pytest.approx(30.76e-3, abs=0.02e-3),
    }
    verdict = data["findings"][0]
    assert (verdict["code"], verdict["quantity"]) == ("Z108", "solid_height")
    assert {path.rsplit("/")[-1] for path in data["files"]} >= {
        "spring.toml",
        "report.html",
        "run.json",
    }
    spring = load_case("out/spring.toml").springs[0]
    assert spring.name == "outer" and spring.installed_height == pytest.approx(46e-3, abs=1e-9)
    assert forces_at(spring.wire, [46e-3, 34e-3]) == pytest.approx((350, 830), rel=1e-3)


def test_inches_and_pounds_are_the_same_card(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    inches = (
        "--installed",
        f"{46 / 25.4} in, {350 / 4.4482216152605} lbf",
        "--open-load",
        f"{34 / 25.4} in, {830 / 4.4482216152605} lbf",
    )
    found = [
        json.loads(invoke(*CARD, *loads, "--json").stdout)["card"]["total_coils"]["found"]
        for loads in (LOADS, inches)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-9)


def test_a_table_gives_rate_length_and_pitch_with_intervals(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = table(tmp_path)
    shown = invoke(
        "spring-card",
        str(file),
        *typed(
            "--wire-diameter '4.2 mm' --outer-diameter '30.2 mm' --installed-height '48 mm' --json"
        ),
    )
    data = json.loads(shown.stdout)
    assert (
        data["rate"]["value"] == pytest.approx(40e3, rel=5e-3)
        and data["rate"]["standard_deviation"] > 0
    )
    assert data["preload"]["value"] == pytest.approx(280, rel=5e-3)
    assert not data["reaches_coil_bind"] and len(data["pitch"]) >= 3
    codes = [one["code"] for one in data["findings"]]
    assert codes[0] == "Z111" and "Z140" in codes


@pytest.mark.parametrize(("head", "rows", "mark"), [
    ("height [mm]; force [N]", np.column_stack([HEIGHTS, FORCES]), ";"), ("Kraft [N]\tHöhe [mm]", np.column_stack([FORCES, HEIGHTS]), "\t"),
    ("force (lbf), length (in)", np.column_stack([FORCES / 4.4482216152605, HEIGHTS / 25.4]), ", "),
    ("height [mm]; load [N]", np.column_stack([HEIGHTS, -FORCES]), ";"),
], ids=("heights first", "forces first", "inches", "forces of the other sign"))  # fmt: skip
def test_a_table_is_read_in_any_form(tmp_path, head, rows, mark):
    found = read_force_height(table(tmp_path, head, rows, mark))
    assert found.heights == pytest.approx(
        1e-3 * HEIGHTS, rel=1e-5
    ) and found.forces == pytest.approx(FORCES, rel=1e-5)


def test_compressions_make_heights_by_the_free_length(tmp_path):
    file = table(tmp_path, "deflection [mm]; force [N]", np.column_stack([55.0 - HEIGHTS, FORCES]))
    assert read_force_height(file).rate_at(-10e-3).value == pytest.approx(40e3, rel=1e-4)
    assert read_force_height(file, free_length=55e-3).heights == pytest.approx(
        1e-3 * HEIGHTS, rel=1e-6
    )


def test_loading_and_unloading_are_told_apart_and_averaged(tmp_path):
    """Friction of 3 N: 3 N more on the way down, 3 N less on the way up."""
    rows = np.column_stack(
        [np.append(HEIGHTS, HEIGHTS[::-1]), np.append(FORCES + 3, FORCES[::-1] - 3)]
    )
    found = read_force_height(table(tmp_path, rows=rows))
    assert found.forces[:-1] == pytest.approx(FORCES[:-1], abs=0.01)
    assert (
        found.hysteresis == pytest.approx(3, rel=0.01) and "loading and unloading" in found.notes[0]
    )


@pytest.mark.parametrize(("more", "words"), [
    ((), "a card has two loads"), (("--installed", "46 mm"), "a card has two loads"),
    (("--installed", "46 mm, 350 mm", "--open-load", "34 mm, 830 N"), "force"), ((*LOADS, "--installed-height", "40 mm"), "where there is no table"),
    ((*LOADS, "--material", "cheese"), "not in the library"), ((*LOADS, "--mass", "9 g"), "inactive turns"),
])  # fmt: skip
def test_wrong_cards_are_refused_in_one_sentence(tmp_path, monkeypatch, more, words):
    monkeypatch.chdir(tmp_path)
    shown = invoke(*CARD, *more)
    assert (
        shown.exit_code == 2
        and words in " ".join(shown.output.split())
        and not list(tmp_path.iterdir())
    )


@pytest.mark.parametrize(("head", "rows", "words"), [
    ("a; b", None, "which of its 2 columns is what"), ("height; force", None, "unit of its length"),
    ("height [mm]; force [kN/m]", None, "no unit of force"),
    ("height [mm]; force [mm]", None, r"^force_unit: 'mm' is no unit of force; use one such as N$"),
    ("height [mm]; force [stone]", None, r"^force_unit: 'stone' is no unit of force; use one such as N$"),
    ("height [N]; force [N]", None, r"^length_unit: 'N' is no unit of length; use one such as mm$"),
    ("height [furlong]; force [N]", None, r"^length_unit: 'furlong' is no unit of length; use one such as mm$"),
    ("height [mm]; force [N]", np.column_stack([HEIGHTS, FORCES])[:2], "3 or more"),
    ("height [mm]; force [N]", np.column_stack([HEIGHTS, FORCES[::-1]]), "does not rise as the height falls"),
    ("height [mm]; force [N]; load [N]", np.column_stack([HEIGHTS, FORCES, HEIGHTS]), "which of its 3 columns is what"),
])  # fmt: skip
def test_tables_that_leave_questions_are_refused_in_one_sentence(tmp_path, head, rows, words):
    with pytest.raises(InputError, match=words):
        read_force_height(table(tmp_path, head, rows))


def test_a_table_and_loads_are_not_taken_together(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = invoke(*CARD, *LOADS, str(table(tmp_path)))
    assert shown.exit_code == 2 and "a table holds the loads" in shown.output
    case = invoke("spring-card", "engine.toml")
    assert case.exit_code == 2 and "valvetrain static engine.toml" in case.output
    for more, words in (
        (("--closes", "middle"), "use lower, upper, both"),
        (("--installed-height", "60 mm"), "the table holds heights"),
    ):
        shown = invoke(*CARD, str(table(tmp_path)), *more)
        assert shown.exit_code == 2 and words in " ".join(shown.output.split())
