"""The one-file teaching twin agrees with the assembled train to 0.1 %."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from train_parts import TrainSystem, build_mechanism, direct
from valvetrain.cam.closed_form import SinePower
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.parameters.train_parts import CamParameters, FollowerParameters, ValveParameters
from valvetrain.springs.massless import MasslessSpring

PATH = Path(__file__).resolve().parents[2] / "examples" / "single_mass_valvetrain.py"


@pytest.fixture(scope="module")
def twin():
    spec = importlib.util.spec_from_file_location("single_mass_valvetrain", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def assembled(twin):
    law = ContactParameters(
        "linear", {"contact_stiffness": twin.CONTACT_STIFFNESS, "damping": twin.CONTACT_DAMPING}
    )
    train = direct(
        model="single-mass",
        lash=twin.LASH,
        follower=FollowerParameters("flat", mass=0.05),
        valve=ValveParameters(twin.MASS - 0.05),
        contacts={"cam": law, "valve_tip": law, "seat": law},
        cam=CamParameters(0.022),
    )
    lift = SinePower(
        maximum_lift=twin.LIFT, opening_start=twin.START, closing_end=twin.END, power=4
    )
    system = TrainSystem(
        build_mechanism(train, lift), (MasslessSpring(twin.SPRING_RATE, twin.PRELOAD),)
    )
    ready = runner(system, twin.CAM_SPEED, TrainOptions(step_fraction=0.02))
    state = ready.initial_state()
    for _ in range(2):
        state, record = ready.cycle(state)
    return system, record


def test_the_twin_and_the_assembled_train_are_the_same_motion(twin, assembled):
    system, record = assembled
    assert system.masses[0] == pytest.approx(twin.MASS, rel=1e-12)
    run = twin.simulate()
    assert np.max(np.abs(record.q[:, 0] - run["valve_lift"])) < 1e-3 * run["valve_lift"].max()
    difference = record.forces[:, 0] - run["cam_force"]
    assert np.sqrt(np.mean(difference**2)) < 1e-3 * run["cam_force"].max()
    assert record.q[:, 0].max() == pytest.approx(run["valve_lift"].max(), rel=1e-4)
    assert record.forces[:, 0].max() == pytest.approx(run["cam_force"].max(), rel=1e-3)
    assert record.forces[0, 1] == pytest.approx(run["seat_force"][0], rel=1e-4)


def test_the_example_prints_its_numbers(twin, capsys):
    run = twin.simulate()
    assert run["valve_lift"].max() == pytest.approx(twin.LIFT - twin.LASH, rel=5e-3)
    assert len(PATH.read_text().splitlines()) < 90
