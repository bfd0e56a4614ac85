"""The wire of the pushrod template, which is not in the library, moving its train and moved by it:
reduced rod against rod (limit between models).
"""

from __future__ import annotations

from importlib.resources import files

import numpy as np
import pytest

import valvetrain as vt


@pytest.mark.long
def test_it_moves_its_train_as_the_rod_does():
    case = str(files("valvetrain") / "templates" / "pushrod.toml")
    both = vt.simulate(
        case, "5500 rpm", spring_models=["finite-element", "reduced-rod"], spring_set="wire"
    )
    rod, reduced = both.solutions
    assert reduced.quantities["minimum_spring_force"] == pytest.approx(
        rod.quantities["minimum_spring_force"], rel=0.02
    )
    angle = rod.channel("cam_angle")
    found = np.interp(angle, reduced.channel("cam_angle"), reduced.channel("seat_force"))
    expected = rod.channel("seat_force")
    assert np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2)) < 0.015
    assert (
        np.max(
            np.abs(
                np.interp(angle, reduced.channel("cam_angle"), reduced.channel("valve_lift"))
                - rod.channel("valve_lift")
            )
        )
        < 5e-6
    )
