"""Unit: every row and curve of the pages of a scanned spring and of measured lifts beside made-up
numbers, in the units of the page.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from spring_parts import CLOSED_ENDS
from valvetrain.lift.band import CarriedSpread
from valvetrain.lift.figures import LiftFigure, figure_rows
from valvetrain.lift.page import derivatives_chart, residuals_chart
from valvetrain.lift.verdict import carried_text
from valvetrain.parameters.spring import EndCoil
from valvetrain.report import theme
from valvetrain.report.chart import Line
from valvetrain.scan.compare import ComparedNumber
from valvetrain.scan.page import (
    cloud_chart,
    compared_rows,
    curves_chart,
    difference_chart,
    force_chart,
    motion_chart,
    residual_chart,
    scan_rows,
    section_chart,
)
from valvetrain.scan.result import ScanCurves, ScannedEnd, ScannedSpring, WireSection

RPM, DEG, MM = np.pi / 30, np.pi / 180, 1e-3
#: A normal number lies within so many standard deviations in 95 of 100 draws.
BAND = 1.959964
COIL = np.linspace(0.0, 5.0, 61)
#: Diameter from 24 to 25 mm, height 6 mm a turn; the scatter of the last station of the diameter is
#: far too large.
MEAN, HEIGHT = (24 + 0.2 * COIL) * MM, 6 * MM * COIL
SPREAD = np.append(np.full(60, 1e-5), 1e-3)
TURNED = 2 * np.pi * COIL
AXIS = np.column_stack([MEAN / 2 * np.cos(TURNED), MEAN / 2 * np.sin(TURNED), HEIGHT])
CURVES = ScanCurves(
    COIL, MEAN, SPREAD, HEIGHT, np.full(61, 2e-5), (6 + 0.1 * COIL) * MM, np.full(61, 3e-5), AXIS
)
TURNS = np.array([[0.5, 4.01e-3, 2e-6, 300.0], [1.5, 4.02e-3, 3e-6, 310.0]])
ROUND = WireSection((4e-3, 1e-6), (4e-3, 1e-6), (4e-3, 1e-6), 0.0, TURNS, np.array([[2e-3, 0.0]]))
OVATE = replace(ROUND, long_axis=(4.2e-3, 5e-6), short_axis=(3.8e-3, 4e-6), inclination=0.3)
#: The definition that the scan gave: ends ground over 0.8 and 0.6 turns.
WIRE = CLOSED_ENDS.replace(
    lower_end=EndCoil("closed-ground", 1.0, 0.8), upper_end=EndCoil("closed-ground", 1.0, 0.6)
)


def scanned(section=ROUND, **more):
    told = {
        "source": "own.stl", "form": "STL", "unit": "mm", "definition": WIRE, "curves": CURVES, "section": section,
        "lower_end": ScannedEnd("closed-ground", 900, 2 * DEG, 0.002), "upper_end": ScannedEnd("open", 0, 0.5, 0.003),
        "total_coils": (5.0, 0.004), "free_length": (34e-3, 6e-5), "axis_point": np.zeros(3), "axis_direction": np.array([0.0, 0.0, 1.0]),
        "noise": 2e-5, "residuals": np.random.default_rng(1).normal(0.0, 2e-5, 20000), "points_read": 500, "points_fitted": 400,
        "points_on_wire": 450, "shown": AXIS + np.array([0.0, 0.0, 1e-3]), "notes": (),
    }  # fmt: skip
    return ScannedSpring(**(told | more))


ENDS = [
    ("hand", WIRE.hand, "", ""), ("lower end", "closed and ground", "", ""), ("lower end, ground turns", "0.800", "", ""),
    ("lower face against the axis", "2.00", "", "deg"), ("upper end", "open", "", ""), ("noise of a point", "20.0", "", "µm"),
]  # fmt: skip
FIRST = [("free length", "34.000", "0.120", "mm"), ("turns, tip to tip", "5.000", "0.008", "")]
OUTER = [
    ("largest outer diameter", "28.983", "0.020", "mm"),
    ("smallest outer diameter", "28.000", "0.020", "mm"),
    ("largest pitch", "6.500", "0.060", "mm"),
]


@pytest.mark.parametrize(
    ("section", "wire"),
    [
        (ROUND, [("wire diameter", "4.000", "0.002", "mm")]),
        (
            OVATE,
            [
                ("wire, long axis", "4.200", "0.010", "mm"),
                ("wire, short axis", "3.800", "0.008", "mm"),
                ("equivalent round wire", "4.000", "0.002", "mm"),
            ],
        ),
        (replace(ROUND, diameter=(4e-3, 0.0)), [("wire diameter", "4", "", "mm")]),
        (replace(ROUND, diameter=(4e-3, 1e-7)), [("wire diameter", "4.000", "0.001", "mm")]),
    ],
)
def test_every_size_of_a_scanned_spring_stands_with_twice_its_standard_deviation(section, wire):
    """Diameters over the wire: 24 and, before the station that scatters, 24.983 mm and 4 mm of
    wire.
    """
    assert scan_rows(scanned(section)) == [*FIRST, *wire, *OUTER, *ENDS]


def test_what_has_a_ground_face_says_how_far_it_is_ground_and_how_it_leans():
    turned = scanned(
        upper_end=ScannedEnd("closed-ground", 500, 3 * DEG, 0.003),
        lower_end=ScannedEnd("closed", 0, 0.1, 0.002),
    )
    rows = [row for row in scan_rows(turned) if row[0].startswith(("lower", "upper"))]
    assert rows == [
        ("lower end", "closed", "", ""),
        ("upper end", "closed and ground", "", ""),
        ("upper end, ground turns", "0.600", "", ""),
        ("upper face against the axis", "3.00", "", "deg"),
    ]


def test_a_scanned_number_stands_beside_its_design_with_its_share_at_rest_first_and_then_by_speed():
    numbers = (
        ComparedNumber("peak_spring_force", "finite-element", 8000 * RPM, 800.4, 840.42),
        ComparedNumber("peak_spring_force", "finite-element", 4200 * RPM, 500.2, 495.198),
        ComparedNumber("clash_count", "finite-element", 4200 * RPM, 0.0, 2.0),
        ComparedNumber("preload", "", None, 288.9, 277.344), ComparedNumber("free_length", "", None, 47.25e-3, 47.7225e-3),
        ComparedNumber("shoe_size", "finite-element", 4200 * RPM, 45.0, 46.0),
    )  # fmt: skip
    rows = compared_rows(SimpleNamespace(numbers=numbers))
    assert [(row[1], *row[2:]) for row in rows] == [
        ("", "288.9", "277.3", "N", "−4.0 %"),
        ("", "47.25", "47.72", "mm", "+1.0 %"),
        ("finite-element, 4200 rpm", "500.2", "495.2", "N", "−1.0 %"),
        ("finite-element, 4200 rpm", "0", "2", "", ""),
        ("finite-element, 8000 rpm", "800.4", "840.4", "N", "+5.0 %"),
    ]
    assert [row[0] for row in rows] == [
        "preload",
        "free length",
        "peak spring force below 10 kHz",
        "coil contacts",
        "peak spring force below 10 kHz",
    ]


def lines(panel):
    return {one.name: one for one in panel.layers}


def test_the_residuals_of_a_scan_stand_in_bars_under_the_bell_of_their_scatter():
    """48 bars over six standard deviations of 20 µm to either side; 20 000 normal numbers follow
    the bell.
    """
    (panel,) = residual_chart(scanned()).panels
    bars, bell = panel.layers
    assert panel.x_range == pytest.approx((-120.0, 120.0)) and bell.name == "bell of 20 µm"
    counts = bars.y[np.isfinite(bars.y) & (bars.y > 0)]
    assert np.sum(counts) == pytest.approx(20000, abs=2)
    due = 20000 * 5.0 / (20 * np.sqrt(2 * np.pi)) * np.exp(-0.5 * (bell.x / 20) ** 2)
    assert bell.y == pytest.approx(due, rel=0.02) and (bell.x[0], bell.x[-1]) == pytest.approx(
        (-120.0, 120.0)
    )


def test_the_cloud_and_the_wire_axis_stand_above_the_seat_seen_from_two_sides():
    """The shown points lie 1 mm above the wire's axis all along; front: towards the lower tip."""
    front, side = cloud_chart(scanned()).panels
    for panel, across in ((front, np.cos), (side, np.sin)):
        points, axis = panel.layers
        assert points.x == pytest.approx(1e3 * MEAN / 2 * across(TURNED), abs=1e-9)
        assert points.y == pytest.approx(1e3 * HEIGHT + 1.0, abs=1e-9)
        place = np.interp(axis.y, 1e3 * HEIGHT, COIL)
        assert axis.x == pytest.approx(
            (12 + 0.1 * place) * across(2 * np.pi * place), abs=0.04
        )  # chords of 30 degrees between stations
        assert (axis.y[0], axis.y[-1]) == pytest.approx((0.0, 30.0))


