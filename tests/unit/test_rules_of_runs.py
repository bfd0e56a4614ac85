"""Unit: rules on what a run keeps, a stretch covers, a mesh may miss and a mode is called, each on
both sides of its bound.
"""

from __future__ import annotations

import numpy as np
import pytest
from validation.calculix.jobs import axial_modes

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import as_written
from valvetrain.explore.space import Varied
from valvetrain.parameters.overrides import set_value
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
    ("key", "unit", "value", "after"),
    [
        (
            "spring.wire_diameter",
            "mm",
            3.9e-3,
            {"spring": {"wire_diameter": "0.0039 m", "coils": [1, 2]}},
        ),
        (
            "spring.pitch.level",
            "m",
            8e-3,
            {"spring": {"wire_diameter": "4 mm", "coils": [1, 2], "pitch": {"level": "0.008 m"}}},
        ),
        (
            "train.valve.mass",
            "g",
            0.05,
            {
                "spring": {"wire_diameter": "4 mm", "coils": [1, 2]},
                "train": {"valve": {"mass": "0.05 kg"}},
            },
        ),
        ("spring.coils.1", "", 3.0, {"spring": {"wire_diameter": "4 mm", "coils": [1, 3]}}),
        (
            "lift_law.nose",
            "",
            2.5,
            {"spring": {"wire_diameter": "4 mm", "coils": [1, 2]}, "lift_law": {"nose": 2.5}},
        ),
    ],
)
def test_a_value_is_set_in_tables_that_the_case_has_and_in_those_it_lacks(key, unit, value, after):
    tree = {"spring": {"wire_diameter": "4 mm", "coils": [1, 2]}}
    set_value(tree, key, as_written(value, Varied(key, unit).si_unit))
    assert tree == after


def test_nothing_is_multiplied_or_shifted_in_a_table_that_is_not_there():
    tree = {"spring": {"wire_diameter": "4 mm"}}
    with pytest.raises(InputError, match="the case has no 'train' there"):
        set_value(tree, "train.valve.mass", lambda before: before)
    assert tree == {"spring": {"wire_diameter": "4 mm"}}


@pytest.mark.parametrize(
    ("transmission", "found"),
    [
        ([0.5, -0.9, 0.4], (0, 1, 2)),
        ([0.3, 0.9, 0.5, -0.2, -0.8, -0.3, 0.7], (1, 4, 6)),
        ([0.2, -0.5, 0.3, 0.9, 0.4], (0, 1, 3)),
        ([0.2, -0.9, -0.3, 0.6, 0.5], (0, 1, 3)),
        ([0.119, -0.121, 0.0], (1,)),
        ([], ()),
    ],
)
def test_the_axial_modes_of_a_solid_are_the_strongest_of_each_run_of_one_sign(transmission, found):
    assert axial_modes(np.array(transmission)) == found


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
