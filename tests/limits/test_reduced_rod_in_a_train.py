"""The wire of the pushrod template, which is not in the library, moving its train and moved by it:
reduced rod against rod (limit between models).
"""

from __future__ import annotations

from importlib.resources import files

import numpy as np
import pytest

import valvetrain as vt
from spring_shapes import cylindrical
from valvetrain.runs.statics import axial_frequencies


@pytest.mark.long
def test_it_moves_its_train_as_the_rod_does():
    case = str(files("valvetrain") / "templates" / "pushrod.toml")
    both = vt.simulate(
        case, "5500 rpm", models=["finite-element", "reduced-rod"], spring_sets="wire"
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


def test_its_matrices_are_the_static_rate_and_its_surge_the_rod_s():
    """Condensed onto the retainer the stiffness is the slope of the force at rest; the mode that takes most mass along
    is the first axial one of the finite elements.
    """
    wire = cylindrical("2.9 mm", "19.4 mm", total_coils=6.9, free_length="41.5 mm")
    rod = vt.springs.FiniteElementRod(wire, "8 mm", elements_per_coil=12)
    spring = vt.springs.ReducedRod(rod, 8e-3)
    for lift in (2e-3, 5e-3):
        matrix, step = spring.stiffness(lift), 1e-5
        condensed = matrix[-1, -1] - matrix[-1, :-1] @ np.linalg.solve(
            matrix[:-1, :-1], matrix[:-1, -1]
        )
        above, below = (
            spring.force(spring.initial_state(at), at).retainer for at in (lift + step, lift - step)
        )
        assert condensed == pytest.approx((above - below) / (2 * step), rel=1e-6)
    assert spring.surge_frequency(0.0) == pytest.approx(axial_frequencies(rod, 1)[0], rel=2e-3)
