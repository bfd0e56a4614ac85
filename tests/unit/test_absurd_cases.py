"""Cases that no valvetrain is: refused with a sentence on the part, before anything runs, or answered."""

from __future__ import annotations

import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.errors import InputError
from valvetrain.explore.case_paths import vary
from valvetrain.explore.space import Varied
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.templates import template_text
from valvetrain.runs.refusals import refuse_implausible
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.system.build import build


def case(template="spring", **changes):
    return vt.Case(template_text(template)).set(
        {key.replace("__", "."): value for key, value in changes.items()}
    )


def refused(made, words):
    with pytest.raises(InputError, match=words):
        refuse_implausible(build(made.parameters), ())
    with pytest.raises(InputError, match=words):
        made.run("3000 rpm")


@pytest.mark.parametrize("wire", ["0.3 mm", "0.2 mm", "0.39 mm"])
def test_a_wire_thinner_than_that_of_any_valve_spring_is_refused(wire):
    refused(case(spring__wire_diameter=wire), r"wire_diameter: the thinnest wire is 0\.")


def test_coils_too_wide_for_their_wire_are_refused():
    refused(case(spring__wire_diameter="0.5 mm"), r"the spring index .* is 44, above 25: ")


@pytest.mark.parametrize("friction", [100, 3])
def test_a_contact_that_rubs_as_none_does_is_refused(friction):
    made = vt.Case(template_text("direct")).set(
        {"train.contacts.cam.friction_coefficient": friction}
    )
    words = rf"cam\.friction_coefficient: the friction coefficient is {friction}, above 2: "
    with pytest.raises(InputError, match=words):
        made.run("3000 rpm")


def test_the_command_says_it_with_the_option_that_lets_it_pass(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text(template_text("spring"))
    said = sentence(
        call("run", "own.toml", "--set", "spring.wire_diameter=0.3 mm", "--rpm", "4000 rpm")
    )
    assert "0.3 mm" in said and "--implausible" in said


def test_rates_that_follow_from_a_wire_are_not_taken_for_slips_of_units():
    """A wire of 0.3 mm makes 1.5 N/m, which nobody wrote."""
    spring = case(spring__wire_diameter="0.3 mm").parameters.springs[0]
    assert EquivalentSpring.from_installed(spring).rate == pytest.approx(1.5, rel=0.1)


@pytest.mark.parametrize("height", ["44.1 mm", 0.0441, "4.41 cm"])
def test_a_spring_installed_at_its_free_length_has_no_preload(height):
    """Its free length is 44.1 mm but for rounding in the last digit of a double."""
    made = case(spring__installed_height=height)
    wire = made.parameters.springs[0].wire
    assert 0 < abs(wire.free_length - 0.0441) < 1e-15
    assert made.parameters.springs[0].precompression == 0
    assert (
        InstalledSpring(wire=wire, precompression=abs(wire.free_length - 0.0441)).precompression
        < 1e-15
    )
    run = made.run("3000 rpm", models="massless")
    assert run.status.completed and not run.gaps, run.gaps
    assert run.quantities["minimum_spring_force"] == pytest.approx(0.0, abs=1e-6)


RATIO = "train.springs.stock[0].damping.ratio"


def test_a_place_in_a_list_is_taken_in_brackets_too():
    """By --set, by set and by studies alike."""
    made = vt.Case(template_text("direct"))
    for changed in (made.set({RATIO: 0.5}).parameters, vary(made.parameters, {Varied(RATIO): 0.5})):
        assert changed.train.springs["stock"][0].damping.ratio == 0.5
    dotted = {"train.springs.stock.0.wire_diameter": "4 mm"}
    assert made.set({"train.springs.stock[0].wire_diameter": "4 mm"}) == made.set(dotted)
    assert made.set({"train.springs.stock[0].wire_diameter": 0.004}) == made.set(dotted)


def test_the_command_takes_it_too(tmp_path):
    (tmp_path / "own.toml").write_text(template_text("direct"))
    shown = call("check", str(tmp_path / "own.toml"), "--set", f"{RATIO}=0")
    assert shown.exit_code == 0, shown.output
