"""Unit: rules of charts: what is shaded, how wide a curve is, how a drawn wire is coloured,
marginals in any unit.
"""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.compare_test import page as compare_test_page
from valvetrain.explore import identification_charts
from valvetrain.explore.identification_charts import _density
from valvetrain.explore.identification_file import Search
from valvetrain.explore.identification_summary import identified_verdict
from valvetrain.explore.posterior import Datum, Posterior, Unknown
from valvetrain.explore.solve import solve
from valvetrain.explore.space import Prior
from valvetrain.explore.store import Store
from valvetrain.lift.page import derivatives_chart, residuals_chart
from valvetrain.report.chart import Band, Chart, Line, Marks, Panel, Rule, rule_place
from valvetrain.report.motion.parts import Body, Colouring, Shape, SpringDrawing
from valvetrain.report.motion.project import SLICES, _wire
from valvetrain.report.motion.project import _body_project as _body
from valvetrain.report.plotly_chart import figure
from valvetrain.report.results import comparison_blocks, train_modes_blocks
from valvetrain.report.svg_chart import svg
from valvetrain.rig.page import MARKS, raw_chart, speed_chart
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.modes import TrainModes

#: Least and largest width of a curve (px); a band's edge is thinner than what it is about.
THINNEST, WIDEST = 0.8, 2.4


def recorded(kept, outliers, cycles=8):
    channel = SimpleNamespace(
        cycles=SimpleNamespace(quantity="spring_force", unit="N"),
        raw=SimpleNamespace(start=0.0, step=0.01, values=np.linspace(0.0, 5.0, 10 * cycles)),
    )
    grid = SimpleNamespace(cut_times=0.1 * np.arange(cycles + 1))
    return SimpleNamespace(
        channels=(channel, channel),
        grid=grid,
        retained=kept,
        outliers=tuple((one, "why") for one in outliers),
    )


@pytest.mark.parametrize(
    ("kept", "outliers", "out"),
    [
        ((0, 1, 2, 4, 5, 6, 7), (3,), (3,)),
        ((0, 1, 2, 3, 4, 5, 6, 7), (3,), ()),  # asked to stay
        ((0, 2, 3, 4, 6), (1, 5, 7), (1, 5, 7)),
        ((0, 1, 2, 4, 5, 6), (3, 5, 7), (3, 7)),
        ((0, 1), (), ()),
    ],
)
def test_shaded_are_the_cycles_that_were_left_out_and_no_others(kept, outliers, out):
    panels = raw_chart(recorded(kept, outliers)).panels
    assert len(panels) == 2
    for panel in panels:
        assert [(band.first, band.last) for band in panel.bands] == [
            pytest.approx((0.1 * one, 0.1 * one + 0.1)) for one in out
        ]
        assert {band.label for band in panel.bands} <= {"left out"}
        assert [rule.value for rule in panel.rules] == pytest.approx(0.1 * np.arange(9))


@pytest.mark.parametrize(
    ("cycles", "every", "said"),
    [
        (MARKS - 2, 1, "were cut."),
        (2 * MARKS - 2, 1, "were cut."),
        (2 * MARKS, 2, "(one in 2)."),
        (3 * MARKS, 3, "(one in 3)."),
    ],
)
def test_of_many_cuts_few_are_drawn_and_the_caption_says_how_many(cycles, every, said):
    chart = raw_chart(recorded((), (), cycles))
    assert chart.caption.startswith(
        "Upright lines: where cycles were cut"
    ) and chart.caption.endswith(said)
    for panel in chart.panels:
        assert [rule.value for rule in panel.rules] == pytest.approx(
            0.1 * np.arange(0, cycles + 1, every)
        )


def lobe():
    angles = np.linspace(1.0, 2.0, 30)
    smoothed = SimpleNamespace(
        event=(1.0, 2.0),
        base=0.0,
        noise=1e-6,
        cam_angles=angles,
        residuals=1e-6 * np.cos(40 * angles),
        lift=lambda at, derivative=0: 1e-3 * np.sin(at + derivative),
        spread=lambda at, derivative=0: 1e-5 * np.ones_like(at),
    )
    measured = SimpleNamespace(name="intake", lifts=1e-3 * np.sin(angles), cam_angles=angles)
    return SimpleNamespace(measured=measured, smoothed=smoothed)


