"""Contact is lost by one criterion in a run, a sweep with and one without search, and what a sentence
says of it is what the table has.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import valvetrain as vt
from synthetic_study import train_study
from valvetrain.findings.table import findings_of
from valvetrain.integrate.train_channels import Scatter
from valvetrain.quantities.train_events import LOSSES, counted_losses
from valvetrain.solution.channels import empty_channels
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.status import Cause, Event
from valvetrain.solution.study import Study

RPM = math.pi / 30


def train(**values: float) -> vt.Solution:
    """A run of a train with these quantities among calm ones."""
    run = train_study().solutions[0]
    calm = {"coil_bind_clearance": 2.2e-3, "bounce_count": 0.0, "minimum_cam_contact_force": 35.0}
    return replace(run, quantities={**calm, **values})


def study_of(run: vt.Solution, command: str = "run", **changes: object) -> Study:
    return Study(CaseRecord("own"), command, solutions=(replace(run, **changes),))


def loss(kind: str, degrees: float, gap: float, cause: str = Cause.SURGE, **more: float) -> Event:
    return Event(kind, math.radians(degrees), 0.01, 2e-4, gap, "m", "cam", {"cause": cause, **more})


def test_a_run_loses_contact_where_the_search_over_speed_does():
    """Contract: a run said no loft and a cam force of 0 N at a speed that the search called lost: it
    counted gaps above 2 µm, the search any force of zero.
    """
    found = vt.critical_speeds(
        "tdi-pushrod", "6800:7000:200 rpm", models=["multi-mass"], spring_sets="stock", ranges=False, workers=1
    )  # fmt: skip
    onset = found.of("contact-loss").engine_speed / RPM
    for engine_speed, lost in ((onset - 1, False), (onset + 1, True)):
        study = vt.simulate("tdi-pushrod", f"{engine_speed} rpm", models=["multi-mass"], spring_sets="stock", workers=1)  # fmt: skip
        (run,) = study.solutions
        assert (run.statistics["least_cam_contact_force"] <= 0) == lost
        assert (
            (run.quantities["loss_of_contact_duration"] > 0)
            == lost
            == bool(counted_losses(run.events))
        )
        assert (findings_of(study).verdict.code in ("C101", "C102")) == lost
        if lost:  # by less than any vibration of a contact on a ramp may open
            assert run.quantities["loft_gap"] < 2e-6
            assert 0 < run.quantities["loss_of_contact_duration"] < 1e-4


def test_a_contact_that_opens_on_a_ramp_alone_is_no_loss_in_run_or_sweep():
    """Contract: 2.4 µm at 152 cam deg, on the opening ramp, were "contact is lost first" in a sweep, "no
    loft" in the sentence of a run, and 0.06 ms in its table.
    """
    ramp = replace(loss("loft", 122.0, 2.4e-6, Cause.VIBRATION), counts=False)
    calm = train(loss_of_contact_duration=0.0, loft_gap=0.0)
    found = findings_of(study_of(calm, events=(ramp,)))
    assert found.verdict.code in ("C103", "C104") and found.by("C120")
    assert findings_of(study_of(calm, "sweep", events=(ramp,))).verdict.code in ("C103", "C104")
    lost, nose = train(loft_duration=2e-4, loft_gap=2.4e-6), loss("loft", 180.0, 2.4e-6)
    verdict = findings_of(study_of(lost, events=(nose,))).verdict
    assert verdict.code == "C102" and verdict.value == 2e-4
    assert verdict.fields["gap"].value == 2.4e-6
    assert findings_of(study_of(lost, "sweep", events=(nose,))).verdict.code == "C102"


@pytest.mark.parametrize(
    ("left", "run", "compare"), [(29.0, "C103", "M103"), (31.0, "C104", "M102")]
)
def test_run_and_comparison_are_near_the_limit_by_one_rule(left, run, compare):
    """Contract: 16.5 N were "in control" in a run and "at its limit" in a comparison. Closed form: a twentieth of 600 N is 30 N."""
    one = train(minimum_cam_contact_force=left, open_spring_force=600.0)
    one = replace(one, channels=empty_channels())  # of rigid parts nothing is known
    assert findings_of(study_of(one)).verdict.code == run
    pair = tuple(
        replace(one, provenance=replace(one.provenance, model=name))
        for name in ("modal-uniform", "multi-mass")
    )
    assert findings_of(Study(CaseRecord("own"), "compare", solutions=pair)).verdict.code == compare


def test_losses_near_the_seat_are_events_that_do_not_count():
    """Contract: of the pushrod train the valve tip parts on the ramp alone, and no number of lost contact has it."""
    study = vt.simulate("tdi-pushrod", "4000 rpm", models=["modal-uniform"], spring_sets="stock", workers=1)  # fmt: skip
    (run,) = study.solutions
    near = [one for one in run.events if one.kind in LOSSES]
    assert near and not any(one.counts for one in near)
    assert run.quantities["loss_of_contact_duration"] == run.quantities["loft_gap"] == 0


def test_landings_of_a_flight_that_does_not_repeat_have_their_ends():
    """Closed form: least and largest of landings on both sides of the end of a turn."""
    landings = tuple(np.radians([355.0, 8.0, 2.0]))
    found = Scatter(1e-4, 9e-3, {"loft_gap": 1e-4}, True, landings).statistics
    ends = [math.degrees(found[f"{name}_landing_cam_angle"]) for name in ("least", "largest")]
    assert ends == pytest.approx([355.0, 8.0])
    assert "least_landing_cam_angle" not in Scatter(1e-4, 9e-3, {}).statistics


def test_the_energy_of_a_train_closes_and_its_preload_is_that_of_the_card():
    """Property: work of the cam is what contacts and springs lose where the motion repeats; a solver that
    added energy would show.
    """
    study = vt.simulate("tdi-pushrod", "3000 rpm", models=["multi-mass"], spring_sets="stock", workers=1)  # fmt: skip
    (run,) = study.solutions
    work, lost, heat = (run.quantities[name] for name in ("cycle_work_energy", "cycle_dissipated_energy", "spring_dissipated_energy"))  # fmt: skip
    assert abs(work - lost - heat) < 1e-3 * work
    assert study.still["stock"]["preload"] == pytest.approx(195.8, abs=0.1)
