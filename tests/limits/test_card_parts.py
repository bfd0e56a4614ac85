"""Parts written from card values: a spring by two loads at heights, its mass by its wire, contacts
of steel parts by Hertz.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from valvetrain.contact.library import build_contact_law
from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.steel_contacts import steel_contact
from valvetrain.parameters.train_parts import CamParameters

POUND, INCH = 4.4482216152605, 25.4e-3
LOADS = {
    "preload": "130 lbf",
    "installed_height": "1.80 in",
    "open_load": "350 lbf",
    "open_height": "1.25 in",
}
WIRE = {"wire_diameter": "0.177 in", "outer_diameter": "1.30 in"}


def spring(**values: object):
    lines = "\n".join(
        f"{key} = {value if isinstance(value, int | float) else repr(value)}"
        for key, value in values.items()
    )
    (found,) = parse_case(f"[spring]\n{lines}\n").springs
    return found.card


def test_two_loads_at_heights_make_rate_preload_and_lift():
    card = spring(**LOADS, solid_height="1.15 in", mass="96 g")
    assert card.rate == pytest.approx(220 * POUND / (0.55 * INCH), rel=1e-12)
    assert (card.preload, card.open_load) == pytest.approx((130 * POUND, 350 * POUND))
    assert card.open_lift == pytest.approx(0.55 * INCH) and card.solid_height == pytest.approx(
        1.15 * INCH
    )
    assert card.surge_frequency == pytest.approx(0.5 * math.sqrt(card.rate / 0.096))


@pytest.mark.parametrize(("apart", "refused"), [
    (-0.021, True), (-0.019, False), (0.019, False), (0.021, True),
])  # fmt: skip
def test_a_told_rate_may_lie_two_per_cent_from_that_of_the_loads_and_is_the_one_that_counts(
    apart, refused
):
    told = 220 * POUND / (0.55 * INCH) / (1 + apart)
    if refused:
        with pytest.raises(InputError, match="contradicts the loads"):
            spring(**LOADS, rate=f"{told!r} N/m")
    else:
        assert spring(**LOADS, rate=f"{told!r} N/m").rate == pytest.approx(told, rel=1e-12)


def test_a_service_manual_gives_the_rate_by_free_length_and_one_load():
    """Closed form: force over compression; a card of a motorcycle (free length, load at a height, wire) was read as a wire
    whose key preload is unknown.
    """
    manual = {"preload": "146 N", "installed_height": "33.4 mm", "free_length": "41.5 mm"}
    card = spring(**manual, wire_diameter="2.8 mm", outer_diameter="23 mm")
    assert card.rate == pytest.approx(146 / 8.1e-3, rel=1e-12)
    assert (card.preload, card.open_load) == (146.0, None)
    lower = spring(**manual | {"installed_height": "32.4 mm", "preload_height": "33.4 mm"})
    assert lower.preload == pytest.approx(146 * 9.1 / 8.1)


def test_a_spring_shimmed_to_another_height_keeps_the_line_of_its_card():
    card = spring(**LOADS | {"installed_height": "1.75 in", "preload_height": "1.80 in"})
    assert card.preload == pytest.approx(
        (130 + 400 * 0.05) * POUND
    ) and card.open_load == pytest.approx(350 * POUND)
    assert card.open_lift == pytest.approx(0.50 * INCH) and card.installed_height == pytest.approx(
        1.75 * INCH
    )


def test_the_mass_of_the_active_turns_gives_the_surge_frequency_of_the_wire():
    """f = d / (2 pi n D^2) sqrt(G / (2 rho)) of a cylindrical spring fixed at both ends (Wahl
    1963), free of the loads.
    """
    wire, mean, shear, density = 0.177 * INCH, 1.123 * INCH, 79.5e9, 7850.0
    card = spring(**LOADS, **WIRE)
    turns = shear * wire**4 / (8 * mean**3 * card.rate)
    assert card.mass == pytest.approx(density * math.pi**2 * wire**2 * mean * turns / 4, rel=1e-9)
    assert card.surge_frequency == pytest.approx(
        wire / (2 * math.pi * turns * mean**2) * math.sqrt(shear / (2 * density)), rel=1e-9
    )
    assert spring(**LOADS, **WIRE, active_coils=1.1 * turns).mass == pytest.approx(1.1 * card.mass)


@pytest.mark.parametrize(("changes", "words"), [
    ({"open_height": "1.85 in"}, "open_height is not below"), ({"open_lift": "0.5 in"}, "open_lift and open_height"),
    ({"open_load": "120 lbf"}, "does not exceed preload"), ({"active_coils": 9, **WIRE}, "takes .* active coils"),
    ({"outer_diameter": "1.30 in"}, "needs wire_diameter"), ({"wire_diameter": "0.177 in"}, "mean_diameter or outer_diameter"),
    ({"solid_height": "1.9 in"}, "solid_height is not below"),
])  # fmt: skip
def test_cards_that_contradict_themselves_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        spring(**LOADS | changes)


def law_at(place: str):
    contact = steel_contact(place, CamParameters(0.015, width=0.0152))
    return build_contact_law(contact.law, **contact.values)


def test_the_line_of_the_cam_is_as_stiff_as_two_cylinders_in_contact():
    """Approach of two cylinders under q = F / L by plane theory (Johnson 1985, section 5.6), a
    formula of another kind: within 10 %.

    q / (pi E) (1 - nu^2) (2 ln(4 R1 / a) - 1) for either body, half-width a = sqrt(4 q R / (pi
    E*)); radii of a lobe and a roller.
    """
    force, width, one, other, young, poisson = 2000.0, 0.0152, 0.020, 0.0095, 206e9, 0.3
    per_length, reduced = force / width, young / (2 * (1 - poisson**2))
    half = math.sqrt(4 * per_length / (math.pi * reduced * (1 / one + 1 / other)))
    each = (2 * math.log(4 * radius / half) - 1 for radius in (one, other))
    approach = per_length * (1 - poisson**2) / (math.pi * young) * sum(each)
    assert float(law_at("cam").force(approach, 0.0)) == pytest.approx(force, rel=0.1)


def test_a_ball_in_its_cup_and_the_head_on_its_seat():
    """Hertz: F = 4/3 E* sqrt(R) d^1.5 with R = 83.3 mm; a plate of 40 by 5 mm, by hand 117 N/um."""
    reduced = 206e9 / (2 * 0.91)
    assert float(law_at("rocker").force(1e-5, 0.0)) == pytest.approx(
        4 / 3 * reduced * math.sqrt(21 * 3.96875e-3) * 1e-5**1.5, rel=1e-9
    )
    assert float(law_at("seat").force(1e-6, 0.0)) == pytest.approx(116.8, rel=2e-3)


TRAIN = """
[lift_law]
kind = "cam-card"
angle_of = "crank"
lobe_lift = "0.3 in"
duration = "220 deg"
[operation]
engine_speeds = "3000 rpm"
[train]
kind = "direct"
CONTACTS
[train.cam]
base_radius = "18 mm"
[train.follower]
mass = "50 g"
[train.valve]
mass = "90 g"
[[train.springs.one]]
preload = "250 N"
rate = "40 N/mm"
"""


def test_one_word_stands_for_every_place_or_for_those_not_named():
    whole = parse_case(TRAIN.replace("CONTACTS", 'contacts = "steel"')).train
    assert (
        set(whole.contacts) == {"cam", "valve_tip", "seat"}
        and whole.contact("cam").law == "hunt-crossley"
    )
    table = 'contacts.others = "steel"\ncontacts.seat = { law = "linear", contact_stiffness = "100 kN/mm" }'
    mixed = parse_case(TRAIN.replace("CONTACTS", table)).train
    assert mixed.contact("seat").law == "linear" and mixed.contact("cam") == whole.contact("cam")
    one = parse_case(TRAIN.replace("CONTACTS", 'contacts.cam = "steel"')).train
    assert set(one.contacts) == {"cam"}


def test_friction_alone_is_added_to_contacts_of_steel():
    """``--set train.contacts.cam.friction_coefficient=0.06`` asked for a law, of a template by cards."""
    plain = parse_case(TRAIN.replace("CONTACTS", 'contacts = "steel"')).train
    for table in (
        'contacts.others = "steel"\ncontacts.cam.friction_coefficient = 0.06',
        'contacts.others = "steel"\ncontacts.cam = { law = "steel", friction_coefficient = 0.06 }',
    ):
        train = parse_case(TRAIN.replace("CONTACTS", table)).train
        assert train.contact("cam") == replace(plain.contact("cam"), friction_coefficient=0.06)
        assert train.contact("seat") == plain.contact("seat")
    stiff = 'contacts.cam = { law = "steel", contact_stiffness = "100 kN/mm" }'
    with pytest.raises(InputError, match="takes friction_coefficient and friction_velocity alone"):
        parse_case(TRAIN.replace("CONTACTS", stiff))


def test_missing_contacts_are_named_all_at_once_with_the_word_that_fills_them():
    from valvetrain.system.build import build

    with pytest.raises(InputError, match=r"'valve_tip' and 'seat'.*contacts.others = 'steel'"):
        build(parse_case(TRAIN.replace("CONTACTS", 'contacts.cam = "steel"')))
    with pytest.raises(InputError, match="no typical contact of steel parts is known at 'piston'"):
        parse_case(TRAIN.replace("CONTACTS", 'contacts.piston = "steel"'))
