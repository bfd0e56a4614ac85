"""Unit: the sentence of a run, a comparison, a sweep and a map of models says what its numbers say:
what did not complete first, limits next, the worst run by name, words that agree in number.
"""

from __future__ import annotations

import io
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

import valvetrain as vt
from synthetic_study import own_study, published_study, sweep_study, train_study
from valvetrain.cli.answers import show_study
from valvetrain.cli.modes import followed_sentence
from valvetrain.integrate.clash import RESTS, STRIKES
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.quantities.train_events import CAUSE_INERTIA, CAUSE_SURGE, CAUSE_VIBRATION
from valvetrain.report.chart import Chart, Line, Panel, Rule
from valvetrain.report.headlines import headline_rows
from valvetrain.report.key_figures import key_figures
from valvetrain.report.model_charts import error_bar_chart
from valvetrain.report.model_verdict import refine_verdict
from valvetrain.report.page import Details, Tabs, render
from valvetrain.report.plotly_chart import figure
from valvetrain.report.study import study_page
from valvetrain.runs.error_bars import Uncertainty, UncertaintyStudy
from valvetrain.runs.statics import static_study
from valvetrain.solution.later import is_computed
from valvetrain.solution.modes import TrainModes
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.status import Event, Status
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import ErrorBars

RPM = np.pi / 30
CALM = {
    "coil_bind_clearance": 2.2e-3, "loss_of_contact_duration": 0.0, "loft_gap": 0.0, "bounce_count": 1.0, "bounce_height": 4e-4,
    "minimum_cam_contact_force": 35.0,
}  # fmt: skip


def train(*runs: dict[str, float], status: Status | None = None, **changes) -> Study:
    """A study of one train with these quantities, at 6000, 7000, ... rpm."""
    first = train_study().solutions[0]
    made = tuple(
        replace(
            first,
            quantities={**CALM, **values},
            provenance=replace(
                first.provenance, engine_speed=(6000 + 1000 * place) * RPM, label="stock"
            ),
            status=status if status is not None and place == len(runs) - 1 else first.status,
        )
        for place, values in enumerate(runs)
    )
    return Study(CaseRecord("own"), solutions=made, **changes)


def test_one_run_of_a_train():
    expected = (
        "One bounce of 0.4 mm, no loft, clear of coil bind by 2.2 mm, minimum cam force 35 N."
    )
    assert train({}).verdict == expected
    assert repr(train({})).splitlines()[0] == expected
    assert train({}).solutions[0].verdict == expected


@pytest.mark.parametrize(
    ("values", "clause"),
    [
        ({"bounce_count": 0.0}, "no loft, no bounce,"),
        ({"bounce_count": 3.0}, "3 bounces up to 0.4 mm,"),
        ({"bounce_height": 2.65e-6}, "no loft, no bounce above 0.1 mm, minimum"),
        ({"bounce_height": 1.01e-4}, "One bounce of 0.101 mm, no loft, clear of"),
        ({"loss_of_contact_duration": 2e-4, "loft_gap": 5.9e-5, "minimum_cam_contact_force": 0.0},
         "without contact, one bounce of 0.4 mm, clear of coil bind by 2.2 mm."),
        ({"loss_of_contact_duration": 2e-4, "loft_gap": 5.9e-5}, "Loft of 59 µm, 0.2 ms without contact,"),
        ({"loss_of_contact_duration": 2e-4}, "Contact lost for 0.2 ms, one bounce of 0.4 mm, clear of"),
        ({"float_excess_lift": 1e-4}, "Floats 0.1 mm above the rigid lift,"),
        ({"float_excess_lift": 4e-5}, "One bounce of 0.4 mm, no loft, clear"),
        ({"coil_bind_clearance": 1.7e-4}, "no loft, only 0.17 mm clear of coil bind,"),
        ({"lift_loss_displacement": 7.6e-5}, "no loft, flex takes 76 µm of lift, clear"),
        ({"lift_loss_displacement": 3e-5}, "no loft, clear"),
        ({"coil_bind_clearance": -6e-4}, "Solid 0.6 mm before the largest lift,"),
        ({"seating_velocity": 0.8}, "minimum cam force 35 N; seating velocity 0.8 m/s, above the 0.52 m/s called smooth."),
        ({"seating_velocity": 0.8, "permitted_seating_velocity": 0.7}, "seating velocity 0.8 m/s, above its limit of 0.7 m/s."),
        ({"seating_velocity": 0.8, "permitted_seating_velocity": 0.9}, "clear of coil bind by 2.2 mm, minimum cam force 35 N."),
        ({"clash_count": 1.0}, "one coil clash, minimum"),
        ({"clash_count": 0.0}, "clear of coil bind by 2.2 mm, minimum"),
        ({"minimum_piston_clearance_gap": 1.5e-3}, "clear of the piston by 1.5 mm,"),
        ({"minimum_cam_contact_force": 1234.6}, "minimum cam force 1235 N."),
    ],
)  # fmt: skip
def test_what_a_train_did(values, clause):
    assert clause in train(values).verdict


