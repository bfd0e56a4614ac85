"""``run``, ``compare`` and ``sweep`` of a spring alone: the answer, the folder that is kept, and
what a list of runs tells.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from unit.cli_parts import PUBLISHED, SMALL, call, sentence, typed
from valvetrain.parameters.templates import KINDS

QUICK = ("--workers", "1", "--no-report")
RANGE = ("--rpm", "1000:9000:100 rpm")
#: Words that only the papers of the library use.
PAPERS = ("Stage", "Node", "Gu ", "beehive", "published", "valley", "rebound")


@pytest.fixture
def small(tmp_path, monkeypatch):
    """The small case, with what a source said of it, in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "told.toml").write_text(SMALL + PUBLISHED)
    return tmp_path


@pytest.mark.parametrize("kind", KINDS)
def test_every_template_runs_as_it_stands_and_answers_on_a_screen(tmp_path, monkeypatch, kind):
    monkeypatch.chdir(tmp_path)
    made = call("new", "mine", "--kind", kind)
    assert made.exit_code == 0 and made.stdout.startswith(f"mine.toml: {KINDS[kind]}")
    assert "is there already" in sentence(call("new", "mine.toml", "--kind", kind))
    checked = call("check", "mine.toml")
    assert checked.exit_code == 0, checked.stderr
    result = call("run", "mine.toml", "--model", "massless,multi-mass", *QUICK)
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    assert len(lines) < 30 and max(map(len, lines)) <= 100
    assert not [word for word in PAPERS if word in result.stdout]
    labels = [line.split("  ")[1] for line in lines if line.startswith("  ")]
    assert {
        "spring" if kind != "spring" else "on the seat",
        "surge, 0 to peak",
        "coil bind",
    } <= set(labels)
    assert re.search(r"runs.mine.\d{8}-\d{6}-[0-9a-f]{8}$", lines[-1])


def test_a_run_is_kept_whole_and_repeated_from_its_folder(small):
    result = call(
        "run", "small.toml", "--set", "spring.damping.ratio=0.03", "--workers", "1", "--json"
    )
    assert result.exit_code == 0, result.stderr
    found = json.loads(result.stdout)
    folder = Path(found["folder"])
    assert (small / "runs" / "small" / "latest").resolve() == (small / folder).resolve()
    names = {path.relative_to(folder).as_posix() for path in map(Path, found["files"])}
    assert {"inputs/case.toml", "run.json", "report.html"} <= names and all(
        (folder / name).is_file() for name in names
    )
    kept = json.loads((folder / "run.json").read_text())
    assert (
        kept["versions"]["valvetrain"]
        and kept["command_line"][0] == "valvetrain"
        and kept["completed"] is True
    )
    assert "0.03" in (folder / "inputs" / "case.toml").read_text()
    again = json.loads(call("run", str(folder), *QUICK, "--json").stdout)
    assert Path(again["folder"]).parent == folder.parent and again["folder"] != found["folder"]
    assert [run["quantities"] for run in again["runs"]] == [
        run["quantities"] for run in found["runs"]
    ]
    assert (
        Path(again["folder"]).name.split("-")[2] == folder.name.split("-")[2]
    )  # the same inputs, the same digest


def test_runs_are_listed_and_compared(small):
    assert json.loads(call("runs", "--json").stdout)["findings"][0]["code"] == "J201"
    for value in ("4 mm", "3.9 mm"):
        words = ("--set", f"lift_law.maximum_lift={value}", "--model", "massless", *QUICK)
        assert call("run", "small.toml", *words).exit_code == 0
    call("sweep", "told.toml", "--rpm", "7000:8000:500", "--model", "massless", *QUICK)
    listed = call("runs").stdout
    assert (
        len(re.findall(r"^  \d\d-\d\d \d\d:\d\d ", listed, re.MULTILINE)) == 3
        and "7000–8000" in listed
        and "failed" not in listed
    )
    data = json.loads(call("runs", "small", "--json").stdout)["runs"]
    assert [run["models"] for run in data] == [["massless"]] * 2 and data[0]["verdict"]["code"]
    compared = call("compare-runs", data[1]["digest"], "small/latest")
    assert compared.exit_code == 0, compared.stderr
    assert "lift_law.maximum_lift" in compared.stdout and "peak spring force" in compared.stdout
    found = json.loads(call("compare-runs", data[1]["folder"], data[0]["folder"], "--json").stdout)
    assert [row["key"] for row in found["inputs"]] == ["lift_law.maximum_lift"]
    peak = next(row for row in found["results"] if row["quantity"] == "peak_spring_force")
    assert (
        peak["difference"]["value"] == pytest.approx(peak["b"]["value"] - peak["a"]["value"])
        and peak["difference"]["value"] < 0
    )
    assert found["findings"][0]["code"] == "J221"
    data = json.loads(call("compare-runs", "small", "small", "--json").stdout)
    assert data["findings"][0]["code"] == "J223" and not data["inputs"]


