"""Unit: a verdict that fails costs nothing else of an answer."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain import registry
from valvetrain.report.chart import Chart, Line, Panel
from valvetrain.report.page import Figure, Page, Section, text
from valvetrain.solution.saveable import Saveable

SENTENCE = "Holds <100 N> with 2 mm to spare."
ONE = np.arange(3.0)


def figure(key: str) -> Figure:
    return Figure(
        Chart(key, key, "", (Panel("x (1)", "y (1)", (Line(ONE, ONE, "y", "#000000"),)),))
    )


class Answer(Saveable):
    """A result with a page of its own."""

    def __repr__(self) -> str:
        return "Answer of two numbers"


def page_of(result: object) -> Page:
    sections = (
        Section("first", "First", (text("one number"),)),
        Section("versions", "Versions", (text("one version"),), folded=True),
        Section("second", "Second", (figure("later"),)),
    )
    return Page("Title", "Kicker", "Lead.", (), sections, "Foot.", SENTENCE, (figure("opening"),))


def sentence_of(result: object) -> str:
    return SENTENCE


def failing(result: object) -> str:
    raise ValueError("no numbers")


@pytest.fixture
def known(monkeypatch):
    monkeypatch.setitem(registry.BUILT_IN["results"], "Answer", f"{__name__}:page_of")
    monkeypatch.setitem(registry.BUILT_IN["verdicts"], "Answer", f"{__name__}:sentence_of")
    registry.places.cache_clear()
    registry._load.cache_clear()
    yield
    registry.places.cache_clear()
    registry._load.cache_clear()


def test_a_sentence_that_fails_costs_nothing_else(known, monkeypatch):
    monkeypatch.setitem(registry.BUILT_IN["verdicts"], "Answer", f"{__name__}:failing")
    registry.places.cache_clear()
    assert Answer().verdict == ""
    assert "<svg" in Answer()._repr_html_()
