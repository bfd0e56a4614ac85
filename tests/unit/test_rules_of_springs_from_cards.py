"""Every rule on springs from cards and testers on two springs: one in which it holds and one in which it does not."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.measured.door import Doubt
from valvetrain.spring_card import CatalogueCard, SpringLoad, card_from_table, spring_from_tester
from valvetrain.spring_card.answer import CardAnswer
from valvetrain.spring_card.rules import RULES, CardFacts

PLAIN = {
    "wire_diameter": "4.4 mm", "outer_diameter": "32 mm", "installed_load": SpringLoad("46 mm", "350 N"),
    "open_load": SpringLoad("34 mm", "830 N"),
}  # fmt: skip
DUAL = {
    "wire_diameter": "0.177 in", "outer_diameter": "1.43 in", "installed_load": SpringLoad("1.80 in", "121 lbf"),
    "open_load": SpringLoad("1.20 in", "344 lbf"), "solid_height": "1.06 in",
}  # fmt: skip
SINGLE = {
    "wire_diameter": "0.187 in", "outer_diameter": "1.43 in", "installed_load": SpringLoad("1.80 in", "84 lbf"),
    "open_load": SpringLoad("1.20 in", "239 lbf"), "total_coils": 6.15,
}  # fmt: skip
STEEL = vt.load_case("job-t").springs[0].wire.material
CARDS = {
    "plain": PLAIN, "solid": PLAIN | {"solid_height": "29 mm"}, "long": PLAIN | {"free_length": "57 mm"}, "dual": DUAL,
    "turns": PLAIN | {"total_coils": 6.4}, "single": SINGLE, "odd": PLAIN | {"total_coils": 6.4, "solid_height": "31 mm"},
    "named": PLAIN | {"material": STEEL}, "beehive": PLAIN | {"top_outer_diameter": "28 mm"},
}  # fmt: skip


@cache
def from_table() -> vt.spring_card.TesterFit:
    heights = np.linspace(50e-3, 38e-3, 13)
    table = vt.measured.ForceHeight(heights, 40e3 * (55e-3 - heights))
    card = card_from_table(table, wire_diameter="4.2 mm", outer_diameter="30.2 mm")
    return spring_from_tester(table, card)


@cache
def answer(name: str) -> CardAnswer:
    if name in CARDS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fit = vt.spring_card.spring_from_card(CatalogueCard(**CARDS[name]))
        return CardAnswer(CardFacts(fit, "spring.toml"))
    fit = from_table()
    if name == "off":
        fit = replace(
            fit, wire=replace(fit.wire, by_rod=fit.wire.by_rod + np.array([0.0, 0.0, 30.0]))
        )
    if name == "alone":
        fit = spring_from_tester(fit.table)
    if name == "doubted":
        doubts = tuple(Doubt(f"Z10{k}", "odd", "table.csv", "look") for k in range(4, 8))
        fit = replace(fit, table=replace(fit.table, doubts=doubts))
    if name == "noted":
        fit = replace(fit, table=replace(fit.table, notes=("their sign was turned",)))
    return CardAnswer(CardFacts(fit))


#: Code -> where it holds, where it does not.
HOLDS = {
    "Z101": ("dual", "plain"), "Z102": ("long", "plain"), "Z103": ("off", "tested"),
    **{f"Z10{k}": ("doubted", "tested") for k in range(4, 8)}, "Z112": ("alone", "tested"),
    "Z108": ("solid", "plain"), "Z110": ("plain", "long"), "Z111": ("tested", "off"),
    "Z121": ("noted", "tested"), "Z130": ("plain", "named"), "Z131": ("plain", "solid"), "Z132": ("solid", "plain"),
    "Z133": ("turns", "single"), "Z134": ("single", "turns"), "Z135": ("odd", "solid"), "Z136": ("beehive", "plain"), "Z137": ("plain", "tested"),
    "Z138": ("plain", "tested"), "Z139": ("plain", "long"), "Z140": ("tested", "plain"), "Z141": ("tested", "plain"),
}  # fmt: skip


@pytest.mark.parametrize("code", HOLDS)
def test_a_rule_holds_in_one_spring_and_not_in_the_other(code):
    there, elsewhere = (answer(name).findings.codes for name in HOLDS[code])
    assert code in there and code not in elsewhere


def test_every_rule_has_its_springs():
    assert {rule.code for rule in RULES} == set(HOLDS)


def test_the_number_that_contradicts_the_others_is_the_verdict_and_is_marked():
    shown = answer("long")
    assert (shown.verdict.code, shown.verdict.quantity) == ("Z102", "free_length")
    assert shown.verdict.limit == pytest.approx(57e-3)
    assert shown.verdict.value == pytest.approx(54.65e-3, rel=1e-3)
    assert [one.mark for one in shown.lines].count("warn") == 1


def test_a_stress_is_that_of_the_open_load():
    """Bergsträsser's k 8 F D / (pi d^3) of 830 N, D = 27.6 mm, d = 4.4 mm."""
    index = 27.6 / 4.4
    stress = (index + 0.5) / (index - 0.75) * 8 * 830 * 27.6 / (np.pi * 4.4**3)
    assert f"{stress:.1f} MPa" in answer("plain").lines[-2].cells