def test_a_law_is_drawn_between_thinner_edges_of_its_band():
    """Edges two standard deviations to either side; the law is the widest curve, and no more than
    twice as wide as they are.
    """
    panels = derivatives_chart(lobe()).panels
    assert len(panels) == 4
    for derivative, panel in enumerate(panels):
        lines = [layer for layer in panel.layers if isinstance(layer, Line)]
        low, high, law = lines
        assert low.width == high.width < law.width <= 2 * low.width
        assert (
            law.name == "law behind the stations"
            and np.all(low.y < law.y)
            and np.all(law.y < high.y)
        )
        assert [one.in_legend for one in lines] == [derivative == 0, False, derivative == 0]
    lines = [
        layer
        for chart in (derivatives_chart(lobe()), residuals_chart(lobe()))
        for panel in chart.panels
        for layer in panel.layers
    ]
    assert all(THINNEST <= one.width <= WIDEST for one in lines if isinstance(one, Line))


def wire(values, coil):
    colouring = Colouring("share", "share", "1", values, 0.0, 1.0, ("#000000", "#ffffff"))
    even, still, height = (
        np.ones(len(coil)),
        np.zeros((len(values), len(coil))),
        np.full(len(values), 0.05),
    )
    return SpringDrawing(
        "one", coil, 10e-3 * even, 2e-3 * even, 1.0, 5e-3 * coil, still, height, (colouring,)
    )


@pytest.mark.parametrize("frame", [0, 1, 2])
@pytest.mark.parametrize("coil", [np.linspace(0.0, 6.0, 25), np.array([0.0, 0.5, 1.0, 3.0, 6.0])])
def test_a_piece_of_wire_has_the_colour_of_its_own_coil_in_its_frame(frame, coil):
    """Grey over the light that falls on its strip is the channel between the nodes: rising,
    falling, and even along the wire.
    """
    values = np.array([coil / 6.0, 1.0 - coil / 6.0, np.full(len(coil), 0.5)])
    pieces = _wire(wire(values, coil), frame, (0.0, 0.0), 1)
    lit = _wire(wire(np.ones_like(values), coil), frame, (0.0, 0.0), 1)
    middle = (np.arange(len(pieces)) + 0.5) * 6.0 / len(pieces)
    shown = np.array([one.colour[0] for one in pieces]) / np.array([one.colour[0] for one in lit])
    bright = np.array([one.colour[0] for one in lit]) < 255
    due = np.interp(middle, coil, values[frame])
    assert bright.sum() > 0.5 * len(pieces) and np.allclose(shown[bright], due[bright], atol=0.02)


def test_a_marginal_bears_the_unit_of_its_density_and_a_name_within_a_sentence_is_lower_case():
    """A density of millimetres is per millimetre; names of quantities stood with capitals within the sentence."""

    def model(points):
        return [{"load": 1e6 * wire, "turns": coils} for wire, coils in points]

    priors = {
        name: Prior("uniform", low, high)
        for name, low, high in (("wire_diameter", 3e-3, 5e-3), ("closed_coils", 0.5, 1.5))
    }
    unknowns = tuple(
        Unknown(name, prior, unit)
        for (name, prior), unit in zip(priors.items(), ("mm", ""), strict=True)
    )
    data = (Datum("load", 4e3, 40.0), Datum("turns", 1.0, 0.05))
    with Store(None) as journal:
        found = solve(Posterior(unknowns, data, journal.through(model)), Search(draws=4), journal)
    first, second = identification_charts.marginals_chart(found).panels
    assert (first.y_label, second.y_label) == ("density (1/mm)", "density")
    said = identified_verdict(found)
    assert re.match(
        r"(Wire diameter|Closed coils) [\d.]+ .*\), (closed coils|wire diameter) ", said
    )


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e6])
def test_a_marginal_of_draws_is_the_same_curve_in_any_unit(scale):
    """Draws of 0 to 1 within bounds of -10 to 10: bars over 1.8 times the middle 90 % alone, as
    many as there are bins, of area one.
    """
    values = scale * np.linspace(0.0, 1.0, 4001)[:, None]
    interval = SimpleNamespace(low=0.05 * scale, high=0.95 * scale)
    found = SimpleNamespace(
        evidence_kind="nested",
        names=("one",),
        values=values,
        weights=np.full(4001, 1 / 4001),
        branch_of=np.zeros(4001, dtype=int),
    )
    edges, heights = _density(
        found, SimpleNamespace(quantities={"one": interval}), 0, 0, -10 * scale, 10 * scale
    )
    assert (edges[0] / scale, edges[-1] / scale) == pytest.approx((0.05 - 0.36, 0.95 + 0.36))
    assert np.sum(heights[1:-1:2] * np.diff(edges[::2])) == pytest.approx(1.0)
    assert np.median(heights[heights > 0]) * scale == pytest.approx(1.0, rel=0.02)


