"""Contract: doubtful values of points are counted once, and a quantity of a pair is asked by its spring."""

from __future__ import annotations

import numpy as np

from valvetrain.explore.evaluate import doubts
from valvetrain.explore.space import Varied
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text

KEY = "train.springs.dual.0.open_load"


def test_the_points_with_turns_that_no_spring_has_are_counted():
    """Closed form: n = G d^4 / (8 D^3 k) turns; a rate of a fifth has five times as many, more than are solid."""
    case = parse_case(template_text("pushrod", cards=True))
    found = doubts(case, (Varied(KEY, "N"),), np.array([[1040.0], [500.0], [1030.0], [490.0]]))
    assert list(found) == [1, 3]
    assert found[1].startswith("at ") and "active turns" in found[1]
    assert not doubts(None, (), np.zeros((3, 0)))
