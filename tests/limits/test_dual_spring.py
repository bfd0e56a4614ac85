"""Closed form: a dual spring that is known by its total loads has the loads of its two springs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.dual_spring import part
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text

SHEAR = 79.5e9
#: Wire, mean diameter (m), active turns, free length (m).
OUTER, INNER = (4.8e-3, 31e-3, 4.4, 0.056), (3.3e-3, 22.8e-3, 5.2, 0.0545)
HEIGHT = 0.0457
PAIR = '''
[[spring]]
loads_of = "pair"
preload = "PRELOAD N"
installed_height = "45.7 mm"
rate = "RATE N/m"
wire_diameter = "4.8 mm"
mean_diameter = "31 mm"
active_coils = 4.4
material = { name = "own", youngs_modulus = "206 GPa", shear_modulus = "79.5 GPa", density = "7850 kg/m^3" }
OUTER
[[spring]]
loads_of = "pair"
wire_diameter = "3.3 mm"
mean_diameter = "22.8 mm"
active_coils = 5.2
material = { name = "own", youngs_modulus = "206 GPa", shear_modulus = "79.5 GPa", density = "7850 kg/m^3" }
INNER
'''  # fmt: skip


def of_formula(wire, mean, turns, free):
    """Rate (N/m) and preload (N) by EN 13906-1."""
    rate = SHEAR * wire**4 / (8 * mean**3 * turns)
    return rate, rate * (free - HEIGHT)


LOADS = np.array([of_formula(*OUTER), of_formula(*INNER)])
RATE, PRELOAD = LOADS.sum(axis=0)


def half(spring, turns=True, free=True):
    wire, mean, coils, length = spring
    return SpringCard(
        loads_of="pair", wire_diameter=wire, mean_diameter=mean, installed_height=HEIGHT, material="EN 10270-2 VDSiCr",
        active_coils=coils if turns else None, free_length=length if free else None,
    )  # fmt: skip


@pytest.mark.parametrize(("turns", "free"), [((1, 1), (1, 1)), ((1, 1), (1, 0)), ((1, 1), (0, 1)), ((1, 0), (1, 0)), ((0, 1), (1, 1))])  # fmt: skip
def test_both_springs_are_found_from_their_sum(turns, free):
    found = part(RATE, PRELOAD, half(OUTER, turns[0], free[0]), half(INNER, turns[1], free[1]))
    assert found.rates == pytest.approx(LOADS[:, 0])
    assert found.preloads == pytest.approx(LOADS[:, 1])
    assert found.active_coils == pytest.approx((OUTER[2], INNER[2]))
    assert found.free_lengths == pytest.approx((OUTER[3], INNER[3]))


@given(some.floats(0.75, 1.35), some.floats(10.0, 2000.0), some.booleans())
def test_the_parts_add_up_to_the_total_at_every_height(factor, preload, free):
    found = part(factor * RATE, preload, half(OUTER, free=False), half(INNER, free=False))
    heights = np.linspace(0.03, HEIGHT, 5)
    assert ("measure wires, diameters and turns again" in found.rates_by) == (abs(factor - 1) > 0.1)
    loads = sum(
        rate * (length - heights)
        for rate, length in zip(found.rates, found.free_lengths, strict=True)
    )
    assert loads == pytest.approx(preload + factor * RATE * (HEIGHT - heights))
    assert found.rates[0] / found.rates[1] == pytest.approx(LOADS[0, 0] / LOADS[1, 0])


def written(outer="", inner="", preload=PRELOAD, rate=RATE):
    text = PAIR.replace("OUTER", outer).replace("INNER", inner)
    return parse_case(text.replace("PRELOAD", repr(float(preload))).replace("RATE", repr(float(rate))), "own")  # fmt: skip


def test_a_case_file_is_parted_and_says_how():
    outer, inner = written('free_length = "56 mm"', 'free_length = "54.5 mm"').springs
    assert (outer.name, inner.name) == ("outer", "inner")
    assert (outer.card.rate, inner.card.rate) == pytest.approx(LOADS[:, 0])
    assert (outer.card.preload, inner.card.preload) == pytest.approx(LOADS[:, 1])
    split = outer.card.split
    assert (split["outer_rate"], split["inner_rate"]) == pytest.approx(LOADS[:, 0])
    assert (split["outer_preload"], split["inner_preload"]) == pytest.approx(LOADS[:, 1])
    assert "both free lengths" in split["preloads_by"]
    wire, mean, turns, _ = INNER
    assert inner.card.mass == pytest.approx(7850 * np.pi**2 * wire**2 * mean * turns / 4)


def test_two_heights_are_as_good_as_a_rate():
    text = template_text("pushrod", cards=True)
    singles = parse_case(text, "own").train.springs["dual"]
    head, rest = text.split("[[train.springs.dual]]", 1)
    rest = rest.replace("\n", '\nloads_of = "pair"\n', 1)
    rest = rest.replace('preload = "95 lbf"', 'preload = "135 lbf"').replace(
        '"234 lbf"', '"336 lbf"'
    )
    for key in ('preload = "40 lbf"', 'open_load = "102 lbf"', 'open_height = "1.17 in"'):
        rest = rest.replace(f"{key}\n", "")
    second = rest.index("[[train.springs.dual]]\n") + len("[[train.springs.dual]]\n")
    rest = f'{rest[:second]}loads_of = "pair"\n{rest[second:]}'
    pair = parse_case(f"{head}[[train.springs.dual]]{rest}", "own").train.springs["dual"]
    lift = singles[0].card.open_lift
    for closed in (True, False):
        loads = [[one.card.preload if closed else one.card.preload + one.card.rate * lift for one in both] for both in (singles, pair)]  # fmt: skip
        assert sum(loads[1]) == pytest.approx(sum(loads[0]), rel=1e-6)
        assert loads[1] == pytest.approx(loads[0], rel=0.1), "turns by solid heights"


@pytest.mark.parametrize(
    ("outer", "inner", "given", "says"),
    [
        ('mass = "90 g"', "", {}, "change total_coils or wire_diameter, and leave mass out"),
        ("", 'preload = "90 N"', {}, "are those of both; leave preload out here"),
        ('free_length = "45 mm"', "", {}, "the free length of the outer spring makes"),
        ("", "", {"rate": 3 * RATE}, "check wires, diameters, turns and loads"),
        (
            'solid_height = "40 mm"\nopen_height = "37 mm"',
            "",
            {},
            r"spring\.0\.open_height: the open load is given at 37 mm",
        ),
        ("", "", {"preload": 0.0}, "the total preload of the pair is missing"),
    ],
)
def test_what_contradicts_the_total_is_refused_at_its_place(outer, inner, given, says):
    with pytest.raises(InputError, match=says):
        written(outer, inner, **given)


def test_a_pair_is_detuned_by_the_turns_of_one_which_leave_the_loads_of_both(tmp_path):
    """Closed form: the rate of a spring goes as 1 / turns, its mass as turns; a study of detuning varied the
    mass, which a pair refuses.
    """
    turns = np.array([4.7, 5.2, 5.7])
    text = PAIR.replace("OUTER", "").replace("INNER", "")
    text = text.replace("PRELOAD", repr(float(PRELOAD))).replace("RATE", repr(float(RATE)))
    (tmp_path / "pair.toml").write_text(text)
    study = f"""
case = "{(tmp_path / "pair.toml").as_posix()}"
spring_models = ["multi-mass"]
outputs = ["inner_card_surge_frequency", "inner_card_rate", "outer_card_rate", "inner_card_preload", "outer_card_preload"]
points = {{ sampler = "grid" }}
vary = [{{ key = "spring.1.active_coils", values = {turns.tolist()} }}]
"""
    table = vt.study(study, workers=1)
    rates, loads = (
        [table.column(f"{one}_card_{name}") for one in ("inner", "outer")]
        for name in ("rate", "preload")
    )
    assert sum(rates) == pytest.approx(np.full(3, RATE)) and sum(loads) == pytest.approx(
        np.full(3, PRELOAD)
    )
    wire, mean, _, _ = INNER
    mass = 7850 * np.pi**2 * wire**2 * mean * turns / 4
    assert table.column("inner_card_surge_frequency") == pytest.approx(
        0.5 * np.sqrt(rates[0] / mass)
    )
