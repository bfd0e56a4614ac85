"""Unit: each line and mark of a scanned spring's figures holds the column of the scan that its name and axis tell."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.measurements.spring_scan.result import ScanCurves, WireSection
from valvetrain.report.scan_charts import COIL, curves_chart, section_chart

COILS = np.linspace(0.0, 5.0, 11)
CURVES = ScanCurves(
    COILS, 24e-3 + 1e-4 * COILS, 1e-5 + 1e-6 * COILS, 6e-3 * COILS, 2e-5 + 1e-6 * COILS, 6e-3 + 1e-4 * COILS, 3e-5 + 2e-6 * COILS,
    np.zeros((11, 3)),
)  # fmt: skip
#: Coil, mean diameter, its standard deviation, points of three turns.
TURNS = np.array([[0.5, 4.01e-3, 2e-6, 300.0], [1.5, 4.02e-3, 3e-6, 310.0], [2.5, 3.99e-3, 5e-6, 290.0]])
SHOWN = np.array([[2e-3, 0.0], [0.0, 1.9e-3], [-2e-3, 1e-4]])


def scan(long_axis=4.2e-3, short_axis=3.8e-3, inclination=0.3):
    section = WireSection((4e-3, 1e-6), (long_axis, 1e-6), (short_axis, 1e-6), inclination, TURNS, SHOWN)
    return SimpleNamespace(curves=CURVES, section=section)


def layers(panel):
    return {one.name: one for one in panel.layers}


def test_the_section_shows_its_points_its_ellipse_and_every_turn():
    around, along = section_chart(scan()).panels
    found = layers(around)
    points, ellipse = found["point of the scan"], found["fitted ellipse"]
    assert [points.x, points.y] == [pytest.approx(1e3 * SHOWN[:, 0]), pytest.approx(1e3 * SHOWN[:, 1])]
    long = np.cos(0.3) * ellipse.x + np.sin(0.3) * ellipse.y
    short = np.cos(0.3) * ellipse.y - np.sin(0.3) * ellipse.x
    assert (long / 2.1) ** 2 + (short / 1.9) ** 2 == pytest.approx(np.ones(len(long))) and np.max(long) == pytest.approx(2.1)
    assert (around.x_label, along.x_label, along.y_label) == ("from the wire axis outward (mm)", COIL, "mean wire diameter (mm)")
    found = layers(along)
    marks, bars, whole = found["mean of a turn"], found["95 % of a turn"], found["whole wire"]
    assert marks.x.tolist() == [0.5, 1.5, 2.5] and marks.y == pytest.approx([4.01, 4.02, 3.99])
    assert bars.x.tolist() == [0.5] * 3 + [1.5] * 3 + [2.5] * 3
    ends = [4.006, 4.014, np.nan, 4.014, 4.026, np.nan, 3.98, 4.0, np.nan]
    assert bars.y == pytest.approx(ends, nan_ok=True)
    assert (whole.x.tolist(), whole.y) == ([0.0, 5.0], pytest.approx([4.0, 4.0]))


def test_a_round_wire_has_a_circle():
    circle = layers(section_chart(scan(4e-3, 4e-3)).panels[0])["fitted circle"]
    assert np.hypot(circle.x, circle.y) == pytest.approx(np.full(len(circle.x), 2.0))


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
