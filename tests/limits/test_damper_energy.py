"""Energy lost in the damper against closed forms: a spring moved slowly and harmonically is one dashpot,
which loses pi c omega x^2 per cycle, and a train loses what its cam puts in.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt

#: Cam at 1200 rpm, a tenth of the surge frequency and less; the whole cycle is one cosine of 3 mm.
CAM_SPEED, AMPLITUDE = 2 * np.pi * 20, 3e-3
TURNS, PITCH = 6, 7.5e-3
SLOW = {
    "lift_law.opening_start": "0 deg",
    "lift_law.closing_end": "360 deg",
    "lift_law.power": 2,
    "lift_law.maximum_lift": "6 mm",
    "operation.cam_speeds": "1200 rpm",
}


def slow(model, **damping):
    case = vt.load_case(
        "job-t",
        {
            **SLOW,
            "spring.damping": damping,
            "spring.options": {"multi-mass": {"from_rod": False}},  # the mass of the wire itself
        },
    )
    return vt.simulate(case, models=[model]).solutions[0].quantities


@pytest.mark.parametrize(
    ("model", "within"),
    [("multi-mass", 0.005), ("finite-element", 0.02)],  # the rod's damping leaves its shear out
)
def test_a_slow_spring_is_a_dashpot_of_its_rate_times_the_damping_time(model, within):
    found = slow(model, stiffness_damping="2e-5 s")
    rate = (found["peak_spring_force"] - found["minimum_spring_force"]) / (2 * AMPLITUDE)
    assert found["cycle_damper_energy"] == pytest.approx(
        np.pi * 2e-5 * rate * CAM_SPEED * AMPLITUDE**2, rel=within
    )


def test_a_slow_spring_loses_to_mass_damping_what_a_third_of_its_mass_does():
    found = slow("multi-mass", mass_damping="40 1/s")
    mass = 7850 * np.pi / 4 * 4e-3**2 * TURNS * np.hypot(np.pi * 24e-3, PITCH)
    assert found["cycle_damper_energy"] == pytest.approx(
        np.pi * 40 * mass / 3 * CAM_SPEED * AMPLITUDE**2, rel=0.02
    )


def test_a_spring_without_damping_loses_nothing():
    assert slow("multi-mass", stiffness_damping="0 s")["cycle_damper_energy"] == 0.0


def test_what_the_cam_puts_into_a_train_is_lost_in_contacts_and_damper():
    found = vt.simulate("vaz-ohc", "3000 rpm", models=["multi-mass"]).solutions[0].quantities
    lost = found["cycle_dissipated_energy"] + found["cycle_damper_energy"]
    assert 0 < found["cycle_damper_energy"] < lost
    assert lost == pytest.approx(found["cycle_work_energy"], rel=5e-3)
