"""Engines from card values of every train, and two springs side by side: contract of templates and
commands; the mass that moves against its formula (closed form).
"""

from __future__ import annotations

import math
import re
import warnings

import pytest

import valvetrain as vt
from fact_parts import with_code
from unit.cli_parts import call
from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.runs.compare_springs import with_two_springs
from valvetrain.runs.cost import RunRequest, planned
from valvetrain.system.build import build

SOFT = 'name = "soft"\n[spring]\npreload = "300 N"\nrate = "36 N/mm"\nmass = "42 g"\n'
STIFF = 'name = "stiff"\n[spring]\npreload = "340 N"\nrate = "46 N/mm"\nmass = "50 g"\n'


@pytest.mark.parametrize("kind", ["direct", "finger", "rocker", "pushrod"])
@pytest.mark.parametrize("spring_set", ["card", "dual"])
def test_every_train_runs_from_cards(kind, spring_set):
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # cards that go together
        case = parse_case(template_text(kind, cards=True))
    assert case.train.lash == pytest.approx(case.lift_law.values.get("lash", case.train.lash))
    springs = case.train.springs[spring_set]
    assert len(springs) == (2 if spring_set == "dual" else 1) and all(
        one.wire is None for one in springs
    )
    (run,) = vt.simulate(case, "3000 rpm", "massless", spring_sets=spring_set).solutions
    assert run.status.completed
    assert run.quantities["minimum_cam_contact_force"] > 50


def test_a_spring_of_a_pair_whose_coil_bind_is_not_known_is_named():
    """The clearance of a pair is then that of the other spring alone."""
    text = template_text("direct", cards=True)
    assert text.count('solid_height = "21 mm"') == 1  # of the inner card
    for changed, named in ((text, False), (text.replace('solid_height = "21 mm"', ""), True)):
        study = vt.simulate(parse_case(changed), "3000 rpm", "massless", spring_sets="dual")
        assert study.solutions[0].quantities["coil_bind_clearance"] > 0
        unknown = with_code(study.facts, "unknown-solid-height")
        assert [one.fields["spring"] for one in unknown] == ["inner"] * named


@pytest.mark.parametrize("cards", [False, True], ids=["wire", "cards"])
@pytest.mark.parametrize("kind", ["direct", "finger", "rocker", "pushrod"])
def test_every_train_has_its_modes_valve_closed_and_open(kind, cards):
    """The bucket by cards came to no rest: its tappet falls through the lash."""
    case = vt.Case(template_text(kind, cards=cards), name=kind)
    found = vt.runs.train_modes(case, models=["massless"])
    assert [one.state for one in found] == ["closed", "full_lift"]
    assert "seat" in found[0].closed and "seat" in found[1].open


@pytest.mark.parametrize("cards", [False, True], ids=["wire", "cards"])
@pytest.mark.parametrize("kind", ["direct", "finger", "rocker", "pushrod"])
def test_friction_at_the_cam_is_added_to_every_template_as_the_guide_says(kind, cards):
    """Guide 18; templates by cards have contacts of steel, which asked for a law."""
    key = "train.contacts.cam.friction_coefficient"
    case = parse_case(template_text(kind, cards=cards), changes={key: 0.06})
    assert case.train.contact("cam").friction_coefficient == 0.06


@pytest.mark.parametrize("kind", ["direct", "finger", "rocker", "pushrod"])
def test_the_friction_that_a_template_names_is_taken_by_its_train(kind):
    """Contract: comments named the cam of a roller, which takes none."""
    text = template_text(kind, cards=True)
    place, given = re.findall(r"(\w+)\.friction_coefficient = (\d\.\d+)", text)[0]
    build(parse_case(text, changes={f"train.contacts.{place}.friction_coefficient": float(given)}))
    if place != "cam":
        rolls = parse_case(text, changes={"train.contacts.cam.friction_coefficient": 0.06})
        with pytest.raises(
            InputError, match=r"rolls.*give train.contacts.valve_tip.friction_coeff"
        ):
            build(rolls)


def test_the_moving_mass_of_a_card_is_that_of_its_active_turns():
    """rho pi^2 d^2 D n / 4 with n = G d^4 / (8 D^3 k)."""
    (spring,) = parse_case(template_text("direct", cards=True)).train.springs["card"]
    d, mean, rate = 3.8e-3, 23.2e-3, 320 / 9e-3
    turns = 79.5e9 * d**4 / (8 * mean**3 * rate)
    assert spring.card.mass == pytest.approx(7850 * math.pi**2 * d**2 * mean * turns / 4, rel=0.01)


@pytest.mark.parametrize("words", [(), ("--red-line", "6000 rpm")], ids=["wire", "cards"])
@pytest.mark.parametrize("kind", ["direct", "finger", "rocker", "pushrod"])
def test_every_spring_of_a_template_is_damped_and_new_says_by_how_much(
    kind, words, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    printed = call("new", "mine", "--kind", kind, *words).stdout
    case = vt.Case("mine.toml").parameters
    for springs in case.train.springs.values():
        assert all(one.damping.ratio or one.damping.mass_damping for one in springs)
    damping = case.train.spring_parts()[0].damping
    assert f"damped by {damping.ratio:g} of critical at {damping.ratio_frequency:g} Hz" in printed


def test_two_springs_run_in_the_engine_under_their_own_names():
    both = with_two_springs(
        parse_case(template_text("direct")), parse_case(SOFT), parse_case(STIFF)
    )
    assert list(both.train.springs) == ["soft", "stiff"]
    rates = {name: springs[0].card.rate for name, springs in both.train.springs.items()}
    assert rates == {"soft": 36e3, "stiff": 46e3}
    # of the engine's own spring, for neither card gives any
    assert both.train.springs["soft"][0].damping.ratio == 0.016
    with pytest.raises(InputError, match=r"no \[train\]"):
        with_two_springs(parse_case(SOFT), parse_case(SOFT), parse_case(STIFF))


def test_a_sweep_runs_the_spring_set_that_the_case_names_as_a_run_does():
    """It ran both, and its estimate counted both; where none is named, every one."""
    case = parse_case(template_text("direct", cards=True))
    free = parse_case(template_text("direct", cards=True).replace('spring_set = "card"\n', ""))
    for asked, sets in ((case, {"card"}), (free, {"card", "dual"})):
        study = vt.sweep(asked, "3000 rpm", ["massless"], critical_speeds=False)
        assert {run.spring_set for run in study.solutions} == sets
        request = RunRequest("sweep", asked, (300.0,), ("massless",), (), 1)
        assert [springs for _, springs in planned(request)] == [
            asked.train.springs[name] for name in sorted(sets)
        ]
