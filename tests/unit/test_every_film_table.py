"""Unit: sections, tables and sentences of the page of a film, beside made-up numbers."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.film import page as made
from valvetrain.film.cycles import CoilPeak
from valvetrain.film.surge import SurgeFit, SurgeLine
from valvetrain.report.page import Figure, Grid

PEAKS = (
    CoilPeak(1, 2e-3, 4e-5, 1e-5, 7),
    CoilPeak(2, 5e-3, float("nan"), 2e-5, 7),
    CoilPeak(3, 1e-4, 5e-6, 1e-5, 6),
)
DRAWN = ("displacement", "space_time", "peaks", "overlay", "decay", "spectrum")


def lines(*pairs: tuple[float, float]) -> SurgeFit:
    """Surge lines of frequency (Hz) and damping ratio."""
    few = np.zeros(3)
    found = tuple(SurgeLine(frequency, 0.25, ratio, 1e-4, 3.5e-5) for frequency, ratio in pairs)
    return SurgeFit(found, few, few, few, few, 1, 1e-6, 2)


def film(**changes: object) -> SimpleNamespace:
    """Three coils in 600 frames of a cam that turns at 1000 rpm."""
    told = {
        "seen": SimpleNamespace(name="film.avi", size=(480, 640), frame_rate=8000.0), "places": np.zeros((600, 3)), "coils": 3,
        "spread": np.array([0.05, 0.04, np.nan, 0.06]), "metres_per_pixel": 2e-4, "peaks": PEAKS, "notes": ("first note", "second note"),
        "surge": lines((500.0, 0.01), (1010.0, 0.02)), "phase": SimpleNamespace(cam_speed=1000 * np.pi / 30, spread=0.1, by="marker"),
    }  # fmt: skip
    return SimpleNamespace(**told | changes)


def model(**changes: object) -> SimpleNamespace:
    told = {
        "case": "beehive", "peaks": np.array([2.1e-3, 4.9e-3, 2e-4]), "apart": np.array([1e-5, 3.456e-5, 2e-5]), "notes": ("of the model",),
        "surge": lines((540.0, 0.012), (470.0, 0.011), (1200.0, 0.03)),
    }  # fmt: skip
    return SimpleNamespace(**told | changes)


@pytest.fixture
def sections(monkeypatch):
    """Sections of a page by key; a figure is its name."""
    for name in DRAWN:
        monkeypatch.setattr(made, f"{name}_chart", name)
    monkeypatch.setattr(made, "figure_or_gap", lambda title, chart, *_: (Figure(chart),))
    return lambda *given, **more: {one.key: one for one in made.film_page(*given, **more).sections}


def cells(section, first: str) -> list[list[str]]:
    (grid,) = (one for one in section.blocks if isinstance(one, Grid) and one.headers[0] == first)
    assert all(cell.tone == "number" for row, _ in grid.rows for cell in row)
    return [list(grid.headers), *([cell.text for cell in row] for row, _ in grid.rows)]


def test_peaks_are_millimetres_with_their_interval(sections):
    """1.96 deviations; a share only where the peak is more than twenty of them."""
    assert cells(sections(film())["peaks"], "coil") == [
        ["coil", "mean peak (mm)", "95 %", "scatter of a turn (mm)"],
        ["1", "2.000", "±0.020", "0.040"],
        ["2", "5.000", "±0.039", "–"],
        ["3", "0.100", "±0.020", "0.005"],
    ]
    assert cells(sections(film(), model())["peaks"], "coil") == [
        [
            "coil",
            "mean peak (mm)",
            "95 %",
            "scatter of a turn (mm)",
            "model (mm)",
            "model less film",
        ],
        ["1", "2.000", "±0.020", "0.040", "2.100", "+5.0 %"],
        ["2", "5.000", "±0.039", "–", "4.900", "−2.0 %"],
        ["3", "0.100", "±0.020", "0.005", "0.200", "–"],
    ]
