"""Values of a case as a page shows them: numbers with units, no names of classes."""

from __future__ import annotations

import re

import pytest

from valvetrain.parameters.loading import load_case


def shown_values(name: str) -> dict[str, str]:
    """Key path -> words of every value of a library case that names where it comes from."""
    return {value.path: value.words for value in load_case(name).record().values}


@pytest.mark.parametrize("name", ["gu2021-beehive", "vaz-ohc", "tdi-pushrod"])
def test_no_value_is_shown_by_its_class_name(name: str) -> None:
    for path, value in shown_values(name).items():
        assert value, path
        assert not re.search("Parameters|Mapping|<", value), path


def test_values_carry_the_unit_of_their_file() -> None:
    shown = shown_values("vaz-ohc")
    assert shown["operation.cam_speeds"] == "2068 rpm"
    assert shown["train.cam"] == "base radius 18 mm, width 15 mm"
    assert shown["train.contacts.seat"] == "linear, contact stiffness 100 kN/mm, damping 1500 N s/m"
    assert shown["train.contacts.cam"] == "hunt-crossley, contact stiffness 200 kN/mm, exponent 1, damping 2 s/m"


def test_a_contact_stiffness_shows_the_power_it_stands_with() -> None:
    shown = shown_values("tdi-pushrod")
    assert "N/m^1.5" in shown["train.contacts.cam"]
    assert shown["train.springs.stock.0.open_lift"] == "8.5 mm"
