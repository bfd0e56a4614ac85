"""Unit: every row and curve of the pages of a scanned spring and of measured lifts beside made-up
numbers, in the units of the page.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from spring_parts import CLOSED_ENDS
from valvetrain.lift.figures import LiftFigure, figure_rows
from valvetrain.parameters.spring import EndCoil
from valvetrain.scan.result import ScanCurves, ScannedEnd, ScannedSpring, WireSection

RPM, DEG, MM = np.pi / 30, np.pi / 180, 1e-3
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


def curve(rate, path=None):
    compression = np.linspace(0.0, 10e-3, 5)
    return SimpleNamespace(
        compression=compression, force=rate * compression, stiffness=np.full(5, rate), path=path
    )


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