def test_scan_less_design_and_the_design_beside_the_scan():
    design = WIRE
    height = 1e3 * (HEIGHT - (design.axial_position(COIL) - design.lower_seat_height))
    outer = 1e3 * (MEAN + 4e-3 - design.outer_diameter(COIL))
    for panel, away, spread in zip(
        difference_chart(scanned(), design).panels,
        (outer, height),
        (1e3 * SPREAD, 2e-2),
        strict=True,
    ):
        low, high, middle = panel.layers
        for line, due in ((low, away - 2 * spread), (high, away + 2 * spread), (middle, away)):
            assert line.x == pytest.approx(COIL) and line.y == pytest.approx(due)
    coil = np.linspace(0.0, design.total_coils, 401)
    told = (
        design.outer_diameter(coil),
        design.axial_position(coil) - design.lower_seat_height,
        design.pitch.value(coil),
    )
    for panel, due in zip(curves_chart(scanned(), design).panels, told, strict=True):
        one = lines(panel)["design"]
        assert one.x == pytest.approx(coil) and one.y == pytest.approx(1e3 * due)
        assert panel.x_range == (0.0, pytest.approx(max(design.total_coils, 5.0)))


def curve(rate, path=None):
    compression = np.linspace(0.0, 10e-3, 5)
    return SimpleNamespace(
        compression=compression, force=rate * compression, stiffness=np.full(5, rate), path=path
    )


