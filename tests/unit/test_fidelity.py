"""Unit: verdicts on spring models beside a reference, from rows of known numbers; the command, its
answer and its refusals.
"""

from __future__ import annotations

import csv
import json
import math
import re
from dataclasses import replace

import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.errors import InputError
from valvetrain.report.json import fidelity_object
from valvetrain.report.run_summary import fidelity_notes, reach_rows, reason_for
from valvetrain.report.sections.answers import fidelity_blocks as blocks
from valvetrain.runs import fidelity as studied
from valvetrain.runs.fidelity import fidelity_models
from valvetrain.runs.run import run_problem
from valvetrain.runs.stopping import StudyStopped
from valvetrain.runs.train_runs import STOPPED
from valvetrain.solution.fidelity import GOOD, MISSING, OPEN, POOR, RPM, FidelityMap, FidelityRow
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.status import Status
from valvetrain.solution.study import Study

SPEEDS = [1000 * RPM, 2000 * RPM, 3000 * RPM]


def row(
    value,
    speed=SPEEDS[0],
    model="massless",
    quantity="peak_spring_force",
    error=math.nan,
    reference=500.0,
    doubt=math.nan,
):
    """One row; the largest value of the reference is 1000 N."""
    return FidelityRow(quantity, model, speed, value, error, reference, doubt, 1000.0)


def rows_of(values, **more):
    return tuple(row(value, speed, **more) for value, speed in zip(values, SPEEDS, strict=False))


def mapped(*rows, costs=(("massless", 0.05), ("multi-mass", 0.5), ("finite-element", 12.0))):
    return FidelityMap("finite-element", 0.05, rows, costs, ("multi-mass", "finite-element"))


@pytest.mark.parametrize(
    ("one", "verdict"),
    [
        (row(549.0), GOOD),
        (row(451.0), GOOD),
        (row(551.0), POOR),
        (row(449.0), POOR),
        (row(540.0, error=9.0), GOOD),
        (row(540.0, error=11.0), OPEN),
        (row(560.0, error=9.0), POOR),
        (row(560.0, error=11.0), OPEN),
        (row(540.0, error=5.0, doubt=6.0), OPEN),
        (row(540.0, doubt=9.0), GOOD),
        (row(math.nan), MISSING),
        (row(500.0, error=math.inf), OPEN),
        (row(900.0, doubt=math.inf), OPEN),
        (row(500.0, reference=math.nan), OPEN),
        (row(math.nan, reference=math.nan), MISSING),
    ],
)
def test_a_verdict_counts_the_errors_of_both_against_the_tolerance(one, verdict):
    assert one.verdict(0.05) == verdict


def test_a_difference_is_a_share_of_the_largest_reference():
    one = row(530.0, error=4.0, doubt=2.0)
    assert one.difference == pytest.approx(0.03) and one.doubt == pytest.approx(0.006)


@pytest.mark.parametrize(
    ("values", "words", "good_to", "poor_from"),
    [
        ((510.0, 490.0, 549.0), "all", 3000, None),
        ((510.0, 490.0, 600.0), "to 2000", 2000, 3000),
        ((600.0, 500.0, 500.0), "none", None, 1000),
        ((500.0, 600.0, 500.0), "to 1000", 1000, 2000),
        ((math.nan,) * 3, "missing", None, 1000),
        ((500.0, math.nan, 500.0), "to 1000", 1000, 2000),
    ],
)
def test_a_model_reaches_to_the_last_speed_before_the_first_that_is_not_good(
    values, words, good_to, poor_from
):
    found = mapped(*rows_of(values)).reach("peak_spring_force", "massless")
    assert found.text == words and found.everywhere == (words == "all")
    assert (
        found.good_to and round(found.good_to / RPM),
        found.poor_from and round(found.poor_from / RPM),
    ) == (good_to, poor_from)


def test_what_the_bars_leave_open_is_neither_good_nor_poor():
    found = mapped(*rows_of((540.0, 500.0, 500.0), error=20.0)).reach(
        "peak_spring_force", "massless"
    )
    assert found.text == "open" and not found.everywhere and found.poor_from is None
    later = mapped(*rows_of((500.0, 500.0, 540.0), error=20.0)).reach(
        "peak_spring_force", "massless"
    )
    assert later.text == "to 2000, then open" and later.poor_from is None


