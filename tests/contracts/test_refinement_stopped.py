"""A refinement that is stopped keeps the bars whose runs are all there and all numbers; a level
that fails is a sentence.
"""

from __future__ import annotations

import csv
import json
import signal
import sys

import pytest

from fault_parts import gone, started
from unit.cli_parts import SMALL, call, typed, wait_until
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.runs import refine, refine_variants
from valvetrain.runs.error_bars import DOUBTFUL, RefinementStopped
from valvetrain.runs.refine import refined

OWN_MESH = SMALL.replace("elements_per_coil = 6", "elements_per_coil = 8")
REPORTING = """
from contextlib import contextmanager
from valvetrain.cli import main, progress

@contextmanager
def bar(title):
    def report(done, words):
        if "variants, 3 of" in words:
            open("reached", "w").close()
    yield report

progress.progress_bar = bar
main.main()
"""
SPEEDS = (400.0, 500.0, 600.0)


def lines_of(path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="finds processes by their environment in /proc"
)
@pytest.mark.parametrize(("number", "train"), [(signal.SIGINT, False), (signal.SIGTERM, True)])
def test_a_signal_keeps_what_was_finished(number, train, tmp_path):
    """A progress bar that leaves a file once some runs of the variants are finished."""
    (tmp_path / "small.toml").write_text(OWN_MESH)
    case = ("tdi-pushrod", "2000, 3000 rpm") if train else ("small.toml", "2000:9000:500 rpm")
    code = REPORTING
    words = ("refine", case[0], "--rpm", case[1], "--workers", "2", "--output", "out")
    with started(*words, folder=tmp_path, code=code) as (run, mark):
        wait_until((tmp_path / "reached").exists, "some runs are finished")
        run.send_signal(number)
        output, errors = run.communicate(timeout=60)
        gone(mark)
    assert run.returncode == 128 + number and "Traceback" not in errors, errors
    last = errors.splitlines()[-1]
    assert (
        last.startswith("interrupted: ")
        and "were finished, and their numbers are saved in 'out'" in last
    )
    answer = json.loads((tmp_path / "out" / "run.json").read_text())
    assert not answer["completed"] and any(
        words.startswith("interrupted: ") for words in answer["failures"]
    )
    levels = lines_of(tmp_path / "out" / "levels.csv")
    assert {"mesh 1" in row["level"] for row in levels} == ({True, False}) and all(
        float(row["value"]) == float(row["value"]) for row in levels
    )
    assert (tmp_path / "out" / "report.html").exists() and not list(
        (tmp_path / "out").glob(".*.part")
    )
    assert "out/report.html" in output


def stopping_at(count: int):
    """A progress callback that ends in Ctrl-C at its call number ``count``."""
    calls = []

    def progress(share, text):
        calls.append(text)
        if len(calls) == count:
            raise KeyboardInterrupt

    return progress


@pytest.mark.parametrize(
    ("count", "bars", "finished"),
    [(2, set(), 0), (8, {None}, 1), (11, {None}, 1), (18, {None, 400.0}, 8)],
)
def test_only_speeds_with_all_their_runs_have_bars(count, bars, finished):
    """Seven variants are prepared, then three runs of the own mesh, then all eight variants of each
    speed.
    """
    case = parse_case(OWN_MESH, name="small")
    with pytest.raises(KeyboardInterrupt) as found:
        refined(case, SPEEDS, workers=1, progress=stopping_at(count))
    assert isinstance(found.value, RefinementStopped)
    study = found.value.study
    assert {row.engine_speed for row in study.rows} == bars and study.runs == 24
    assert study.finished >= finished and study.values["mesh 1"][None]["preload"] > 0
    if bars:
        whole = refined(case, SPEEDS[:1], workers=1)
        assert [row for row in study.rows] == [
            row for row in whole.rows if row.engine_speed in bars
        ]


def test_a_train_that_is_stopped_has_the_bars_of_its_finished_variants():
    case = load_case("tdi-pushrod")
    case = case.replace(train=case.train.replace(variants=case.train.variants[:2]))
    first = case.train.variants[0].label
    jobs = (
        2 + 9
    )  # both own ones; two steps, samples, two finer springs and four contacts of the first
    prepared = 12  # finer springs and contacts of both
    with pytest.raises(RefinementStopped) as found:
        refined(case, [300.0], workers=1, progress=stopping_at(prepared + jobs + 1))
    study = found.value.study
    assert {row.label for row in study.rows} == {first} and study.finished == jobs + 1 < study.runs
    assert f"{case.train.variants[1].label}, mesh 1" in study.values and not study.failures


def test_a_mesh_that_cannot_be_is_told_and_two_meshes_give_the_bars(tmp_path, monkeypatch):
    """250 elements a coil are 563 on the finest mesh, more than the rod holds: the whole refinement
    was refused for it.
    """
    usual = refine_variants.prepare_refined
    whole = refined(parse_case(OWN_MESH, name="small"), SPEEDS[:1], workers=1)

    def without_the_finest(problem, member, *surge):
        if member.springs[0].options_of("finite-element").get("elements_per_coil") == 18:
            raise InputError("3375 vertices exceed the 1536 that the rod holds")
        return usual(problem, member, *surge)

    monkeypatch.setattr(refine_variants, "prepare_refined", without_the_finest)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(OWN_MESH)
    result = call(*typed("refine small.toml --rpm '400 rad/s' --workers 1 --output out --json"))
    assert result.exit_code == 1, result.stderr
    data = json.loads(result.stdout)
    assert (
        data["failures"] == ["mesh 3: 3375 vertices exceed the 1536 that the rod holds"]
        and not data["completed"]
    )
    rows = {row["quantity"]: row for row in data["uncertainties"]}
    for row in whole.rows:
        middle = whole.values["mesh 2"][row.engine_speed][row.quantity]
        expected = (
            DOUBTFUL * abs(row.value - middle) * 1.5**2 / (1.5**2 - 1) + row.step_part
        )  # Roache's factor for two grids
        assert rows[row.quantity]["numerical_uncertainty"]["value"] == pytest.approx(
            expected, rel=1e-9
        )
    assert not any(row["level"] == "mesh 3" for row in lines_of(tmp_path / "out" / "levels.csv"))


def test_a_run_that_fails_is_told_and_costs_no_other(monkeypatch):
    """A halved step that diverges leaves its speed without bars; a contact that does, its range
    without an end.
    """
    usual, case = refine._moving, parse_case(OWN_MESH, name="small")
    whole = refined(case, SPEEDS[:2], workers=1)
    calls: list[int] = []

    def failing(*given):
        calls.append(0)
        if len(calls) in (
            5,
            16,
        ):  # the halved step of the first speed, the last contact of the second
            raise ZeroDivisionError("float division by zero")
        return usual(*given)

    monkeypatch.setattr(refine, "_moving", failing)
    study = refined(case, SPEEDS[:2], workers=1)
    assert [words.partition(":")[0] for words in study.failures] == [
        "step 2 at 3820 rpm",
        "damping 2 at 4775 rpm",
    ]
    assert {row.engine_speed for row in study.rows} == {
        None,
        SPEEDS[1],
    } and study.finished == study.runs == 16
    for row, other in zip(
        study.rows, (row for row in whole.rows if row.engine_speed != SPEEDS[0]), strict=True
    ):
        assert (row.quantity, row.value, row.numerical) == (
            other.quantity,
            other.value,
            other.numerical,
        )
