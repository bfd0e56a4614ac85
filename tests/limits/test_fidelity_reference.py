"""Limit between models: what judges spring models of a card whose damping has a share by stiffness.

Closed form: the exact damped wave equation of ``test_card_default``.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from limits.test_card_default import EVENT, MASS, PRELOAD, RATE, exact_seat_force
from valvetrain.runs.fidelity import REFERENCE_MODES, fidelity_models

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


def test_modes_judge_where_stiffness_damps_and_meet_the_wave_equation():
    """The rod of the wave equation, whose damping is another, does not pass; 40 modes do. What modes
    leave out is the damping of the static shape alone, ``k b x'``.
    """
    case, spring = case_of(1.0)
    study = vt.fidelity(
        case.parameters, f"{RPM} rpm", spring_models=["modal-uniform", "wave-rod"], workers=1
    )
    found = study.fidelity
    damping = spring.parameters.damping
    exact = exact_seat_force(
        RPM * np.pi / 30, damping.mass_damping, damping.stiffness_damping, lift
    )
    turn = np.linspace(0.0, 2 * np.pi, len(exact) + 1)
    closing = np.gradient([lift(one) for one in turn], turn)[:-1] * RPM * np.pi / 60
    static_shape = RATE * damping.stiffness_damping * closing
    name = "minimum_spring_force"
    (modes,), (rod,) = (found.of(name, model) for model in ("modal-uniform", "wave-rod"))
    assert found.reference.startswith("modal-uniform, ")
    assert np.ptp(static_shape) < 0.01 * PRELOAD
    assert modes.reference == pytest.approx((exact - static_shape).min(), abs=2e-4 * PRELOAD)
    assert found.reach(name, "modal-uniform").everywhere
    assert (
        abs(rod.value - exact.min()) > 0.05 * PRELOAD
        and not found.reach(name, "wave-rod").everywhere
    )


def test_the_rod_judges_where_mass_alone_damps():
    case, spring = case_of(0.0)
    assert fidelity_models(case.parameters)[-1] == "wave-rod"
    exact = exact_seat_force(RPM * np.pi / 30, spring.parameters.damping.mass_damping, 0.0, lift)
    run = case.run(f"{RPM} rpm", model="wave-rod")
    assert run.quantities["minimum_spring_force"] == pytest.approx(exact.min(), abs=5e-3 * PRELOAD)


@pytest.mark.parametrize(("ratio", "modes"), [(0.004, REFERENCE_MODES), (0.05, 12)])
def test_the_reference_takes_modes_of_which_half_as_many_more_oscillate(ratio, modes):
    spring = vt.Spring(
        preload=PRELOAD, rate=RATE, mass=MASS, damping=DAMPING | {"ratio": ratio, "stiffness_share": 1.0}
    )  # fmt: skip
    case = vt.Case(spring=spring, lift_law=lift, operation={"cycles": 2})
    found = vt.fidelity(case.parameters, "600 rpm", spring_models=["massless"], workers=1).fidelity
    assert found.reference == f"modal-uniform, {modes} modes" and found.reference in found.divided
    assert np.isfinite(found.rows[0].reference_error)
