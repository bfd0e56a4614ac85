"""Unit: rules of charts: what is shaded, which runs are drawn, marginals in any unit."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.compare_test import page as compare_test_page
from valvetrain.explore import identification_charts
from valvetrain.explore.identification_charts import _density
from valvetrain.explore.space import Prior
from valvetrain.report.chart import Rule
from valvetrain.report.motion.parts import Colouring, SpringDrawing
from valvetrain.report.motion.project import _wire
from valvetrain.rig.page import raw_chart, speed_chart

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
