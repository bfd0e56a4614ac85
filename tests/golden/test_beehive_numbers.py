"""Golden: the headline numbers of the main job as this version gives them; a change here is a breaking change (CHANGELOG)."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.solution.quantity import Quantity
from valvetrain.studies.spring_study import run_spring_study

RPM = 2 * np.pi / 60

#: Value in SI and relative room: smooth quantities move by rounding alone, spikes by what rounding does through a clash.
STATIC = {"preload": 288.89, "mode_1_frequency": 628.85, "mode_2_frequency": 1154.1, "mode_3_frequency": 1572.6}
RUNS = {
    ("stage_2_peak_force", 4200, "finite-element"): (816.54, 0.002),
    ("stage_2_peak_force", 5600, "finite-element"): (823.75, 0.002),
    ("stage_3_peak_force", 5600, "finite-element"): (368.22, 0.02),
    ("stage_3_below_10_khz_peak_force", 8000, "finite-element"): (485.86, 0.02),
    ("stage_2_peak_force", 4200, "modal-varied"): (815.44, 0.002),
    ("stage_2_first_peak_force", 8000, "modal-varied"): (890.47, 0.002),
}


@pytest.fixture(scope="module")
def quantities():
    return run_spring_study(load_case("gu2021-beehive")).quantities


@pytest.mark.parametrize("name", STATIC)
def test_statics_and_modes(quantities, name):
    assert quantities[Quantity(name)] == pytest.approx(STATIC[name], rel=1e-3)


@pytest.mark.parametrize("key", RUNS, ids=lambda key: f"{key[0]}-{key[1]}-{key[2]}")
def test_runs(quantities, key):
    name, rpm, model = key
    expected, share = RUNS[key]
    found = [
        v
        for q, v in quantities.items()
        if q.name == name and q.label == model and q.engine_speed and abs(q.engine_speed / RPM - rpm) < 1e-6
    ]
    assert found == [pytest.approx(expected, rel=share)]
