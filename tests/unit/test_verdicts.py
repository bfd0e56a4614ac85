"""Unit: a verdict that fails costs nothing else of an answer."""

from __future__ import annotations

import pytest

from valvetrain import registry
from valvetrain.solution.display import Saveable


class Answer(Saveable):
    """A result with an answer of its own."""

    def __repr__(self) -> str:
        return "Answer of two numbers"


def failing(result: object) -> None:
    raise ValueError("no numbers")


@pytest.fixture
def known(monkeypatch):
    monkeypatch.setitem(registry.BUILT_IN["answers"], "Answer", f"{__name__}:failing")
    registry.places.cache_clear()
    yield
    registry.places.cache_clear()


def test_an_answer_that_fails_costs_nothing_else(known):
    assert Answer().verdict == "" and "Answer of two numbers" in Answer()._repr_html_()
