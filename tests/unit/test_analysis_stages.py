"""Stages follow the lift law of the case; what has no stages gives no numbers by stage."""

from __future__ import annotations

import numpy as np
import pytest

from synthetic_spring import bump, run
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.evaluate import run_quantities
from valvetrain.quantities.filters import bandwidth_quantities
from valvetrain.quantities.stages import Stages, stage_quantities, stages_of

DEG = np.pi / 180


def _sine(first: float, last: float) -> LiftLawParameters:
    return LiftLawParameters("sine-power", {"maximum_lift": 9e-3, "opening_start": first * DEG, "closing_end": last * DEG, "power": 2})


def test_beehive_keeps_the_stages_of_its_source():
    assert stages_of(load_case("gu2021-beehive").lift_law) == Stages() == Stages(np.radians(127.0), np.radians(233.0))


def test_shaped_law_gives_its_own_event():
    law = load_case("gu2021-beehive").lift_law
    assert stages_of(law.replace(ramp_start=80 * DEG, event_start=110 * DEG)) == Stages(np.radians(110.0), np.radians(250.0))


def test_ramped_law_gives_its_own_event():
    angles = {"ramp_start": 90, "event_start": 100, "event_end": 230, "ramp_end": 250}
    law = LiftLawParameters("ramped", {"maximum_lift": 9e-3, "ramp_lift": 3e-4} | {key: angle * DEG for key, angle in angles.items()})
    assert stages_of(law) == Stages(np.radians(100.0), np.radians(230.0))


def test_other_laws_give_where_the_lift_passes_4_percent():
    stages = stages_of(_sine(100.0, 260.0))
    # sin^2 passes 4 % where the sine is 0.2
    edge = 160 * np.arcsin(0.2) / np.pi
    assert np.degrees([stages.first_end, stages.second_end]) == pytest.approx([100 + edge, 260 - edge], abs=0.06)


@pytest.mark.parametrize("law", [None, LiftLawParameters("zero"), _sine(-70.0, 70.0), _sine(290.0, 430.0)])
def test_no_stages_without_lift_or_across_the_zero(law):
    assert stages_of(law) is None


def test_no_stages_no_numbers_by_stage():
    found = run_quantities(run({"seat_force": lambda degrees: 300 + 50 * bump(degrees, 180, 100)}), stages=None)
    assert not [key.name for key in found if "stage" in key.name]


def test_an_empty_stage_is_left_out():
    found = stage_quantities(reported_cycle(run({"seat_force": 300 + np.arange(1440.0) % 720})), 10 * DEG, Stages(0.0, np.radians(140.0)))
    assert "stage_2_peak_force" in found and not [name for name in found if name.startswith("stage_1")]


def test_highest_instant_stands_beside_the_sampled_spike():
    from synthetic_study import rod_run

    solution = rod_run()
    cycle = reported_cycle(solution)
    found = bandwidth_quantities(cycle)
    fine = solution.channel("seat_force_fine")[cycle.samples]
    late = cycle.cam_angle >= np.radians(240.0)
    assert found["stage_3_every_instant_peak_force"] == np.max(fine[late])
    assert found["stage_3_every_instant_peak_force"] >= stage_quantities(cycle, 10 * DEG)["stage_3_peak_force"]