def test_what_a_failed_run_leaves_unknown_is_open_and_said():
    """Neither a reference without a value nor a bar that was not found lets a model pass."""
    gone = mapped(
        *rows_of((500.0, 500.0), reference=500.0), row(500.0, SPEEDS[2], reference=math.nan)
    )
    assert (
        gone.reach("peak_spring_force", "massless").text == "to 2000, then open"
        and gone.cheapest("peak_spring_force") == gone.reference
    )
    assert (
        "gave no value, so nothing is said there of: peak spring force below 10 kHz at 3000 rpm."
        in " ".join(fidelity_notes(gone))
    )
    *_, last = blocks(Study(CaseRecord("own"), fidelity=gone))[2].rows[0][0]
    assert (last.text, last.hint) == ("?", "no value of the reference: open")
    blind = mapped(*rows_of((510.0, 500.0, 500.0), error=math.inf))
    assert blind.reach("peak_spring_force", "massless").text == "open"
    assert (
        reason_for(blind, "peak_spring_force")
        == "massless comes nearest, but the finer run that should give the error gave no result"
    )
    assert "3 of 3 error bars are unknown" in " ".join(fidelity_notes(blind))
    assert fidelity_object(blind)["rows"][0]["doubt"]["value"] is None


def test_the_cheapest_good_model_is_recommended_and_else_the_reference():
    poor, good = (
        rows_of((600.0, 500.0, 500.0)),
        rows_of((520.0, 510.0, 470.0), model="multi-mass", error=5.0),
    )
    found = mapped(*poor, *good)
    assert (
        found.models == ("massless", "multi-mass")
        and found.cheapest("peak_spring_force") == "multi-mass"
    )
    assert reason_for(found, "peak_spring_force") == "at worst 3 % ± 0.5 % off, in 1/24 of the time"
    assert mapped(*poor).cheapest("peak_spring_force") == "finite-element"
    assert (
        reason_for(mapped(*poor), "peak_spring_force")
        == "the nearest, massless, is 10 % off at worst"
    )
    blind = mapped(*rows_of((math.nan,) * 3))
    assert reason_for(blind, "peak_spring_force") == "no other model gives it"
    wide = mapped(*rows_of((600.0, 500.0, 500.0), error=150.0))
    assert "its error bar, 15 %, is larger than the difference" in reason_for(
        wide, "peak_spring_force"
    )


def test_rows_stand_by_model_in_order_of_cost_and_notes_name_what_has_no_bar():
    found = mapped(*rows_of((500.0,) * 3, model="multi-mass"), *rows_of((600.0,) * 3))
    (line,) = reach_rows(found)
    assert (
        line.cells == ("none", "all")
        and line.label == "Peak spring force below 10 kHz"
        and line.cheapest == "multi-mass"
    )
    notes = " ".join(fidelity_notes(found))
    assert (
        "1000 to 3000 rpm" in notes
        and "peak spring force below 10 kHz 1000 N" in notes
        and "bar of their own: massless." in notes
    )


def test_the_page_shows_signed_differences_in_the_tone_of_their_verdict():
    found = mapped(
        *rows_of((530.0, 394.0, math.nan)),
        *rows_of((540.0, 500.0, 500.2), model="multi-mass", error=20.0),
    )
    recommended, reaches, one_map, *_ = blocks(Study(CaseRecord("own"), fidelity=found))
    assert [cell.text for cell in recommended.rows[0][0]][:2] == [
        "Peak spring force below 10 kHz",
        "finite-element rod",
    ]
    assert [cell.text for cell in reaches.rows[0][0]] == [
        "Peak spring force below 10 kHz",
        "to 1000",
        "open",
    ]
    assert [cell.text for cell in reaches.rows[1][0]][1:] == ["0.0042", "0.042"]
    assert one_map.headers == ("model", "1000", "2000", "3000")
    told = [[(cell.text, cell.tone) for cell in cells[1:]] for cells, _ in one_map.rows]
    assert told[0] == [("+3.0", "number good"), ("−11", "number bad"), ("–", "number quiet")]
    assert told[1] == [("+4.0", "number quiet"), ("0.0", "number good"), ("0.0", "number good")]
    assert "± 2 %: open" in one_map.rows[1][0][1].hint
    assert blocks(Study(CaseRecord("own"))) == ()


