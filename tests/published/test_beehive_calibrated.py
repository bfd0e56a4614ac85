"""Published: what the calibrated spring of gu2021-beehive meets of its source, and that docs/beehive.md
prints what comes out.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from beehive_page import (
    AIMS,
    EQUATIONS,
    PAGE,
    ROD,
    SETTLED,
    misses_of,
    shown,
    value_of,
)
from beehive_sentences import peak_text, place_text, spike_text

import valvetrain as vt
from architecture.layout import ROOT
from valvetrain.solution.study import Study

RPM = np.pi / 30


@pytest.fixture(scope="module")
def study() -> Study:
    return vt.simulate("gu2021-beehive", workers=1)


def printed() -> dict[str, tuple[str, ...]]:
    """First cell of each row of the table of aims -> its other cells."""
    table = PAGE.read_text(encoding="utf-8").split("<!-- aims -->")[1].split("<!-- end")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line.startswith("| ")]
    return {row[0]: tuple(row[1:]) for row in rows[1:]}


def test_the_page_prints_every_aim_as_it_comes_out(study: Study) -> None:
    """Within 2 % of the printed number (spikes 10 %), and the same words on what is met."""
    rows = printed()
    assert len(rows) == len(AIMS)
    stale = []
    for aim in AIMS:
        where = f", {aim.rpm} rpm" if aim.rpm else ""
        cells, value = rows[f"{aim.group}: {aim.what}{where}"], value_of(study, aim)
        if value is None:
            stale += [] if cells[2] == "none" else [aim]
            continue
        room = 0.1 if aim.group in ("spikes", "durations") else 0.02
        near = abs(float(cells[2]) - value) <= room * abs(value) + 10.0 ** -len(
            shown(value, aim.unit).partition(".")[2]
        )
        if not near or (cells[3] == "yes") != aim.met(value):
            stale.append(aim)
    assert not stale, "run python scripts/beehive_page.py"


def test_the_calibrated_spring_misses_no_aim_by_more_than_the_page_says(study: Study) -> None:
    """Example: the largest miss, in half widths of an aim."""
    worst = float(misses_of(study).max())
    words = r"none of its aims is missed by more than ([\d.]+) half widths"
    (stated,) = re.findall(words, PAGE.read_text(encoding="utf-8"))
    assert float(stated) - 0.1 < worst <= float(stated)


NUMBER = re.compile(r"\d+(?:\.\d+)?")


def test_sentences_of_numbers_are_as_they_come_out(study: Study) -> None:
    """Example: the same words, and numbers within 10 %; a difference of two of them is left out."""
    later = vt.load_case("gu2021-beehive", {"operation.cycles": SETTLED})
    settled = vt.simulate(later, "8000 rpm", spring_models=[ROD], workers=1).solutions[0].quantities
    run, page = study.solution(ROD, 8000 * RPM).quantities, PAGE.read_text(encoding="utf-8")
    for mark, text in (("spike", spike_text(study)), ("peak", peak_text(run, settled))):
        there = page.split(f"<!-- {mark} -->\n")[1].split("\n<!-- end")[0]
        there, text = (re.sub(r"\d+ N (below|above) the", r"\1", one) for one in (there, text))
        assert NUMBER.sub("#", there) == NUMBER.sub("#", text), "run python scripts/beehive_page.py"
        found, made = (np.array(NUMBER.findall(one), dtype=float) for one in (there, text))
        assert found == pytest.approx(made, rel=0.1, abs=1e-3), "run python scripts/beehive_page.py"


def test_other_pages_print_the_spike_of_the_page() -> None:
    """Contract: README and pages repeat numbers of the table of aims."""
    row, angle = printed()["spikes: Stage III, 8000 rpm"], printed()["angles: spike, 8000 rpm"][2]
    for name, words in (
        ("README.md", f"calibrated {row[2]} N, blind prediction {row[4]} N, for {row[0]}"),
        ("docs/model-against-test.md", f"the spike {row[2]} N at {angle} degrees"),
        ("docs/theory/coil-contact.md", f"Its spike there is {row[2]} N without friction"),
    ):
        assert words in (ROOT / name).read_text(encoding="utf-8"), (
            "run python scripts/beehive_page.py"
        )


def test_no_value_of_the_calibrated_case_is_called_a_prediction(study: Study) -> None:
    assert {row.role for row in study.comparisons} == {"calibration", "check"}
    assert all(row.reading for row in study.comparisons)


#: Names of the case for the peaks of the source's modal model, which the page finds on the lift by its equations.
BY_EQUATIONS = {
    "stage_2": "stage_2_peak_force", "stage_2_first": "stage_2_first_peak_force",
    "stage_2_second": "stage_2_second_peak_force", "stage_3": "stage_3_peak_force",
}  # fmt: skip


def test_the_role_calibration_is_that_of_the_aims() -> None:
    """Contract: a printed value is calibration exactly where the table of the page aims at it."""
    aims = {
        (aim.model == EQUATIONS, aim.rpm, BY_EQUATIONS[aim.quantity] if aim.model == EQUATIONS else aim.quantity)
        for aim in AIMS
    }  # fmt: skip
    roles = {
        (value.model == "analytical modal", round((value.engine_speed or 0.0) / RPM), str(value.quantity))
        for value in vt.load_case("gu2021-beehive").published
        if value.role == "calibration"
    }  # fmt: skip
    assert roles == aims


def test_the_page_says_where_contacts_were_read(study: Study) -> None:
    """Example: the same words, angles within a degree."""
    there = PAGE.read_text(encoding="utf-8").split("<!-- places -->\n")[1].split("\n<!-- end")[0]
    text = place_text(study)
    assert NUMBER.sub("#", there) == NUMBER.sub("#", text), "run python scripts/beehive_page.py"
    found, made = (np.array(NUMBER.findall(one), dtype=float) for one in (there, text))
    assert found == pytest.approx(made, abs=1.0), "run python scripts/beehive_page.py"


def test_where_the_peak_at_8000_rpm_lies_is_among_the_findings(study: Study) -> None:
    (found,) = [one for one in study.findings if "the peak force is in Stage III" in one.statement]
    run = study.solution("finite-element", 8000 * RPM).quantities
    holds = run["stage_3_peak_force"] > run["stage_2_peak_force"]
    assert (found.verdict == "agrees") == holds and found.statement.startswith("8000 rpm")


def test_two_maxima_agree_by_their_heights_not_by_their_order(study: Study) -> None:
    (found,) = [one for one in study.findings if "two force maxima" in one.statement]
    run = study.solution("finite-element", 8000 * RPM).quantities
    names = [f"stage_2_{word}_force" for word in ("first_peak", "valley", "second_peak")]
    near = all(
        abs(run[name] / value - 1) <= 0.05
        for name, value in zip(names, (940, 580, 1200), strict=True)
    )
    assert found.verdict.startswith("agrees") == near


def test_a_case_of_ones_own_that_names_the_study_is_compared_with_it(tmp_path) -> None:
    """Contract: no published table of its own, all roles are checks."""
    text = (ROOT / "src/valvetrain/parameters/library/gu2021-beehive.toml").read_text("utf-8")
    own = tmp_path / "own.toml"
    own.write_text(text.partition("[[published]]")[0], encoding="utf-8")
    made = vt.simulate(str(own), "8000 rpm", spring_models=["finite-element"], workers=1)
    assert made.comparisons and {row.role for row in made.comparisons} == {"check"}
    assert {row.quantity for row in made.comparisons} >= {"preload", "stage_2_valley_force"}
    assert made.findings