def test_what_is_lost_is_told_before_what_is_well_but_after_a_solid_spring():
    """Contract: the sentence of a train that floats began with its room to coil bind."""
    flies = {"loss_of_contact_duration": 2e-4, "loft_gap": 5e-4, "float_excess_lift": 4e-4}
    said = train(flies).verdict
    places = [said.lower().index(one) for one in ("loft of", "floats", "one bounce", "clear of coil bind")]  # fmt: skip
    assert places == sorted(places) and places[0] == 0
    solid = train({**flies, "coil_bind_clearance": -6e-4}).verdict
    assert solid.startswith("Solid 0.6 mm before the largest lift, loft of")
    assert train({"bounce_count": 0.0}).verdict.startswith("Clear of coil bind by 2.2 mm, no loft")
    piston = train({"minimum_piston_clearance_gap": -1e-4, "bounce_count": 0.0}).verdict
    assert piston.startswith("The valve meets the piston, no loft, no bounce, clear of")


def test_a_valve_above_its_rigid_lift_has_no_lift_lost():
    """Contract: minus 2.9 um stood as "lift lost" where the valve floats; other columns keep theirs."""
    lifts = {"lift_loss_displacement": -2.9e-6}
    study = train(lifts)
    assert "lift_loss_displacement" not in [row.name for row in headline_rows(study)]
    assert study.solutions[0].quantities["lift_loss_displacement"] == -2.9e-6
    rows = {row.name: row.values for row in headline_rows(train(lifts, {"lift_loss_displacement": 4e-5}))}  # fmt: skip
    assert rows["lift_loss_displacement"] == (None, pytest.approx(0.04))


def test_a_single_spring_beside_a_pair_has_its_surge_frequency():
    """Contract: the row was left out for all columns where one of them was a nested pair."""
    pair = {"surge_frequency": 500.0, "outer_surge_frequency": 500.0, "inner_surge_frequency": 580.0}  # fmt: skip
    found = {row.name: row.values for row in headline_rows(train({"surge_frequency": 540.0}, pair))}
    assert found["surge_frequency"] == (540.0, None)
    assert found["outer_surge_frequency"] == (None, 500.0)
    alone = [row.name for row in headline_rows(train(pair))]
    assert "surge_frequency" not in alone and "outer_surge_frequency" in alone


def test_the_worst_speed_is_named_once_and_where_runs_differ_each_by_itself():
    worse = {"minimum_cam_contact_force": 5.0, "bounce_count": 2.0, "bounce_height": 5e-4}
    said = train({}, worse).verdict
    assert said.startswith("Worst at 7000 rpm: 2 bounces up to 0.5 mm, no loft, clear of")
    mixed = train({"bounce_count": 2.0, "bounce_height": 5e-4}, {"minimum_cam_contact_force": 5.0})
    assert (
        "2 bounces up to 0.5 mm at 6000 rpm; no loft, clear of coil bind by 2.2 mm; minimum cam force 5 N at 7000 rpm."
        in mixed.verdict
    )


def test_a_number_of_one_label_is_not_told_of_another():
    """A card without a solid height beside one that has it: the clearance is the other's."""
    one, other = train({}, {"loft_gap": 2e-6, "loss_of_contact_duration": 1e-4}).solutions
    bare = {k: v for k, v in other.quantities.items() if k != "coil_bind_clearance"}
    speed = one.provenance.engine_speed
    card = replace(other, quantities=bare, provenance=replace(other.provenance, engine_speed=speed, label="card", spring_set="card"))  # fmt: skip
    said = Study(CaseRecord("own"), solutions=(one, card)).verdict
    assert said.startswith("Loft of 2 µm, 0.1 ms without contact (card);")
    assert "; clear of coil bind by 2.2 mm (stock);" in said


def test_a_loss_says_why_and_how_much_surge_takes_off_the_spring():
    def lost(cause: str, **details: float) -> str:
        event = Event("loft", 3.3, 0.01, 1e-4, 9e-5, "m", "cam", {"cause": cause, **details})
        values = {"loss_of_contact_duration": 2e-4, "loft_gap": 9e-5, "surge_amplitude_cam_order": 7.0}  # fmt: skip
        study = train(values)
        return replace(study, solutions=(replace(study.solutions[0], events=(event,)),)).verdict

    surge = lost(CAUSE_SURGE, spring_force_loss=123.4)
    assert (
        "ms without contact because surge lowers the spring force by 123 N there (order 7),"
        in surge
    )
    assert "because inertia exceeds the spring force," in lost(CAUSE_INERTIA)
    assert "because the train vibrates," in lost(CAUSE_VIBRATION)
    assert "because" not in lost("something else")


