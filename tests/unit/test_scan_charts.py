"""Unit: each line and mark of a scanned spring's figures holds the column of the scan that its name
and axis tell.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from unit.test_result_display import RPM, curve, solution
from valvetrain.report.chart import Chart
from valvetrain.scan.page import (
    DESIGN,
    SCAN,
    curves_chart,
    difference_chart,
    force_chart,
    motion_chart,
    residual_chart,
)
from valvetrain.scan.result import ScanCurves, WireSection

COILS = np.linspace(0.0, 5.0, 11)
CURVES = ScanCurves(
    COILS,
    24e-3 + 1e-4 * COILS,
    1e-5 + 1e-6 * COILS,
    6e-3 * COILS,
    2e-5 + 1e-6 * COILS,
    6e-3 + 1e-4 * COILS,
    3e-5 + 2e-6 * COILS,
    np.zeros((11, 3)),
)
#: Coil, mean diameter, its standard deviation, points of three turns.
TURNS = np.array(
    [[0.5, 4.01e-3, 2e-6, 300.0], [1.5, 4.02e-3, 3e-6, 310.0], [2.5, 3.99e-3, 5e-6, 290.0]]
)
SHOWN = np.array([[2e-3, 0.0], [0.0, 1.9e-3], [-2e-3, 1e-4]])


def scan(long_axis=4.2e-3, short_axis=3.8e-3, inclination=0.3):
    section = WireSection(
        (4e-3, 1e-6), (long_axis, 1e-6), (short_axis, 1e-6), inclination, TURNS, SHOWN
    )
    return SimpleNamespace(curves=CURVES, section=section)


def layers(panel):
    return {one.name: one for one in panel.layers}


def test_the_curves_are_outer_diameter_height_and_pitch_with_two_deviations_either_way():
    known = {
        "outer diameter (mm)": (28 + 0.1 * COILS, 1e-2 + 1e-3 * COILS), "height of the wire axis (mm)": (6 * COILS, 2e-2 + 1e-3 * COILS),
        "pitch (mm per turn)": (6 + 0.1 * COILS, 3e-2 + 2e-3 * COILS),
    }  # fmt: skip
    panels = curves_chart(scan()).panels
    assert [panel.y_label for panel in panels] == list(known)
    for panel, (mean, spread) in zip(panels, known.values(), strict=True):
        low, high, middle = panel.layers
        assert [one.name for one in panel.layers] == ["95 % band", "95 % band", "3-D scan"]
        for line, values in ((low, mean - 2 * spread), (high, mean + 2 * spread), (middle, mean)):
            assert line.x == pytest.approx(COILS) and line.y == pytest.approx(values)


def drawing() -> SimpleNamespace:
    """A design of four turns: 28 mm over the outside, a pitch of 6.1 mm, its first 0.5 mm below the
    seat.
    """
    return SimpleNamespace(
        total_coils=4.0,
        lower_seat_height=0.5e-3,
        outer_diameter=lambda coil: np.full(len(coil), 28e-3),
        axial_position=lambda coil: 6.1e-3 * coil,
        pitch=SimpleNamespace(value=lambda coil: np.full(len(coil), 6.1e-3)),
    )


def test_the_design_stands_beside_the_curves_of_the_scan():
    chart = curves_chart(scan(), drawing())
    told = [layers(panel)["design"] for panel in chart.panels]
    coil = np.linspace(0, 4, 401)
    for line, values in zip(
        told, (np.full(401, 28.0), 6.1 * coil - 0.5, np.full(401, 6.1)), strict=True
    ):
        assert (
            line.x == pytest.approx(coil)
            and line.y == pytest.approx(values)
            and (line.colour, line.dash) == (DESIGN, "dash")
        )
    assert chart.title.endswith(": design and scan") and (chart.columns, chart.rows) == (1, 3)
    assert [panel.x_range for panel in chart.panels] == [(0.0, 5.0)] * 3


def test_scan_less_design_where_both_have_coils():
    chart = difference_chart(scan(), drawing())
    coil = COILS[:9]
    known = {
        "outer diameter, scan − design (mm)": (0.1 * coil, 1e-2 + 1e-3 * coil),
        "height, scan − design (mm)": (0.5 - 0.1 * coil, 2e-2 + 1e-3 * coil),
    }
    assert [panel.y_label for panel in chart.panels] == list(known) and (
        chart.columns,
        chart.rows,
    ) == (1, 2)
    for panel, (away, spread) in zip(chart.panels, known.values(), strict=True):
        low, high, middle = panel.layers
        assert [one.name for one in panel.layers] == [
            "95 % band",
            "95 % band",
            "scan − design",
        ] and panel.x_range == (0.0, 4.0)
        for line, values in ((low, away - 2 * spread), (high, away + 2 * spread), (middle, away)):
            assert line.x == pytest.approx(coil) and line.y == pytest.approx(values, abs=1e-12)


def test_residuals_are_counted_beside_the_bell_of_their_scatter():
    """48 bars over twelve deviations; the bell holds as many points as lie within two deviations,
    by 0.9545.
    """
    left = 5e-6 * np.array([0.1, 0.1, 0.1, -1.1, 2.6, 7.0])
    (panel,) = residual_chart(SimpleNamespace(noise=5e-6, residuals=left)).panels
    bars, bell = panel.layers
    counts = dict(zip(np.round(bars.x[1::3], 6), bars.y[1::3], strict=True))
    assert {place: count for place, count in counts.items() if count} == {
        0.625: 3.0,
        -5.625: 1.0,
        13.125: 1.0,
    } and len(counts) == 48
    assert bell.name == "bell of 5 µm" and panel.x_range == pytest.approx((-30.0, 30.0))
    density = 4 / 0.9545 * 1.25 / (5 * np.sqrt(2 * np.pi))
    assert bell.y.max() == pytest.approx(density) and bell.y[
        bell.x.searchsorted(5.0)
    ] == pytest.approx(density * np.exp(-0.5), rel=1e-6)


def test_force_and_rate_stand_over_the_height_between_the_seats():
    """Design of 7 mm precompression at 40 mm, scan of 8 mm at 39.5 mm: 47 and 47.5 mm free; the
    dashed one is the design.
    """
    springs = [
        SimpleNamespace(installed_height=height, precompression=short)
        for height, short in ((40e-3, 7e-3), (39.5e-3, 8e-3))
    ]
    cases = tuple(SimpleNamespace(springs=(one,)) for one in springs)
    rest = tuple(SimpleNamespace(rest=(SimpleNamespace(curve=curve()),)) for _ in springs)
    chart = force_chart(SimpleNamespace(cases=cases, rest=rest))
    assert chart is not None and (chart.columns, chart.rows, chart.key) == (1, 2, "scan-force")
    short = np.linspace(0, 8, 9)
    for panel, label, values in zip(
        chart.panels, ("force (N)", "rate (N/mm)"), (40 * short, np.full(9, 40.0)), strict=True
    ):
        assert (panel.x_label, panel.y_label) == ("height between the seats (mm)", label)
        seen = {one.name: one for one in panel.layers}
        assert seen["3-D scan"].x == pytest.approx(47.5 - short) and seen[
            "design"
        ].x == pytest.approx(47 - short)
        assert all(one.y == pytest.approx(values) for one in seen.values())
        assert [(one.name, one.colour, one.dash) for one in panel.layers] == [
            ("3-D scan", SCAN, "solid"),
            ("design", DESIGN, "dash"),
        ]
    bare = (rest[0], SimpleNamespace(rest=(SimpleNamespace(curve=None),)))
    assert force_chart(SimpleNamespace(cases=cases, rest=bare)) is None


def test_the_force_of_both_stands_over_the_cam_angle_of_its_own_speed_and_model():
    def study(factor: float) -> SimpleNamespace:
        runs = [
            solution(speed * RPM, label)
            for speed in (4200, 5600)
            for label in ("multi-mass", "rod")
        ]
        changed = [
            one.channels.assign(seat_force=(factor + place) * one.channels["seat_force"])
            for place, one in enumerate(runs)
        ]
        return SimpleNamespace(
            solutions=[replace(one, channels=more) for one, more in zip(runs, changed, strict=True)]
        )

    found = SimpleNamespace(runs=(study(1.0), study(10.0)))
    force, angle = solution().channel("seat_force")[:-1], np.arange(360.0)
    for place, (speed, label) in enumerate(
        [(4200, "multi-mass"), (4200, "rod"), (5600, "multi-mass"), (5600, "rod")]
    ):
        chart = motion_chart(found, speed * RPM, label)
        assert (
            isinstance(chart, Chart)
            and (chart.columns, chart.rows) == (1, 1)
            and chart.height > 300
        )
        assert (
            chart.title
            == f"Spring force at {speed} rpm, {'multi-mass chain' if label == 'multi-mass' else 'rod'}"
        )
        (panel,) = chart.panels
        assert (panel.x_label, panel.y_label) == (
            "cam angle (cam degrees)",
            "force on the cylinder head (N)",
        )
        for line, name, factor in zip(
            panel.layers, ("3-D scan", "design"), (10.0, 1.0), strict=True
        ):
            assert line.name == name and np.all(np.diff(line.x) >= 0)
            assert np.interp(angle, line.x, line.y) == pytest.approx(
                (factor + place) * force, rel=1e-6
            )
    assert (
        motion_chart(found, 5000 * RPM, "rod") is None
        and motion_chart(found, 4200 * RPM, "chain") is None
    )
