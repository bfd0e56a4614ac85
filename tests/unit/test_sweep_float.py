"""Where a sweep says that a train floats, from columns written by hand."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.solution.provenance import Provenance
from valvetrain.solution.record import CaseRecord
from valvetrain.solution.result import Solution, empty_channels
from valvetrain.solution.study import Study
from valvetrain.studies.sweep import control_quantities, float_engine_speed, lone_float_engine_speeds

LABEL = "stock"


def swept(excess_um: list[float], force: list[float]) -> Study:
    """A sweep at 1, 2, ... rad/s whose runs hold these numbers; a run without a number failed."""
    runs = []
    for place, (excess, least) in enumerate(zip(excess_um, force, strict=True)):
        found = {} if np.isnan(excess) else {"float_excess_lift": 1e-6 * excess, "minimum_cam_contact_force": least}
        origin = Provenance("own-train", "modal-uniform", 1.0 + place, label=LABEL, system="train")
        runs.append(Solution(empty_channels(), provenance=origin, quantities=found))
    return Study(CaseRecord("own-train"), "sweep", tuple(runs))


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
    study = swept(excess_um, [1.0] * 5)
    found = float_engine_speed(*study.series(LABEL, "float_excess_lift"))
    assert np.isnan(found) if from_speed is None else found == from_speed
    assert control_quantities(study, LABEL) == ({} if from_speed is None else {"float_engine_speed": from_speed})
    assert lone_float_engine_speeds(study, LABEL).tolist() == alone


def test_the_first_speed_that_lets_the_cam_go_is_told_apart_from_float() -> None:
    assert control_quantities(swept([0, 0, 0, 0], [50, 0, 20, 0]), LABEL) == {"contact_loss_engine_speed": 2.0}
