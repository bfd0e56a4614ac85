"""Contract: what an engine card is answered with where a user's words, units or heights are not those
of a case file. Each of these passed silently, or was answered with another thing, before.
"""

from __future__ import annotations

import warnings

import pytest

from unit.cli_parts import call
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_kind, template_text
from valvetrain.units import parse_quantity
from valvetrain.workbench.workspace import Workspace

PUSHROD = template_text("pushrod", cards=True)
#: The open load of the first card, below its solid height.
LOW = PUSHROD.replace('open_height = "1.25 in"', 'open_height = "1.10 in"', 1)
SAYS = "the open load is given at 27.94 mm, but the spring is solid at 29.21 mm"


@pytest.mark.parametrize("command", [("check",), ("run",), ("sweep", "--engine-speed", "3000:4000:500")])  # fmt: skip
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


@pytest.mark.parametrize(
    ("word", "kind"),
    [("bucket", "direct"), ("Tappet", "direct"), ("push-rod", "pushrod"), ("finger follower", "finger"), ("swing_arm", "finger"),
     ("rocker-arm", "rocker"), ("OHV", "pushrod"), ("direct", "direct")],
)  # fmt: skip
def test_trains_go_by_the_words_of_their_users(word, kind):
    assert template_kind(word) == kind
    if word != kind:
        text = PUSHROD.replace('kind = "pushrod"', f'kind = "{word}"', 1)
        with pytest.raises(InputError, match=f'train.kind: .* is called {kind}: write "{kind}"'):
            parse_case(text, "own")


@pytest.mark.parametrize(
    ("word", "says"),
    [("roller", "a shape of what runs on the cam"), ("DOHC", "an overhead cam drives direct"), ("buckit", "did you mean direct?"),
     ("desmo", "use direct (a bucket tappet), finger")],
)  # fmt: skip
def test_what_names_no_train_is_answered_with_those_there_are(word, says):
    with pytest.raises(InputError) as refused:
        parse_case(PUSHROD.replace('kind = "pushrod"', f'kind = "{word}"', 1), "own")
    assert says in str(refused.value)


def test_a_doubt_about_a_dual_spring_names_spring_and_set():
    text = PUSHROD.replace('preload = "95 lbf"', 'preload = "135 lbf"').replace('open_load = "234 lbf"', 'open_load = "500 lbf"')  # fmt: skip
    with pytest.warns(UnusualValueWarning, match="spring 'outer' of set 'dual': rate, wire"):
        parse_case(text, "own")


@pytest.mark.parametrize("kind", ["pushrod", "direct", "finger", "rocker"])
def test_the_cards_of_the_templates_raise_no_doubt(kind):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parse_case(template_text(kind, cards=True), kind)


@pytest.mark.parametrize(
    ("text", "dimension", "offers"),
    [("0.187", "length", "'0.187 in' or '0.187 mm'"), ("4.2", "length", "'4.2 mm' or '4.2 in'"), ("130", "force", "'130 N' or '130 lbf'"),
     ("360", "stiffness", "'360 N/mm' or '360 lbf/in'"), ("96", "mass", "'96 g' or '96 lb'"), ("236", "angle", "'236 deg'"),
     ("130 lbf/in", "force", "'1 N' or '1 lbf'")],
)  # fmt: skip
def test_a_bare_number_is_offered_the_units_of_both_systems(text, dimension, offers):
    with pytest.raises(InputError) as refused:
        parse_quantity(text, dimension)
    assert str(refused.value).endswith(offers)


def test_the_command_offers_inches_for_a_wire_in_inches():
    result = call("spring-card", "--wire-diameter", "0.187", "--outer-diameter", "1.30 in")
    assert result.exit_code == 2 and "write '0.187 in' or '0.187 mm'" in result.stderr