def test_the_speed_of_a_recording_is_drawn_from_its_first_cut_to_its_last():
    """A cam that gathers 50 rad/s each second from 100 rad/s on; a cycle of 0.2 s has its mean in
    the middle.
    """
    cuts = 0.4 + 0.2 * np.arange(6)
    shaft = SimpleNamespace(cam_speed=lambda time: 100 + 50 * time, readings=60.0)
    grid = SimpleNamespace(cut_times=cuts, cam_speeds=100 + 50 * (cuts[:-1] + 0.1))
    (panel,) = speed_chart(SimpleNamespace(grid=grid, shaft=shaft)).panels
    spline, mean = panel.layers
    assert (
        panel.x_range == pytest.approx((0.4, 1.4))
        and panel.x_label == "time (s)"
        and panel.y_label == "cam speed (rpm)"
    )
    assert (spline.x[0], spline.x[-1]) == pytest.approx((0.4, 1.4)) and np.all(
        np.diff(spline.x) > 0
    )
    assert spline.y == pytest.approx((100 + 50 * spline.x) * 30 / np.pi)
    assert mean.x == pytest.approx([0.5, 0.7, 0.9, 1.1, 1.3]) and mean.y == pytest.approx(
        (100 + 50 * mean.x) * 30 / np.pi
    )


@pytest.mark.parametrize("rows", [3, 16])
def test_on_a_narrow_page_the_label_of_a_row_is_clear_of_the_marks_of_both_rows(rows):
    """Labels stood on dots and rules at 390 px; a label takes 15 px above its row, a dot 4 either way."""
    height = np.arange(rows, dtype=float)
    marks = Marks(height, height, "", "#000000", filled=True, size=8.0)
    names = tuple((float(at), f"row {at:g}") for at in height)
    panel = Panel("x (m)", "", (marks,), y_range=(-0.7, rows - 0.3), y_tick_labels=names)
    layout = figure(Chart("rows", "title", "", (panel,), 1, max(240, 26 * rows + 110)))["narrow"]
    inside = layout["height"] - layout["margin"]["t"] - layout["margin"]["b"]
    each = inside / rows
    labels = [one for one in layout["annotations"] if one["text"].startswith("row ")]
    assert len(labels) == rows and all(one["bgcolor"] for one in labels)
    assert all(4 < one["yshift"] <= each - 15 - 4 for one in labels), each