def compared(*curves, runs=None):
    """Design first; installed heights of 40 and 41 mm at 6 and 5 mm of precompression."""
    cases = tuple(
        SimpleNamespace(springs=(SimpleNamespace(installed_height=high, precompression=low),))
        for high, low in ((40e-3, 6e-3), (41e-3, 5e-3))
    )
    rest = tuple(SimpleNamespace(rest=(SimpleNamespace(curve=one),)) for one in curves)
    return SimpleNamespace(cases=cases, rest=rest, runs=runs)


def test_force_and_rate_of_both_stand_over_the_height_between_their_seats():
    force, rate = force_chart(compared(curve(40e3), curve(42e3, path=curve(44e3)))).panels
    for word, free, stiffness in (("design", 46.0, 40.0), ("3-D scan", 46.0, 44.0)):
        one, other = lines(force)[word], lines(rate)[word]
        assert one.x == pytest.approx(free - np.linspace(0.0, 10.0, 5)) and np.array_equal(
            one.x, other.x
        )
        assert one.y == pytest.approx(
            stiffness * np.linspace(0.0, 10.0, 5)
        ) and other.y == pytest.approx(np.full(5, stiffness))
    assert (
        force_chart(compared(curve(40e3), None)) is None
        and force_chart(compared(None, curve(40e3))) is None
    )


def test_the_force_of_both_over_the_cam_angle_at_one_speed_by_one_model():
    """Angles go on from turn to turn; the curve begins at the least of one turn."""
    angle = 0.3 + np.arange(720) * np.pi / 360

    def run(speed, label, level):
        return SimpleNamespace(
            engine_speed=speed,
            label=label,
            has=lambda name: True,
            cam_angle=angle,
            channel=lambda name: level + np.sin(angle) if name == "seat_force" else None,
        )

    def study(level):
        places = [(one, word) for one in (300.0, 400.0) for word in ("massless", "finite-element")]
        return SimpleNamespace(
            solutions=[run(*one, level + 10 * place) for place, one in enumerate(places)]
        )

    found = compared(curve(40e3), curve(42e3), runs=(study(500.0), study(600.0)))
    (panel,) = motion_chart(found, 400.0, "massless").panels
    for word, level in (("design", 520.0), ("3-D scan", 620.0)):
        one = lines(panel)[word]
        assert (
            np.all(np.diff(one.x) > 0)
            and one.x[0] == pytest.approx(0.0, abs=0.51)
            and one.x[-1] < 360
        )
        assert one.y == pytest.approx(level + np.sin(np.radians(one.x)), abs=1e-4)
    assert (
        motion_chart(found, 350.0, "massless") is None
        and motion_chart(found, 400.0, "multi-mass") is None
    )


ANGLES = np.linspace(1.0, 2.0, 41)
LOBE = SimpleNamespace(
    measured=SimpleNamespace(name="intake", lifts=1e-3 * ANGLES + 2e-4, cam_angles=ANGLES),
    smoothed=SimpleNamespace(
        event=(1.0, 2.0),
        base=2e-4,
        noise=3e-6,
        cam_angles=ANGLES,
        residuals=1e-6 * np.cos(40 * ANGLES),
        lift=lambda at, derivative=0: 1e-3 * np.sin(at + derivative),
        spread=lambda at, derivative=0: np.full(len(at), 1e-5 * (1 + derivative)),
    ),
)


