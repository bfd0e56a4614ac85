"""Where a sweep says that a train floats, from columns written by hand."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.solution.status import COMPLETED
from valvetrain.studies.sweep import SweepSeries, float_engine_speed


@pytest.mark.parametrize(
    ("excess_um", "from_speed", "alone"),
    [
        ([0, 0, 0, 0, 0], None, []),
        ([0, 200, 0, 0, 0], None, [2.0]),  # one resonance: named, though the train does not float from there on
        ([0, 200, 0, 80, 90], 4.0, [2.0]),
        ([0, 0, 0, 0, 60], 5.0, []),
        ([0, np.nan, np.nan, 0, 0], 2.0, []),  # a run that failed has not kept control
    ],
)
def test_a_resonance_that_lets_go_is_never_passed_over(excess_um: list[float], from_speed: float | None, alone: list[float]) -> None:
    speeds = np.arange(1.0, 6.0)
    columns = {"float_excess_lift": 1e-6 * np.array(excess_um), "minimum_cam_contact_force": np.ones(5)}
    found = float_engine_speed(speeds, columns)
    series = SweepSeries("stock", "modal-uniform", speeds, columns, np.zeros((5, 1)), (COMPLETED,) * 5, found, 6.0)
    assert np.isnan(found) if from_speed is None else found == from_speed
    assert series.lone_float_engine_speeds.tolist() == alone
