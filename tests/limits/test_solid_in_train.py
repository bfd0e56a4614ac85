"""Solids that follow a train: its own motion and the rod beside, recorded motion, pairs, refusals, stored runs."""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

from fact_parts import with_code
from valvetrain.errors import InputError
from valvetrain.integrate import solid_store
from valvetrain.integrate.solid_in_train import motion_of
from valvetrain.parameters.installed_spring import Rubbing
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.runs import own_error_bars
from valvetrain.runs.api import simulate
from valvetrain.runs.run_up import run_up
from valvetrain.runs.train_runs import train_modes
from valvetrain.system.build import build
from valvetrain.system.driven import DrivenSprings, RecordedMotion

TURN = 2 * np.pi
RPM = np.pi / 30


def pushrod(bricks=12):
    """The pushrod template with its wire on coarse meshes, damped so that it settles in two turns."""
    text = (resources.files("valvetrain") / "templates" / "pushrod.toml").read_text()
    case = parse_case(text.replace("ratio = 0.016", "ratio = 0.15"), "pushrod")
    wires = tuple(
        one.with_options("finite-element", elements_per_coil=16).with_options(
            "solid", bricks_per_coil=bricks
        )
        for one in case.train.springs["wire"]
    )
    springs = {**case.train.springs, "wire": wires}
    return case.replace(train=case.train.replace(springs=springs, spring_set="wire"))


@pytest.fixture(scope="module")
def study():
    return simulate(
        pushrod(9),
        engine_speeds=[6500 * RPM],
        models=["finite-element", "solid"],
        workers=1,
    )


@pytest.mark.slow
def test_the_train_is_that_of_the_rod(study):
    """Contract: every channel of valve, cam and lever is that of the train with rods, to the bit."""
    rod, solid = study.solutions
    assert solid.status.completed and solid.provenance.system == "train"
    for name in ("valve_lift", "retainer_velocity", "cam_contact_force", "stem_force"):
        assert np.array_equal(rod.channel(name), solid.channel(name)), name
    assert solid.quantities["seating_velocity"] == rod.quantities["seating_velocity"]


def test_rod_and_solid_agree_in_a_train(study):
    """Limit between models: end forces within 2 % of the largest of the rod's, and so their peak below
    10 kHz."""
    rod, solid = study.solutions
    for name in ("seat_force", "retainer_force"):
        one, other = rod.channel(name), solid.channel(name)
        assert np.sqrt(np.mean((one - other) ** 2)) < 0.02 * np.abs(one).max(), name
    peaks = (run.quantities["peak_spring_force"] for run in study.solutions)
    one, other = peaks
    assert other == pytest.approx(one, rel=0.02)


def test_the_missing_feedback_is_told(study):
    """Contract: the difference of the forces on the retainer is a number of the run and stands in its
    fact, with the model that drove."""
    rod, solid = study.solutions
    difference = solid.channel("retainer_force") - rod.channel("retainer_force")
    found = solid.quantities["driver_difference_force"]
    assert found == pytest.approx(np.sqrt(np.mean(difference**2)), rel=1e-6)
    assert "driver_difference_force" not in rod.quantities
    (fact,) = with_code(study.facts, "follows-a-train")
    assert fact.fields["driver"] == "finite-element" and fact.fields["force_difference"] == found


def test_the_error_bar_is_of_a_second_mesh():
    """Contract: numbers carry a bar from a solid two thirds as fine behind the same train."""
    problem = build(pushrod(), spring_models=["solid"])
    way = own_error_bars._way(problem, problem.members[0], {}, 1 / own_error_bars.RATIO)
    assert way.fineness == pytest.approx(2 / 3)
    coarse, own = way.ready.member.system(), problem.members[0].system()
    assert coarse.springs[0].size.per_coil == 8 and own.springs[0].size.per_coil == 12
    assert coarse.train.springs[0].elements_per_coil == own.train.springs[0].elements_per_coil


def test_recorded_motion_goes_through_its_samples():
    """Closed form: a harmonic motion of 12 orders and its derivatives, between the samples of a train."""
    angle = np.arange(1440) * TURN / 1440
    law = RecordedMotion(*(12.0**k * np.sin(12 * angle + k * np.pi / 2) for k in range(3)))
    between = np.linspace(-1.0, 20.0, 997)
    for order, within in ((0, 1e-10), (1, 1e-7), (2, 1e-4)):
        exact = 12.0**order * np.sin(12 * between + order * np.pi / 2)
        assert np.abs(law.lift(between, order) - exact).max() < within * 12.0**order
    assert law.continuity == 2 and len(law.joints) == 1440


def test_the_motion_is_that_of_the_retainer(study):
    """Contract: of a valve with an elastic stem the retainer moves with the tip, not with the head."""
    (member,) = build(pushrod(), spring_models=["solid"]).members
    system = member.system()
    assert isinstance(system, DrivenSprings)
    rod = study.solutions[0]
    law = motion_of(system, rod)
    moved = law.lift(rod.arrays.coords["cam_angle"].values)
    assert moved == pytest.approx(rod.channel("valve_tip_displacement"), abs=1e-12)
    assert np.abs(moved - rod.channel("valve_lift")).max() > 1e-7


@pytest.mark.long
def test_springs_of_a_pair_move_each_by_itself(tmp_path, monkeypatch):
    """Contract: a nested pair has the channels of both and their sum; a second request reads train and
    springs, of which three files are stored."""
    monkeypatch.setattr(solid_store, "_folder", lambda: tmp_path)
    case = load_case("vaz-ohc")
    pair = tuple(
        one.with_options("finite-element", elements_per_coil=6).with_options(
            "solid", bricks_per_coil=8
        )
        for one in case.train.springs["nested"]
    )
    train = case.train.replace(springs={"nested": pair}, spring_set="nested", variants=(), cycles=3)
    chosen = case.replace(train=train)
    first = simulate(chosen, models=["solid"], workers=1).solutions[0]
    assert first.status.completed and len(list(tmp_path.glob("*.nc"))) == 3
    both = first.channel("outer_seat_force") + first.channel("inner_seat_force")
    assert first.channel("seat_force") == pytest.approx(both)
    parts = [first.statistics[f"{one}_peak_spring_force"] for one in ("outer", "inner")]
    assert max(parts) < first.quantities["peak_spring_force"] <= sum(parts) * (1 + 1e-9)
    again = simulate(chosen, models=["solid"], workers=1).solutions[0]
    assert np.array_equal(again.channel("inner_seat_force"), first.channel("inner_seat_force"))
    assert len(list(tmp_path.glob("*.nc"))) == 3


def test_what_solids_cannot_follow_is_refused():
    """Contract: springs that rub on one another and a run-up are refused, with what to take instead;
    modes of the train are those of its driver."""
    case = load_case("vaz-ohc")
    train = case.train.replace(
        spring_set="nested", variants=(), rubbing=Rubbing(coefficient=0.1, normal_force=5.0)
    )
    with pytest.raises(InputError, match="rub on one another"):
        build(case.replace(train=train), spring_models=["solid"]).members[0].system()
    with pytest.raises(InputError, match="run-up"):
        run_up(pushrod(), "3000 rpm", "4000 rpm", "0.5 s", models="solid")
    solid, rod = (train_modes(pushrod(), one) for one in ("solid", "finite-element"))
    assert solid[0].natural_frequency == pytest.approx(rod[0].natural_frequency)
