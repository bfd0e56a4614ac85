"""Unit: two springs compared in one engine: each judged by its own numbers, under its own name, nothing by
what a stopped search has not computed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_sweep import AMPLITUDE, STRESS, largest_stress
from valvetrain.findings.table import findings_of
from valvetrain.findings.words import Words
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.quantities.stress import most_force_of_wire
from valvetrain.runs import run as run_module
from valvetrain.runs.compare_springs import with_two_springs
from valvetrain.runs.facts import beyond_wire_facts
from valvetrain.runs.requests import CompareSprings
from valvetrain.runs.run import build, sweep_study
from valvetrain.runs.stopping import PointsStopped, StudyStopped
from valvetrain.views.answer import Answer

RPM = np.pi / 30
AT_REST = (("nominal_shear_stress", "closed_nominal_shear_stress"), ("spring_force", "preload"))
CARD = ("spring-card", "--outer-diameter", "29 mm", "--wire-diameter", "3.8 mm", "--installed", "36 mm, 250 N")  # fmt: skip


@pytest.fixture(scope="module")
def cards(tmp_path_factory):
    """Files of two springs as spring-card writes them: soft is solid at less force than stiff."""
    folder = tmp_path_factory.mktemp("springs")
    for name, load in (("soft", "480 N"), ("stiff", "552 N")):
        made = call(*CARD, "--open-load", f"28 mm, {load}", "--name", name, "--output", str(folder / name))  # fmt: skip
        assert made.exit_code == 0, made.stderr
        (folder / f"{name}.toml").write_text((folder / name / "spring.toml").read_text())
    return folder


@pytest.fixture(scope="module")
def both(cards):
    return with_two_springs(parse_case(template_text("direct")), *(vt.load_case(cards / f"{one}.toml") for one in ("soft", "stiff")))  # fmt: skip


@pytest.fixture(scope="module")
def study(both):
    return sweep_study(
        CompareSprings(
            case=both, engine_speeds=(6000 * RPM, 7000 * RPM), models=("massless",), workers=1
        )
    )


def test_a_card_goes_by_the_name_that_was_given(cards, both):
    """Contract: --name is the name in the file and that of its spring set."""
    assert (cards / "soft.toml").read_text().startswith('name = "soft"\n')
    assert list(both.train.springs) == ["soft", "stiff"]


@pytest.mark.slow
def test_the_force_at_solid_of_a_spring_is_compared_with_its_own_runs(both, study):
    """Closed form: with a peak between both forces at solid only the runs of the softer strike."""
    problem = build(both, spring_models=("massless",), spring_set=("soft", "stiff"))
    solid = {one.spring_set: most_force_of_wire(one.springs[0]) for one in problem.members}
    low, high = sorted(solid, key=lambda name: solid[name])
    middle = (solid[low] + solid[high]) / 2
    runs = [
        replace(one, quantities={"peak_spring_force": middle, "peak_shear_stress": 9e8})
        for one in study.solutions
    ]
    found = [one.fields for one in beyond_wire_facts(problem, runs)]
    assert {(one["spring"], one["label"]) for one in found} == {(low, f"{low}, massless")}
    assert found[0]["solid_force"] == pytest.approx(solid[low])


def test_the_largest_stress_amplitude_and_surge_of_each_spring_are_rows(study):
    """Closed form: half the range of the force, of the run where that is largest, times the stress for each newton, by the
    difference between closed and largest lift at rest; the wire that bears more breaks first.
    """
    found, peaks = (largest_stress(Facts(study), name) for name in (AMPLITUDE, STRESS))
    for name in ("soft", "stiff"):
        numbers = [one.quantities for one in study.solutions if one.spring_set == name]
        ranges = [one["peak_spring_force"] - one["minimum_spring_force"] for one in numbers]
        run = next(one for one in study.solutions if one.spring_set == name)
        rest = [Facts(study).value(run, f"open_{one}") - Facts(study).value(run, closed) for one, closed in AT_REST]  # fmt: skip
        assert found[name].value == pytest.approx(rest[0] / rest[1] * max(ranges) / 2, rel=1e-2)
        largest = max(one["peak_spring_force"] for one in numbers)
        assert peaks[name].value == pytest.approx(rest[0] / rest[1] * largest, rel=1e-2)
    assert findings_of(study).verdict.fields["weak"] == "stiff"
    rows = {one.label: one.cells for one in Answer(study).lines}
    assert {"in control", "most shear", "shear amplitude", "you have"} <= set(rows) and len(
        rows["you have"]
    ) == 2
    one = replace(study, command="sweep")
    assert not largest_stress(Facts(one), AMPLITUDE)
    assert "in control" not in {row.label for row in Answer(one).lines}


def test_the_next_step_of_two_springs_names_both(study, cards):
    """Contract: a sweep of the engine alone, with its own spring, was the next step."""
    found = findings_of(study, Words(case="soft.toml stiff.toml --train mine.toml"))
    steps = [one.step for one in found if one.step.startswith("valvetrain ")]
    assert steps and all(" compare-springs soft.toml stiff.toml" in one for one in steps)
    assert found.verdict.step.endswith("--model wave-rod")


def test_a_stopped_search_is_named_and_ranks_nothing(both, monkeypatch):
    """Contract: no spring is better by what is unknown."""

    def stop(*given, **options):
        raise PointsStopped({})

    monkeypatch.setattr(run_module, "find_critical_speeds", stop)
    with pytest.raises(StudyStopped) as caught:
        sweep_study(
            CompareSprings(
                case=both, engine_speeds=(6000 * RPM, 7000 * RPM), models=("massless",), workers=1
            )
        )
    study = caught.value.study
    assert study.command == "compare-springs"
    codes = findings_of(study).codes
    assert "R103" in codes and not any(one.startswith(("D", "W")) for one in codes)


@pytest.mark.slow
def test_what_both_leave_on_the_cam_is_at_a_speed_at_which_both_keep_it(both):
    study = sweep_study(
        CompareSprings(
            case=both, engine_speeds=(3000 * RPM, 5000 * RPM), models=("massless",), workers=1
        )
    )
    verdict = findings_of(study).verdict
    left = {
        run.engine_speed: min(one.quantities["minimum_cam_contact_force"] for one in study.solutions if one.engine_speed == run.engine_speed)
        for run in study.solutions
    }  # fmt: skip
    speed = max(one for one, force in left.items() if force > 0)
    assert verdict.code in ("D101", "D102")
    assert verdict.fields["there"] == f"{speed / RPM:.0f} rpm"
