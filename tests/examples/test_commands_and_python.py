"""Contract: every command that computes has its Python line, and both give equal numbers."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import valvetrain as vt
from unit.cli_parts import call

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STUDY = """
case = "job-t"
spring_models = "massless"
engine_speeds = "3000 rpm"
outputs = "peak_spring_force"
[points]
sampler = "sobol"
count = 3
seed = 5
[[vary]]
key = "spring.wire_diameter"
distribution = "uniform"
low = "3.9 mm"
high = "4.1 mm"
"""


@pytest.fixture
def answer(tmp_path, monkeypatch):
    """The JSON of a command that runs in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def of(*words):
        found = call(*words, "--json")
        assert found.exit_code == 0, found.output
        return json.loads(found.stdout)

    return of


def values(quantities):
    return {name: one["value"] for name, one in quantities.items()}


def test_run(answer):
    data = answer("run", "job-t", "--model", "multi-mass", "--rpm", "5000 rpm")
    told = values(data["runs"][0]["quantities"])
    run = vt.Case("job-t").run("5000 rpm", models="multi-mass")
    assert {name: run.quantities[name] for name in told} == told


def test_static(answer):
    rest = answer("static", "job-t", "--model", "multi-mass")["springs_at_rest"][0]
    curve = vt.Case("job-t").static(models="multi-mass")
    compression, force = (rest["static_curve"][name]["values"] for name in ("compression", "force"))
    assert curve.force_at(compression[10]) == pytest.approx(force[10], rel=1e-9)


def test_modes_and_compare(answer):
    told = values(answer("modes", "job-t", "--model", "multi-mass")["quantities"])
    (rest,) = vt.compare("job-t", "2000 rpm", "multi-mass").rest
    assert told["mode_1_frequency"] == rest.modes.natural_frequency[0]


def test_sweep_and_critical_speeds(answer):
    words = ("--rpm", "2000:2500:500", "--model", "massless")
    answer("new", "engine", "--kind", "direct")
    data = answer("sweep", "engine.toml", *words)
    study = vt.Case("engine.toml").sweep("2000:2500:500 rpm", "massless")
    told = [one["quantities"]["peak_spring_force"]["value"] for one in data["runs"]]
    assert told == [one.quantities["peak_spring_force"] for one in study.solutions]
    assert len(data["critical_speeds"]) == len(study.critical_speeds)


def test_run_up(answer):
    answer("new", "engine", "--kind", "direct")
    words = (
        "--model",
        "massless",
        "--from",
        "2000 rpm",
        "--to",
        "2400 rpm",
        "--duration",
        "0.3 s",
    )
    told = answer("run-up", "engine.toml", *words)["runs"]
    study = vt.run_up("engine.toml", "2000 rpm", "2400 rpm", "0.3 s", models="massless")
    assert [one["quantities"]["peak_cam_contact_force"]["value"] for one in told] == [
        one.quantities["peak_cam_contact_force"] for one in study.solutions
    ]


def test_refine(answer):
    told = answer("refine", "job-t")["uncertainties"]
    first = next(one for one in told if one["quantity"] == "preload")
    same = next(one for one in vt.Case("job-t").refine().rows if one.quantity == "preload")
    assert first["value"]["value"] == same.value
    assert first["numerical_uncertainty"]["value"] == same.numerical


def test_study(answer, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    assert answer("study", "study.toml")["completed"]
    table = vt.Case("job-t").study(
        {"spring.wire_diameter": vt.Uniform("3.9 mm", "4.1 mm")},
        "peak_spring_force",
        count=3,
        seed=5,
        engine_speeds="3000 rpm",
        models="massless",
    )
    assert vt.study("study.toml", output="again").to_xarray().equals(table.to_xarray())


def test_identify(answer):
    told = answer("identify", str(EXAMPLES / "identify-spring.toml"))
    found = vt.identify(EXAMPLES / "identify-spring.toml")
    best = {name: one["best"] for name, one in told["branches"][0]["quantities"].items()}
    assert best == found.best


def test_spring_card(answer):
    words = (
        "--wire-diameter",
        "4.4 mm",
        "--outer-diameter",
        "32 mm",
        "--installed",
        "46 mm, 350 N",
    )
    told = answer("spring-card", *words, "--open-load", "34 mm, 830 N")
    card = vt.spring_card.CatalogueCard(
        wire_diameter="4.4 mm",
        outer_diameter="32 mm",
        installed_load=vt.spring_card.SpringLoad("46 mm", "350 N"),
        open_load=vt.spring_card.SpringLoad("34 mm", "830 N"),
    )
    found = vt.spring_card.spring_from_card(card)
    assert told["card"]["total_coils"]["found"] == found.spring.wire.total_coils


def test_compare_springs(answer, tmp_path):
    (tmp_path / "soft.toml").write_text(
        '[spring]\npreload = "300 N"\nrate = "36 N/mm"\nmass = "42 g"\n'
    )
    answer("new", "engine", "--kind", "direct")
    words = ("--rpm", "2000:2500:500", "--model", "massless")
    data = answer("compare-springs", "soft.toml", "engine.toml", *words)
    study = vt.Case("engine.toml").compare_springs(
        "soft.toml", "engine.toml", "2000:2500:500 rpm", "massless"
    )
    told = [one["quantities"]["peak_spring_force"]["value"] for one in data["runs"]]
    assert told == [one.quantities["peak_spring_force"] for one in study.solutions]
    assert study.verdict.startswith(data["findings"][0]["text"])


def test_every_command_is_tried_here_or_in_the_tests_of_its_tool():
    from valvetrain.cli.main import app

    here = {
        name.removeprefix("test_").replace("_", "-")
        for name in globals()
        if name.startswith("test_")
    }
    of_tools = {"optimise", "film", "scan", "rig", "lift", "compare-test"}
    of_files = {"check", "cases", "new", "runs", "compare-runs", "serve", "findings", "quantities"}
    commands = {one.name for one in app.registered_commands}
    assert commands <= here | {"modes", "compare", "sweep", "branches"} | of_tools | of_files, (
        commands
    )
