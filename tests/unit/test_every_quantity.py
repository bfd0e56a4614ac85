"""Every quantity of the tables has a value known from a formula, a hand calculation or another program, and is held to it."""

from __future__ import annotations

import numpy as np
import pytest

from known_buckling import buckling
from known_quantities import GROUPS as MOST
from valvetrain.solution.definition import pattern_of, tables

GROUPS = (*MOST, buckling)
#: Held to known values elsewhere: the lift law's by the answers of the command line.
ELSEWHERE = {"maximum_lift", "maximum_lift_cam_angle"}


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.__name__)
def test_values_are_the_known_ones(group):
    found, known = group()
    assert not sorted(set(known) - set(found))
    wrong = {}
    for name, value in known.items():
        expected, within = value if isinstance(value, tuple) else (value, 1e-6 * abs(value) + 1e-15)
        if not abs(found[name] - expected) <= within:
            wrong[name] = (found[name], expected)
    assert not wrong


def test_no_quantity_is_without_a_known_value():
    known = {name for group in GROUPS for name in group()[1]} | ELSEWHERE
    rows = [one.name for table in tables().values() for one in table]
    assert not [row for row in rows if not any(pattern_of(row).fullmatch(name) for name in known)]


def test_the_known_values_of_a_group_are_all_different():
    """Two alike would let one quantity be shown for the other."""
    for group in GROUPS:
        values = [value[0] if isinstance(value, tuple) else value for value in group()[1].values()]
        same = len(values) - len(np.unique(np.round(np.array(values), 12)))
        assert same <= 8, group.__name__