@pytest.mark.parametrize(
    ("lift", "degrees", "said"),
    [
        (7.6e-5, 245.6, "flex takes 76 µm of lift and 3.3 crank deg of duration at 0.050 in,"),
        (2e-5, 245.6, "flex takes 20 µm of lift and 3.3 crank deg of duration at 0.050 in,"),
        (-2e-5, 245.6, "flex takes 3.3 crank deg of duration at 0.050 in,"),
        (2e-5, 248.0, "no loft, clear"),
    ],
)
def test_flex_takes_lift_and_duration(lift, degrees, said):
    rigid = {"rigid_valve_50_thou_open_crank_angle_range": math.radians(248.9)}
    values = {"lift_loss_displacement": lift, "valve_50_thou_open_crank_angle_range": math.radians(degrees)}  # fmt: skip
    assert said in train(values, still={"stock": rigid}).verdict


def test_lift_and_duration_that_flex_takes_each_at_the_speed_where_it_takes_most():
    """The duration stood as of the speed of the largest loss of lift: 1.7 deg where 3.3 are lost."""
    rigid = {"rigid_valve_50_thou_open_crank_angle_range": math.radians(248.9)}
    name = "valve_50_thou_open_crank_angle_range"
    slow = {"lift_loss_displacement": 1.16e-4, name: math.radians(247.2)}
    fast = {"lift_loss_displacement": 7.1e-5, name: math.radians(245.6)}
    said = train(slow, fast, still={"stock": rigid}).verdict
    assert (
        "flex takes 0.116 mm of lift at 6000 rpm and 3.3 crank deg of duration at 0.050 in at 7000 rpm"
        in said
    )


def test_bounces_and_their_height_are_of_one_run():
    """The count of one run stood before the height of another."""
    said = train({"bounce_count": 5.0, "bounce_height": 2e-4}, {"bounce_count": 4.0, "bounce_height": 2.4e-3}).verdict  # fmt: skip
    assert "4 bounces up to 2.4 mm" in said and "5 bounces" not in said


def test_two_spring_sets_are_listed_with_power_stress_and_clash(tmp_path):
    """Power stood in the terminal for one spring set alone."""
    one, other = train(
        {"mean_cam_power": 39.3, "open_nominal_shear_stress": 1.035e9, "closed_nominal_shear_stress": 4.2e8,
         "open_uncorrected_shear_stress": 8.8e8, "permitted_shear_stress": 1.1e9, "clash_energy": 0.0},
        {"mean_cam_power": 44.1, "clash_energy": 0.153},
    ).solutions  # fmt: skip
    speed = one.provenance.engine_speed
    stiff = replace(other, provenance=replace(other.provenance, engine_speed=speed, label="stiff, multi-mass", spring_set="stiff"))  # fmt: skip
    soft = replace(one, provenance=replace(one.provenance, label="soft, multi-mass", spring_set="soft"))  # fmt: skip
    study = Study(CaseRecord("own"), solutions=(soft, stiff))
    assert key_figures(study) == (
        ("cam power per valve", "39.3 W (soft), 44.1 W (stiff)"),
        ("shear stress", "420 to 1035 MPa, uncorrected 880 of 1100 MPa permitted (soft)"),
        ("clash energy", "none (soft), 153 mJ (stiff)"),
        ("clearance to coil bind at full lift", "2.2 mm"),
    )
    out = io.StringIO()
    show_study(Console(file=out, width=100), study, tmp_path, None)
    assert out.getvalue().splitlines()[-4] == "cam power per valve 39.3 W (soft), 44.1 W (stiff)"
    assert study.verdict.endswith("; cam power 39.3 W (soft), 44.1 W (stiff), 4.8 W more.")


def test_models_that_differ_inside_their_bars_say_so():
    one, other = train({"peak_spring_force": 700.0}, {"peak_spring_force": 750.0}).solutions
    speed = one.provenance.engine_speed
    names = ("multi-mass", "wave-rod")
    runs = tuple(
        replace(run, provenance=replace(run.provenance, engine_speed=speed, label=name, model=name))
        for run, name in zip((one, other), names, strict=True)
    )
    same = (700.0, 700.0)
    bars = tuple(
        Uncertainty("peak_spring_force", speed, 700.0, size, None, 700.0, 0.0, same, same, name)
        for name, size in zip(names, (20.0, 31.0), strict=True)
    )
    told = Study(CaseRecord("own"), solutions=runs, error_bars=ErrorBars(bars)).verdict
    assert told.endswith("models differ by 6.7 % in peak force, inside their error bars.")
    apart = Study(CaseRecord("own"), solutions=runs, error_bars=ErrorBars(bars[:1])).verdict
    assert apart.endswith("models differ by 6.7 % in peak force.")


@pytest.mark.parametrize(
    ("code", "first"),
    [
        ("diverged", "One of 2 runs diverged at 7000 rpm; one bounce"),
        ("coil-bind", "One of 2 runs reached coil bind at 7000 rpm; one bounce"),
        ("out-of-range", "One of 2 runs left the range of its tables at 7000 rpm; one bounce"),
        ("not-converged", "One of 2 runs did not settle at 7000 rpm; "),
    ],
)
def test_what_did_not_complete_comes_first(code, first):
    assert train({}, {}, status=Status(code, "why")).verdict.startswith(first)
    alone = train({}, status=Status("diverged", "the step was too long"))
    assert alone.verdict == "The run diverged (the step was too long)."