def test_what_stations_leave_stands_between_lines_that_hold_95_of_100():
    (panel,) = residuals_chart(LOBE).panels
    marks, above, below = panel.layers
    assert marks.x == pytest.approx(np.degrees(ANGLES)) and marks.y == pytest.approx(
        np.cos(40 * ANGLES)
    )
    ends = [1 / DEG, 2 / DEG]
    assert above.name == "95 % of the noise"
    assert above.x == pytest.approx(ends) and above.y == pytest.approx([3 * BAND] * 2)
    assert below.x == pytest.approx(ends) and below.y == pytest.approx([-3 * BAND] * 2)


def test_lift_and_its_derivatives_stand_by_the_degree_with_their_bands():
    chart = derivatives_chart(LOBE)
    panels = chart.panels
    assert "1.96 standard deviations" in chart.caption
    assert [panel.y_label for panel in panels] == [
        "lift (mm)",
        "velocity (mm/deg)",
        "acceleration (µm/deg²)",
        "jerk (mm/deg³)",
    ]
    for derivative, panel in enumerate(panels):
        low, high, law, *stations = panel.layers
        scale = (1e3 if derivative == 2 else 1.0) * DEG**derivative  # the acceleration in µm
        half = BAND * (1 + derivative) * 1e-2 * scale
        for line, away in ((low, -half), (high, half), (law, 0.0)):
            assert line.y == pytest.approx(
                np.sin(line.x * DEG + derivative) * scale + away, rel=1e-7, abs=1e-9
            )
        assert len(stations) == (derivative == 0)
    station = panels[0].layers[-1]
    assert station.x == pytest.approx(np.degrees(ANGLES)) and station.y == pytest.approx(ANGLES)


@pytest.mark.parametrize(
    ("value", "spread", "unit", "row"),
    [
        (9.1e-3, 2e-6, "mm", ("9.1000", "±0.0039", "mm")),
        (120 * DEG, 0.05 * DEG, "deg", ("120.000", "±0.098", "cam deg")),
        (1.5e-3 * DEG, 1e-5 * DEG, "mm deg", ("1.500", "±0.020", "mm deg")),
        (0.02e-3 / DEG, 1e-6 / DEG, "mm/deg", ("0.0200", "±0.0020", "mm/deg")),
        (-3e-6 / DEG**2, 1e-7 / DEG**2, "um/deg2", ("-3.00", "±0.20", "µm/deg²")),
        (4e-7 / DEG**3, 1e-7 / DEG**3, "mm/deg3", ("0.00040", "±0.00020", "mm/deg³")),
        (0.25, 0.0, "", ("0.2500", "±0.0000", "")),
        (9e-3, 20e-3, "mm", ("9", "±39", "mm")),
    ],
)
def test_figures_of_a_lobe_in_the_units_of_the_trade_with_two_digits_of_their_interval(
    value, spread, unit, row
):
    assert figure_rows([LiftFigure("key", "words", value, spread, unit)]) == [("words", *row)]


def test_the_interval_of_a_size_does_not_reach_below_zero():
    """The largest jerk stood as 0.0044 ± 0.0058."""
    jerk = LiftFigure("largest_jerk", "jerk", 4.4e-6 / DEG**3, 2.96e-6 / DEG**3, "mm/deg3")
    assert figure_rows([jerk]) == [("jerk", "0.0044", "0 to 0.0102", "mm/deg³")]


@pytest.mark.parametrize(
    ("label", "speed", "run"),
    [
        ("massless", 4200 * RPM, "massless, 4200 rpm"),
        ("", 4200 * RPM, "4200 rpm"),
        ("massless", None, "massless"),
        ("", None, ""),
    ],
)
def test_a_carried_spread_names_its_run_and_stands_in_the_unit_of_its_quantity(label, speed, run):
    one = CarriedSpread("peak_valve_lift", label, speed, 9.123e-3, 1.5e-5, 20)
    assert carried_text(one) == ("peak valve lift", run, "9.123", "±0.029", "mm")


def test_lines_that_only_help_to_read_are_thinner_than_what_they_stand_beside():
    """Grey and ink lines of both pages are 1.6 px at most, and no wider than any coloured line of
    their panel.
    """
    scan = scanned(OVATE)
    charts = [
        derivatives_chart(LOBE),
        residuals_chart(LOBE),
        cloud_chart(scan),
        curves_chart(scan, WIRE),
        difference_chart(scan, WIRE),
        section_chart(scan),
        residual_chart(scan),
    ]
    for chart in charts:
        for panel in chart.panels:
            drawn = [one for one in panel.layers if isinstance(one, Line)]
            aids = [one.width for one in drawn if one.colour in (theme.MUTED, theme.INK)]
            curves = [one.width for one in drawn if one.colour not in (theme.MUTED, theme.INK)]
            assert max(aids, default=0.0) <= min([1.6, *curves]), (chart.key, panel.y_label)
            assert {one.dash for one in drawn if one.colour == theme.INK} <= {"dash"}
