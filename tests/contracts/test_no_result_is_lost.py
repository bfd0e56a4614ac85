"""Every part of an answer is made to fail in turn: the others are there, the gap is named, and no
result is lost.
"""

from __future__ import annotations

import inspect
import json
import re
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

import valvetrain.quantities.evaluate as evaluate
from synthetic_study import own_study, rod_run
from unit.cli_parts import call, typed
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate
from valvetrain.solution.atomic import write_text
from valvetrain.solution.netcdf import load_netcdf
from valvetrain.solution.status import PartialFailures
from valvetrain.views import results as write
from valvetrain.views.answer import Answer
from valvetrain.views.files import FreeNames
from valvetrain.views.page import data_of, page_of
from valvetrain.views.results import write_answer

BROKEN = "made to fail"
#: Functions of the quantities that only ask what a run is, and what they stand for.
ASKS = {"is_closed"}


def broken(*_, **__):
    raise IndexError(BROKEN)


def parts() -> list[str]:
    """Every function that finds numbers or events of a run."""
    made = {
        name
        for name, item in vars(evaluate).items()
        if inspect.isfunction(item) and ".quantities." in item.__module__
    }
    return sorted(
        name
        for name in made
        if not name.startswith("_") and name != "evaluate" and name not in ASKS
    )


@pytest.fixture(scope="module")
def raw():
    """What is evaluated of a spring with the names of a source, of one with clashes, and of a
    train.
    """
    seen = []
    usual = evaluate.evaluate
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "valvetrain.runs.prepared.evaluate",
            lambda run, frame: seen.append((run, frame)) or usual(run, frame),
        )
        simulate(load_case("job-t"), engine_speeds=(400.0,), models=("multi-mass",))
        simulate(
            load_case("tdi-pushrod"),
            engine_speeds=(300.0,),
            models=("multi-mass",),
            spring_sets=("stock",),
            workers=1,
        )
    _, frame = seen[0]
    seen.append((rod_run(), replace(frame, surge_frequencies=(500.0,), source="gu2021")))
    return seen


@pytest.fixture(scope="module")
def before(raw):
    """What is found of them where nothing fails."""
    return [evaluate.evaluate(*one) for one in raw]


@pytest.mark.parametrize("name", parts())
def test_a_quantity_that_fails_is_a_named_gap(raw, before, monkeypatch, name):
    monkeypatch.setattr(evaluate, name, broken)
    after = [evaluate.evaluate(*one) for one in raw]
    assert any(BROKEN in gap for run in after for gap in run.gaps), (
        f"nothing that is evaluated here calls {name}"
    )
    for (given, _), old, new in zip(raw, before, after, strict=True):
        assert not old.gaps and set(new.quantities) <= set(old.quantities)
        assert new.gaps or new.quantities == old.quantities, "a gap that nobody names"
        assert new.has(*given.arrays.variables) and new.status == given.status


def test_most_numbers_outlive_a_quantity_that_fails(raw, before, monkeypatch):
    """One that fails costs its own group, not half of the answer."""
    whole = sum(len(one.quantities) for one in before)
    left = {}
    for name in set(parts()) - {"reported_cycle", "rigid_cycle"}:  # what all others are found from
        with monkeypatch.context() as patch:
            patch.setattr(evaluate, name, broken)
            left[name] = sum(len(evaluate.evaluate(*one).quantities) for one in raw) / whole
    assert min(left.values()) > 0.5, left


def test_a_figure_that_fails_is_named_and_the_others_are_drawn(monkeypatch):
    """Each figure of a page in turn."""
    answer = Answer(own_study())
    drawn = {key for key in data_of(page_of(answer)) if key.startswith("data-")}
    for key in sorted(drawn):
        name = key.removeprefix("data-")
        gaps = PartialFailures()
        with monkeypatch.context() as patch:
            specs = answer.figures()
            specs[name] = replace(specs[name], make=broken)
            patch.setattr(Answer, "figures", lambda _, found=specs: found)
            text = page_of(answer, gaps)
        assert len(gaps.sentences) == 1 and BROKEN in gaps.sentences[0]
        assert {one for one in data_of(text) if one.startswith("data-")} == drawn - {key}


WRITERS = (
    "quantity_table",
    "event_table",
    "save_csv",
    "save_netcdf",
    "static_table",
    "frequency_table",
    "remove_earlier",
    "at_wire_points",
)


@pytest.fixture(scope="module")
def short_study():
    return own_study((rod_run(samples=90),))


@pytest.fixture(scope="module")
def whole(short_study, tmp_path_factory):
    """Names of the files of that study where none fails."""
    files = write_answer(short_study, tmp_path_factory.mktemp("whole"), page=False, figures="")
    return {path.name for path in files.data}


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_that_fails_is_named_and_the_others_are_written(
    short_study, whole, tmp_path, monkeypatch, name
):
    monkeypatch.setattr(write, name, broken)
    files = write_answer(short_study, tmp_path / "cut", page=False, figures="")
    left = {path.name for path in files.data}
    assert files.gaps and all(BROKEN in gap for gap in files.gaps) and left <= whole
    assert len(whole - left) == sum(gap.startswith(("file", "table")) for gap in files.gaps)
    other = ".csv" if name == "save_netcdf" else ".nc"
    assert any(file.endswith(other) for file in left)


