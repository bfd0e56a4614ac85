"""Unit: numbers and names of answers that fresh users took for something else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from synthetic_study import own_study, rod_run, sweep_study, train_study
from valvetrain.cam.event import LiftEvent
from valvetrain.cli.answers import _tables
from valvetrain.explore.damping_found import _meaning, damping_meanings
from valvetrain.explore.identification_file import read_request
from valvetrain.parameters.installed_spring import DampingParameters
from valvetrain.parameters.loading import case_of
from valvetrain.parameters.summary import number
from valvetrain.quantities import clash
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report.opening import opening_chart
from valvetrain.report.page import Details, Grid
from valvetrain.report.sections.answers import answers_blocks
from valvetrain.report.sections.sweep import curve_topics, sweep_chart
from valvetrain.report.study import study_page
from valvetrain.system.build import build

RPM = np.pi / 30
ROOT = Path(__file__).parents[2]


def test_what_rounding_leaves_is_printed_as_zero():
    """A least torque of -2.22e-16 N m stood on the page of a bucket."""
    assert [number(value) for value in (-2.22e-16, 9e-13, 0.0)] == ["0"] * 3
    assert number(4.24e-9).startswith("4.24")


def test_engine_speeds_of_a_table_are_whole_numbers():
    """A sweep printed "93.23 at 6539.07"."""
    study = sweep_study()
    runs = [replace(run, provenance=replace(run.provenance, engine_speed=run.engine_speed + 0.0123)) for run in study.solutions]  # fmt: skip
    shifted = replace(study, solutions=tuple(runs))
    cells = [cell for table in _tables(shifted) for column in table.columns for cell in column.cells]  # fmt: skip
    speeds = [cell.rpartition(" at ")[2].rstrip(" !") for cell in cells if " at " in cell and "(" not in cell]  # fmt: skip
    assert speeds and all(one.isdigit() for one in speeds if one[0].isdigit())


def test_the_page_names_the_spring_model_not_the_spring_set():
    run = train_study().solutions[0]
    origin = replace(run.provenance, label="standard", spring_set="standard", model="modal-uniform")
    page = study_page(replace(train_study(), solutions=(replace(run, provenance=origin),)))
    assert dict(page.facts)["spring model"] == "standard, modal model"


def test_the_list_of_clashes_names_both_of_its_angles():
    """Its one angle was that of the first touch, the verdict's that of the hardest contact."""
    found = [part for block in answers_blocks(own_study()) for part in (block.blocks if isinstance(block, Details) else (block,))]  # fmt: skip
    grids = [one for one in found if isinstance(one, Grid) and "coils" in one.headers]
    assert grids
    for grid in grids:
        assert {"first touch (cam deg)", "hardest (cam deg)"} <= set(grid.headers)


def test_no_line_of_the_first_picture_is_called_contact_lost():
    """The label stood over the base circle, where nothing is lost."""
    chart = opening_chart(train_study())
    assert all("contact lost" not in rule.label for panel in chart.panels for rule in panel.rules)
    assert "in the lift event" in chart.caption


def test_curves_over_engine_speed_hold_the_runs_between_the_swept_speeds():
    """The sentence named 476 N at a speed that the figure below it left out."""
    study = sweep_study()
    label = study.labels[0]
    first = study.runs(label)[0]
    speed = first.engine_speed + 1.0
    there = replace(first.provenance, engine_speed=speed)
    values = {**first.quantities, "peak_spring_force": 4321.0}
    between = replace(first, quantities=values, provenance=there)
    chart = sweep_chart(replace(study, between=(between,)), "Forces", curve_topics()["Forces"], 0)
    (peak,) = [panel for panel in chart.panels if panel.y_label.startswith("peak spring force")]
    line = peak.layers[0]
    assert line.y[np.argmin(abs(line.x - speed / RPM))] == pytest.approx(4321.0)


def test_total_coils_on_a_card_are_refused_by_their_own_name():
    """The refusal said that preload is unknown."""
    card = {"preload": "240 N", "rate": "35 N/mm", "wire_diameter": "3.8 mm", "outer_diameter": "27 mm", "total_coils": 7}  # fmt: skip
    with pytest.raises(vt.InputError, match="on a card with its loads give active_coils") as error:
        vt.Case({"spring": card})
    assert "preload" not in str(error.value)


def test_two_spring_sets_are_labelled_with_their_models():
    """Sets whose case names no model were labelled "stock, "."""
    both = build(case_of("tdi-pushrod"), spring_set=("stock", "performance"))
    assert all(one.label == f"{one.spring_set}, {one.model.word}" for one in both.members)


def test_an_identified_damping_is_said_as_a_share_of_critical():
    """Closed form: a stiffness damping is pi f beta of critical at f; 12 us alone tells an engineer nothing."""
    request = read_request(ROOT / "examples/how-to/damping-from-rig.toml")
    (said,) = damping_meanings(request, {"stiffness_damping": 12e-6}).values()
    share, _, _, _, _, frequency, _ = said.split()
    assert float(share) == pytest.approx(100 * np.pi * float(frequency) * 12e-6, abs=0.05)
    assert said.endswith("of critical at 401 Hz")


def test_an_identified_ratio_of_a_pair_names_its_frequency_and_its_spring():
    """Contract: "Ratio 0.01633 (0.01534 to 0.01732)" told neither."""
    case, key = case_of("vaz-ohc"), "train.springs.nested-cards.{}.damping.ratio"
    damped = DampingParameters(ratio=0.0163, ratio_frequency=400.0)
    springs = tuple(replace(one, damping=damped) for one in case.train.springs["nested-cards"])
    train = replace(case.train, springs={**case.train.springs, "nested-cards": springs})
    damped_case = replace(case, train=train)
    said = [_meaning(damped_case, key.format(place)) for place in (0, 1)]
    assert said == [f"1.6 % of critical at 400 Hz, {one} spring" for one in ("outer", "inner")]


def test_spikes_below_the_base_are_no_main_clash(monkeypatch):
    """Ends that lift leave spikes below the force of the base circle; a sweep failed with an IndexError."""
    angle = np.linspace(0.0, 2 * np.pi, 721)[:-1]
    force = 100.0 + 20.0 * np.sin(40 * angle)

    def held(base: float) -> clash._Force:
        return clash._Force(angle / 400, angle, force, force, force, base)

    monkeypatch.setattr(clash, "_force", lambda cycle, frequency, end: held(200.0))
    event, cycle = LiftEvent(np.radians(60.0), np.radians(200.0)), reported_cycle(rod_run())
    assert clash.find_clash_window(cycle, 600.0, event) is None
