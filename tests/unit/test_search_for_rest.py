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


def searched(monkeypatch, **changes):
    """Largest force left (N) and times the forces were asked for, of the finger follower on
    massless springs with ``changes``.
    """
    case = vt.load_case(
        "vaz-ohc", {key.replace("__", "."): value for key, value in changes.items()}
    )
    problem = build(case, spring_models=("massless",), spring_set=("nested-cards",))
    system, forces, asked = (
        problem.members[0].system({}, problem.built),
        train_rest.generalised_forces,
        [],
    )

    def counted(*given):
        asked.append(0)
        return forces(*given)

    monkeypatch.setattr(train_rest, "generalised_forces", counted)
    rest = train_rest.static_equilibrium(system, 0.0)
    monkeypatch.undo()
    return float(np.max(np.abs(forces(system, rest, 0.0, system.spring_force)))), len(asked)


def test_the_usual_train_is_found_in_a_few_steps(monkeypatch):
    left, asked = searched(monkeypatch)
    assert left < 1e-7 and asked < 150


def test_a_heavy_valve_that_sinks_a_long_way_is_found_by_growing_steps(monkeypatch):
    """By steps of 0.2 mm alone its 12 mm took some 360 sums of forces, of finite elements half a
    minute.
    """
    left, asked = searched(monkeypatch, train__valve__mass="125 kg")
    assert left < 1e-6 and asked < 250


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


def test_capped_steps_double_from_the_sixth_on(monkeypatch):
    """A spring of 10 N/mm pulls from 100 mm away: six steps of 0.2 mm, then twice as long each
    until what is left is nearer.
    """
    places = asked_places(monkeypatch, lambda place: 1e4 * (0.1 - place))
    lengths = np.append(np.full(6, 0.2), 0.2 * 2.0 ** np.arange(1, 8))
    assert places[:13] == pytest.approx(np.cumsum(lengths), rel=1e-6)
    assert places[-1] == pytest.approx(100.0, abs=1e-4)


def test_a_step_that_comes_no_nearer_is_taken_back_and_steps_begin_anew(monkeypatch):
    """A wall at 6.5 mm: from 4 mm a step of 3.2 mm would lie in it. From there six steps of 0.2 mm
    again, then 0.4 and 0.8 mm.
    """
    places = asked_places(
        monkeypatch, lambda place: 1e4 * (0.1 - place) - 1e9 * max(place - 6.5e-3, 0.0)
    )
    before = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.6, 2.4, 4.0, 7.2]
    assert places[:18] == pytest.approx([*before, 4.2, 4.4, 4.6, 4.8, 5.0, 5.2, 5.6, 6.4], rel=1e-6)
    assert places[-1] == pytest.approx(6.5 + 935e3 / 1e9, abs=1e-5)


def test_a_weight_falls_through_its_clearance_until_it_stands(monkeypatch):
    """0.44 N of tappet over 0.2 mm of lash on hard steel: nothing holds it and nothing changes on
    the way. The search ended 7 nm above the steel, where the train "comes to no rest".
    """
    places = asked_places(
        monkeypatch, lambda place: 0.44 - 1e9 * max(place - 0.2e-3, 0.0) ** (10 / 9)
    )
    assert places[-1] == pytest.approx(0.2 + 1e3 * (0.44 / 1e9) ** 0.9, abs=1e-8)


def test_a_body_that_nothing_stops_has_no_rest(monkeypatch):
    """It falls a centimetre and a little, not until 200 steps have doubled."""
    places = asked_places(monkeypatch, lambda place: 0.44)
    assert len(places) < 50


def test_contacts_too_hard_for_the_tangent_end_the_search(monkeypatch):
    """Each step came no nearer, and all 200 of them were taken: 1200 sums of forces, of finite
    elements tens of seconds.
    """
    left, asked = searched(monkeypatch, train__contacts__cam__contact_stiffness="2147483648 N/mm")
    assert left > 1.0 and asked < 450


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
        vt.runs.train_modes(vt.load_case("vaz-ohc", {key: "1e9 N/mm"}), spring_models=["massless"])
    assert vt.runs.train_modes(
        vt.load_case("vaz-ohc", {key: "1e7 N/mm"}), spring_models=["massless"]
    )
