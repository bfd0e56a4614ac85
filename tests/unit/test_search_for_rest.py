"""Unit: the search for a train at rest finds it however slowly it comes nearer, and ends where it
comes no nearer.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.system import train_rest
from valvetrain.system.build import build


def asked_places(monkeypatch, force) -> np.ndarray:
    """Places (mm) of a mass of 1 kg at which the search asks for ``force(place)`` (N), those of its
    tangent left out.
    """
    asked: list[float] = []

    def forces(_system, q, _cam_angle, _spring_force):
        asked.append(1e3 * float(q[0]))
        return np.array([force(float(q[0]))])

    monkeypatch.setattr(train_rest, "generalised_forces", forces)
    train_rest.static_equilibrium(SimpleNamespace(masses=np.ones(1), spring_force=float), 0.0)
    return np.array(asked[2::2])  # the start, then in turn the tangent and the next place


def test_a_weight_falls_through_its_clearance_until_it_stands(monkeypatch):
    """0.44 N of tappet over 0.2 mm of lash on hard steel: nothing holds it and nothing changes on
    the way. The search ended 7 nm above the steel, where the train "comes to no rest".
    """
    places = asked_places(
        monkeypatch, lambda place: 0.44 - 1e9 * max(place - 0.2e-3, 0.0) ** (10 / 9)
    )
    assert places[-1] == pytest.approx(0.2 + 1e3 * (0.44 / 1e9) ** 0.9, abs=1e-8)


@pytest.mark.parametrize("lift", [0.0, 5e-3])
def test_the_springs_press_what_they_press_at_rest(lift):
    """The force of the sum is that of its springs, each by its own curve."""
    case = vt.load_case("vaz-ohc")
    problem = build(case, spring_models=("massless",), spring_set=("nested-cards",))
    system = problem.members[0].system({}, problem.built)
    cards = case.train.springs["nested-cards"]
    by_hand = sum(one.card.preload + one.card.rate * lift for one in cards)
    assert system.spring_force(lift) == pytest.approx(by_hand, rel=1e-6)


@pytest.mark.parametrize("sets", ["nested-cards", "nested"])
def test_the_static_curve_goes_by_32_even_steps_to_a_little_above_the_largest_lift(sets):
    """Level of judgement: four times the force at the largest lift. Between the points straight,
    beyond them on as at the ends.
    """
    problem = build(vt.load_case("vaz-ohc"), spring_models=("massless",), spring_set=(sets,))
    system = problem.members[0].system({}, problem.built)
    rest, top = train_rest.rest_of(system), system.mechanism.kinematics.maximum_lift
    assert 5e-3 < top < 15e-3 and rest.lifts == pytest.approx(
        1.05 * top * np.arange(33) / 32, abs=1e-12
    )
    forces = np.array([system.spring_force(lift) for lift in rest.lifts])
    assert rest.spring_forces == pytest.approx(forces, rel=1e-9)
    assert rest.reference_force == pytest.approx(4 * system.spring_force(float(top)), rel=1e-12)
    step = rest.lifts[1]
    asked = np.array([-step, 0.0, 1.25 * step, 32 * step, 34 * step])
    by_hand = [
        2 * forces[0] - forces[1],
        forces[0],
        0.75 * forces[1] + 0.25 * forces[2],
        forces[32],
        3 * forces[32] - 2 * forces[31],
    ]
    assert rest.static_spring_force(asked) == pytest.approx(by_hand, rel=1e-9)


def test_a_train_that_comes_to_no_rest_has_no_modes():
    """Its modes were those of a place where 418 N pushed it on, told without a word."""
    key = "train.contacts.cam.contact_stiffness"
    with pytest.raises(vt.InputError, match=r"comes to no rest .* are left"):
        vt.runs.train_modes(vt.load_case("vaz-ohc", {key: "1e9 N/mm"}), models=["massless"])
    assert vt.runs.train_modes(vt.load_case("vaz-ohc", {key: "1e7 N/mm"}), models=["massless"])
