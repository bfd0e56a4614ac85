"""Unit: one sentence opens the page of a result, ends the answer of its command and comes first in a
notebook; the picture of the page follows it, what says how it was computed is folded at the end.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

from valvetrain import registry
from valvetrain.cli import outcome
from valvetrain.cli.outcome import Outcome, deliver, set_manner
from valvetrain.report.chart import Chart, Line, Panel
from valvetrain.report.page import Card, Cards, Figure, Page, Section, charts, render, text
from valvetrain.report.read_page import PageFigure, sections_of
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
        Section("first", "First", (Cards((Card("numbers", ("x",), (("a", ("1",)),)),)),)),
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


def test_the_page_opens_with_sentence_and_picture_and_ends_with_what_is_folded():
    html = render(page_of(None))
    body = html[html.index("<main>") : html.index("</main>")]
    marks = ["<h1>", 'class="verdict"', 'id="fig-opening"', "Lead.", 'id="first"', 'id="second"']
    marks += ['<details class="computed"', 'id="versions"', "<footer>"]
    places = [body.index(mark) for mark in marks]
    assert places == sorted(places)
    assert "Holds &lt;100 N&gt; with 2 mm to spare." in body
    assert html[: html.index("<main>")].count("<li>") == 3  # the folded ones share one entry
    assert [chart.key for chart in charts(page_of(None))] == ["opening", "later"]


def test_a_page_read_back_has_its_picture_in_a_section_of_its_own():
    read = sections_of(render(page_of(None)))
    assert [section.key for section in read] == ["opening", "first", "second", "versions"]
    assert read[0].parts[0].text == SENTENCE and isinstance(read[0].parts[1], PageFigure)


def test_a_notebook_shows_sentence_then_picture_then_table(known):
    html = Answer()._repr_html_()
    assert Answer().verdict == SENTENCE
    places = [html.index(mark) for mark in ("&lt;100 N&gt;", "<svg", "Answer of two numbers")]
    assert places == sorted(places)
    assert Answer().plot().layout.title.text == "Answer of two numbers"


def test_a_sentence_that_fails_costs_nothing_else(known, monkeypatch):
    monkeypatch.setitem(registry.BUILT_IN["verdicts"], "Answer", f"{__name__}:failing")
    registry.places.cache_clear()
    assert Answer().verdict == ""
    assert "<svg" in Answer()._repr_html_()


@pytest.mark.parametrize("options", [[], ["--json"], ["--quiet"]])
def test_a_command_ends_with_the_sentence(options, capsys):
    made = Outcome({"a": 1}, lambda console: console.print("a table"), (), SENTENCE)
    set_manner(options)
    try:
        deliver(made)
    finally:
        outcome._MANNER.set(outcome._DEFAULT)
    printed = capsys.readouterr().out
    if "--json" in options:
        assert json.loads(printed) == {"a": 1, "verdict": SENTENCE}
    elif "--quiet" in options:
        assert printed == ""
    else:
        assert printed.splitlines() == ["a table", "", SENTENCE]
