"""One pipeline: a spring told where to go is the limit of a train whose every other part is rigid
and in contact.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import LAW, contacts, direct, system
from valvetrain.integrate.contract import Cycles, Periodic, RunOptions
from valvetrain.integrate.run import run
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.parameters.train_parts import FollowerParameters, ValveParameters
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.massless import MasslessSpring
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.wave_rod import WaveRod
from valvetrain.system.prescribed import PrescribedSpring

CAM_SPEED = 250.0
UNIFORM = EquivalentSpring(rate=30e3, preload=300.0, active_mass=0.04)
MODELS = {
    "massless": MasslessSpring(30e3, 300.0, 0.04),
    "multi-mass": MultiMassSpring.from_card(30e3, 300.0, 0.04, elements=8, mass_damping=300.0),
    "modal-uniform": ModalUniform(UNIFORM, 4, damping_ratio=0.05),
    "wave-rod": WaveRod(UNIFORM, friction=300.0),
}


def stiff_train(spring, stiffness: float, mass: float = 0.02):
    """A direct train whose parts are light and whose contacts are stiff and well damped."""
    law = ContactParameters(
        "linear", {"contact_stiffness": stiffness, "damping": 0.8 * math.sqrt(stiffness * mass)}
    )
    parts = direct(
        contacts=contacts(law),
        follower=FollowerParameters("flat", mass=mass),
        valve=ValveParameters(mass),
        gravity=(0.0, 0.0),
    )
    return system(parts, spring=spring)


@pytest.mark.parametrize("name", MODELS)
def test_a_stiff_light_train_tends_to_prescribed_motion(name):
    told = run(
        PrescribedSpring((MODELS[name],), LAW),
        CAM_SPEED,
        Periodic(60, tolerance=1e-6),
        RunOptions(samples=720),
    )
    assert told.status.completed
    span, errors = float(np.ptp(told.channel("retainer_force"))), []
    for stiffness in (1e7, 1e8, 1e9):
        found = run(
            stiff_train(MODELS[name], stiffness), CAM_SPEED, Periodic(), RunOptions(samples=720)
        )
        assert found.status.completed, found.status.sentence()
        force = np.interp(
            found.cam_angle,
            np.mod(told.cam_angle[:-1], 2 * np.pi),
            told.channel("retainer_force")[:-1],
            period=2 * np.pi,
        )
        errors.append(float(np.max(np.abs(found.channel("retainer_force") - force))) / span)
    assert errors[2] < 0.3 * errors[0] and errors[2] < 0.01, errors


@pytest.mark.parametrize("name", MODELS)
def test_both_systems_give_the_same_names_to_the_same_things(name):
    told = run(PrescribedSpring((MODELS[name],), LAW), CAM_SPEED, Cycles(1), RunOptions(samples=72))
    found = run(stiff_train(MODELS[name], 1e8), CAM_SPEED, Cycles(1), RunOptions(samples=72))
    for channel in ("valve_lift", "retainer_velocity", "seat_force", "retainer_force"):
        one, two = told.channels[channel], found.channels[channel]
        assert one.attrs["units"] == two.attrs["units"] and one.dims == two.dims
    if name != "massless":
        assert told.has("axial_displacement", "axial_velocity") and found.has(
            "axial_displacement", "axial_velocity"
        )
        places = [
            one.channels["coil_number"].values for one in (told, found)
        ]  # a wave rod chooses its grid by the step
        assert (
            all(np.all(np.diff(one) > 0) for one in places)
            and places[0][[0, -1]].tolist() == places[1][[0, -1]].tolist()
        )


def test_the_spring_of_a_train_may_be_told_the_motion_that_it_made():
    """What a train's spring felt, felt again: its recorded lift given to the same spring under
    prescribed motion.
    """
    from valvetrain.cam.spline import Spline

    spring = MODELS["multi-mass"]
    found = run(stiff_train(spring, 1e8), CAM_SPEED, Periodic(), RunOptions(samples=1440))
    lift = found.channel("valve_lift")
    keep = slice(None, None, 4)
    angles, lifts = found.cam_angle[keep], np.where(np.abs(lift[keep]) < 2e-6, 0.0, lift[keep])
    inside = np.flatnonzero(lifts > 0)
    first, last = max(inside[0] - 2, 0), min(inside[-1] + 3, len(lifts))
    law = Spline(
        cam_angles=tuple(angles[first:last]),
        lifts=tuple(np.maximum(lifts[first:last], 0.0)),
        degree=5,
    )
    told = run(
        PrescribedSpring((spring,), law),
        CAM_SPEED,
        Periodic(60, tolerance=1e-6),
        RunOptions(samples=720),
    )
    force = np.interp(
        told.cam_angle[:-1], found.cam_angle, found.channel("retainer_force"), period=2 * np.pi
    )
    assert told.channel("retainer_force")[:-1] == pytest.approx(force, abs=0.03 * np.ptp(force))