def test_a_folder_of_ones_own_is_written_directly_and_a_foreign_one_refused(small):
    (small / "notes").mkdir()
    (small / "notes" / "mine.txt").write_text("kept")
    refused = call("run", "small.toml", "--output", "notes", *QUICK)
    assert refused.exit_code == 2 and "holds files that no run wrote" in sentence(refused)
    words = ("--model", "massless", "--output", "here", *QUICK)
    assert call("run", "small.toml", *words, "--rpm", "7000 rpm").exit_code == 0
    first = {path.name for path in (small / "here").iterdir()}
    assert call("run", "small.toml", *words, "--rpm", "9000 rpm").exit_code == 0
    second = {path.name for path in (small / "here").iterdir()}
    assert (
        "massless-7000rpm.nc" in first - second
        and "massless-9000rpm.nc" in second - first
        and not (small / "runs").exists()
    )


def test_run_options_change_speeds_models_folder_and_values(small):
    result = call(
        *typed("run small.toml --rpm '7000, 9000 rpm' --model modal-varied --output here"),
        *QUICK,
        *typed("--set spring.total_coils=4 --set 'lift_law.maximum_lift=3 mm' --json"),
    )
    assert result.exit_code == 0, result.stderr
    found = json.loads(result.stdout)
    assert [(run["model"], run["engine_speed"]["value"]) for run in found["runs"]] == [
        ("modal-varied", 7000.0),
        ("modal-varied", 9000.0),
    ]
    assert found["page"] is None and not (small / "here" / "report.html").exists()
    from valvetrain.solution.netcdf import load_netcdf

    assert float(
        load_netcdf(small / "here" / "modal-varied-7000rpm.nc").channel("valve_lift").max()
    ) == pytest.approx(3e-3, rel=1e-6)


def test_quiet_prints_nothing_but_errors(small):
    result = call("run", "small.toml", "--model", "massless", "--quiet", *QUICK)
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
    result = call("run", "nothing.toml", "--quiet")
    assert result.exit_code == 2 and result.stdout == "" and "there is no file" in sentence(result)


def test_errors_are_an_object_under_json_with_the_same_exit_codes(small):
    for arguments, where, words in (
        (
            ("run", "small.toml", "--set", "spring.pitch=1 N"),
            "--set spring.pitch",
            "but a length is needed",
        ),
        (("run", "small.toml", "--steps", "3"), "", "no such option"),
        (("rum",), "", "did you mean 'run'?"),
    ):
        result = call(*arguments, "--json")
        found = json.loads(result.stdout)["error"]
        assert (
            result.exit_code == 2
            and found["code"] == 2
            and found["where"] == where
            and words in found["message"]
        )
        assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "--rpm", "10:9000:1 rpm"), "min and "),
        (
            ("sweep", "--rpm", "10:9000:1", "--set", "operation.cycles=3"),
            "beyond the bound of 10 min",
        ),
        (
            (
                "run",
                "--set",
                "spring.options.finite-element.elements_per_coil=24",
                "--set",
                "operation.cycles=10000",
            ),
            "--limit",
        ),
        (
            (
                *typed(
                    "run --model multi-mass --set spring.options.multi-mass.masses_per_coil=2000"
                ),
                *RANGE,
            ),
            "beyond the bound",
        ),
        (
            (
                *typed(
                    "run --model finite-element --set spring.options.finite-element.elements_per_coil=1000 --limit '1 h'"
                ),
                *RANGE,
            ),
            "GB",
        ),
    ],
)
def test_a_request_beyond_the_bound_is_refused_with_its_numbers_and_the_option(
    small, arguments, words
):
    command, *rest = arguments
    result = call(command, "small.toml", *rest)
    assert result.exit_code == 2
    text = sentence(result)
    assert words in text and "this request will take about" in text and "--limit '" in text


def test_a_run_that_diverges_writes_what_it_has_and_ends_with_1(small):
    words = typed(
        "run small.toml --set 'spring.options.finite-element.time_step=2e-5 s' --output out"
    )
    result = call(*words, "--json")
    assert result.exit_code == 1, result.stderr
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("failed: ")]
    assert "finite-element at 9000 rpm: diverged" in line and "leave time_step out" in line
    found = json.loads(result.stdout)
    assert found["completed"] is False and [run["status"]["code"] for run in found["runs"]] == [
        "diverged",
        "completed",
    ]
    assert (small / "out" / "finite-element-9000rpm.nc").exists() and (
        small / "out" / "report.html"
    ).exists()
    words = call(
        "run", "small.toml", *QUICK, "--set", "spring.options.finite-element.time_step=2e-5 s"
    )
    assert words.exit_code == 1
    (verdict,) = json.loads(call("runs", "--json").stdout)["findings"]
    assert verdict["code"] == "J203"
