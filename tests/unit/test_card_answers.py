"""Contract: what an engine card is answered with where a user's words, units or heights are not those
of a case file. Each of these passed silently, or was answered with another thing, before.
"""

from __future__ import annotations

import warnings

import pytest

from unit.cli_parts import call
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.system.build import build
from valvetrain.units import parse_quantity
from valvetrain.workbench.workspace import Workspace

PUSHROD = template_text("pushrod", cards=True)
#: The open load of the first card, below its solid height.
LOW = PUSHROD.replace('open_height = "1.25 in"', 'open_height = "1.10 in"', 1)
SAYS = "the open load is given at 27.94 mm, but the spring is solid at 29.21 mm"


@pytest.mark.parametrize("command", [("check",), ("run",), ("sweep", "--rpm", "3000:4000:500")])  # fmt: skip
def test_an_open_load_below_the_solid_height_is_refused_at_its_line(command, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(LOW, encoding="utf-8")
    result = call(command[0], str(path), *command[1:])
    assert result.exit_code == 2
    assert SAYS in result.stderr and "springs.card.0.open_height" in result.stderr


def test_the_field_of_the_workbench_refuses_it_too(tmp_path):
    space = Workspace(tmp_path)
    case = space.new_case("own", "pushrod")
    with pytest.raises(InputError, match="the open load is given at"):
        space.set_value(case, "train.springs.card.0.open_height", "1.10 in")


def test_an_open_lift_below_the_solid_height_is_refused():
    text = PUSHROD.replace('open_height = "1.25 in" # or open_lift, or rate', 'open_lift = "0.70 in"', 1)  # fmt: skip
    with pytest.raises(InputError, match=r"springs\.card\.0\.open_lift: .*by open_lift"):
        parse_case(text, "own")


def test_an_open_load_at_the_solid_height_passes():
    """Catalogues print the load at coil bind."""
    parse_case(PUSHROD.replace('open_height = "1.25 in"', 'open_height = "1.15 in"', 1), "own")


@pytest.mark.parametrize("kind", ["pushrod", "direct", "finger", "rocker"])
def test_the_cards_of_the_templates_raise_no_doubt(kind):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parse_case(template_text(kind, cards=True), kind)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('preload = "130 lbf"', 'preload = "130 lb"', "'130 lb' is a mass, but a force is needed here, write '130 lbf'"),
        ('preload = "130 lbf"', 'preload = "130#"', "pounds of force are written 'lbf'"),
        ('open_load = "350 lbf"\nopen_height = "1.25 in"', 'rate = "400 lb/in"', "write '400 lbf/in'"),
        ('installed_height = "1.80 in"', "installed_height = '1.80\"'", "inches are written 'in'"),
        ("rocker_ratio = 1.6", 'rocker_ratio = "1.6:1"', "write a ratio as a plain number"),
        ("rocker_ratio = 1.6", "rocker_ratio = 16", "give a value of at most 5"),
        ('preload = "130 lbf"', 'seat_load = "130 lbf"', "that is preload here"),
        ('solid_height = "1.15 in"', 'coil_bind = "1.15 in"', "that is solid_height here"),
        ('outer_diameter = "1.44 in"', 'OD = "1.44 in"', "that is outer_diameter here"),
        ('outer_diameter = "1.03 in"', 'outer_diameter = "1.50 in"', "38.1 mm wide and does not fit into the outer one, which is 26.82 mm"),
        ('wire_diameter = "0.192 in"', 'wire_diameter = "0.192 mm"', "active turns, which no spring has"),
        ('advertised_duration = "288 deg"', 'advertised_duration = "250 deg"', "count at 0.015 or 0.020 in: advertised_lift"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::valvetrain.errors.UnusualValueWarning")
def test_a_slip_on_a_card_is_answered_with_what_is_meant(old, new, says):
    text = PUSHROD
    assert old in text
    with pytest.raises(InputError) as refused:
        build(parse_case(text.replace(old, new, 1), "own"))
    assert says in str(refused.value)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('angle_of = "crank"', 'angle_of = "cam"', "472 crank deg .* longer than that of any engine"),
        ('mass = "145 g"', 'mass = "0.145 g"', "a valve of 0.145 g is light for a lift of 14.35 mm"),
        ('wire_diameter = "0.130 in"', 'wire_diameter = "0.160 in"', "active turns, but the solid height leaves"),
    ],
)  # fmt: skip
def test_what_hardly_any_engine_has_is_warned_of(old, new, says):
    assert old in PUSHROD
    with pytest.warns(UnusualValueWarning, match=says):
        build(parse_case(PUSHROD.replace(old, new, 1), "own"), spring_set=("card",))


def test_inches_are_read_in_every_spelling():
    assert parse_quantity("1.8 inches", "length") == parse_quantity("1.8 in", "length")
