"""The page and the files of a study, and its surrogate beside a function that is known."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.explore.study import StudyText, analysed, read_plan, read_study_file
from valvetrain.explore.study_page import (
    answer_table,
    points_csv,
    points_json,
    points_page,
    sentences,
)
from valvetrain.explore.surrogate import surrogate_of
from valvetrain.explore.table import StudyTable
from valvetrain.report.page import Text, charts, render
from valvetrain.report.plotly_chart import figure
from valvetrain.report.svg_chart import svg
from valvetrain.solution.status import COMPLETED, Status

TEXT = """
kind = "{kind}"
title = "Two <b>quantities</b>"
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = "massless"
outputs = ["peak_spring_force", "peak_valve_lift"]
points = {{ sampler = "{sampler}", count = 256 }}
vary = [
  {{ key = "spring.precompression", low = "6 mm", high = "8 mm", label = "installed <i>compression</i>" }},
  {{ key = "lift_law.maximum_lift", as = "factor", low = 0.9, high = 1.1 }},
]
"""
RUN = (6000 * np.pi / 30, "massless", "")


def made(kind="points", sampler="latin-hypercube", function=None, failed=()) -> StudyTable:
    """A table whose outputs are a function of the inputs, no run behind it."""
    plan = read_plan(StudyText(TEXT.format(kind=kind, sampler=sampler), "study", Path()))
    inputs = plan.sampler.first(plan.varied, plan.options)
    cube = (inputs - inputs.min(axis=0)) / np.ptp(inputs, axis=0)
    found = (function or (lambda c: 800 + 40 * c[:, 0] + 5 * c[:, 1] ** 2))(cube)
    values = np.column_stack([found, np.full(len(found), 9e-3)])
    statuses = [
        Status("refused", "the coils overlap") if row in failed else COMPLETED
        for row in range(len(inputs))
    ]
    values[list(failed)] = np.nan
    return analysed(
        StudyTable(plan, inputs, (plan.runs[0],) * len(inputs), values, tuple(statuses))
    )


def titles(table) -> list[str]:
    return [chart.title for chart in charts(points_page(table))]


def test_a_page_of_tolerances_has_the_shares_in_a_figure_and_a_table():
    table = made("tolerance", "saltelli")
    page = render(points_page(table))
    assert (
        "What makes the spread of the peak spring force below 10 kHz, 6000 rpm, massless"
        in titles(table)
    )
    assert sentences(table)[0].startswith(
        "What makes the spread of the peak spring force below 10 kHz is installed <i>compression</i> ("
    )
    assert sentences(table)[1] == "None of the varied quantities moves the peak valve lift."
    assert "with all it acts together with (%)" in page
    assert (
        "<i>compression" not in page and "<b>quantities" not in page
    )  # words of a file are words, not HTML


def test_failed_points_are_listed_with_their_values_and_left_out_of_the_figures():
    table = made(failed=(3, 7))
    page = render(points_page(table))
    assert page.count("refused: the coils overlap") == 2 and "2 of 256 points failed." in page
    assert f"installed &lt;i&gt;compression&lt;/i&gt; {1e3 * table.inputs[3, 0]:.6g} mm" in page
    assert "point that failed" in page and points_json(table)["completed_points"] == 254


def test_a_page_stands_where_nothing_came_out():
    table = made(failed=range(256))
    assert "256 of 256 points failed." in render(points_page(table)) and not charts(
        points_page(table)
    )


def test_an_output_that_no_completed_point_has_is_named_with_those_near_it():
    """A row of dashes alone would leave its reader guessing; a point that has it, or none that came
    out, says nothing.
    """
    table = made(failed=(3,))
    assert table.not_given == ()
    table.values[:, 0] = np.nan
    (said,) = table.not_given
    assert said.startswith(
        "No run gave the peak spring force below 10 kHz (peak_spring_force); similar: "
    ) and said in sentences(table)
    assert said in points_json(table)["sentences"] and "(peak_spring_force)" in render(
        points_page(table)
    )
    table.values[5, 0] = 800.0
    assert table.not_given == () == made(failed=range(256)).not_given


def test_a_grid_has_no_histogram_for_its_levels_are_nobodys_scatter():
    text = TEXT.format(kind="points", sampler="grid").replace("count = 256", "levels = 5")
    plan = read_plan(StudyText(text, "study", Path()))
    inputs = plan.sampler.first(plan.varied, plan.options)
    values = np.column_stack([inputs.sum(axis=1), inputs.sum(axis=1)])
    table = StudyTable(plan, inputs, (plan.runs[0],) * 25, values, (COMPLETED,) * 25)
    assert not [title for title in titles(table) if "scatter" in title] and len(titles(table)) == 4


def test_the_table_as_text_has_every_digit_and_every_sentence():
    table = made(failed=(3,))
    rows = list(csv.reader(io.StringIO(points_csv(table))))
    assert len(rows) == 257 and rows[0][:2] == [
        "spring.precompression [m]",
        "lift_law.maximum_lift factor [1]",
    ]
    assert [float(row[0]) for row in rows[1:]] == table.inputs[:, 0].tolist()
    assert rows[4][-2:] == ["refused", "refused: the coils overlap"] and rows[4][5] == ""
    assert float(rows[1][5]) == table.values[0, 0]


def test_the_json_answer_holds_what_the_page_says():
    table = made("tolerance", "saltelli", failed=(3,))
    data = json.loads(json.dumps(points_json(table), default=lambda x: x.tolist()))
    (first, _) = data["sensitivities"]
    assert first["dropped"] == 1 and first["sentence"] in sentences(table)
    assert first["quantities"]["installed <i>compression</i>"]["total"] == pytest.approx(
        0.98, abs=0.03
    )
    assert (
        data["outputs"]["peak_spring_force"]["unit"] == "N"
        and "1 base row was left out" in data["sentences"][-1]
    )


def test_a_surrogate_of_a_smooth_function_predicts_each_point_from_the_others():
    pytest.importorskip("sklearn")
    table = made("surrogate", function=lambda c: 800 + 30 * np.sin(3 * c[:, 0]) * (1 + c[:, 1]))
    (one,) = table.surrogates  # the other output never changes
    assert (
        one.fitted == len(table)
        and one.share < 0.01
        and one.error < 0.1
        and "so it does not" not in one.sentence
    )
    where = table.inputs[:5]
    mean, deviation = one.predict(where)
    assert mean == pytest.approx(table.values[:5, 0], abs=0.2) and np.all(deviation < 1)
    with pytest.raises(vt.InputError, match="takes 2 inputs"):
        one.predict([1.0])
    assert any(
        "Surrogate of the peak spring force below 10 kHz" in title for title in titles(table)
    )


def test_the_colours_of_a_map_are_the_values_themselves():
    """Contract: the scale of forces near 800 N begins at the least of them and reads in N, not above it."""
    charts_of = [one for one in charts(points_page(made())) if "over both" in one.title]
    (heat,) = charts_of[0].panels[0].layers
    shown = made().values[:, 0]
    assert heat.low == pytest.approx(shown.min()) and heat.name == "peak spring force below 10 kHz"
    assert heat.low <= heat.z.min() and heat.top <= shown.max() + 1e-9
    axis = figure(charts_of[0])["layout"]["coloraxis"]
    assert (axis["cmin"], axis["cmax"]) == (heat.low, heat.top)
    assert f">{int(-(-heat.low // 10) * 10)}" in svg(charts_of[0])


def test_a_surrogate_of_noise_says_that_it_does_not_stand_for_a_run():
    pytest.importorskip("sklearn")
    noise = np.random.default_rng(3).normal(size=256)
    (one,) = made("surrogate", function=lambda c: noise).surrogates
    assert (
        one.share > 0.8
        and one.sentence.endswith("so it cannot replace a run.")
        and one.covered > 0.85
    )


def test_a_surrogate_of_few_points_is_not_made():
    pytest.importorskip("sklearn")
    assert (
        surrogate_of(
            "peak_spring_force",
            RUN,
            ("a", "b"),
            np.random.default_rng(1).random((11, 2)),
            np.arange(11.0),
        )
        is None
    )


def many_runs(count: int, failed=()) -> StudyTable:
    """A grid of five levels each at ``count`` speeds from 3000 rpm on, 100 rpm apart."""
    speeds = ", ".join(f'"{3000 + 100 * place} rpm"' for place in range(count))
    text = (
        TEXT.format(kind="points", sampler="grid")
        .replace("count = 256", "levels = 5")
        .replace('"6000 rpm"', f"[{speeds}]")
    )
    plan = read_plan(StudyText(text, "study", Path()))
    inputs = np.repeat(plan.sampler.first(plan.varied, plan.options), count, axis=0)
    values = np.column_stack([inputs.sum(axis=1), np.full(len(inputs), 9e-3)])
    statuses = [
        Status("refused", "the coils overlap") if row in failed else COMPLETED
        for row in range(len(inputs))
    ]
    values[list(failed)] = np.nan
    return StudyTable(plan, inputs, plan.runs * 25, values, tuple(statuses))


@pytest.mark.parametrize(
    ("failed", "more"), [(50, []), (53, ["And 3 more; points.csv has them all."])]
)
def test_the_first_failures_are_listed_and_all_are_counted(failed, more):
    table = many_runs(3, failed=range(failed))
    (section,) = (one for one in points_page(table).sections if one.key == "failed")
    told = [(one.tone, one.html) for one in section.blocks if isinstance(one, Text)]
    assert [tone for tone, _ in told[:50]] == ["alert"] * 50 and told[50:] == [
        ("note", one) for one in more
    ]
    assert all(
        "the coils overlap" in words for _, words in told[:50]
    ) and f"{failed} of 75 points failed." in sentences(table)


LIST = """
title = "Springs compared"
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = "finite-element"
outputs = ["{names[0]}", "{names[1]}", "peak_valve_lift"]
points = {{ sampler = "list" }}
vary = [
  {{ key = "spring.precompression", values = {first}, label = "compression" }},
  {{ key = "lift_law.maximum_lift", as = "factor", values = {second}, label = "lift factor" }},
]
"""


def listed(
    first, second, forces, failed=(), names=("minimum_spring_force", "peak_spring_force"), text=LIST
) -> StudyTable:
    """A list of points whose first two outputs are ``forces`` and twice them; no run behind it."""
    text = text.format(first=[f"{one} mm" for one in first], second=second, names=names)
    plan = read_plan(StudyText(text, "study", Path()))
    inputs = plan.sampler.first(plan.varied, plan.options)
    values = np.column_stack([forces, 2 * np.array(forces), np.full(len(forces), 9e-3)])
    values[list(failed)] = np.nan
    statuses = [
        Status("refused", "the coils overlap") if row in failed else COMPLETED
        for row in range(len(forces))
    ]
    return StudyTable(plan, inputs, plan.runs * len(forces), values, tuple(statuses))


def test_two_springs_of_a_list_stand_side_by_side_by_their_points():
    """Percentiles of two values would not tell which is which."""
    table = listed([7.0, 8.0], [1.0, 1.1], [290.0, 310.0])
    heads, rows, _ = answer_table(table)
    assert heads == ("", "point 1", "point 2", "")
    assert rows[:3] == [
        ("compression", "7", "8", "mm"),
        ("lift factor", "1", "1.1", "× case"),
        ("Minimum spring force", "290", "310", "N"),
    ]
    page, notebook, text = render(points_page(table)), table._repr_html_(), repr(table)
    body = page[page.index("<main>") : page.index("<script", page.index("<main>"))]
    assert "95 %" not in body and "median" not in body and "mean of the points there" not in page
    assert "point 2" in notebook and "nine in ten" not in text and "290 to 310 N" in text


def test_a_list_that_changes_one_quantity_at_a_time_is_drawn_as_change_from_its_first_point():
    table = listed([7.0, 8.0, 7.0], [1.0, 1.0, 1.1], [300.0, 330.0, 290.0])
    page = points_page(table)
    assert charts(page)[0].key == "run-0-minimum_spring_force-changes"
    (panel,) = charts(page)[0].panels
    assert panel.y_tick_labels == ((1.0, "compression 8 mm"), (0.0, "lift factor × 1.1"))
    assert panel.layers[1].x.tolist() == pytest.approx([30.0, -10.0])
    assert "mean of the points there" not in render(page)
    assert table.verdict == (
        "Most is moved by compression 8 mm: minimum spring force 330 N (+30 N) from 300 N; then lift factor × 1.1 −10 N."
    )


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        (
            lambda: listed([7.0, 8.0], [1.0, 1.1], [290.0, 310.0]),
            "Best is compression 8 mm, lift factor × 1.1: minimum spring force 310 N against 290 N with "
            "compression 7 mm, lift factor × 1; worse there: peak spring force below 10 kHz 620 N against 580 N.",
        ),
        (
            lambda: listed([7.0, 8.0], [1.0, 1.1], [290.0, 290.0]),
            "The minimum spring force is 290 N at every point.",
        ),
        (
            lambda: listed([7.0, 8.0, 9.0], [1.0, 1.1, 1.2], [290.0, 310.0, 320.0], failed=(2,)),
            "1 of 3 points failed; of the others: best is compression 8 mm, lift factor × 1.1: minimum spring force 310 N "
            "against 290 N with compression 7 mm, lift factor × 1; worse there: peak spring force below 10 kHz 620 N against 580 N.",
        ),
        (
            lambda: listed([7.0, 8.0], [1.0, 1.1], [290.0, 310.0], failed=(0, 1)),
            "No point completed: compression 7 mm, lift factor × 1, 6000 rpm, finite-element: refused: the coils overlap.",
        ),
        (
            lambda: made("tolerance", "saltelli"),
            "The peak spring force below 10 kHz is 803.6 to 839.5 N in nine of ten draws, median 821.9 N; "
            "installed <i>compression</i> makes 98 % of its variance.",
        ),
    ],
)
def test_the_verdict_of_a_study_names_the_best_point_and_what_it_costs(table, sentence):
    assert table().verdict == sentence


def test_a_list_with_names_tells_each_change_by_name_and_for_each_gram():
    """Contract: it named one of three parts, by its mass, then judged a search for float speeds by rigid
    theory and left out the parts that gain least.
    """
    path = Path(__file__).parents[2] / "examples" / "how-to" / "lighter-parts.toml"
    plan = read_plan(read_study_file(path))
    inputs = plan.sampler.first(plan.varied, plan.options)
    speeds = np.array([800.0, 815.0, 885.0, 814.0, 807.0, 806.0, 800.0])
    table = StudyTable(
        plan, inputs, plan.runs * 7, np.column_stack([speeds + 40.0, speeds]), (COMPLETED,) * 7
    )
    parts = ("valve and retainer", "retainer of", "tappet", "thinner pushrod", "rocker")
    gains = (
        "8451 rpm (+812 rpm, 16 rpm per g)",
        "+143 rpm, 14",
        "+134 rpm, 5.3",
        "+66.8 rpm",
        "+57.3 rpm",
    )
    for told in (parts, gains):
        places = [table.verdict.index(words) for words in told]
        assert places == sorted(places)
    assert answer_table(table)[1][2][0] == "valve and retainer of titanium"


def test_what_rigid_theory_gives_is_no_input():
    names = ("rigid_contact_loss_engine_speed", "minimum_spring_margin_force")
    train = LIST.replace("gu2021-beehive-blind", "tdi-pushrod").replace(
        "spring.precompression", "train.cam.base_radius"
    )
    table = listed([7.0, 9.0], [1.0, 1.1], [800.0, 820.0], names=names, text=train)
    assert ": contact-loss speed, rigid parts 7830 rpm" in table.verdict


@pytest.mark.parametrize("put_in", ["coil_bind_clearance", "outer_coil_bind_clearance"])
def test_the_best_point_is_that_of_what_the_motion_gives_not_of_what_was_put_in(put_in):
    """The largest clearance was named best of a study that sets the clearance."""
    names = (put_in, "clash_energy")
    table = listed([7.0, 9.0], [1.0, 1.1], [5.74e-3, 3.74e-3], names=names)
    assert table.verdict.startswith(
        "Best is compression 9 mm, lift factor × 1.1: clash energy 7.48 mJ against 11.48 mJ with compression 7 mm, "
        "lift factor × 1; worse there: clearance"
    )


def test_a_study_over_the_clearance_says_at_which_it_is_calm_and_draws_over_it():
    """Example: clash least at 3.5 mm, surge at 1.5 mm, within what the trade runs."""
    text = """
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = "finite-element"
outputs = ["coil_bind_clearance", "clash_energy", "surge_amplitude_force"]
vary = [{ key = "spring.precompression", values = ["7 mm", "9 mm", "11 mm"] }]
"""
    plan = read_plan(StudyText(text, "study", Path()))
    clearance, clash, surge = [5.5e-3, 3.5e-3, 1.5e-3], [4e-3, 2e-3, 6e-3], [24.0, 33.0, 19.0]
    values = np.column_stack([clearance, clash, surge])
    inputs = plan.sampler.first(plan.varied, plan.options)
    table = StudyTable(plan, inputs, plan.runs * 3, values, (COMPLETED,) * 3)
    assert table.verdict == (
        "1.5 mm of clearance to coil bind, as the trade runs, does not pay here: less surge amplitude (19 N for 24 N) "
        "but more clash energy (6 mJ for 4 mJ) next to 5.5 mm; choose 3.5 mm, for clash energy is least there (2 mJ, with surge amplitude 33 N)."
    )
    page = points_page(table)
    clash_panel, surge_panel = charts(page)[0].panels
    assert clash_panel.layers[0].x.tolist() == pytest.approx([1.5, 3.5, 5.5])
    assert surge_panel.layers[0].y.tolist() == pytest.approx([19.0, 33.0, 24.0])
    assert [(one.first, one.last) for one in surge_panel.bands] == [(1.5, 1.8)]
