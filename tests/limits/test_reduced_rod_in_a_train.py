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

    def at_the_rod_s_angles(name: str) -> np.ndarray:
        return np.interp(rod.cam_angle, reduced.cam_angle, reduced.channel(name))

    expected = rod.channel("seat_force")
    apart = at_the_rod_s_angles("seat_force") - expected
    assert np.sqrt(np.mean(apart**2) / np.mean(expected**2)) < 0.015
    lifts = at_the_rod_s_angles("valve_lift"), rod.channel("valve_lift")
    assert np.max(np.abs(lifts[0] - lifts[1])) < 5e-6
