"""Unit: sections, tables and sentences of the page of a film, beside made-up numbers."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.film import page as made
from valvetrain.film.cycles import CoilPeak
from valvetrain.film.surge import SurgeFit, SurgeLine
from valvetrain.report.page import Figure, Grid, Text

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


def test_the_coil_that_moves_most_is_drawn_first_and_noise_is_no_motion():
    """The first panel was a coil on its seat whose scale of its own made ten micrometres a motion."""
    angle = np.radians(np.arange(0.0, 360.0, 30.0))
    moved = np.array([1e-5, 2e-3, 9e-3]) * np.sin(angle / 2)[:, None] ** 2
    motion = SimpleNamespace(cycles=[SimpleNamespace(values=row[None, :]) for row in moved.T])
    beside = SimpleNamespace(
        cam_angle=angle,
        displacement=moved,
        turns=(0.6, 1.6, 2.6),
        model="multi-mass",
        spring="outer",
    )
    panels = made.overlay_chart(motion, beside).panels
    assert [panel.title.split(" (")[0] for panel in panels] == ["coil 3", "coil 2", "coil 1"]
    assert [panel.y_range is None for panel in panels] == [True, True, False]
    assert panels[2].y_range[1] == pytest.approx(0.02 * 9.0)


@pytest.fixture
def sections(monkeypatch):
    """Sections of a page by key; a figure is its name."""
    for name in DRAWN:
        monkeypatch.setattr(made, f"{name}_chart", name)
    monkeypatch.setattr(made, "figure_or_gap", lambda title, chart, *_: (Figure(chart),))
    return lambda *given, **more: {one.key: one for one in made.film_page(*given, **more).sections}


def shape(section) -> list[str]:
    """Figures by name, tables by their first head, sentences in full."""
    return [
        one.chart
        if isinstance(one, Figure)
        else one.headers[0]
        if isinstance(one, Grid)
        else one.html
        for one in section.blocks
    ]


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("peaks", [(), PEAKS])
@pytest.mark.parametrize("surge", [None, lines((500.0, 0.01))])
def test_a_section_stands_where_there_is_something_to_tell(sections, beside, peaks, surge):
    found = sections(film(peaks=peaks, surge=surge), model() if beside else None)
    expected = {"motion": ["displacement", "space_time"] if beside else ["space_time"]}
    expected |= {"peaks": ["peaks", "coil"]} if peaks else {}
    apart = "Film less model, root mean square over the turn by coil: 0.01, 0.0346, 0.02 mm; most at coil 2."
    expected |= {"model": ["line of the film", apart, "Of the model."]} if beside else {}
    expected |= {
        "surge": ["decay", "line", "spectrum"] if surge else ["decay", "spectrum"],
        "found": ["First note.", "Second note."],
    }
    assert {key: shape(one) for key, one in found.items()} == expected and list(found) == list(
        expected
    )
    assert not beside or found["model"].title == "Compared with the case beehive"


def test_a_film_of_a_decay_opens_with_it(monkeypatch):
    """No cam turns, so nothing is drawn over its angle; the page had no picture."""
    for name in DRAWN:
        monkeypatch.setattr(made, f"{name}_chart", name)
    drawn = {"displacement": ()}
    monkeypatch.setattr(
        made, "figure_or_gap", lambda title, chart, *_: drawn.get(chart, (Figure(chart),))
    )
    page = made.film_page(film(phase=None))
    assert [one.chart for one in page.picture] == ["decay"]
    surge = next(one for one in page.sections if one.key == "surge")
    assert shape(surge) == ["line", "spectrum"]


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


def test_surge_lines_stand_beside_the_nearest_of_the_run_within_a_tenth(sections):
    """Decay rate 2 pi f z, decrement 2 pi z / sqrt(1 - z^2); digits go as far as the interval."""
    found = sections(film(), model())
    assert cells(found["surge"], "line") == [
        [
            "line",
            "frequency",
            "95 %",
            "damping ratio",
            "95 %",
            "decay rate",
            "log. decrement",
            "amplitude",
        ],
        ["1", "500.00 Hz", "±0.49", "0.01000", "±0.0002", "31.4 1/s", "0.0628", "35 µm"],
        ["2", "1010.00 Hz", "±0.49", "0.02000", "±0.0002", "127 1/s", "0.126", "35 µm"],
    ]
    assert cells(found["model"], "line of the film") == [
        ["line of the film", "its damping ratio", "line of the run", "its damping ratio"],
        ["500 Hz", "0.01", "470 Hz", "0.011"],
        ["1010 Hz", "0.02", "–", "–"],
    ]
    for motion, beside, rows in ((film(surge=None), model(), 0), (film(), model(surge=None), 2)):
        bare = cells(sections(motion, beside)["model"], "line of the film")[1:]
        assert len(bare) == rows and all(row[2:] == ["–", "–"] for row in bare)


def test_facts_and_lead_say_what_was_filmed(monkeypatch, sections):
    facts = dict(made.film_facts(film()))
    assert facts == {
        "film": "600 frames of 640 x 480 px, 8000 a second",
        "coils": "3",
        "place of a coil within": "0.05 px = 10 µm",
        "cam speed": "1000 ±1.9 rpm, by the marker",
        "turns": "7",
    }
    exact = SimpleNamespace(cam_speed=1000 * np.pi / 30, spread=0.0, by="lift")
    assert (
        dict(made.film_facts(film(phase=exact, peaks=())))["cam speed"] == "1000 rpm, by the lift"
    )
    still = dict(made.film_facts(film(phase=None)))
    assert still["cam"] == "does not turn" and not {"cam speed", "turns"} & set(still)
    assert dict(made.film_facts(film(peaks=())))["turns"] == "0"
    for synthetic in (False, True):
        page = made.film_page(film(), synthetic=synthetic)
        assert (
            page.lead.endswith("it was computed, not taken.") is synthetic
            and page.title == "film.avi"
        )
        assert all(
            not isinstance(one, Text) or one.tone == "note" for one in page.sections[-1].blocks
        )