def test_rules_and_bands_lie_where_they_are_put_across_the_whole_panel():
    """Upright and level lines with and without words; a band that is not shaded has its words
    alone.
    """
    rules = (Rule("x", 3.0, "here"), Rule("y", -2.0, "level"), Rule("x", 5.0), Rule("y", 7.0))
    bands = (Band(1.0, 2.0, "shaded", shaded=True), Band(4.0, 5.0, "bare", shaded=False))
    drawn = Line(np.array([0.0, 10.0]), np.array([-5.0, 9.0]), "curve", "#000000")
    layout = figure(
        Chart(
            "key",
            "title",
            "caption",
            (Panel("x (m)", "y (N)", (drawn,), bands=bands, rules=rules),),
        )
    )["layout"]
    seen = [
        (one["type"], one["x0"], one["x1"], one["y0"], one["y1"], one["layer"])
        for one in layout["shapes"]
    ]
    assert seen == [
        ("rect", 1.0, 2.0, 0, 1, "below"),
        ("line", 3.0, 3.0, 0, 1, "below"),
        ("line", 0, 1, -2.0, -2.0, "below"),
        ("line", 5.0, 5.0, 0, 1, "below"),
        ("line", 0, 1, 7.0, 7.0, "below"),
    ]
    whole = [("domain" in one["xref"], "domain" in one["yref"]) for one in layout["shapes"]]
    assert whole == [(False, True), (False, True), (True, False), (False, True), (True, False)]
    told = {
        one["text"]: (one["x"], one["y"])
        for one in layout["annotations"]
        if one["text"] in {"shaded", "bare", "here", "level"}
    }
    assert told == {
        "shaded": (1.5, 1),
        "bare": (4.5, 1),
        "here": (3.0, pytest.approx(0.98)),
        "level": (1, -2.0),
    }


@pytest.mark.parametrize(("kind", "count"), [("lathe", 3), ("extrude", SLICES)])
def test_a_turned_body_has_its_lit_end_and_its_rings_and_a_plate_its_slices(kind, count):
    """A profile of three points has two bands and an end."""
    points = np.array([[1.0, 0.0], [2.0, 1.0], [1.0, 3.0]])
    shape = Shape(kind, points, (0.0, 1.0)) if kind == "extrude" else Shape(kind, points)
    assert len(_body(Body("one", "seat", (shape,), np.zeros((1, 3))), 0, (0.3, 0.2))) == count


@pytest.mark.parametrize("cycles", [1, 3])
def test_every_model_with_a_curve_is_drawn_over_the_test(monkeypatch, cycles):
    """In the unit of the page; a model without a curve has no line, a single cycle no range."""
    monkeypatch.setattr(compare_test_page, "_axis", lambda found, unit: f"lift ({unit})")
    monkeypatch.setattr(compare_test_page, "_stretches", lambda found: ())
    values = 1e-3 * np.arange(1.0, 1 + cycles)[:, None] * np.ones(8)
    test = SimpleNamespace(
        cam_angle=np.radians(45.0 * np.arange(8)),
        values=values,
        synthetic=False,
        quantity="valve_lift",
    )
    curves = {"rod": np.full(8, 4e-3), "chain": None, "modal": np.full(8, 5e-3)}
    found = SimpleNamespace(
        runs=[SimpleNamespace(label=name, curve=curve) for name, curve in curves.items()]
    )
    known = {
        name: SimpleNamespace(label=f"the {name}", colour="#000000", dash="") for name in curves
    }
    (panel,) = compare_test_page.overlay_chart(found, test, "mm", 1e3, known).panels
    drawn = [(one.name, float(one.y[0])) for one in panel.layers]
    spread = [(f"minimum and maximum of the {cycles} cycles", 1.0), ("", 3.0)] if cycles > 1 else []
    assert drawn == [
        *spread,
        ("mean of the test", (1 + cycles) / 2),
        ("the rod", 4.0),
        ("the modal", 5.0),
    ]


@pytest.mark.parametrize(
    ("ends", "reach"), [((25.0, 40.0), (28.4, 33.6)), ((29.0, 33.0), (29.0, 33.0))]
)
def test_a_marginal_reaches_a_little_beyond_its_posterior_within_the_prior(
    monkeypatch, ends, reach
):
    """31 N/mm with 0.5 N/mm of deviation, 30 to 32 N/mm: eight tenths of the width on either side,
    densities per N/mm.
    """
    monkeypatch.setattr(identification_charts, "title_of", lambda one: "rate (N/mm)")
    unknown = SimpleNamespace(
        name="rate", unit="N/mm", prior=Prior("uniform", 1e3 * ends[0], 1e3 * ends[1])
    )
    branch = SimpleNamespace(
        share=1.0,
        quantities={"rate": SimpleNamespace(low=30e3, high=32e3, best=31e3, deviation=500.0)},
    )
    found = SimpleNamespace(
        unknowns=(unknown,), names=("rate",), branches=(branch,), evidence_kind="linearised"
    )
    (panel,) = identification_charts.marginals_chart(found).panels
    prior, posterior = panel.layers
    assert panel.x_range == pytest.approx(reach) and panel.rules == (Rule("x", 31.0),)
    assert prior.y == pytest.approx(np.full(121, 1 / (ends[1] - ends[0])))
    assert posterior.y == pytest.approx(
        np.exp(-0.5 * ((posterior.x - 31) / 0.5) ** 2) / (0.5 * np.sqrt(2 * np.pi))
    )


