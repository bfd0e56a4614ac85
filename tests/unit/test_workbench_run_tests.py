"""Unit: the panel of tests over a run, its elements written down instead of drawn: which are
listed, which is shown, what was refused.
"""

from __future__ import annotations

import os
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest

from valvetrain.workbench.saved_runs import keep_test, remove_test
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, kept


class Element:
    """What the panel makes: a tag with its words and what lies in it."""

    stack: ClassVar[list[Element]] = []

    def __init__(
        self, name: str, words: str = "", classes: str = "", **attributes: str | None
    ) -> None:
        self.name, self.words, self.classes, self.attributes, self.inside = (
            name,
            words,
            classes,
            attributes,
            list[Element](),
        )
        if Element.stack:
            Element.stack[-1].inside.append(self)

    def __enter__(self) -> Element:
        Element.stack.append(self)
        return self

    def __exit__(self, *error: object) -> None:
        Element.stack.pop()

    def clear(self) -> None:
        self.inside.clear()


class Shown:
    """The sections of a comparison, known by the address they were asked from."""

    source = ""

    def __init__(self, whole: bool) -> None:
        assert whole

    def show(self, source: str) -> None:
        self.source = source


@pytest.fixture
def panel(tmp_path, monkeypatch):
    """The panel of a run over which two tests lie, the second one sent last."""
    pytest.importorskip("nicegui")
    from valvetrain.workbench.pages import run_page as run_tests
    from valvetrain.workbench.settings import ServeSettings

    workspace = Workspace(tmp_path / "bench")
    workspace.upload("small.toml", SMALL.encode())
    run = workspace.run(kept(workspace))
    for place, name in enumerate(("first.csv", "second.csv")):
        os.utime(keep_test(run, name, b"a;").path, (1.7e9 + place, 1.7e9 + place))
    monkeypatch.setattr(run_tests, "tag", Element)
    monkeypatch.setattr(
        run_tests,
        "button",
        lambda words, press, classes, **more: Element(
            "button", words, classes, press=press, **more
        ),
    )
    monkeypatch.setattr(run_tests, "Upload", lambda *given: None)
    monkeypatch.setattr(run_tests, "Results", Shown)
    return run_tests.RunTests(SimpleNamespace(settings=ServeSettings()), run)


def told(panel: Any) -> tuple[list[str], str, list[str]]:
    """Names listed, the one whose comparison is asked for, and the sentences of refusals."""
    alerts = [
        one.words
        for one in panel.refusal.inside
        if one.attributes.get("role") == "alert" and one.classes == "refusal"
    ]
    return (
        [row.inside[0].words for row in panel.list.inside],
        panel.over.source.split("?")[0].rpartition("/")[2],
        alerts,
    )


def buttons(panel: Any) -> dict[str, Element]:
    """The buttons of all rows by what they say to a screen reader."""
    return {
        one.attributes["aria_label"]: one
        for row in panel.list.inside
        for one in row.inside[2].inside
    }


def test_a_visit_begins_with_the_newest_test_and_no_refusal(panel):
    names, shown, alerts = told(panel)
    assert (set(names), shown, alerts) == ({"first.csv", "second.csv"}, "second.csv", [])
    pressed = {
        name: one.attributes["aria_pressed"]
        for name, one in buttons(panel).items()
        if one.words == "Show"
    }
    assert pressed == {"Show first.csv": "false", "Show second.csv": "true"}


def test_another_test_is_shown_or_taken_away_by_its_buttons(panel):
    buttons(panel)["Show first.csv"].attributes["press"]()
    assert (
        told(panel)[1:] == ("first.csv", [])
        and buttons(panel)["Show first.csv"].attributes["aria_pressed"] == "true"
    )
    buttons(panel)["Remove second.csv"].attributes["press"]()
    assert told(panel) == (["first.csv"], "first.csv", []) and set(buttons(panel)) == {
        "Remove first.csv"
    }
    buttons(panel)["Remove first.csv"].attributes["press"]()
    assert told(panel) == ([], "", []) and panel.over.source == ""


def test_a_test_that_another_visitor_has_removed_is_refused_in_a_sentence_until_the_next_click(
    panel,
):
    gone = buttons(panel)["Remove first.csv"]
    remove_test(panel.run, "first.csv")
    gone.attributes["press"]()
    names, shown, (sentence,) = told(panel)
    assert (names, shown) == (["second.csv"], "second.csv")
    assert sentence == "There is no test 'first.csv' over this run; it may have been removed."
    panel.arrived(SimpleNamespace(args={"test": "second.csv"}))
    assert told(panel) == (["second.csv"], "second.csv", [])