def test_models_of_a_spring_and_published_values():
    said = own_study().verdict
    assert (
        "hardest 345 N between coils 1–2 at 251 cam deg at 5600 rpm (finite-element); clear of coil bind"
        in said
    )
    assert said.endswith("models differ by 1.4 % in peak force at 5600 rpm.")
    assert (
        " in peak force at 5600 rpm. Compared with the source, median (count): 3 values. "
        "Calibration: forces 91.0 % (1). Prediction: forces 4.5 % (2). Furthest:"
        " Stage II peak force +91.0 %, Stage II peak force at 5600 rpm −7.0 %."
        in published_study().verdict
    )


def test_error_bars_are_named_once_known_and_never_computed_for_it():
    bar = Uncertainty("minimum_cam_contact_force", 6000 * RPM, 35.0, 7.0, None, 35.0, 0.0, (35.0,) * 2, (35.0,) * 2, "stock")  # fmt: skip
    from valvetrain.solution.later import Later
    from valvetrain.solution.uncertainty import ErrorBars

    later = train({}, error_bars=Later(ErrorBars, (bar,)))
    assert later.verdict.endswith("minimum cam force 35 N.") and not is_computed(
        later, "error_bars"
    )
    assert later.error_bars.rows and later.verdict.endswith("minimum cam force 35 ± 7 N.")


@pytest.mark.parametrize(
    ("bar", "said"),
    [
        (
            0.98,
            "seating velocity 0.542 m/s (not resolved), not resolved from the 0.52 m/s called smooth.",
        ),
        (0.01, "seating velocity 0.542 m/s, above the 0.52 m/s called smooth."),
    ],
)
def test_a_value_whose_bar_reaches_below_its_limit_is_not_above_it(bar, said):
    """Contract: "0.542 ± 0.98 m/s, above the 0.52 m/s called smooth" stood in a sentence."""
    known = Uncertainty("seating_velocity", 6000 * RPM, 0.542, bar, None, 0.542, 0.0, (0.542,) * 2, (0.542,) * 2, "stock")  # fmt: skip
    study = train({"seating_velocity": 0.542}, error_bars=ErrorBars((known,)))
    assert study.verdict.endswith(said)


def test_a_sweep_says_up_to_where_it_is_controlled():
    said = sweep_study().verdict
    assert said.startswith(
        "Worst (stock): controlled to 6217 rpm, where contact is lost at the cam, until 6494 and again from 6589 rpm; "
        "floats from 6688 rpm; no bounce to 8000 rpm. "
    )
    assert ". Worst surge amplitude 64.7 N at 4182 rpm, beyond 6217 rpm 65 N at 7455 rpm; " in said
    assert said.endswith("one of 12 speeds did not settle, at 8000 rpm.")


def test_the_text_of_a_sweep_explains_its_rows_and_names_what_did_not_settle(tmp_path):
    out = io.StringIO()
    show_study(Console(file=out, width=100), sweep_study(), tmp_path, None)
    text = " ".join(out.getvalue().split())
    assert "that did not settle 1: 8000" in text
    assert "again: further ranges of speed without control" in text
    facts = dict(study_page(sweep_study()).facts)
    assert facts["runs"].startswith("22 of 24 settled; not settled: stock at 8000 rpm")


def test_the_page_of_a_sweep_has_its_curves_behind_tabs():
    page = study_page(sweep_study())
    (over,) = [section for section in page.sections if section.key == "sweep"]
    (tabs,) = over.blocks
    assert isinstance(tabs, Tabs) and [title for title, _ in tabs.items][:2] == ["Forces", "Surge"]
    (control,) = [section for section in page.sections if section.key == "critical-speeds"]
    assert any(isinstance(block, Details) for block in control.blocks)


def test_power_timing_and_causes_stand_on_the_page():
    lost = train_study().solutions[0].events
    numbers = {"mean_cam_power": 109.2, "valve_50_thou_opening_cam_angle": np.radians(172.5),
               "valve_50_thou_closing_cam_angle": np.radians(294.3), "valve_50_thou_open_crank_angle_range": np.radians(243.7)}  # fmt: skip
    from valvetrain.solution.status import Event

    loft = Event("loft", 4.0, 0.01, 1e-4, 5.9e-5, "m", "cam", {"cause": "surge lowers the force"})
    study = train(numbers)
    study = replace(study, solutions=(replace(study.solutions[0], events=(*lost, loft)),))
    (timing,) = [one for one in study_page(study).sections if one.key == "timing"]
    lines = dict(timing.blocks[0].cards[0].lines)
    assert lines["Mean cam power"] == ("109 W",)
    assert lines["Valve, at 0.050 in"] == ("172.5, 294.3, 243.7",)
    cells = [[cell.text for cell in row] for row, _ in timing.blocks[-1].rows]
    assert ["loft, cam", "1", "59 µm", "surge lowers the force"] in [row[2:] for row in cells]