def test_a_command_of_which_everything_fails_keeps_its_run(tmp_path, monkeypatch):
    """Numbers, sections, tables, page, JSON and terminal at once: the solution and the reasons are
    there.
    """
    for name in parts():
        monkeypatch.setattr(evaluate, name, broken)
    places = (
        "views.results.page_of", "views.results.quantity_table", "views.results.remove_earlier", "views.json.study_json",
        "views.terminal._rows", "runs.run.next_to_published", "runs.spring_runs.rest_quantities", "runs.facts.case_facts",
    )  # fmt: skip
    for place in places:
        monkeypatch.setattr(f"valvetrain.{place}", broken)
    out = tmp_path / "out"
    result = call("run", "job-t", "--rpm", "2000 rpm", "--model", "massless", "--output", str(out))
    assert result.exit_code == 1 and "Traceback" not in result.stderr
    run = load_netcdf(out / "massless-2000rpm.nc")
    assert (
        run.status.completed
        and run.has("seat_force", "valve_lift")
        and all(BROKEN in gap for gap in run.gaps)
        and len(run.gaps) > 3
    )
    answer = json.loads((out / "run.json").read_text())
    assert not answer["completed"] and len(answer["failures"]) > 8
    told = [line for line in result.stderr.splitlines() if line.startswith("failed: ")]
    assert (
        len(told) > 8
        and all(BROKEN in line for line in told)
        and str(out) in result.stdout.replace("\n", "")
    )


LABELS = [
    "x 1", "x/1", "x 1", "X 1", "X-1", "", ".", "..", "x 1-2", "caf\u00e9", "cafe\u0301", "CAF\u00c9", "\ufb01n", "fin", "stra\u00dfe",
    "STRASSE", "a" * 300, "a" * 299 + "b", "a" * 300, "\u6c34" * 300, "nul\0", "con", "-rf", "~", "x\n1",
]  # fmt: skip


def test_no_two_results_share_a_file_name():
    names = FreeNames()
    found = [
        names.free(f"{label}-{speed:.10g}rpm")
        for label in LABELS
        for speed in (3000.001, 3000.002, 3000.0, 3000.00000001)
    ]
    assert len({name.casefold() for name in found}) == len(found)
    assert all(
        len(name.encode()) <= 120 and not set(name) & set('/\\\0\n:*?"<>|') and name[0] not in ".-"
        for name in found
    )


def test_every_labelled_run_has_a_file_of_its_own(tmp_path, monkeypatch):
    monkeypatch.setattr(write, "save_csv", lambda run, path: write_text(path, ""))
    runs = [rod_run(samples=24, label=label or "-") for label in LABELS]
    runs += [
        rod_run(samples=24, label="speed", engine_speed=speed * 3.141592653589793 / 30)
        for speed in (3000.001, 3000.002)
    ]
    files = write_answer(
        replace(own_study(), solutions=tuple(runs), rest=()), tmp_path, page=False, figures=""
    )
    assert not files.gaps
    kept = [load_netcdf(path) for path in files.data if path.suffix == ".nc"]
    assert sorted((run.label, run.engine_speed) for run in kept) == sorted(
        (run.label, run.engine_speed) for run in runs
    )


TWO = """
[[train.variants]]
label = "{0}"
spring_model = "massless"
spring_set = "stock"

[[train.variants]]
label = "{1}"
spring_model = "multi-mass"
spring_set = "stock"
"""


def two_variants(folder, first: str, second: str) -> str:
    """A train of the library with two variants of one's own, as a case file."""
    source = (
        resources.files("valvetrain") / "parameters" / "library" / "tdi-pushrod.toml"
    ).read_text("utf-8")
    head, *tables = re.split(r"(?m)^(?=\[)", source)
    kept = [table for table in tables if not table.startswith("[[train.variants]]")]
    path = folder / "two.toml"
    path.write_text(head + "".join(kept) + TWO.format(first, second), "utf-8")
    return str(path)


@pytest.mark.parametrize(
    "labels", [("x 1", "x/1"), ("x 1", "x 1"), ("x", "X"), ("caf\u00e9", "cafe\u0301")]
)
def test_variants_of_like_labels_each_keep_their_numbers(tmp_path, labels):
    out = tmp_path / "out"
    speeds = ("--rpm", "3000.001, 3000.002 rpm", "--workers", "1", "--no-report")
    result = call("run", two_variants(tmp_path, *labels), *speeds, "--output", str(out), "--json")
    assert result.exit_code == 0, result.stderr
    answer = json.loads(result.stdout)
    assert len({run["label"] for run in answer["runs"]}) == 2
    kept = [
        load_netcdf(path)
        for path in out.glob("*.nc")
        if not path.name.startswith(("static", "modes"))
    ]
    told = {
        (run["label"], run["model"], round(run["engine_speed"]["value"], 3))
        for run in answer["runs"]
    }
    assert {
        (run.label, run.model, round(run.engine_speed * 30 / np.pi, 3)) for run in kept
    } == told and len(told) == 4
    rows = (out / "quantities.csv").read_text().splitlines()[1:]
    assert len({tuple(row.split(",")[:-4]) for row in rows}) == len(rows)


@pytest.mark.parametrize("damping", ["1e6 1/s", "1e9 1/s"])
def test_a_damping_that_one_model_refuses_costs_that_model_alone(tmp_path, damping):
    words = (
        *typed("--rpm '2000 rpm' --model modal-varied,massless --set"),
        f"spring.damping.mass_damping={damping}",
    )
    result = call("run", "job-t", *words, "--no-report", "--output", str(tmp_path / "out"))
    states = {
        run["label"]: run["status"]["code"]
        for run in json.loads((tmp_path / "out" / "run.json").read_text())["runs"]
    }
    assert result.exit_code == 1 and states == {"modal-varied": "refused", "massless": "completed"}
