"""The comparison of two checkouts' numbers notices what differs and passes what rounding makes."""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

from compare_numbers import differences

OLD = {"case": {"peak_spring_force": 500.0, "minimum_spring_force": 1e-16, "loft": math.nan}}


def test_rounding_and_missing_values_pass():
    new = {
        "case": {
            "peak_spring_force": 500.0 * (1 + 5e-10),
            "minimum_spring_force": -3e-16,
            "loft": math.nan,
        }
    }
    assert differences(OLD, new) == (3, [])


def test_a_changed_a_missing_and_a_new_number_are_named():
    new = {"case": {"peak_spring_force": 500.0 * (1 + 5e-9), "loft": 0.0, "stroke": 1.0}}
    count, found = differences(OLD, new)
    assert count == 2 and len(found) == 4
    assert any("peak_spring_force 500.0 ->" in line for line in found)
    assert any("minimum_spring_force is in one checkout alone" in line for line in found)
