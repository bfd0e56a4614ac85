"""Rules on springs at rest, each on a real one that hits and one that does not; codes and numbers, no sentences."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from spring_parts import GUIDED, SLENDER
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_rest import lift_of
from valvetrain.findings.springs_at_rest import pair_of, states_of
from valvetrain.findings.table import findings_of
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.runs.requests import Modes, Static
from valvetrain.runs.static_study import static_study
from valvetrain.runs.statics import reach_of
from valvetrain.runs.train_runs import train_modes
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.views.answer import Answer
from valvetrain.views.page import data_of, page_of
from valvetrain.views.results import figures_of

LS = str(Path(__file__).resolve().parents[1] / "net" / "ls-v8.toml")
TEMPLATE = str(Path(vt.__file__).parent / "templates" / "pushrod.toml")
MODES = {"count": 6}
TO = {"largest_compression": 18e-3}
TURNS = {
    "train.spring_set": "card",
    "train.springs.card[0].solid_height": None,
    "train.springs.card[0].wire_diameter": "0.2 in",
}


def lift(height: str) -> tuple:
    return "job-c", {"lift_law.maximum_lift": height}, {"models": ("modal-uniform",)}


#: Name -> case, changes, options of a static study.
STUDIES = {
    "pair": (LS, {}, {}),
    "pair-open": (LS, {"train.spring_set": "dual", "train.springs.dual[1].solid_height": None}, {}),
    "turns": (LS, {**TURNS, "train.springs.card[0].active_coils": 4.5}, {}),
    "far": lift("10 mm"),
    "near": lift("13.5 mm"),
    "modes-wire": ("uniform-spring", {}, MODES),
    "alone": ("uniform-spring", {}, {"models": ("modal-uniform",)}),
    "stated": ("uniform-spring", {"spring.solid_height": "21 mm"}, {"models": ("modal-uniform",)}),
    "slender": (SLENDER, {}, TO),
    "guided": (GUIDED, {}, TO),
    "modes": ("job-c", {}, MODES),
    "modes-pair": (LS, {}, MODES),
    "modes-none": ("uniform-spring", {}, {**MODES, "models": ("massless",)}),
    "modes-free": ("uniform-spring", {}, {**MODES, "attached_mass": 0.05}),
    "modes-bent": (SLENDER, {}, {**MODES, "compression": 16.5e-3}),
    "modes-train": (TEMPLATE, {"train.spring_set": "card"}, MODES),
}  # fmt: skip


@cache
def study(name: str) -> Study:
    case, changes, options = STUDIES[name]
    text = case.startswith("\n")
    chosen = parse_case(case, name) if text else load_case(case, changes)
    of_modes = name.startswith("modes")
    request = (
        Modes(case=chosen, **options) if of_modes else Static(case=chosen, steps=12, **options)
    )
    found = static_study(request)
    if name != "modes-train":
        return found
    lowest = (one.lowest(10) for one in train_modes(chosen))
    return replace(found, train_modes=tuple(lowest))


@pytest.mark.parametrize(
    ("code", "holds", "holds_not"),
    [
        ("F101", "slender", "guided"), ("F102", "pair", "alone"), ("F103", "alone", "pair"),
        ("F110", "near", "far"), ("F111", "guided", "slender"), ("F112", "pair-open", "pair"),
        ("F114", "turns", "pair-open"), ("N101", "modes-bent", "modes"),
        ("N102", "modes", "modes-free"), ("F113", "stated", "alone"),
        ("N103", "modes-free", "modes"), ("N104", "modes-none", "modes"),
        ("N111", "modes-train", "modes"), ("N112", "modes-pair", "modes"),
    ],
)  # fmt: skip
def test_a_rule_holds_where_it_must_and_nowhere_else(code, holds, holds_not):
    assert code in findings_of(study(holds)).codes
    assert code not in findings_of(study(holds_not)).codes


def test_the_numbers_of_the_verdict_are_those_of_the_study():
    found = findings_of(study("far"))[0]
    (rest,) = study("far").rest
    assert found.fields["closed"].value == rest.curve.force_at(rest.precompression)
    assert found.value == pytest.approx(rest.curve.force_at(rest.precompression + 10e-3))
    surge = findings_of(study("modes"))[0]
    assert surge.value == study("modes").rest[0].modes.axial_frequencies[0]
    pair = findings_of(study("pair"))[0]
    both = [one.curve.force_at(one.precompression) for one in study("pair").rest]
    assert pair.fields["closed"].value == pytest.approx(sum(both))


def test_a_wire_that_nearly_binds_has_its_load_at_full_lift():
    """Beyond 98 % of the travel to solid, where a curve without need ends, and not at the lift that binds."""
    wire = load_case("uniform-spring").springs[0]
    travel, closed = wire.wire.solid_compression, wire.precompression
    assert reach_of(wire, 0.99 * travel - closed) == pytest.approx(0.99 * travel)
    assert reach_of(wire, travel - closed) == pytest.approx(0.98 * travel)
    assert reach_of(wire, 0.5 * travel - closed) < 0.53 * travel


def test_modes_leave_rubbing_out():
    rubbing = {"train.rubbing": {"coefficient": 0.12, "normal_force": "40 N"}}
    free, rubbed = (train_modes(load_case(LS, changes)) for changes in ({}, rubbing))
    assert np.array_equal(free[0].natural_frequency, rubbed[0].natural_frequency)


def test_a_pair_is_one_load_whichever_models_know_its_springs():
    outer, inner = study("pair").rest
    mixed = replace(study("pair"), rest=(outer, replace(inner, model="finite-element")))
    assert findings_of(mixed)[0].value == findings_of(study("pair"))[0].value
    lifts, force, rate = pair_of(states_of(mixed)).curve()
    at_full = np.interp(states_of(mixed)[0].lift, lifts, force)
    assert at_full == pytest.approx(findings_of(mixed)[0].value, rel=1e-4)
    assert np.gradient(force, lifts)[150] == pytest.approx(rate[150], rel=1e-6)
    assert force[0] == pytest.approx(0, abs=1e-6)
    assert "together" in Answer(mixed).headings and "together" not in Answer(study("far")).headings


def test_the_verdict_names_the_strongest_order_in_use_of_each_spring():
    """By the lift of the train, transformed here, among the orders that meet the surge below the red line."""
    (member,) = build(load_case(LS)).members
    angle = np.arange(7200) * 2 * np.pi / 7200
    lift = 2 / 7200 * np.abs(np.fft.rfft(member.gear.mechanism.kinematics.valve_lift(angle)))
    fields = findings_of(study("modes-pair"))[0].fields
    rows = {one.label: one.cells for one in Answer(study("modes-pair")).lines}
    for place, word in enumerate(("strongest", "other_order")):
        surge = study("modes-pair").rest[place].modes.axial_frequencies[0]
        orders = [k for k in range(1, 41) if 120 * surge / k <= 7000]
        best = max(orders, key=lambda k: lift[k])
        assert int(fields[word]) == best != orders[-1]
        assert rows[f"cam order {best}"][place] == f"{120 * surge / best:.0f} rpm"
    size = lift_of(Facts(study("modes-pair")), int(fields["strongest"]))
    assert size.value == pytest.approx(lift[int(fields["strongest"])], rel=1e-3)
    # the next order, stronger still, is above the red line: a row says so, and the picture has it pale
    surges = [one.modes.axial_frequencies[0] for one in study("modes-pair").rest]
    beyond = math.ceil(120 * min(surges) / 7000) - 1
    assert rows[f"cam order {beyond}"] == tuple(f"{120 * one / beyond:.0f} rpm" for one in surges)
    stems = [
        one
        for one in figures_of(Answer(study("modes-pair")))["surge-orders"].data
        if one.yaxis == "y2"
    ]
    assert {one.opacity < 1 for one in stems if one.x[0] > 7000} == {True}
    assert {one.opacity for one in stems if one.x[0] <= 7000} == {1.0}
    # small orders crowd at low speeds, where their labels would cover each other; those of the verdict have labels
    sizes = [one.y[1] for one in stems if one.x[0] <= 7000]
    labels = {one.y[1] for one in stems if one.text[1]}
    assert min(labels) > max(sizes) / 4 > min(sizes) and max(sizes) in labels


def test_surge_halves_by_the_damping_of_its_mode():
    """Closed form: ln 2 / (2 pi f zeta); of two springs the widths at half power are 2 zeta each."""
    case, found = load_case(LS), findings_of(study("modes-pair")).by("N112")[0].fields
    widths, surges = 0.0, []
    for spring, rest in zip(case.train.spring_parts(), study("modes-pair").rest, strict=True):
        surge = rest.modes.axial_frequencies[0]
        zeta = spring.damping.ratio_at(surge)
        half = study("modes-pair").still[f"{rest.spring}, {rest.model}"]["surge_half_duration"]
        assert half == pytest.approx(math.log(2) / (2 * math.pi * surge * zeta))
        widths += zeta
        surges.append(surge)
    assert found["width"] == f"{100 * widths:.2g} %"
    if "order" in found:  # both resonances at one speed: 120 f / order rpm
        outer, inner = (
            120 * one / int(found[key]) for one, key in zip(surges, ("order", "other"), strict=True)
        )
        assert outer == pytest.approx(inner, rel=widths)
    assert "order" in findings_of(study("modes-wire"))[0].fields


@pytest.mark.parametrize(
    "name", ["pair", "alone", "guided", "modes-pair", "modes-train", "modes-free"]
)
def test_page_rows_and_tables_hold_what_was_computed(name):
    answer = Answer(study(name))
    assert answer.lines and all(len(one.cells) == len(answer.headings) for one in answer.lines)
    assert len(str(answer.verdict).split()) <= 25
    data = data_of(page_of(answer))
    assert data is not None and set(data) == {f"data-{key}" for key in figures_of(answer)}
    assert "modes" in answer.tables() if name.startswith("modes") else "rest" in figures_of(answer)
    assert answer.next_step.split()[:1] == ["valvetrain"] or not answer.next_step