def test_rows_of_error_bars_are_named_by_what_differs_and_fit_beside_the_figure():
    """Names were cut at both widths; every row repeated the one model."""

    def row(quantity: str, speed: float, label: str) -> Uncertainty:
        return Uncertainty(quantity, speed * RPM, 35.0, 7.0, None, 35.0, 0.0, (35.0,) * 2, (35.0,) * 2, label)  # fmt: skip

    def names(*rows: Uncertainty) -> list[str]:
        return [name for _, name in error_bar_chart(rows).panels[0].y_tick_labels]

    long = "minimum_valve_tip_contact_force"
    assert names(row(long, 5500, "modal-uniform"), row(long, 3000, "modal-uniform")) == [
        "Minimum valve tip contact force while open, 5500 rpm",
        "Minimum valve tip contact force while open, 3000 rpm",
    ]
    apart = row(long, 5500, "modal-uniform"), row("bounce_height", 5500, "multi-mass")
    cut, short = names(*apart)
    assert cut == "Minimum valve tip contact force while open, modal-uni…"
    assert short == "Bounce height, multi-mass"
    made = figure(error_bar_chart(apart))
    assert made["layout"]["margin"]["l"] >= 6.6 * len(cut)
    (trace,) = made["data"]
    assert "modal-uniform: 20 %" in str(trace["customdata"])


def test_a_refinement_names_its_largest_bar():
    def row(name: str, value: float, bar: float) -> Uncertainty:
        same = (value, value)
        return Uncertainty(name, 4000 * RPM, value, bar, None, value, 0.0, same, same)

    rows = (row("peak_spring_force", 800.0, 4.0), row("clash_energy", 1e-3, 1e-4))
    study = UncertaintyStudy(CaseRecord("own"), (12, 18), rows, {})
    assert refine_verdict(study) == (
        "Peak spring force below 10 kHz at 4000 rpm 800 N ± 0.5 %; largest error bar ± 10 % in clash energy at 4000 rpm; "
        "1 of 2 numbers within 1 %."
    )


def test_what_a_sentence_cannot_hold_stands_beside_it():
    """Durations, power and the step, of one run or each with the run it is of; the hardest clash by its
    force (not its energy) in the sentence.
    """
    numbers = {
        "valve_1_mm_open_crank_angle_range": math.radians(234.1), "mean_cam_power": 9.81,
        "valve_50_thou_open_crank_angle_range": math.radians(225.9), "time_step_duration": 1.68e-6,
    }  # fmt: skip
    soft = Event("clash", 2.0, 0.1, 0.0, 40.0, "N", "coils 2-3", {"lower_coil": 2, "upper_coil": 3, "energy": 9e-3})  # fmt: skip
    hard = Event("clash", math.radians(141), 0.1, 0.0, 66.5, "N", "coils 1-2", {"lower_coil": 1, "upper_coil": 2, "energy": 1e-3})  # fmt: skip
    one = train(numbers)
    one = replace(one, solutions=(replace(one.solutions[0], events=(soft, hard)),))
    (run,) = one.solutions
    values = {**run.quantities, "clash_count": 2.0, "clash_energy": 0.01}
    clashes = replace(one, solutions=(replace(run, quantities=values),))
    hardest = "hardest 66.5 N between coils 1–2 at 141 cam deg"
    assert f"2 coil clashes (10 mJ in all), {hardest}" in clashes.verdict
    assert "clear of coil bind by 2.2 mm at full lift (at rest)," in clashes.verdict.lower()
    expected = (
        ("valve open, crank deg", "225.9 at 0.050 in, 234.1 at 1 mm"),
        ("cam power per valve", "9.81 W"),
        ("stable time step", "1.68 µs"),
        ("begins at rest, at a preload of", "303 N"),
    )
    assert key_figures(one) == expected
    page = render(study_page(one))
    opening = page[page.index('id="opening"') : page.index('class="about"')]
    assert opening.index("verdict") < opening.index("1.68 µs") < opening.index("figure")
    both = key_figures(train(numbers, numbers | {"mean_cam_power": 12.0}))
    assert ("begins at rest, at a preload of", "303 N") in both  # "... of at 7000 rpm" before
    assert [name for name, _ in both][:2] == [
        "valve open, crank deg at 7000 rpm",
        "cam power per valve",
    ]
    apart = key_figures(train(numbers | {"mean_cam_power": 12.0}, numbers))
    assert apart[1] == ("cam power per valve at 6000 rpm", "12 W")
    flies = dict(key_figures(train(numbers | {"minimum_cam_contact_force": 0.0})))
    assert flies["cam power per valve"] == "9.81 W, beyond control: with impacts"
    swept = dict(key_figures(sweep_study()))
    assert (
        set(swept) >= {"surge of one cam order, 0 to peak"}
        and "(stock)" in swept["surge of one cam order, 0 to peak"]
    )


