"""A spring by its card in an engine, and its wire: what lies between the two (limit between models), and
that the answers say it (contract). The engine is an own one.
"""

from __future__ import annotations

import pytest

import valvetrain as vt
from fact_parts import with_code
from valvetrain.spring_card import CatalogueCard, SpringLoad, spring_from_card
from valvetrain.springs.equivalent import EquivalentSpring

DAMPING = {"ratio": 0.016, "ratio_frequency": "600 Hz"}
VALVE = 42.0
CARD = CatalogueCard(
    wire_diameter="3.7 mm",
    outer_diameter="25 mm",
    installed_load=SpringLoad("36 mm", "220 N"),
    open_load=SpringLoad("27.4 mm", "590 N"),
    solid_height="22 mm",
)


def engine(spring: dict[str, object], valve: float = VALVE) -> vt.Case:
    """A bucket tappet with one spring; ``valve`` in grams."""
    return vt.Case(
        name="bucket",
        lift_law={"kind": "cam-card", "angle_of": "crank", "valve_lift": "8.6 mm", "duration": "248 deg", "duration_lift": "1 mm", "lash": "0.2 mm"},
        train={
            "kind": "direct", "contacts": "steel", "cam": {"base_radius": "18 mm", "width": "14 mm"}, "spring_model": "modal-uniform",
            "follower": {"shape": "flat", "mass": "22 g"}, "valve": {"mass": f"{valve} g"}, "springs": {"one": [{**spring, "damping": DAMPING}]},
        },
    )  # fmt: skip


@pytest.fixture(scope="module")
def fit():
    return spring_from_card(CARD)


@pytest.fixture(scope="module")
def wire(fit):
    """The block of a case file."""
    turns = fit.definition
    return {
        "wire_diameter": "3.7 mm", "outer_diameter": "25 mm", "total_coils": turns.total_coils, "precompression": fit.spring.precompression,
        "pitch": {"coils": list(turns.pitch.coils), "values": list(turns.pitch.values)}, "material": "EN 10270-2 VDSiCr",
        "ends": {"kind": "closed-ground", "inactive_coils": turns.lower_end.inactive_coils, "ground_coils": 0.5},
    }  # fmt: skip


def least_force(case: vt.Case) -> float:
    return case.run("10000 rpm").quantities["minimum_cam_contact_force"]


def test_end_turns_on_the_retainer_are_what_a_card_lacks(fit, wire):
    """By one model, a card of the wire's rate, preload and moving mass needs the end turns as mass of the
    valve to have the wire's force at the cam; without them it has more.
    """
    same = EquivalentSpring.from_installed(fit.spring)
    card = {
        "rate": same.rate,
        "preload": same.preload,
        "mass": same.active_mass,
        "installed_height": "36 mm",
    }
    due = least_force(engine(wire))
    assert least_force(engine(card, VALVE + 1e3 * same.inactive_mass)) == pytest.approx(
        due, rel=2e-3
    )
    assert least_force(engine(card)) > 1.03 * due


def test_a_run_on_a_card_says_once_what_it_lacks(wire):
    card = {
        "wire_diameter": "3.7 mm", "outer_diameter": "25 mm", "preload": "220 N", "installed_height": "36 mm",
        "open_load": "590 N", "open_height": "27.4 mm",
    }  # fmt: skip
    study = engine(card).compare("6000 rpm")
    assert len(with_code(study.facts, "card-alone")) == 1
    assert "card" not in study.verdict
    assert not with_code(engine(wire).compare("6000 rpm").facts, "card-alone")
