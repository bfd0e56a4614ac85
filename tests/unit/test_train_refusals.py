"""Bodies, contacts and trains with impossible values are refused with the reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import LAW, STIFF, contacts, direct, finger, pushrod, rocker, system
from valvetrain.errors import InputError
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.parameters.train_parts import (
    CamParameters,
    CrankParameters,
    FollowerParameters,
    LeverParameters,
    PushrodParameters,
    SupportParameters,
    ValveParameters,
)
from valvetrain.springs.massless import MasslessSpring
from valvetrain.system.build import build

ROUGH = ContactParameters("linear", STIFF.values, 0.1)


def vaz_with_contact_stiffness(value: str):
    return (
        build(load_case("vaz-ohc", {"train.contacts.cam.contact_stiffness": value}))
        .members[0]
        .system()
    )


@pytest.mark.parametrize(("make", "words"), [
    (lambda: ValveParameters(0.0), "give a value above zero"), (lambda: ValveParameters(-0.1), "give a value above zero"),
    (lambda: ValveParameters(float("nan")), "mass of the valve: nan is not a finite number"),
    (lambda: ValveParameters(0.1, friction=-1.0), "friction"), (lambda: ValveParameters(0.1, head_fraction=1.0), "head_fraction"),
    (lambda: PushrodParameters(-0.2, lower_end=(0, 0)), "mass of the pushrod"), (lambda: SupportParameters(0.0, 0.1), "stiffness of the support"),
    (lambda: LeverParameters((0, 0), 0.03, 0.04, inertia=0.0), "inertia of the lever"), (lambda: CamParameters(0.0), "base_radius"),
    (lambda: CamParameters(0.01, rotation=0), "rotation"),
    (lambda: CrankParameters(0.05, 0.04, 0.001, 0.0), "connecting rod must be longer"),
    (lambda: direct(lash=-1e-4), "at least zero"),
    (lambda: build_mechanism(direct(follower=FollowerParameters("flat")), LAW), "needs a positive mass"),
    (lambda: direct(kind="desmodromic"), "use direct (a bucket tappet), finger"),
    (lambda: direct(model="solid"), "model of the train: 'solid'"),
    (lambda: build_mechanism(finger(lever=None), LAW), "train.lever: a finger train needs a lever"),
    (lambda: build_mechanism(pushrod(pushrod=None), LAW), "needs a pushrod"),
    (lambda: build_mechanism(direct(lash=6e-3), LAW), "not smaller than the valve lift"),
    (lambda: build_mechanism(direct(cam=CamParameters(0.004)), LAW), "cusp"),
    (lambda: build_mechanism(direct(cam=CamParameters(0.004), follower=FollowerParameters("roller", 0.03, 0.05)), LAW), "undercut"),
    (lambda: build_mechanism(direct(contacts={}), LAW), "contact law for 'cam', 'valve_tip' and 'seat', and has none"),
    (lambda: build_mechanism(pushrod(contacts={"cam": STIFF, "seat": STIFF}), LAW),
     "needs a contact law for 'tappet', 'rocker' and 'valve_tip', and has cam, seat; add [train.contacts.tappet], "
     "[train.contacts.rocker], [train.contacts.valve_tip]"),
    (lambda: build_mechanism(direct(contacts=dict.fromkeys(("cam", "valve_tip", "seat"), ContactParameters("linaer"))), LAW), "did you mean linear"),
    (lambda: build_mechanism(finger(lever=LeverParameters((-0.2, 0.0), 0.03, 0.047, inertia=1e-4)), LAW), "cannot rest on a base circle"),
    (lambda: build_mechanism(finger(lever=LeverParameters((-0.03, -0.028), 0.03354, 0.047, inertia=1e-4, valve_angle=math.pi)), LAW),
     "close the valve"),
    (lambda: build_mechanism(finger(lever=LeverParameters((-0.03, -0.028), 0.03354, 0.047, inertia=1e-4, valve_angle=-math.pi / 2)), LAW),
     "parallel to the valve axis"),
    (lambda: ContactParameters("linear", {}, -0.1), "friction_coefficient of the contact must not be negative"),
    (lambda: build_mechanism(direct(contacts=contacts(ROUGH)), LAW), "contact 'valve_tip' of a direct train takes no friction"),
    (lambda: build_mechanism(direct(contacts={**contacts(), "seat": ROUGH}), LAW), "move along one line"),
    (lambda: build_mechanism(rocker(contacts={**contacts(), "cam": ROUGH}), LAW), "a roller, which rolls"),
    (lambda: build_mechanism(pushrod(contacts={**contacts(), "rocker": ROUGH}), LAW), "meet in a ball"),
    (lambda: build_mechanism(finger(contacts={**contacts(), "cam": ROUGH}, model="lumped"), LAW), "knows no tangent"),
    (lambda: build_mechanism(finger(contacts={**contacts(), "cam": ROUGH}, model="single-mass"), LAW), "needs model = 'planar'"),
    (lambda: runner(system(direct()), 0.0), "cam speed must be positive"), (lambda: runner(system(direct()), -10.0), "cam speed must be positive"),
    (lambda: runner(system(direct()), 200.0, TrainOptions(time_step=1e-3)), "cannot resolve the stiffest contact"),
    (lambda: runner(vaz_with_contact_stiffness("2e11 N/mm"), 200.0), "100 kN/mm"),
    (lambda: build(load_case("vaz-ohc", {"train.springs.nested.0.installed_height": "26 mm"})),
     "spring 'outer' of set 'nested' reaches coil bind: 26 mm"),
    (lambda: build(load_case("tdi-pushrod", {"train.springs.stock.0.installed_height": "40 mm", "train.springs.stock.0.solid_height": "33 mm"})),
     "solid at 33 mm"),
])  # fmt: skip
def test_the_impossible_is_refused_in_one_sentence(make, words):
    with pytest.raises(InputError) as error:
        make()
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_step_too_long_for_the_force_that_came_is_reported_as_a_status():
    """A contact that hardens with its force, judged at too low a force: the run says that the step
    was too long, and what to do.
    """
    stiff = ContactParameters(
        "impact",
        {"contact_stiffness": 1e17, "exponent": 2.5, "damping": 0.0, "full_damping_depth": 1e-5},
    )
    built = system(
        direct(contacts=dict.fromkeys(("cam", "valve_tip", "seat"), stiff)),
        spring=MasslessSpring(150.0, 5.0),
    )
    ready = runner(built, 900.0, TrainOptions(samples=720, step_fraction=0.99))
    state = ready.initial_state()
    for _ in range(4):
        state, record = ready.cycle(state)
        if not record.status.completed:
            break
    assert record.status.code == "diverged"
    assert "resolve" in record.status.message or "km/s" in record.status.message
    assert record.status.remedy


def test_a_time_step_that_a_train_would_not_take_is_refused():
    """It was read, and the train ran by its own."""
    case = load_case("vaz-ohc")
    name = next(iter(case.train.springs))
    key = f"train.springs.{name}.0.options.finite-element.time_step"
    with pytest.raises(InputError, match="a train chooses the time step of its springs"):
        load_case("vaz-ohc", {key: "1 us"})


def test_a_spring_that_no_train_would_carry_is_refused():
    from valvetrain.parameters.loading import LIBRARY

    text = (
        LIBRARY / "tdi-pushrod.toml"
    ).read_text() + '\n[spring]\npreload = "200 N"\nrate = "20 N/mm"\n'
    with pytest.raises(
        InputError, match=r"spring: a train carries its springs in \[train.springs\]"
    ):
        parse_case(text)


@pytest.mark.parametrize("word", [
    "multi-mass", "modal-uniform", "wave-rod",
])  # fmt: skip
def test_the_damping_of_a_trains_spring_is_felt(word):
    """Energy per cycle: damping per mass times a third of the mass times the square of the
    retainer's velocity, where no coil surges.
    """
    lost, expected = [], []
    for rate in (0.0, 20.0, 200.0):
        case = load_case(
            "tdi-pushrod", {"train.springs.stock.0.damping.mass_damping": f"{rate} 1/s"}
        )
        built = build(case, spring_models=[word], spring_set=["stock"]).members[0].system()
        ready = runner(built, 200.0, TrainOptions(samples=360))
        state = ready.initial_state()
        for _ in range(6):
            state, record = ready.cycle(state)
        velocity = record.v[:, built.mechanism.index(built.mechanism.retainer)]
        lost.append(float(record.work[3]))
        expected.append(rate * 0.040 / 3 * float(np.mean(velocity**2)) * 2 * math.pi / 200.0)
    assert lost[2] == pytest.approx(expected[2], rel=0.15)
    assert abs(lost[0]) < lost[1] / 3 and lost[1] == pytest.approx(expected[1], rel=0.35)
