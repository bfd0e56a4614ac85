"""Unit: rules on what a run keeps, a stretch covers, a mesh may miss and a mode is called, each on
both sides of its bound.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.parameters.train_parts import LeverParameters
from valvetrain.quantities.cycle import Cycle

DEG = np.pi / 180


@pytest.mark.parametrize(
    ("first", "last", "covered"),
    [
        (0, 359, True),
        (1.4, 359, True),
        (-1.4, 359, True),
        (-1.6, 359, False),
        (0, 360.4, True),
        (0, 360.6, False),
        (100, 200, True),
        (400, 500, False),
        (-50, -10, False),
    ],
)
def test_a_stretch_is_covered_but_for_one_step_and_a_half_at_either_end(first, last, covered):
    """Samples every degree from 0 to 359."""
    cycle = Cycle(None, slice(0, 360), np.arange(360) * DEG, np.arange(360.0), True)
    assert cycle.covers(first * DEG, last * DEG) is covered
    assert not Cycle(None, slice(0, 1), np.zeros(1), np.zeros(1), True).covers(0.0, 0.0)


def test_samples_far_apart_at_an_end_cover_no_more_than_the_first_of_them():
    cycle = Cycle(
        None, slice(0, 5), np.array([0.0, 40.0, 41.0, 42.0, 43.0]) * DEG, np.arange(5.0), False
    )
    assert (
        cycle.covers(0.0, 43 * DEG)
        and cycle.covers(-1 * DEG, 44 * DEG)
        and not cycle.covers(-2 * DEG, 43 * DEG)
    )


@pytest.mark.parametrize(
    ("arm", "ratio", "taken"),
    [("45 mm", None, 45e-3), (None, 1.5, 45e-3), ("45 mm", 1.5, 45e-3), ("45.2 mm", 1.5, 45.2e-3)],
)
def test_the_ratio_of_a_lever_is_that_of_its_arms(arm, ratio, taken):
    own = {
        "pivot": ["0 mm", "0 mm"],
        "inertia": "1e-5 kg m^2",
        "drive_arm": "30 mm",
        "valve_arm": arm,
        "ratio": ratio,
    }
    assert LeverParameters(
        **{name: value for name, value in own.items() if value is not None}
    ).valve_arm == pytest.approx(taken)


def test_a_ratio_that_contradicts_the_arms_is_told_with_theirs():
    with pytest.raises(
        Exception, match=r"ratio 3 contradicts the arms, whose ratio is 1\.5; drop one of the three"
    ):
        LeverParameters(
            pivot=["0 mm", "0 mm"],
            inertia="1e-5 kg m^2",
            drive_arm="30 mm",
            valve_arm="45 mm",
            ratio=3.0,
        )
