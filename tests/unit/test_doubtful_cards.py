"""Published: cards of catalogues that are in no library. Total loads entered with the outer wire of a
dual spring are doubted; a single whose open load is near solid is met, or refused for that reason.
"""

from __future__ import annotations

import math
import warnings

import pytest

import valvetrain as vt
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.dual_spring import read_pair
from valvetrain.parameters.loading import parse_case
from valvetrain.spring_card import SpringLoad
from valvetrain.views.results import answer_of

#: Total loads of a dual spring with the wire and diameter of its outer spring.
DUAL = {"wire_diameter": "0.177 in", "outer_diameter": "1.43 in"}
#: A published single spring.
SINGLE = {
    "wire_diameter": "0.187 in", "outer_diameter": "1.43 in", "installed_load": SpringLoad("1.80 in", "84 lbf"),
    "open_load": SpringLoad("1.20 in", "239 lbf"), "total_coils": 6.15,
}  # fmt: skip
SAYS = r"1\.9 active turns, but the solid height makes 6\.5 in all.*dual spring.*enter outer and inner as two springs"


def test_a_catalogue_card_of_a_dual_spring_is_doubted():
    loads = {"installed_load": SpringLoad("1.80 in", "121 lbf"), "open_load": SpringLoad("1.20 in", "344 lbf")}  # fmt: skip
    with pytest.warns(UnusualValueWarning, match=SAYS.replace(r"6\.5", r"5\.99")):
        fit = vt.spring_card.spring_from_card(
            vt.spring_card.CatalogueCard(**DUAL, **loads, solid_height="1.06 in")
        )
    assert answer_of(fit).verdict.code == "Z101"


@pytest.mark.parametrize(
    ("solid", "says"),
    [({"solid_height": "1.15 in"}, SAYS), ({}, "fewer than the 2 that a spring has: .* dual")],
)
def test_a_card_of_a_case_file_is_doubted(solid, says):
    loads = {"preload": "121 lbf", "installed_height": "1.80 in", "open_load": "344 lbf", "open_height": "1.20 in"}  # fmt: skip
    with pytest.warns(UnusualValueWarning, match=says):
        vt.Case(name="own", spring=vt.Spring(**DUAL, **loads, **solid))


def test_the_outer_spring_alone_is_not_doubted():
    """Its share of the rate, G d^4 / (8 D^3 n) of 4.5 active turns, is 156 of 372 lbf/in."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        card = vt.Spring(**DUAL, preload="52 lbf", installed_height="1.80 in", rate="156 lbf/in", solid_height="1.15 in")  # fmt: skip
        vt.Case(name="own", spring=card)


def test_a_published_single_is_met_with_its_turns():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fit = vt.spring_card.spring_from_card(vt.spring_card.CatalogueCard(**SINGLE))
    held = {one.quantity: one for one in fit.held}
    for load, force in (("installed_load", 373.65), ("open_load", 1063.1)):
        assert held[load].found == pytest.approx(force, rel=1e-3)
    assert held["total_coils"].found == pytest.approx(6.15)
    # by torsion, G d^4 / (8 D^3 k), there are 3.55
    assert fit.definition.active_coils == pytest.approx(3.55, rel=0.02)
    assert "early" in fit.free


def test_where_coils_close_before_the_second_load_the_refusal_says_so():
    with pytest.raises(
        InputError, match=r"solid at 29\.\d+ mm, 1\.\d mm below .* coils close before it"
    ) as refused:
        vt.spring_card.spring_from_card(
            vt.spring_card.CatalogueCard(**SINGLE, solid_height="1.15 in")
        )
    assert "6.18 active" not in str(refused.value)


@pytest.mark.parametrize(("wire", "doubted"), [("0.177 in", True), ("0.187 in", False)])
def test_a_dual_spring_whose_inner_one_is_the_stiffer_is_doubted(wire, doubted):
    """Closed form, G d^4 / (8 D^3 n) of 4.5 active turns: total loads with a thin outer wire left 37.7 of 65.7 N/mm to an
    inner spring of two turns, ready to run without a word.
    """
    outer = {"preload": "130 lbf", "installed_height": "1.80 in", "open_load": "355 lbf", "open_height": "1.20 in"}  # fmt: skip
    pair = [
        {
            "loads_of": "pair",
            "solid_height": "1.15 in",
            "wire_diameter": wire,
            "outer_diameter": "1.430 in",
            **outer,
        },
        {"loads_of": "pair", "wire_diameter": "0.120 in", "outer_diameter": "1.000 in"},
    ]
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        read_pair(pair)
    says = [str(one.message) for one in found]
    assert bool(says) is doubted
    assert all("inner spring would be the stiffer one (37.7 against 28 N/mm, 2.04 active turns)" in one for one in says)  # fmt: skip


def card_of(**keys):
    lines = "\n".join(f'{key} = "{value}"' for key, value in keys.items())
    return parse_case(f'name = "own"\n[spring]\n{lines}', "own").springs[0].card


def test_a_manual_with_free_length_and_two_loads_takes_the_rate_of_the_loads():
    """(52.3 - 25.5) kgf / 12.4 mm is 21.2 N/mm; 25.5 kgf over the 13 mm from the free length are 19.2."""
    loads = {"preload": "25.5 kgf", "installed_height": "44 mm", "open_load": "52.3 kgf", "open_height": "31.6 mm"}  # fmt: skip
    with pytest.warns(UnusualValueWarning, match=r"21\.2 N/mm.* 19\.24 N/mm"):
        card = card_of(**loads, free_length="57 mm")
    assert card.rate == pytest.approx(26.8 * 9.80665 / 12.4e-3)


def test_a_weighed_card_may_state_its_diameter_without_the_wire():
    loads = {"preload": "150 lbf", "installed_height": "1.80 in", "open_load": "420 lbf", "open_height": "1.14 in"}  # fmt: skip
    assert card_of(**loads, outer_diameter="1.29 in", mass="45 g").mass == pytest.approx(0.045)


@pytest.mark.parametrize(
    ("given", "doubted"),
    [({}, False), ({"mass": 1.1}, False), ({"mass": 1.5}, True), ({"active_coils": 1.3}, True)],
)
def test_mass_or_turns_that_do_not_go_with_rate_and_wire_are_doubted(given, doubted):
    """First surge of n turns in closed form: d sqrt(G / (2 rho)) / (2 pi D^2 n), with n = G d^4 / (8 D^3 k)."""
    wire, mean, rate, shear, density = 2.9e-3, 19.6e-3, 28e3, 79.5e9, 7850.0
    sizes = {"preload": 165.0, "rate": rate, "wire_diameter": wire, "mean_diameter": mean}
    plain, turns = SpringCard(**sizes), shear * wire**4 / (8 * mean**3 * rate)
    surge = wire * math.sqrt(shear / (2 * density)) / (2 * math.pi * mean**2 * turns)
    assert plain.surge_frequency == pytest.approx(surge, rel=1e-12)
    of_wire = {"mass": plain.mass, "active_coils": turns}
    card = SpringCard(**sizes, **{key: share * of_wire[key] for key, share in given.items()})
    assert (f"{surge:.0f} Hz" in card.doubt) == doubted == bool(card.doubt)
    assert not doubted or f"{card.surge_frequency:.0f} Hz" in card.doubt