def test_spring_margin_cam_force_and_red_line_stand_in_the_terminal(tmp_path):
    """Contract: they stood on the page alone; of several runs the least margin and the largest force."""
    margin, force = "minimum_spring_margin_force", "peak_cam_contact_force"
    study = train({margin: 420.0, force: 4100.0}, {margin: 188.0, force: 4600.0})
    study = replace(study, record=CaseRecord("own", red_line=7400 * RPM))
    told = dict(key_figures(study))
    assert told["spring margin over inertia, rigid parts at 7000 rpm"] == "188 N"
    assert told["largest cam force"] == "4600 N"
    assert told["fastest run"] == "7000 rpm, 400 rpm below the red line of 7400"
    out = io.StringIO()
    show_study(Console(file=out, width=300), study, tmp_path, None)
    line = out.getvalue().splitlines()[-1]
    assert "188 N" in line and "4600 N" in line and "red line of 7400" in line
    swept = replace(study, command="sweep")
    assert "fastest run" not in dict(key_figures(swept))


def test_a_seating_velocity_on_a_ramp_that_no_card_gives_says_so():
    """Contract: the default ramp was behind "above the 0.52 m/s called smooth" without a word."""
    text = template_text("direct", cards=True).replace('"3000, 5500 rpm"', '"5500 rpm"')
    said = "(on a ramp that is assumed)"
    for ramp, assumed in (("", True), ('ramp_velocity = "0.0005 in/deg"\n', False)):
        case = parse_case(text.replace('lash = "0.2 mm"', f'{ramp}lash = "0.2 mm"'), "own")
        study = vt.simulate(case, spring_models="massless", workers=1)
        notes = [one for one in study.notes if one.startswith("Ramp of the cam assumed: 0.0127 mm")]
        assert len(notes) == assumed
        (run,) = study.solutions
        fast = replace(run, quantities={**run.quantities, "seating_velocity": 0.8})
        told = replace(study, solutions=(fast,)).verdict
        assert (f"0.8 m/s, above the 0.52 m/s called smooth {said}." in told) is assumed
        assert assumed or said not in told


def test_a_sentence_opens_with_the_doubt_of_a_model_that_does_not_hold():
    """Contract: a note said that coils clash too hard for the model, behind firm numbers."""
    said = ("± of reduced-rod: ...", "Coils clash or swing too hard for reduced-rod at 6000 rpm (peak 2 %): take finite-element there.")  # fmt: skip
    study = replace(train({}), error_bars=ErrorBars((), said))
    begins = "Doubtful: coils clash or swing too hard for reduced-rod at 6000 rpm (peak 2 %), take finite-element there; one bounce"
    assert study.verdict.startswith(begins)
    assert train({}).verdict.startswith("One bounce")


def clash(kind: str, size: float, begins: float, peak: float, coils: int, cause: str) -> Event:
    detail = {"lower_coil": coils, "upper_coil": coils + 1, "peak_cam_angle": math.radians(peak), "cause": cause}  # fmt: skip
    return Event(kind, math.radians(begins), 0.1, 0.0, size, "N", f"coils {coils}-{coils + 1}", detail)  # fmt: skip


def test_the_hardest_clash_is_a_blow_at_the_angle_of_its_force():
    """job-c was told "hardest 917 N at 27 deg, try more gap", where coils began to rest on each other as
    the spring closed; the blow has 870 N at 178 deg. A finger whose coils only close was told 4 clashes.
    """
    rests = clash("clash", 917.0, 27.0, 178.4, 1, RESTS)
    blow = clash("clash", 870.0, 537.9, 537.98, 2, STRIKES)
    one = train({"clash_count": 2.0, "clash_energy": 0.026})
    (run,) = one.solutions
    said = replace(one, solutions=(replace(run, events=(rests, blow)),)).verdict
    assert "one coil clash, hardest 870 N between coils 2–3 under surge at 178 cam deg, coils 1–2 rest on each other" in said  # fmt: skip
    assert "917" not in said and "mJ" not in said
    closes = replace(run, quantities={**run.quantities, "clash_count": 1.0}, events=(rests,))
    quiet = replace(one, solutions=(closes,)).verdict
    assert "clash" not in quiet and "gap" not in quiet and "917" not in quiet
    assert "coils 1–2 rest on each other as the spring closes" in quiet


def test_the_hardest_clash_is_told_with_its_error_bar():
    """Contract: a force that mesh and step move had no bar beside it, as other numbers have."""
    (run,) = train({"clash_count": 1.0, "surge_clash_peak_force": 584.0}).solutions
    blow, own = clash("clash", 584.0, 241.0, 242.0, 1, STRIKES), (584.0, 584.0)
    row = Uncertainty("surge_clash_peak_force", run.engine_speed, 584.0, 120.0, None, 600.0, 0.0, own, own, run.label)  # fmt: skip
    study = Study(CaseRecord("own"), solutions=(replace(run, events=(blow,)),))
    assert "hardest 584 N between coils 1–2" in study.verdict
    told = replace(study, error_bars=ErrorBars((row,))).verdict
    assert "hardest 584 ± 120 N between coils 1–2" in told
    wide = replace(study, error_bars=ErrorBars((replace(row, numerical=700.0),))).verdict
    assert "hardest 584 N (not resolved) between coils 1–2" in wide