def test_json_tells_every_row_with_its_units():
    told = fidelity_object(mapped(row(530.0, error=4.0, doubt=2.0)))
    assert told["rows"] == [
        {
            "quantity": "peak_spring_force",
            "model": "massless",
            "engine_speed": {"value": pytest.approx(1000.0), "unit": "rpm"},
            "value": {"value": 530.0, "unit": "N"},
            "error": {"value": 4.0, "unit": "N"},
            "reference": {"value": 500.0, "unit": "N"},
            "reference_error": {"value": 2.0, "unit": "N"},
            "difference": {"value": pytest.approx(0.03), "unit": "1"},
            "doubt": {"value": pytest.approx(0.006), "unit": "1"},
            "verdict": "good",
        },
    ]
    assert told["reference"] == "finite-element" and told["cheapest"] == {
        "peak_spring_force": "massless"
    }


@pytest.fixture(scope="module")
def quick():
    return vt.fidelity(
        "job-t",
        "500, 6000 rpm",
        spring_models=["multi-mass", "massless"],
        reference="wave-rod",
        workers=1,
    )


def test_slow_motion_is_told_alike_by_every_model_and_fast_motion_not(quick):
    """Far below the surge every model is the static spring; a spring without mass is not at a cam
    order of 7.
    """
    found = quick.fidelity
    slow = [
        one
        for one in found
        if round(one.engine_speed / RPM) == 500 and one.quantity == "peak_spring_force"
    ]
    assert len(slow) == 2 and all(abs(one.difference) < 0.01 for one in slow)
    massless = {
        round(one.engine_speed / RPM): one for one in found.of("surge_amplitude_force", "massless")
    }
    assert massless[6000].verdict(0.05) == POOR and massless[6000].difference < -0.5


def test_an_error_bar_is_that_of_a_finer_division(quick):
    """By hand: the chain with 18 masses per coil instead of 12; two grids of second order, safety
    factor three.
    """
    case = vt.load_case("job-t", {"spring.options.multi-mass.masses_per_coil": 18})
    finer = vt.simulate(case, "6000 rpm", spring_models=["multi-mass"], workers=1).solutions[0]
    one = next(
        one
        for one in quick.fidelity.of("peak_spring_force", "multi-mass")
        if one.engine_speed > 600
    )
    apart = abs(one.value - finer.quantities["peak_spring_force"])
    assert one.error == pytest.approx(3 * apart / (1.5**2 - 1) * 1.5**2, rel=1e-9) and apart > 0
    assert math.isnan(quick.fidelity.of("peak_spring_force", "massless")[0].error)


ASKED = {
    "engine_speeds": "500, 6000 rpm",
    "spring_models": ["multi-mass", "massless"],
    "reference": "wave-rod",
    "workers": 1,
}


def test_a_finer_run_that_fails_leaves_its_bar_unknown(quick, monkeypatch):
    """The chain's finer run at 6000 rpm diverges, as one of a division that its step does not suit
    would.
    """
    whole = studied.run_problem

    def run(problem, *given, **more):
        found = whole(problem, *given, **more)
        if len(problem.members) > 1:
            return found
        runs = tuple(
            replace(one, status=Status("diverged", "made up")) if one.engine_speed > 600 else one
            for one in found.solutions
        )
        return replace(found, solutions=runs)

    monkeypatch.setattr(studied, "run_problem", run)
    found = vt.fidelity("job-t", **ASKED).fidelity
    slow, fast = found.of("peak_spring_force", "multi-mass")
    assert slow == quick.fidelity.of("peak_spring_force", "multi-mass")[0] and math.isfinite(
        slow.error
    )
    assert (
        math.isinf(fast.error)
        and fast.verdict(0.05) == OPEN
        and fast.value == quick.fidelity.of("peak_spring_force", "multi-mass")[1].value
    )
    assert found.of("peak_spring_force", "massless") == quick.fidelity.of(
        "peak_spring_force", "massless"
    )


def test_a_map_that_is_stopped_among_its_finer_runs_keeps_its_own_runs(quick, monkeypatch):
    whole = studied.run_problem

    def run(problem, *given, **more):
        found = whole(problem, *given, **more)
        if len(problem.members) > 1:
            return found
        raise StudyStopped(
            replace(found, solutions=tuple(replace(one, status=STOPPED) for one in found.solutions))
        )

    monkeypatch.setattr(studied, "run_problem", run)
    with pytest.raises(StudyStopped) as cut:
        vt.fidelity("job-t", **ASKED)
    kept = cut.value.study
    assert (
        kept.command == "fidelity"
        and [one.status.code for one in kept.solutions] == ["completed"] * 6
    )
    assert {one.verdict(0.05) for one in kept.fidelity.of("peak_spring_force", "multi-mass")} == {
        OPEN
    }
    assert kept.fidelity.of("peak_spring_force", "massless") == quick.fidelity.of(
        "peak_spring_force", "massless"
    )


