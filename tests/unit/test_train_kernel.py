"""The compiled train loop against its plain twin, and its gap gradients against differences."""

from __future__ import annotations

import numpy as np
import pytest

from train_parts import KINDS, STIFF, contacts, system
from twins.train_step import integrate_in_time
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.parameters.train_parts import SupportParameters, ValveParameters
from valvetrain.system.train_forces import gap_state

IMPACT = ContactParameters(
    "impact",
    {"contact_stiffness": 3.16e9, "exponent": 1.5, "damping": 49920.0, "full_damping_depth": 2e-5},
)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", ["planar", "lumped", "single-mass"])
def test_gap_gradients_are_derivatives(kind, model):
    train = KINDS[kind](
        model=model, support=None if kind == "direct" else SupportParameters(5e7, 0.1), lash=1e-4
    )
    built = system(train)
    position = np.random.default_rng(3).normal(size=len(built.masses)) * 1e-3
    for angle in (0.3, 1.7, 2.6, 5.0):
        _, gradients, slopes = gap_state(built, position, angle)
        for i, unit in enumerate(np.eye(len(position))):
            ahead, behind = (
                gap_state(built, position + step * unit, angle)[0] for step in (1e-7, -1e-7)
            )
            assert (ahead - behind) / 2e-7 == pytest.approx(gradients[:, i], abs=1e-7)
        ahead, behind = (gap_state(built, position, angle + step)[0] for step in (1e-6, -1e-6))
        assert (ahead - behind) / 2e-6 == pytest.approx(slopes, abs=1e-8)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", ["linear", "impact", "rough"])
def test_the_loop_equals_its_plain_twin(kind, law):
    changes = {
        "lash": 1e-4,
        "support": None if kind == "direct" else SupportParameters(5e7, 0.1, 200.0),
    }
    changes["valve"] = ValveParameters(
        0.1, stem_stiffness=1e8, stem_damping=100.0, damping=3.0, friction=2.0
    )
    if law == "impact":
        changes["contacts"] = dict.fromkeys(
            ("cam", "tappet", "rocker", "valve_tip", "seat"), IMPACT
        )
    if law == "rough":
        rubs = {
            "direct": ("cam",),
            "finger": ("cam", "valve_tip"),
            "rocker": ("valve_tip",),
            "pushrod": ("cam", "valve_tip"),
        }[kind]
        changes["contacts"] = contacts() | {
            place: ContactParameters("linear", STIFF.values, 0.12, 0.02) for place in rubs
        }
    ready = runner(system(KINDS[kind](**changes)), 250.0, TrainOptions(samples=720, impact_steps=0))
    start = ready.initial_state()
    steps = ready.steps // 2  # through opening and most of the event
    q, v, _ = integrate_in_time(ready, start, steps)
    end, record = ready.cycle(start)
    contact = ready.system.arrays.laws >= 0
    assert np.min(record.forces[:, contact]) == 0.0
    row = record.q[steps // (ready.steps // 720)]
    assert row == pytest.approx(q, rel=1e-9, abs=1e-13)
    assert np.max(np.abs(v)) > 0.1
    assert end.cam_angle == pytest.approx(2 * np.pi)