def test_the_clash_of_the_finest_model_is_told():
    """Of two models the sentence took the one with more energy, the coarser one's estimate."""
    one, other = train(
        {"clash_count": 3.0, "clash_energy": 7e-3}, {"clash_count": 1.0, "clash_energy": 5e-3}
    ).solutions
    speed = one.provenance.engine_speed
    runs = tuple(
        replace(
            run,
            events=(clash("clash", size, 241.0, 241.3, 1, STRIKES),),
            provenance=replace(run.provenance, engine_speed=speed, label=name, model=name),
        )
        for run, name, size in ((one, "reduced-rod", 778.0), (other, "finite-element", 584.0))
    )
    said = Study(CaseRecord("own"), solutions=runs).verdict
    assert (
        "hardest 584 N between coils 1–2 under surge at 241 cam deg" in said and "778" not in said
    )


def test_a_contact_that_parts_once_the_valve_is_shut_is_no_loss_of_control():
    """A tip that parts by 78 µm after seating opened the sentence."""
    (run,) = train({"loss_of_contact_duration": 9e-4}).solutions
    shut, nose = (math.radians(angle) for angle in (300.0, 180.0))

    def said(*angles: float) -> str:
        cause = {"cause": CAUSE_VIBRATION}
        events = tuple(
            Event("loss-of-contact", angle, 0.01, 9e-4, 7.8e-5, "m", "valve tip", cause)
            for angle in angles
        )
        return Study(CaseRecord("own"), solutions=(replace(run, events=events),)).verdict

    assert (
        "no loft while the valve is open (78 µm at the valve tip near the seat, at 300 cam deg)"
        in said(shut)
    )
    assert "ontact lost" not in said(shut)
    assert said(nose).startswith("Contact lost at the valve tip for 0.9 ms because the train")
    assert said(shut, nose).startswith("Contact lost at the valve tip for 0.9 ms because the train")
    run = replace(run, quantities={**run.quantities, "loss_of_contact_duration": 1.8e-3})
    whole = "Contact lost at the valve tip for 0.9 ms while the valve is open because"
    assert said(shut, nose).startswith(whole), "the table counts both, 1.8 ms"


def test_durations_of_lobe_and_rigid_valve_stand_beside_that_of_the_run():
    """Example: a card gives 248 deg at 1 mm, and only the lobe's 240.6 at 0.050 in was told, of one speed alone."""
    angles = {
        "lobe_50_thou": 240.6, "lobe_1_mm": 248.0, "rigid_valve_50_thou": 236.9, "rigid_valve_1_mm": 243.8,
    }  # fmt: skip
    still = {f"{name}_open_crank_angle_range": math.radians(one) for name, one in angles.items()}
    still["rigid_contact_loss_engine_speed"] = 8721 * RPM
    values = {"valve_50_thou_open_crank_angle_range": math.radians(236.7), "valve_1_mm_open_crank_angle_range": math.radians(243.6)}  # fmt: skip
    told = dict(key_figures(train(values, still={"stock": still})))
    said = "236.7 at 0.050 in, 243.6 at 1 mm (lobe 240.6 and 248, rigid valve 236.9 and 243.8)"
    assert told["valve open, crank deg"] == said
    assert told["contact-loss speed, rigid parts"] == "8721 rpm"
    several = dict(key_figures(train(values, values, still={"stock": still})))
    assert next(iter(several.values())) == said
    bare = {name: one for name, one in still.items() if not name.startswith("lobe_1")}
    assert "lobe" not in dict(key_figures(train(values, still={"stock": bare})))["valve open, crank deg"]  # fmt: skip


def test_the_surge_of_a_massless_spring_is_none():
    """4e-15 N of round-off was named worst surge."""
    study = sweep_study()
    none = tuple(
        replace(run, quantities={**run.quantities, "surge_amplitude_force": 4e-15})
        for run in study.solutions
    )
    assert "surge" in study.verdict
    assert "surge" not in replace(study, solutions=none, between=()).verdict


def test_both_springs_of_a_pair_are_told_together():
    """The pair's total is the load on the seat; the outer spring alone was told."""
    case = parse_case(template_text("direct", cards=True))
    study = static_study(case, spring_sets=("dual",))
    assert study.verdict.startswith(
        "Together preload 235 N, 540 N at the full lift of 9 mm and rate 33.9 N/mm; outer: preload 150 N, "
        "330 N at the full lift of 9 mm and rate 20 N/mm by modal-uniform, 5 mm from coil bind at full lift; inner: preload 85 N"
    )
    assert "ogether" not in static_study(case).verdict


