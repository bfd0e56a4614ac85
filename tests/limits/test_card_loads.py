"""The loads of a card are the card's: every spring by card of every case that ships, at each of its
heights, by every model and in every interface.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call
from valvetrain import registry
from valvetrain.explore.evaluate import PointRequest, evaluate
from valvetrain.explore.outputs import Run
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import library_names, parse_case
from valvetrain.parameters.templates import CARDS, KINDS, template_text
from valvetrain.runs.statics import spring_statics, statics_by_model
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build

CASES = {name: vt.load_case(name) for name in library_names()}
CASES |= {kind: vt.load_case(f"template:{kind}") for kind in KINDS}
CASES |= {f"{kind} by cards": parse_case(template_text(kind, True)) for kind in (*CARDS, "pushrod")}


def springs() -> dict[InstalledSpring, tuple[str, str]]:
    """Spring by card -> its case and its spring set, each spring once."""
    return {
        spring: (name, label)
        for name, case in CASES.items()
        if case.train is not None
        for label, members in case.train.springs.items()
        for spring in members
        if spring.card is not None
    }


SPRINGS = springs()
GIVEN = [pytest.param(one, id=f"{name} {label} {one.name}") for one, (name, label) in SPRINGS.items()]  # fmt: skip


def loads(spring: InstalledSpring) -> dict[float, float]:
    """Lift from the installed height (m) -> load of the card (N)."""
    card = spring.card
    assert card is not None
    known = {0.0: card.preload, 8e-3: card.preload + 8e-3 * card.rate}
    return known if card.open_lift is None else known | {card.open_lift: card.open_load}


@pytest.mark.parametrize("spring", GIVEN)
def test_every_interface_at_rest_gives_the_loads_of_the_card(spring):
    """Contract: the curve of Python was by finite elements on a made-up wire, up to 1.6 % off."""
    name, label = SPRINGS[spring]
    given = loads(spring)
    at, expected = spring.precompression + np.array(list(given)), list(given.values())
    table = {"rate": f"{spring.card.rate:.17g} N/m", "preload": f"{spring.card.preload:.17g} N"}
    own = vt.Spring(**table, mass=f"{spring.card.mass or 0.04:.17g} kg")
    problem = build(CASES[name], spring_set=(label,))
    curves = {"static_curve": vt.static_curve(spring, float(max(at)), steps=24)}
    curves |= {"Spring.static": own.static(float(max(at)), steps=24)}
    curves |= {"run": spring_statics(problem, spring, max(given)).curve}
    for word in registry.names("springs"):
        spec = spring_model(word)
        if not (spec.why_not(spring) or spec.needs_rest or spec.no_statics):
            curves[word] = statics_by_model(spring, word, spec.build(spring, None), np.sort(at), 0).curve  # fmt: skip
    for curve in curves.values():
        assert np.interp(at, curve.compression, curve.force) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("spring", GIVEN)
def test_a_wire_made_up_for_a_card_bears_both_loads_of_it_in_motion(spring):
    """Contract: finite elements of a card had 0.1 to 1.6 % more or less at each of its heights."""
    card = spring.card
    if card.mass is None:
        return
    model = spring_model("finite-element").build(spring, None)
    for lift in (0.0, card.open_lift or 12e-3):
        force = model.force(model.initial_state(lift), lift).retainer
        assert force == pytest.approx(card.preload + card.rate * lift, rel=1e-6)


@pytest.mark.parametrize("kind", [*CARDS, "pushrod"])
def test_the_command_and_a_study_give_the_loads_of_the_card(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(template_text(kind, True), encoding="utf-8")
    (spring,) = CASES[f"{kind} by cards"].train.springs["card"]
    heights = [spring.installed_height - lift for lift in loads(spring)]
    words = [word for one in heights for word in ("--height", f"{one:.17g} m")]
    for model in ("", "finite-element"):
        chosen = ["--model", model] if model else []
        answer = call("static", "mine.toml", "--spring-set", "card", *chosen, *words, "--json")
        (rest,) = json.loads(answer.stdout)["springs_at_rest"]
        found = [one["force"]["value"] for one in rest["points"]]
        assert found == pytest.approx(list(loads(spring).values()), rel=1e-9)
        request = PointRequest(("preload",), rest_model=model)
        outcome = evaluate(CASES[f"{kind} by cards"], {}, Run(), request)
        assert outcome.values["preload"] == pytest.approx(spring.card.preload, rel=1e-9)
