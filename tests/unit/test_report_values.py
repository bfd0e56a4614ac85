"""Values of a case as a page shows them: numbers with units, no names of classes."""

from __future__ import annotations

import re

import pytest

from valvetrain.parameters.loading import load_case


@pytest.mark.parametrize("name", ["gu2021-beehive-blind", "vaz-ohc", "tdi-pushrod"])
def test_no_value_is_shown_by_its_class_name(name: str) -> None:
    for one in load_case(name).record().values:
        assert one.text, one.path
        assert not re.search("Parameters|Mapping|<", one.text), one.path


def test_values_carry_the_unit_of_their_file() -> None:
    shown = {one.path: one.text for one in load_case("vaz-ohc").record().values}
    assert shown["operation.cam_speeds"] == "2068 rpm"
    assert shown["train.cam"] == "base radius 18 mm, width 15 mm"
    assert shown["train.contacts.seat"] == "linear, contact stiffness 100 kN/mm, damping 1500 N s/m"
    assert (
        shown["train.contacts.cam"]
        == "hunt-crossley, contact stiffness 200 kN/mm, exponent 1, damping 2 s/m"
    )


def test_a_contact_stiffness_shows_the_power_it_stands_with() -> None:
    shown = {one.path: one.text for one in load_case("tdi-pushrod").record().values}
    assert "N/m^1.5" in shown["train.contacts.cam"]
    assert shown["train.springs.stock.0.open_lift"] == "8.5 mm"
