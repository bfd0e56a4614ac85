"""Unit: every kind of result shows a table and a figure in a notebook and has a figure by plotly,
with what its page shows first.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from synthetic_study import at_rest, critical_speeds
from valvetrain import registry
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.solution.modes import TrainModes

DEGREES = np.arange(360.0)
LOBE = 9e-3 * np.clip(1 - ((DEGREES - 180) / 60) ** 2, 0, None) ** 3


def cycles(name: str = "valve_lift", unit: str = "m") -> MeasuredCycles:
    return MeasuredCycles(name, unit, np.radians(DEGREES), np.stack([LOBE, 1.01 * LOBE]), 100.0)


def lift(smoothed: bool = False):
    angles = np.radians(DEGREES[90:271])
    noisy = LOBE[90:271] + np.random.default_rng(1).normal(0, 3e-6, 181)
    if smoothed:
        return vt.measured.smooth_lift(angles, noisy)
    return vt.measured.MeasuredLift("lift", angles, noisy, "valve", "columns")


def train_modes() -> TrainModes:
    share = np.array([[0.62, 0.2, 0.18], [0.1, 0.7, 0.2]])
    frequencies, parts = np.array([500.0, 912.34]), ("valve", "spring", "rod")
    return TrainModes(
        "own", "open", 1.5, 9e-3, frequencies, ("valve",), parts, np.ones((2, 1)), share
    )


def from_card():
    low, high = (
        vt.spring_card.SpringLoad("46 mm", "350 N"),
        vt.spring_card.SpringLoad("34 mm", "830 N"),
    )
    card = vt.spring_card.CatalogueCard(wire_diameter="4.4 mm", outer_diameter="32 mm", installed_load=low, open_load=high)  # fmt: skip
    return vt.spring_card.spring_from_card(card)


def from_tester():
    heights = np.linspace(50e-3, 38e-3, 13)
    table = vt.measured.ForceHeight(heights, 40e3 * (55e-3 - heights))
    card = vt.spring_card.card_from_table(table, wire_diameter="4.2 mm", outer_diameter="30.2 mm")
    return vt.spring_card.spring_from_tester(table, card)


#: Data without a verdict -> one, a word of its table, and what an axis of its figure shows.
DATA = {
    "StaticCurve": (lambda: at_rest()[0].curve, "compression", "stiffness, N/mm"),
    "ModalResult": (lambda: at_rest()[0].modes, "natural frequency", "axial displacement"),
    "TrainModes": (train_modes, "natural frequency", "share of kinetic energy, %"),
    "CriticalSpeeds": (critical_speeds, "contact-loss", "engine speed, rpm"),
    "MeasuredCycles": (cycles, "largest", "valve lift, mm"),
}  # fmt: skip


def titles(figure) -> list[str]:
    layout = figure.layout
    return [layout[name].title.text or "" for name in layout if name[1:5] == "axis"]


@pytest.mark.parametrize("name", DATA)
def test_data_show_their_table_and_their_figure(name):
    make, heading, axis = DATA[name]
    result = make()
    page, figure = result._repr_html_(), result.plot()
    assert heading.replace(" ", "_") in page or heading in page
    assert any(axis in title for title in titles(figure))
    assert figure.data and all(len(trace.x) and len(trace.y) for trace in figure.data)


def test_every_public_result_has_an_answer():
    public = {one for one in vt.__all__[1:] if hasattr(getattr(vt, one), "_repr_html_")}
    assert public - {"Case", "Quantities"} <= set(registry.names("answers"))


@pytest.mark.parametrize("smoothed", [True, False])
def test_a_measured_lift_shows_its_rows_and_its_band(smoothed):
    assert "<table>" in lift(smoothed)._repr_html_()
    figure = lift(smoothed).plot()
    law, (low, high, mean) = lift(smoothed=True), figure.data[:3]
    assert mean.y == pytest.approx(1e3 * law.lift(np.radians(mean.x)), abs=1e-4)
    assert np.all(low.y <= mean.y) and np.all(mean.y <= high.y) and np.ptp(high.y - low.y) > 0


@pytest.mark.parametrize("made", [from_card, from_tester])
def test_a_spring_shows_its_rows_and_the_points_that_were_given(made):
    fit = made()
    assert fit.verdict and "<table>" in fit._repr_html_()
    wire, given, _ = fit.plot().data
    assert np.interp(given.x, wire.x[::-1], wire.y[::-1]) == pytest.approx(given.y, rel=0.01)
