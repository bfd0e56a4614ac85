"""A card whose damping has a share by stiffness: surge modes and the rod of the wave equation.

Closed form: the exact damped wave equation of ``test_card_default``.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from limits.test_card_default import EVENT, MASS, PRELOAD, RATE, exact_seat_force

RPM = 7750  # the second mode is in resonance
DAMPING = {"ratio": 0.015, "ratio_frequency": "353.55 Hz"}


def lift(cam_angle: float) -> float:
    """A lift (m) with two continuous derivatives, so that more than one mode is excited."""
    return 5e-3 * max(0.0, 1 - ((cam_angle - np.pi) / (EVENT / 2)) ** 2) ** 3


def case_of(stiffness_share):
    spring = vt.Spring(
        preload=PRELOAD, rate=RATE, mass=MASS, damping=DAMPING | {"stiffness_share": stiffness_share}
    )  # fmt: skip
    return vt.Case(spring=spring, lift_law=lift, operation={"cycles": 60}), spring


@pytest.fixture(scope="module")
def damped_by_stiffness():
    """Run of a model, the exact seat force and the part of it that damps the static shape (N)."""
    case, spring = case_of(1.0)
    damping = spring.parameters.damping
    exact = exact_seat_force(
        RPM * np.pi / 30, damping.mass_damping, damping.stiffness_damping, lift
    )
    turn = np.linspace(0.0, 2 * np.pi, len(exact) + 1)
    closing = np.gradient([lift(one) for one in turn], turn)[:-1] * RPM * np.pi / 60
    return case, exact, RATE * damping.stiffness_damping * closing


@pytest.mark.parametrize(("modes", "off"), [(20, 2e-3), (60, 2e-4)])
def test_modes_meet_the_wave_equation_damped_by_stiffness(modes, off, damped_by_stiffness):
    """What modes leave out is the damping of the static shape alone, ``k b x'``."""
    case, exact, static_shape = damped_by_stiffness
    assert np.ptp(static_shape) < 0.01 * PRELOAD
    run = case.set({"spring.options.modal-uniform.modes": modes}).run(
        f"{RPM} rpm", models="modal-uniform"
    )
    least = run.quantities["minimum_spring_force"]
    assert least == pytest.approx((exact - static_shape).min(), abs=off * PRELOAD)


def test_the_rod_of_the_wave_equation_has_another_damping(damped_by_stiffness):
    case, exact, _ = damped_by_stiffness
    run = case.run(f"{RPM} rpm", models="wave-rod")
    assert abs(run.quantities["minimum_spring_force"] - exact.min()) > 0.05 * PRELOAD


def test_the_rod_meets_the_wave_equation_damped_by_mass():
    case, spring = case_of(0.0)
    exact = exact_seat_force(RPM * np.pi / 30, spring.parameters.damping.mass_damping, 0.0, lift)
    run = case.run(f"{RPM} rpm", models="wave-rod")
    assert run.quantities["minimum_spring_force"] == pytest.approx(exact.min(), abs=5e-3 * PRELOAD)
