"""Published: what the calibrated spring of gu2021-beehive meets of its source over the phases of its
samples, and that docs/beehive.md prints what comes out.
"""

from __future__ import annotations

import re
import tomllib

import numpy as np
import pytest
from beehive_study.page import (
    AIMS,
    EQUATIONS,
    PAGE,
    ROD,
    STORED,
    blind_file,
    met_at_every_phase,
    shown,
    spike_samples,
    spike_text,
    unused_text,
    value_of,
)

import valvetrain as vt
from architecture.layout import ROOT
from valvetrain.solution.study import Study

RPM = np.pi / 30


@pytest.fixture(scope="module")
def study() -> Study:
    return vt.simulate("gu2021-beehive", workers=1)


def between(mark: str) -> str:
    return PAGE.read_text("utf-8").split(f"<!-- {mark} -->\n")[1].split("\n<!-- end")[0]


def printed() -> dict[str, tuple[str, ...]]:
    """First cell of each row of the table of values -> its other cells."""
    rows = [line.strip("| ").split(" | ") for line in between("values").splitlines()]
    return {row[0]: tuple(row[1:]) for row in rows if len(row) > 1 and row[0] != "value"}


@pytest.mark.slow
def test_the_page_prints_every_value_as_it_comes_out(study: Study) -> None:
    """Within 2 % of the printed number (spikes 10 %), the same words on what is met, and the counts."""
    rows = printed()
    of_the_rod = [aim for aim in AIMS if aim.model != EQUATIONS]
    assert len(rows) == len(of_the_rod)
    stale = []
    for aim in of_the_rod:
        where = f", {aim.rpm} rpm" if aim.rpm else ""
        cells, value = rows[f"{aim.group}: {aim.what}{where}"], value_of(study, aim)
        assert value is not None
        room = 0.1 if aim.group in ("spikes", "durations") else 0.02
        near = abs(float(cells[1].split()[0]) - value) <= room * abs(value) + 10.0 ** -len(
            shown(value, aim.unit).partition(".")[2]
        )
        if not near or (cells[2] == "yes") != aim.met(value):
            stale.append(aim)
    assert not stale, "run python -m beehive_study.page"
    met = sum(aim.met(value_of(study, aim)) for aim in AIMS)
    always = sum(met_at_every_phase(study, aim) for aim in AIMS)
    assert re.findall(r"\d+", between("values"))[:3] == [str(met), str(len(AIMS)), str(always)]


NUMBER = re.compile(r"\d+(?:\.\d+)?")


def test_sentences_of_numbers_are_as_they_come_out(study: Study) -> None:
    for mark, text in (("spike", spike_text(study)), ("unused", unused_text(study))):
        found, made = (np.array(NUMBER.findall(one), dtype=float) for one in (between(mark), text))
        assert found == pytest.approx(made, rel=0.1, abs=2.5), "run python -m beehive_study.page"


def test_the_range_of_a_comparison_is_what_samples_at_every_phase_show(study: Study) -> None:
    """By hand, on the channel alone: every hundredth of a degree a list of half-degree samples, the
    highest of each after the event.
    """
    run = study.solution(ROD, 8000 * RPM)
    event, degrees = study.lift_event, np.degrees(run.cam_angle - run.cam_angle[0])
    assert event is not None
    late = degrees[:-1] > np.degrees(event.end) + 1
    tops = run.channel("seat_force_finest")[:-1][late].max(axis=0)
    (row,) = [
        one for one in study.comparisons
        if (one.quantity, one.origin) == ("stage_3_peak_force", "solid finite elements")
        and one.engine_speed == pytest.approx(8000 * RPM)
    ]  # fmt: skip
    assert row.samples is not None and row.samples.phases >= 50
    assert [row.samples.low, row.samples.high] == pytest.approx([tops.min(), tops.max()], rel=1e-3)
    assert row.samples.share == pytest.approx(np.mean(tops >= 1430.0), abs=0.03)
    assert row.computed == pytest.approx(np.median(tops), rel=0.02)
    # two collisions: no phase shows what lies between them, so one number cannot stand for all
    assert row.samples.high > 2 * row.samples.low


def test_what_the_blind_spring_computes_stands_beside_the_fitted_number(study: Study) -> None:
    """Contract: the stored file is what the blind case gives now, and every comparison has it."""
    blind = vt.simulate("gu2021-beehive-blind", workers=1)
    stored, now = (tomllib.loads(one) for one in (STORED.read_text("utf-8"), blind_file(blind)))
    assert stored.pop("case") == now.pop("case"), "run python -m beehive_study.page"
    assert {head: set(values) for head, values in stored.items()} == {
        head: set(values) for head, values in now.items()
    }
    for head, values in stored.items():
        assert list(values.values()) == pytest.approx(list(now[head].values()), rel=0.01), head
    predicted = {
        (one.quantity, one.engine_speed, one.origin): one.computed for one in blind.comparisons
    }
    for row in study.comparisons:
        other = predicted[row.quantity, row.engine_speed, row.origin]
        assert (row.blind is None) == (other is None)
        assert other is None or row.blind == pytest.approx(other, rel=0.01)


def test_the_readme_has_the_range_of_both_springs(study: Study) -> None:
    words = r"calibrated (\d+) to (\d+) N, blind prediction (\d+) to (\d+) N, for 1430 N"
    (numbers,) = re.findall(words, (ROOT / "README.md").read_text(encoding="utf-8"))
    blind = vt.simulate("gu2021-beehive-blind", "8000 rpm", models=[ROD], workers=1)
    expected = [
        end for one in (study, blind) for end in (spike_samples(one).low, spike_samples(one).high)
    ]
    assert list(map(float, numbers)) == pytest.approx(expected, rel=0.02)


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


def test_claims_of_the_source(study: Study) -> None:
    """Stage II has the larger median over the phases, so the claim that the spike is the largest is not seen."""
    run = study.solution("finite-element", 8000 * RPM).quantities
    assert run["stage_3_peak_force"] < run["stage_2_peak_force"]
    verdicts = {one.statement.partition(",")[0]: one.verdict for one in study.findings}
    assert [one for one, word in verdicts.items() if word != "agrees"] == [
        "The largest force of the cycle is the spike of Stage III."
    ]
    assert len(study.findings) == 7


def test_the_two_maxima_are_near_the_printed_ones(study: Study) -> None:
    run = study.solution("finite-element", 8000 * RPM).quantities
    names = [f"stage_2_{word}_force" for word in ("first_peak", "valley", "second_peak")]
    off = [run[name] / printed - 1 for name, printed in zip(names, (940, 580, 1200), strict=True)]
    assert max(map(abs, off[:2])) <= 0.05 < -off[2], (
        "the second is missed, as docs/beehive.md prints"
    )


def test_a_case_of_ones_own_that_names_the_study_is_compared_with_it(tmp_path) -> None:
    """Contract: no published table of its own, all roles are checks."""
    text = (ROOT / "src/valvetrain/parameters/library/gu2021-beehive.toml").read_text("utf-8")
    own = tmp_path / "own.toml"
    own.write_text(text.partition("[[published]]")[0], encoding="utf-8")
    made = vt.simulate(str(own), "8000 rpm", models=["finite-element"], workers=1)
    assert made.comparisons and {row.role for row in made.comparisons} == {"check"}
    assert {row.quantity for row in made.comparisons} >= {"preload", "stage_2_valley_force"}
    assert made.findings