def test_modes_are_told_before_the_load_where_they_were_asked_for():
    rest = replace(own_study(), solutions=(), comparisons=())
    assert rest.verdict.startswith("Preload ")
    assert replace(rest, command="modes").verdict.startswith(
        "First axial mode 631 Hz (cam order 6 at 12620 rpm to 12 at 6310 rpm), preload "
    )
    assert study_page(replace(rest, command="modes")).kicker == "Natural modes"


def test_modes_of_a_wire_say_why_they_are_below_those_of_its_card():
    """Closed form: d / (2 pi n D^2) sqrt(G / (2 rho)) of five active turns; a beehive, whose rate is not
    that of its free coils, and a model of torsion alone say nothing.
    """
    case = vt.load_case("uniform-spring")
    said = static_study(case, command="modes", modes=12).verdict
    metal = case.springs[0].wire.material
    torsion = (
        3.8e-3 / (2 * np.pi * 5 * 22e-3**2) * math.sqrt(metal.shear_modulus / (2 * metal.density))
    )
    assert said.endswith(": few coils also tilt and move sideways.")
    found = re.search(
        r"; torsion of the wire alone, by which cards go, gives (\d+) Hz, ([\d.]+) % more", said
    )
    assert float(found[1]) == pytest.approx(torsion, rel=0.01)
    mode = float(re.match(r"First axial mode (\d+) Hz", said)[1])
    assert float(found[2]) == pytest.approx(100 * (float(found[1]) / mode - 1), abs=0.3)
    by_torsion = static_study(case, ["modal-uniform"], command="modes", modes=4).verdict
    assert (
        "cards go"
        not in by_torsion
        + static_study(vt.load_case("gu2021-beehive"), command="modes", modes=8).verdict
    )


def test_the_largest_error_bars_fit_on_the_first_screen():
    """Twenty-four rows pushed the axis off it; the caption counts what is left."""

    def row(place: int) -> Uncertainty:
        return Uncertainty(f"mode_{place}_frequency", None, 100.0, 1.0 + place, None, 100.0, 0.0, (100.0,) * 2, (100.0,) * 2, "")  # fmt: skip

    chart = error_bar_chart([row(place) for place in range(1, 31)])
    assert len(chart.panels[0].y_tick_labels) == 16 and chart.caption == "The 16 largest of 30."
    assert chart.height < 520 and chart.panels[0].x_range[0] < 0
    assert error_bar_chart([row(1)]).caption == ""


def test_the_word_of_a_mark_near_the_right_end_stays_on_a_narrow_figure():
    """ "float 7302" of a range to 8000 rpm was cut at 390 pixels; the wide figure has room for it."""
    rule = Rule("x", 7302.0, "float 7302")
    line = Line(np.array([3000.0, 8000.0]), np.zeros(2), "card", "#000")
    panel = Panel("engine speed (rpm)", "force (N)", (line,), rules=(rule,), x_range=(3000, 8000))
    made = figure(Chart("opening", "Control", "", (panel,), 1, 300))
    sides = {
        size: next(one["xanchor"] for one in made[size]["annotations"] if one["text"] == rule.label)
        for size in ("layout", "narrow")
    }
    assert sides == {"layout": "left", "narrow": "right"}


def test_a_step_above_the_stable_one_is_told_with_the_stable_one():
    """Contract: why a stiff helical model blows up, and which step is safe, stands in the sentence;
    a run that takes the stable step says so, and at which preload it begins.
    """
    changes = {"spring.options.finite-element.time_step": "1 us"}
    case = vt.load_case("job-c", changes)
    failed = vt.simulate(case, "8000 rpm", spring_models=["finite-element"], workers=1)
    said = re.search(r"a time step of 1 µs is above the stable ([0-9.]+) µs", failed.verdict)
    assert said and "leave time_step out" in failed.solutions[0].status.remedy
    whole = vt.simulate("job-c", "8000 rpm", spring_models=["finite-element"], workers=1)
    figures = dict(key_figures(whole))
    step = float(figures["stable time step"].split()[0])
    assert 0.9 * float(said[1]) < step <= float(said[1])
    assert figures["begins at rest, at a preload of"] == "236 N"


def test_modes_end_with_what_orders_mean_and_which_mode_became_another():
    """The sentence of a train's modes named neither; a mode that is not printed was referred to."""
    told, last = np.ones((3, 1)), np.array([400.0, 1419.0, 1700.0])
    closed = TrainModes("own", "closed", 0.0, 0.0, np.array([420.0, 800.0, 3269.0]), ("valve",), ("valve",), told, told)  # fmt: skip
    lifted = replace(closed, state="full_lift", natural_frequency=last, closed_mode=(0, 2, 1), overlap=(0.99, 0.36, 0.9))  # fmt: skip
    assert followed_sentence((closed, lifted)) == (
        "Orders are those of the cam, amplitudes 0 to peak; closed mode 3 (3269 Hz) is called 2 (1419 Hz) "
        "at full lift, the nearest by shape, overlap 36 %."
    )
    assert followed_sentence(()) == ""
