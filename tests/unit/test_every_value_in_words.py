"""Numbers of a lift law are changed by text with a unit, and refused without one."""

from __future__ import annotations

import math

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.cam import build_lift_law
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.summary import number, value_text_at

LAWS = {
    "cycloidal": {"maximum_lift": 8e-3, "opening_start": 1.0, "opening_end": 2.0, "closing_start": 2.1, "closing_end": 3.0},
    "ramped": {"maximum_lift": 9e-3, "ramp_lift": 2e-4, "ramp_start": 0.5, "event_start": 1.0, "event_end": 3.0, "ramp_end": 3.5},
    "shaped": {"maximum_lift": 9e-3, "ramp_lift": 2e-4, "ramp_start": 0.5, "event_start": 1.0, "nose": 2.0, "event_end": 3.1,
               "flank_shape": (1.0, 0.5, -0.5, -1.0, -1.0)},
    "three-arc": {"base_radius": 0.018, "nose_radius": 5e-3, "maximum_lift": 9e-3, "nose": 3.1, "opening_start": 2.0},
}  # fmt: skip


@pytest.mark.parametrize("kind", LAWS)
def test_every_number_of_a_lift_law_is_told_in_its_unit_and_changed_by_text_with_one(kind):
    """Angles in degrees, lengths in millimetres, ratios as they are; text with a unit makes the law
    that the SI number makes.
    """
    case = vt.load_case("gu2021-beehive-blind").replace(
        {"lift_law": LiftLawParameters(kind, LAWS[kind])}
    )
    changes = {}
    for key, value in LAWS[kind].items():
        if isinstance(value, tuple):
            continue
        length = "lift" in key or "radius" in key
        unit, factor = ("mm", 1e3) if length else ("deg", 180 / math.pi)
        assert value_text_at(case, f"lift_law.{key}") == f"{number(value * factor)} {unit}"
        changes[f"lift_law.{key}"] = f"{value * factor!r} {unit}"
    told = case.replace(changes).lift_law
    assert {key: told.values[key] for key in LAWS[kind]} == {
        key: pytest.approx(value, rel=1e-12) for key, value in LAWS[kind].items()
    }
    angle = np.linspace(0.0, 6.2, 500)
    assert np.allclose(
        build_lift_law(told).lift(angle),
        build_lift_law(case.lift_law).lift(angle),
        rtol=0,
        atol=1e-12,
    )


def test_a_number_of_a_lift_law_without_its_unit_is_refused():
    case = vt.load_case("gu2021-beehive-blind").replace(
        {"lift_law": LiftLawParameters("cycloidal", LAWS["cycloidal"])}
    )
    with pytest.raises(vt.InputError, match="opening_start"):
        case.replace({"lift_law.opening_start": "120 mm"})