def test_a_map_that_is_stopped_among_its_own_runs_keeps_those_that_are_done(monkeypatch):
    def run(problem, *given, **more):
        found = run_problem(problem, *given, **more)
        raise StudyStopped(
            replace(
                found,
                solutions=(*found.solutions[:-1], replace(found.solutions[-1], status=STOPPED)),
            )
        )

    monkeypatch.setattr(studied, "run_problem", run)
    with pytest.raises(StudyStopped) as cut:
        vt.fidelity("job-t", **ASKED)
    kept = cut.value.study
    assert kept.command == "fidelity" and [one.status.code for one in kept.solutions] == [
        "completed"
    ] * 5 + ["interrupted"]
    assert {
        one.verdict(0.05)
        for one in kept.fidelity
        if one.engine_speed > 600 and one.model == "massless"
    } == {OPEN}


def test_workers_and_order_move_no_bit(quick):
    again = vt.fidelity(
        "job-t",
        "6000, 500 rpm",
        spring_models=["massless", "multi-mass"],
        reference="wave-rod",
        workers=2,
    )
    assert repr(again.fidelity) == repr(quick.fidelity)
    frame = again.fidelity.to_pandas()
    assert list(frame["verdict"]) == [one.verdict(0.05) for one in again.fidelity]


def test_the_command_gives_page_table_and_answer(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = (
        "job-t",
        "--engine-speed",
        "500,6000 rpm",
        "--spring",
        "massless",
        "--reference",
        "wave-rod",
        "--workers",
        "1",
    )
    done = call("fidelity", *words, "--output", "out", "--tolerance", "10 %", "--json")
    assert done.exit_code == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["command"] == "fidelity" and told["fidelity"]["tolerance"][
        "value"
    ] == pytest.approx(0.1)
    with open(tmp_path / "out" / "fidelity.csv", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(told["fidelity"]["rows"]) and {one["verdict"] for one in lines} <= {
        GOOD,
        POOR,
        OPEN,
        MISSING,
    }
    assert "Which model is good enough" in (tmp_path / "out" / "report.html").read_text(
        encoding="utf-8"
    )
    plain = call("fidelity", *words, "--output", "out2").stdout
    assert "Cheapest at all speeds" in plain and "massless" in plain


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("job-t", "--tolerance", "0 %"), "share between 0 and 1"),
        (("job-t", "--tolerance", "5"), "write '5 %'"),
        (("job-t", "--tolerance", "5 mm"), "is a length, but a plain number is needed"),
        (("job-t", "--spring-set", "stock"), "is a spring alone and has no spring sets"),
        (
            ("tdi-pushrod", "--spring-set", "stock", "--reference", "solid"),
            "the reference cannot run",
        ),
        (("job-t", "--reference", "sold"), "did you mean solid"),
        (("job-t", "--spring", "wave-rod", "--reference", "wave-rod"), "no model but"),
        (("tdi-pushrod", "--spring-set", "stock,performance"), "one spring set"),
        (("tdi-pushrod", "--spring-set", "x"), "no spring set 'x'"),
    ],
)
def test_what_cannot_be_compared_is_refused(words, told):
    result = call("fidelity", *words, "--engine-speed", "500 rpm")
    assert result.exit_code == 2 and told in sentence(result)


def test_what_does_not_move_is_refused_before_anything_is_built(tmp_path, monkeypatch):
    """As by a sweep: no kernel is compiled and no cost is told for it."""
    text = re.sub(
        r"^\[lift_law\]\n.*?(?=^\[|\Z)",
        "",
        vt.load_case("job-t").record().text,
        flags=re.MULTILINE | re.DOTALL,
    )
    (tmp_path / "still.toml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(
        "valvetrain.cli.progress.announce_compilation", lambda *_: pytest.fail("compiled")
    )
    result = call("fidelity", str(tmp_path / "still.toml"))
    assert result.exit_code == 2 and "case 'still' holds no lift law" in sentence(result)
    assert "has no spring sets" in sentence(call("fidelity", "job-t", "--spring-set", "x"))


def test_springs_known_by_cards_are_judged_by_the_rod_of_the_wave_equation():
    case = vt.load_case("tdi-pushrod")
    assert fidelity_models(case)[-1] == "wave-rod" and "finite-element" not in fidelity_models(case)
    assert fidelity_models(vt.load_case("job-t"))[-1] == "finite-element"
    with pytest.raises(InputError, match="fewer"):
        vt.fidelity("job-t", "10:9000:1 rpm")
