"""Limits between models and outside cases: springs that meet catalogue cards and tables of a spring
tester.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from spring_shapes import beehive
from valvetrain.errors import InputError
from valvetrain.spring_card import tester as closing_coils
from valvetrain.spring_card.card import ground_off, weight
from valvetrain.spring_card.fit import forces_at
from valvetrain.springs.spec import spring_model

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from sample_measurements import progressive_spring, stations_of_tester

LOW, HIGH = vt.spring_card.SpringLoad("46 mm", "350 N"), vt.spring_card.SpringLoad("34 mm", "830 N")
SIZES = {
    "wire_diameter": "4.4 mm",
    "outer_diameter": "32 mm",
    "installed_load": LOW,
    "open_load": HIGH,
}


def force_at(spring, height):
    return vt.static_curve(spring, spring.free_length - height + 1e-3, steps=8).force_at(
        spring.free_length - height
    )


@pytest.fixture(scope="module")
def plain():
    return vt.spring_card.spring_from_card(vt.spring_card.CatalogueCard(**SIZES))


def test_both_loads_are_met_by_the_rod_of_the_static_command(plain):
    assert force_at(plain.definition, 46e-3) == pytest.approx(350, rel=1e-3)
    assert force_at(plain.definition, 34e-3) == pytest.approx(830, rel=1e-3)
    assert plain.spring.installed_height == pytest.approx(46e-3, abs=1e-9)


def test_active_turns_are_those_of_the_formula_within_what_the_rod_adds(plain):
    """EN 13906-1: n = G d^4 / (8 D^3 R); pitch angle and curvature of the rod are worth about a per
    cent.
    """
    wire = plain.definition
    active = wire.total_coils - 2 * wire.lower_end.inactive_coils
    assert active == pytest.approx(79.5e9 * 4.4e-3**4 / (8 * 27.6e-3**3 * 40e3), rel=0.012)


def test_the_spring_of_shigley_comes_back_from_two_loads_of_its_rate():
    """Example 10-1 (music wire 0.037 in, 7/16 in outer diameter, 12.5 turns, 10.5 active, 4.13
    lbf/in, G = 11.85 Mpsi).

    The loads are told low on the curve: further down this slender spring leans, and the rod, which
    the formula is not, gives way.
    """
    steel = vt.parameters.Material("music wire", "28.5 Mpsi", "11.85 Mpsi", "7850 kg/m^3")
    card = vt.spring_card.CatalogueCard(
        wire_diameter="0.037 in",
        outer_diameter="0.4375 in",
        installed_load=vt.spring_card.SpringLoad("1.55 in", f"{4.13 * 0.1} lbf"),
        open_load=vt.spring_card.SpringLoad("1.35 in", f"{4.13 * 0.3} lbf"),
        total_coils=12.5,
        material=steel,
    )
    fit = vt.spring_card.spring_from_card(card)
    assert 12.5 - 2 * fit.definition.lower_end.inactive_coils == pytest.approx(10.5, rel=0.015)
    assert fit.definition.free_length == pytest.approx(1.65 * 25.4e-3, rel=2e-3)


def stacked(wire):
    """Wire times turns, as a card states the solid height (m)."""
    ground = wire.lower_end.ground_coils + wire.upper_end.ground_coils
    return (wire.total_coils + 1 - ground) * float(wire.wire_diameter.value(1.0))


@pytest.mark.parametrize("told", [
    "mass", "total_coils", "solid_height",
])  # fmt: skip
def test_turns_come_from_what_the_card_tells(plain, told):
    """A card made from a known spring gives its turns back, whichever of its numbers tells them."""
    wire = plain.definition
    value = {
        "mass": weight(wire),
        "total_coils": wire.total_coils,
        "solid_height": stacked(wire),
    }[told]
    fit = vt.spring_card.spring_from_card(vt.spring_card.CatalogueCard(**SIZES, **{told: value}))
    assert fit.definition.total_coils == pytest.approx(wire.total_coils, rel=2e-3)
    assert fit.definition.free_length == pytest.approx(wire.free_length, abs=2e-5)
    found = {one.quantity: one.found for one in fit.held}[told]
    binds = told == "solid_height"
    assert found == pytest.approx(wire.computed_solid_height if binds else value, rel=2e-3)


def test_a_beehive_meets_its_card():
    known = beehive("4 mm", "26 mm", "21 mm", 4.0, total_coils=7.0, free_length="50 mm")
    loads = [
        vt.spring_card.SpringLoad(height, force_at(known, height)) for height in (42e-3, 33e-3)
    ]
    card = vt.spring_card.CatalogueCard(
        wire_diameter="4 mm",
        outer_diameter="30 mm",
        top_outer_diameter="25 mm",
        taper_from_coil=4.0,
        installed_load=loads[0],
        open_load=loads[1],
        total_coils=7.0,
        material=known.material,
    )
    fit = vt.spring_card.spring_from_card(card)
    assert fit.definition.lower_end.inactive_coils == pytest.approx(1.0, abs=0.02)
    assert fit.definition.free_length == pytest.approx(50e-3, abs=5e-5)


def test_ground_off_wire_is_the_segment_of_the_circle():
    """Half a ground turn takes the mean of the segments from nothing to a half, by quadrature of
    the closed form.
    """
    from scipy.integrate import quad

    def segment(depth):
        return (
            np.arccos(1 - 2 * depth) - (1 - 2 * depth) * np.sqrt(1 - (1 - 2 * depth) ** 2)
        ) / np.pi

    assert segment(0.5) == pytest.approx(0.5) and segment(1.0) == pytest.approx(1.0)
    assert ground_off(0.5) == pytest.approx(quad(segment, 0, 0.5)[0], rel=1e-3)


@pytest.mark.parametrize(("changes", "words"), [
    ({"mass": "200 g"}, "mass makes .* solid at .* but the second load is given at 34 mm"), ({"mass": "45 g"}, "inactive turns at either end"),
    ({"open_load": LOW}, "the second load of a card is the larger one"),
    ({"solid_height": "35 mm"}, "the solid height is above that of the second load"),
    ({"free_length": "45 mm"}, "no longer than the height of the first load"), ({"outer_diameter": "10 mm"}, "less than three wires"),
    ({"outer_diameter": 32.0}, "mm"), ({"total_coils": -3.0}, "total_coils of the card: .* too small"),
    ({"total_coils": 1e30}, "too large"),
    ({"open_load": "34 mm, 830 N"}, "instance of SpringLoad"), ({"wire_diameter": "1e300 mm"}, "wire_diameter of the card: .* too large"),
    ({"top_outer_diameter": "27 mm", "taper_from_coil": 40.0}, "the taper begins below the top"),
])  # fmt: skip
def test_cards_that_no_spring_has_are_refused_with_the_place(changes, words):
    with pytest.raises(InputError, match=words):
        vt.spring_card.spring_from_card(vt.spring_card.CatalogueCard(**{**SIZES, **changes}))


@pytest.fixture(scope="module")
def table():
    rows = stations_of_tester(30)
    return vt.measured.ForceHeight(1e-3 * rows[:, 0], rows[:, 1])


@pytest.fixture(scope="module")
def tested(table):
    card = vt.spring_card.card_from_table(
        table, wire_diameter=4e-3, outer_diameter=28e-3, total_coils=8.0
    )
    return vt.spring_card.spring_from_tester(table, card, installed_height=47e-3)


@pytest.mark.long
def test_the_pitch_law_behind_a_noisy_table_is_found_within_its_bands(tested):
    """The table comes from the finite-element rod with noise of 0.2 %; coils that never close
    within it are known to their band only.
    """
    true = progressive_spring().pitch.value(tested.wire.stations.coil)
    off = np.abs(tested.wire.stations.pitch - true)
    assert np.all(off <= 3 * tested.wire.stations.spread + 0.03e-3)
    closing = true < 8e-3  # coils that close within the table are known well
    assert np.count_nonzero(closing) >= 3
    assert np.all(off[closing] < 0.25e-3) and np.all(tested.wire.stations.spread[closing] < 0.25e-3)


@pytest.mark.long
def test_rate_preload_and_length_of_the_table_are_those_of_the_spring(tested):
    true = progressive_spring()
    assert tested.free_length[0] == pytest.approx(true.free_length, abs=0.1e-3)
    assert tested.preload[0] == pytest.approx(force_at(true, 47e-3), rel=2e-3)
    assert tested.wire.active_coils[0] == pytest.approx(6.0, abs=2 * tested.wire.active_coils[1])
    assert tested.wire.worst_by_rod < 0.015 * 830


@pytest.mark.long
def test_the_answer_depends_neither_on_the_stations_of_the_table_nor_on_the_points_of_the_fit(
    table, tested, monkeypatch
):
    """Every second station, and half the places along the wire and half the forces at which the fit
    looks.
    """
    monkeypatch.setattr(closing_coils, "PLACES", closing_coils.PLACES // 2 + 1)
    monkeypatch.setattr(closing_coils, "FORCES", closing_coils.FORCES // 2)
    half = vt.measured.ForceHeight(table.heights[::2], table.forces[::2])
    card = vt.spring_card.card_from_table(
        half, wire_diameter=4e-3, outer_diameter=28e-3, total_coils=8.0
    )
    fit = vt.spring_card.spring_from_tester(half, card, installed_height=47e-3)
    for name in ("active_coils", "free_length", "rate", "preload"):
        (one, band), (other, wider) = getattr(tested, name), getattr(fit, name)
        assert abs(one - other) < 2 * np.hypot(band, wider), name
    assert fit.rate[0] == pytest.approx(tested.rate[0], rel=5e-3) and fit.preload[
        0
    ] == pytest.approx(tested.preload[0], rel=5e-3)


def test_loads_of_a_card_are_met_on_any_mesh(plain):
    for elements in (12, 48):
        rod = spring_model("finite-element").build(
            plain.spring.with_options("finite-element", elements_per_coil=elements)
        )
        assert rod.static_forces(np.array([0.0, 12e-3])) == pytest.approx([350, 830], rel=1e-3)


def test_a_table_of_an_even_pitch_far_from_bind_tells_no_progression_and_little_of_the_gaps(plain):
    true = plain.definition
    heights = np.linspace(true.free_length - 2e-3, true.free_length - 10e-3, 12)
    table = vt.measured.ForceHeight(heights, np.array(forces_at(true, heights.tolist())))
    fit = vt.spring_card.spring_from_tester(
        table, vt.spring_card.card_from_table(table, wire_diameter=4.4e-3, outer_diameter=32e-3)
    )
    assert fit.rate[0] == pytest.approx(40.4e3, rel=0.01) and fit.free_length[0] == pytest.approx(
        true.free_length, abs=0.1e-3
    )
    assert not fit.bound and "gaps" in fit.wire.free
    assert np.all(
        np.abs(fit.wire.stations.pitch - true.pitch.value(fit.wire.stations.coil))
        < 3 * fit.wire.stations.spread + 0.05e-3
    )
    assert float(np.max(fit.wire.stations.spread)) > 0.3e-3


@pytest.mark.long
def test_the_end_that_closes_first_is_a_choice_that_turns_the_spring_round(table, tested):
    card = vt.spring_card.card_from_table(
        table, wire_diameter=4e-3, outer_diameter=28e-3, total_coils=8.0
    )
    other = vt.spring_card.spring_from_tester(table, card, "upper", 47e-3)
    assert other.wire.stations.pitch[::-1] == pytest.approx(tested.wire.stations.pitch, abs=0.03e-3)
    assert other.preload[0] == pytest.approx(tested.preload[0], rel=2e-3)


@pytest.mark.parametrize("told", [
    (), ("free_length",), ("total_coils",), ("solid_height", "mass"),
])  # fmt: skip
def test_each_number_of_a_card_stands_beside_the_same_number_of_the_spring(plain, told):
    """What the card asks, or that it is silent, and what the spring that was found has by its own
    wire.
    """
    wire = plain.definition
    own = {
        "free_length": wire.free_length,
        "total_coils": wire.total_coils,
        "solid_height": stacked(wire),
        "mass": weight(wire),
    }
    fit = vt.spring_card.spring_from_card(
        vt.spring_card.CatalogueCard(**SIZES, **{name: own[name] for name in told})
    )
    rows = {one.quantity: one for one in fit.held}
    asked = {
        "installed_load": 350.0,
        "open_load": 830.0,
        "rate": pytest.approx(480 / 12e-3),
        **{name: own[name] if name in told else None for name in own},
    }
    assert {name: one.requested for name, one in rows.items()} == asked
    made = fit.definition
    found = {
        "installed_load": 350.0,
        "open_load": 830.0,
        "rate": 480 / 12e-3,
        "free_length": made.free_length,
        "total_coils": made.total_coils,
        "solid_height": made.computed_solid_height,
        "mass": weight(made),
    }
    assert {name: one.found for name, one in rows.items()} == pytest.approx(found, rel=1e-3)
