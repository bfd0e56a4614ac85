"""Unit: every rule on a recording, on a case in which it holds and one in which it does not."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from valvetrain.findings.words import Words
from valvetrain.rig.answer import RigAnswer
from valvetrain.rig.channels import RigAnswers
from valvetrain.rig.cycles import cycles_in
from valvetrain.rig.reader import Recording, RigChannel

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from sample_rig import Rig, columns, record


def lift(angle):
    return 9e-3 * np.clip(1 - ((np.asarray(angle) % (2 * np.pi) - np.pi) / 1.05) ** 2, 0, None) ** 3


def force(angle):
    return 250 + 40e3 * lift(angle)


ENCODER = RigAnswers(angle_of="crank", encoder="Crank angle", zero={"spring_force": "250 N"})
PLAIN = {"sampling_rate": 20e3, "cycles": 8}


@cache
def recording(clip: float = np.inf, synthetic: bool = False, **rig) -> Recording:
    own = Rig(**{**PLAIN, **rig})
    channels = tuple(
        RigChannel(
            name,
            unit,
            np.minimum(values, clip) if name == "Spring force" else values,
            step=1 / own.sampling_rate,
        )
        for name, unit, values in columns(record(own, lift, force))
    )
    return Recording("samples", channels, synthetic=synthetic)


def answer(own: Recording, answers: RigAnswers = ENCODER, case_lift=lift) -> RigAnswer:
    return RigAnswer(cycles_in(own, "own.csv", answers, case_lift))


#: Code -> answer in which it holds.
HOLDS = {
    "T101": lambda: answer(recording(clip=0.5)),
    "T103": lambda: answer(recording(), RigAnswers(angle_of="crank", encoder="Crank angle")),
    "T104": lambda: answer(recording(drift_of_speed=0.3)),
    "T105": lambda: answer(recording()),
    "T110": lambda: answer(recording(slipped=3)),
    "T111": lambda: answer(recording(), case_lift=None),
    "T112": lambda: answer(recording(), case_lift=lambda angle: lift(angle) / 1.05),
    "T113": lambda: answer(recording(synthetic=True)),
}


@pytest.mark.parametrize("code", HOLDS)
def test_a_rule_holds_where_it_must_and_not_on_a_plain_recording(code):
    found = HOLDS[code]()
    assert code in found.findings.codes
    assert code == "T105" or answer(recording()).findings.codes == ("T105",)
    assert len(found.lines) == 6 and set(found.figures()) >= {"cycles-spring_force", "raw", "speed"}


def test_half_of_the_cycles_must_be_alike():
    whole = answer(recording()).result
    few = RigAnswer(
        replace(whole, retained=(0, 1), outliers=tuple((k, "is far off") for k in range(2, 8)))
    )
    assert few.verdict.code == "T102" and few.verdict.fields["why"] == "is far off"


def test_the_fields_of_a_verdict_are_the_numbers_of_the_recording():
    good, drifting = answer(recording()), HOLDS["T103"]()
    assert good.verdict.fields["peak"].value == pytest.approx(610.0, abs=6.0)
    named, doubtful = (replace(one, words=Words(case="job-t")) for one in (good, drifting))
    assert named.verdict.fields["step"].fields[
        "test"
    ] == "spring_force.csv" and named.next_step.startswith("valvetrain ")
    assert doubtful.verdict.fields["step"].fields[
        "test"
    ] == "valve_lift.csv" and doubtful.next_step.startswith("valvetrain ")
    assert good.next_step and not good.next_step.startswith("valvetrain ")
    drift = drifting.verdict.fields["drift"].value
    assert drift == pytest.approx(30 * 7 / 8.4, rel=0.2) and "spring_force" in drifting.next_step
    assert HOLDS["T112"]().findings.by("T112")[0].fields["share"].startswith("it is 105")
    uneven = HOLDS["T104"]().verdict.fields
    assert float(uneven["high"].split()[0]) > 1.05 * float(uneven["low"])


def test_a_recording_shows_itself_in_a_notebook_and_in_inches():
    found = answer(recording()).result
    assert "<table>" in found._repr_html_() and found.plot().data
    imperial = RigAnswer(found, words=Words("imperial"))
    assert any("lbf" in cell for line in imperial.lines for cell in line.cells)


def test_an_offset_places_the_mark_even_at_zero():
    stated = answer(recording(), replace(ENCODER, offset=0.0), None)
    assert "T111" not in stated.findings.codes and stated.result.placed