def ringing(rise: float) -> Panel:
    """A force that rings about a limit at 300 N and then stays ``rise`` above it."""
    x = np.linspace(0.0, 360.0, 721)
    y = np.where(x > 240.0, 300.0 + 40.0 * np.sin(x), 300.0 + rise)
    line = Line(x, y, "spring", "#000")
    return Panel("angle", "force (N)", (line,), rules=(Rule("y", 300.0, "preload 300 N"),), x_range=(0, 360), y_range=(0, 1000))  # fmt: skip


@pytest.mark.parametrize("narrow", [False, True])
def test_the_label_of_a_level_rule_stands_where_no_curve_runs(narrow):
    """Contract: "preload" and "contact lost" stood at the right end, over the ringing curve."""
    panel = ringing(400.0)
    end, above = rule_place(panel, panel.rules[0], narrow)
    assert above and end < 240 / 360
    free, side = rule_place(ringing(-200.0), panel.rules[0], narrow)
    assert side and free < 240 / 360
    still = Panel("angle", "", (Line(np.array([0.0, 360.0]), np.full(2, 900.0), "", "#000"),), x_range=(0, 360), y_range=(0, 1000))  # fmt: skip
    assert rule_place(still, panel.rules[0], narrow) == (1.0, True)
    assert rule_place(still, Rule("y", 990.0, "solid"), narrow) == (1.0, False)
    chart = Chart("spring", "", "", (panel,))
    note = next(one for one in figure(chart)["narrow" if narrow else "layout"]["annotations"] if one["text"] == "preload 300 N")  # fmt: skip
    assert (note["x"], note["yanchor"]) == (pytest.approx(end), "bottom")
    written = re.search(r'<text x="([\d.]+)"[^>]*text-anchor="end">preload 300 N', svg(chart))
    wide, _ = rule_place(panel, panel.rules[0])
    assert written and float(written[1]) == pytest.approx(64 + wide * (960 - 64 - 22), abs=1.0)


def test_the_last_number_of_an_axis_has_room_beside_the_panel():
    """Contract: Plotly leaves out a number that the edge would cut; half of "15,000" is 20 px wide."""
    line = Line(np.array([5000.0, 15000.0]), np.zeros(2), "card", "#000")
    chart = Chart("control", "", "", (Panel("engine speed (rpm)", "", (line,)),))
    for layout in ("layout", "narrow"):
        assert figure(chart)[layout]["margin"]["r"] >= 24


def test_what_has_no_dimension_has_no_unit_behind_it_and_bars_have_names():
    """Contract: axes read "mode (1)" and "comparison (1)", and the bars above them 1 to 3."""
    shares = np.array([[0.2, 0.8], [0.7, 0.3]])
    modes = TrainModes("", "closed", 0.0, 0.0, np.array([412.3, 1034.0]), ("valve",), ("valve", "spring"), np.zeros((2, 1)), shares)  # fmt: skip
    (drawn,) = train_modes_blocks(modes)
    (panel,) = drawn.chart.panels
    assert [name for _, name in panel.y_tick_labels] == ["412.3 Hz", "1034 Hz"]
    assert [float(np.nanmax(one.x)) for one in panel.layers] == pytest.approx([70.0, 80.0])
    row = Comparison("motion_period_count", None, "massless", "FE", "1", 2.0, 3.0, 1.0, "check", 1.0, "agrees")  # fmt: skip
    (compared,) = comparison_blocks(row)[1].chart.panels
    assert compared.y_tick_labels == ((1.0, "massless"),)
    assert "(1)" not in f"{panel.x_label}{panel.y_label}{compared.x_label}{compared.y_label}"
    low, high = compared.x_range
    assert low < 1.0 and high > 3.0
