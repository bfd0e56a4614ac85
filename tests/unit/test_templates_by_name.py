"""Templates by name, ``template:KIND``, where a case is called; no shipped case holds an elastic part
that `check` doubts.
"""

from __future__ import annotations

import math

import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.findings.rules_case import CaseFacts, odd_tube, rod_length
from valvetrain.mechanism.pushrod import pushrod_length
from valvetrain.parameters.loading import library_names, parse_case
from valvetrain.parameters.templates import CARDS, KINDS, template_text

SHIPPED = {name: vt.load_case(name) for name in library_names()}
SHIPPED |= {f"template:{kind}": vt.load_case(f"template:{kind}") for kind in KINDS}
SHIPPED |= {f"{kind} by cards": parse_case(template_text(kind, True)) for kind in (*CARDS, "pushrod")}  # fmt: skip


@pytest.mark.parametrize("name", SHIPPED)
def test_no_shipped_case_holds_a_pushrod_that_check_calls_impossible(name):
    facts = CaseFacts(SHIPPED[name], {})
    assert not [one for rule in (rod_length, odd_tube) for one in rule(facts)]


@pytest.mark.parametrize("name", SHIPPED)
def test_no_pushrod_of_a_shipped_case_carries_sound_faster_than_steel(name):
    """Closed form: a bar of mass m and stiffness k passes its length in sqrt(m / k), a plain one of steel
    at 5100 m/s; a pushrod is longer than 0.1 m, so 60 kN/mm at 62 g were 6 km/s over 0.194 m."""
    train = SHIPPED[name].train
    rod = train and train.pushrod
    if rod and rod.stiffness:
        sound = pushrod_length(train) * math.sqrt(rod.stiffness / rod.mass)
        assert sound < 1.03 * math.sqrt(206e9 / 7850)


@pytest.mark.parametrize("kind", KINDS)
def test_a_template_is_called_by_its_name_from_an_empty_folder(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    named = vt.load_case(f"template:{kind}")
    assert (named.name, named.text) == (kind, template_text(kind))
    assert vt.Case(f"template:{kind}").parameters.text == vt.Case(named).parameters.text


def test_a_template_that_is_none_is_refused():
    with pytest.raises(InputError, match="kind"):
        vt.load_case("template:steam")
