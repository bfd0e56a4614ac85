"""Unit: what a change in the form of a case's page asks of the workspace, and what the form is
answered.
"""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import pytest

from valvetrain.errors import InputError

pytest.importorskip("nicegui")

#: Handler, what its event tells, and the call that follows from it for the case "c1".
ASKED = [
    (
        "change",
        {"key": "spring.wire_diameter", "value": "4 mm"},
        ("put", "c1", "spring.wire_diameter", "4 mm"),
    ),
    ("change", {"key": "lift_law.kind", "value": "polynomial"}, ("change_law", "c1", "polynomial")),
    ("change", {"key": "lift_law.kind", "value": ""}, ("put", "c1", "lift_law.kind", "")),
    ("add", {"key": "train"}, ("add_table", "c1", "train")),
    ("remove", {"key": "rubbing"}, ("set_value", "c1", "rubbing", "")),
]


def page(refused: bool):
    """A page of the case over a workspace that writes down what it is asked; and what was written
    down.
    """
    from valvetrain.workbench.pages.case_page import CasePage

    asked, answered = [], []

    def noting(name):
        def call(*words):
            asked.append((name, *words))
            if refused:
                raise InputError("not so", words[1])

        return call

    async def refreshed():
        asked.append(("refreshed",))

    workspace = SimpleNamespace(
        **{name: noting(name) for name in ("change_law", "add_table", "set_value")}
    )
    made = CasePage(SimpleNamespace(workspace=workspace, put=noting("put")), "c1", "", None)
    made.form = SimpleNamespace(answer=lambda key, words: answered.append((key, words)))
    made.refreshed = refreshed
    return made, asked, answered


@pytest.mark.parametrize(("handler", "told", "call"), ASKED)
def test_a_change_in_the_form_is_made_in_the_case_and_the_page_is_refreshed(handler, told, call):
    made, asked, answered = page(refused=False)
    asyncio.run(getattr(made, handler)(SimpleNamespace(args=told)))
    assert asked == [call, ("refreshed",)] and answered == [(told["key"], "")]


@pytest.mark.parametrize(("handler", "told", "call"), ASKED)
def test_a_refused_change_is_answered_in_its_place_and_refreshes_nothing(handler, told, call):
    made, asked, answered = page(refused=True)
    asyncio.run(getattr(made, handler)(SimpleNamespace(args=told)))
    ((key, words),) = answered
    assert asked == [call] and key == told["key"] and "not so" in words.lower()
