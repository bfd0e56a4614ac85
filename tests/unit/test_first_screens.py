"""Unit: the numbers and runs that the first picture of a page is made of."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import own_study, rod_run, sweep_study, train_study
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.report.chart import (
    Line,
    Marks,
)
from valvetrain.report.key_figures import key_figures
from valvetrain.report.opening import motion_blocks, opening_chart
from valvetrain.report.page import Grid
from valvetrain.report.run_charts import with_extremes
from valvetrain.report.sections import at_rest
from valvetrain.runs.api import simulate
from valvetrain.runs.statics import static_study
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.status import Status
from valvetrain.solution.study import Study

RPM = np.pi / 30


def lines(panel) -> dict[str, Line]:
    return {one.name: one for one in panel.layers if isinstance(one, Line)}


def test_the_curve_of_a_force_reaches_its_peak_and_its_minimum():
    """Contract: "peak spring force 1783 N" stood over a curve whose samples reach 1185 N."""
    run = simulate("job-c", "8000 rpm", spring_models=["finite-element"]).solutions[0]
    angle, force = with_extremes(run, "seat_force")
    assert force.max() == run.quantities["raw_peak_spring_force"]
    assert force.min() == run.quantities["minimum_spring_force"]
    assert (np.diff(angle) >= 0).all() and 0 <= angle[0] < angle[-1] <= 360
    assert force.max() > run.channel("seat_force").max() + 5


def test_a_spring_that_would_pull_says_so():
    """Contract: job-t ended with "minimum −1609 N", which no seat bears."""
    runs = tuple(
        replace(one, quantities={**one.quantities, "minimum_spring_force": -20.0})
        for one in own_study().solutions
    )
    assert "minimum −20 N, where the spring would leave its seat" in Study(CaseRecord("own"), solutions=runs).verdict  # fmt: skip
    assert "leave its seat" not in own_study().verdict
    closed = Study(CaseRecord("own"), solutions=runs, still={"": {"solid_force": 500.0}}).verdict
    assert ", more than the 500 N that close all coils" in closed
    assert "close all coils" not in own_study().verdict


def test_the_first_picture_has_the_models_that_the_verdict_names_and_the_finest():
    """Contract: of six models the four first were drawn, without the rod whose clashes were told."""
    models = (
        "massless",
        "multi-mass",
        "modal-uniform",
        "modal-varied",
        "wave-rod",
        "finite-element",
    )
    rod, runs = rod_run(), []
    for model in models:
        origin = replace(rod.provenance, model=model, label=model)
        peak = 811.0 if model == "finite-element" else 700.0
        runs.append(
            replace(rod, provenance=origin, quantities={"peak_spring_force": peak}, events=())
        )
    study = Study(CaseRecord("own"), solutions=tuple(runs))
    drawn = lines(opening_chart(study).panels[0])
    assert {"finite-element rod", "equivalent rod"} <= set(drawn)


def test_loads_at_rest_go_up_to_full_lift_and_to_coil_bind():
    """Closed form: a card of 240 N at 36 mm, 560 N at 27 mm and solid at 24 mm."""
    study = static_study(parse_case(template_text("direct", cards=True)))
    rules = {rule.label: rule.value for rule in opening_chart(study).panels[0].rules}
    assert rules == pytest.approx({"installed": 6.75, "full lift": 15.75, "solid": 18.75})
    grid = next(one for one in at_rest.blocks(study) if isinstance(one, Grid))
    rows = {cells[0].text: [cell.text for cell in cells[1:5]] for cells, _ in grid.rows}
    assert rows == {
        "installed": ["6.75", "36", "240", "35.56"],
        "full lift": ["15.75", "27", "560", "35.56"],
        "solid": ["18.75", "24", "–", "–"],
    }


def test_several_springs_at_rest_stand_in_one_picture_over_the_lift():
    """Contract: of a pair and of two sets the first spring alone was drawn and told."""
    pair = static_study(parse_case(template_text("direct", cards=True)), spring_sets=("dual",))
    force = lines(opening_chart(pair).panels[0])
    assert set(force) == {"outer", "inner", "together"}
    assert [one.y[0] for one in force.values()] == pytest.approx([150.0, 85.0, 235.0])
    sets = static_study(load_case("tdi-pushrod"))
    assert set(lines(opening_chart(sets).panels[0])) == {"stock", "performance"}


def test_models_do_not_differ_by_all_of_a_force_that_is_none():
    """Contract: round-off at no compression was drawn as a difference of -100 %."""
    curve = at_rest_curve(np.linspace(0, 8e-3, 9), 40e3)
    off = replace(curve, force=curve.force * 1.01)
    start = replace(curve, force=np.maximum(curve.force, 1e-13))
    found = at_rest.difference(off, start)
    assert np.isnan(found[0]) and found[1:] == pytest.approx(1.0)


def at_rest_curve(compression, rate):
    from valvetrain.solution.static import StaticCurve

    none, size = np.zeros((len(compression), 0)), np.zeros(0)
    return StaticCurve(compression, rate * compression, np.full(len(compression), rate), none, none, size, none, size)  # fmt: skip


def test_modes_open_with_the_orders_that_meet_the_first_one():
    """Closed form: order n meets f at 120 f / n rpm; 24 dots at one height told nothing."""
    study = static_study(parse_case(template_text("direct", cards=True)), command="modes", modes=6)
    (panel,) = opening_chart(study).panels
    marks = next(one for one in panel.layers if isinstance(one, Marks) and one.hints)
    assert marks.y == pytest.approx(541.78, abs=0.01)
    assert marks.x == pytest.approx(120 * marks.y / np.arange(6, 13))
    order = lines(panel)["order 8"]
    assert order.y == pytest.approx(8 * order.x / 120)
    names = next(one for one in panel.layers if isinstance(one, Marks) and one.labels)
    orders = np.array([int(one) for one in names.labels])
    assert names.y == pytest.approx(orders * names.x / 120), "each at the end of its line"
    assert not any("mode" in one.title.lower() for one in figures(study)), "nothing more to show"


def figures(study: Study) -> list:
    return [
        panel
        for block in at_rest.blocks(study)
        if hasattr(block, "chart") and block.chart.key.startswith("modes")
        for panel in block.chart.panels
    ]


def test_a_speed_between_at_which_the_spring_runs_solid_is_told():
    """Contract: the curve of the pushrod template had a gap at 8542 rpm, of which sentence and figures said nothing."""
    study = sweep_study()
    label = study.labels[0]
    last = study.runs(label)[-1]
    origin = replace(last.provenance, engine_speed=last.engine_speed - 1.0)
    values = {**last.quantities, "coil_bind_clearance": 0.0}
    stopped = replace(last, provenance=origin, quantities=values, status=Status("coil-bind", "is solid"))  # fmt: skip
    open_ones = (replace(one, quantities={**one.quantities, "coil_bind_clearance": 2e-3}) for one in study.solutions)  # fmt: skip
    bound = replace(study, solutions=tuple(open_ones), between=(stopped,))
    speed = f"{origin.engine_speed / RPM:.0f} rpm"
    assert f"the run at {speed} reached coil bind" in bound.verdict
    assert "reached coil bind" not in study.verdict
    known = dict(key_figures(bound))["clearance to coil bind at full lift"]
    assert known.startswith("2 mm (") and f"none at {speed})" in known


def test_the_worst_of_a_run_up_is_the_one_that_loses_contact_first():
    """Contract: eight runs up of tdi-pushrod were "worst (stock): in contact" where five others lost it."""
    first, turns = train_study().solutions[0], []
    others = [(f"other {n}", 9000, 20.0) for n in range(4)]
    for label, lost_from, surge in (("stock", 9000, 20.0), *others, ("soft", 3400, 10.0)):
        for speed in range(3000, 4000, 100):
            gap = 2e-4 if speed >= lost_from else 0.0
            values = {"minimum_cam_contact_force": 0.0 if gap else 90.0, "loft_gap": gap, "surge_amplitude_force": surge}  # fmt: skip
            origin = replace(first.provenance, label=label, spring_set=label, engine_speed=speed * RPM)  # fmt: skip
            turns.append(replace(first, provenance=origin, quantities=values, events=()))
    study = Study(CaseRecord("own"), "run-up", tuple(turns))
    assert study.verdict.startswith("Worst (soft): contact is lost first at 3400 rpm")
    drawn = opening_chart(study)
    assert drawn.title == "Least cam force over engine speed" and len(drawn.panels) == 1
    assert "soft" in {one.name for one in drawn.panels[0].layers}, "of which the sentence is"


def test_the_motion_shows_a_model_that_the_figure_draws_and_names_it():
    """Contract: of six models the rod with clash moved, which is not among the four curves beside it."""
    models = "massless", "modal-uniform", "modal-varied", "wave-rod", "wave-rod-clash", "multi-mass"
    study = simulate("job-t", "3000 rpm", spring_models=models, workers=1)
    drawn = {one.name for one in opening_chart(study).panels[0].layers}
    (block,) = motion_blocks(study)
    first = json.loads(block.data)["variants"][0]["words"].removesuffix(", 3000 rpm")
    assert first in drawn and "equivalent rod with clash" not in drawn
    assert block.caption.startswith(f"{first}, 3000 rpm. The reported cam revolution")
