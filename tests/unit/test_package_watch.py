"""The watch over replaced functions tells one left behind, and none that was put back."""

from __future__ import annotations

from functools import partial
from unittest import mock

from package_watch import callables, from_tests, replaced
from valvetrain.cam.shaped import Shaped
from valvetrain.solution import read_apart


def test_a_function_left_replaced_is_told(monkeypatch):
    before = callables()
    with monkeypatch.context() as inside:
        inside.setattr(read_apart, "no_interpreter", lambda *_: "not here")
        assert replaced(before) == replaced({}) == ["valvetrain.solution.read_apart.no_interpreter"]
    assert not replaced(before) and not replaced({})


def test_a_method_left_replaced_is_told_and_so_is_what_only_a_test_makes(monkeypatch):
    before = callables()
    with monkeypatch.context() as inside:
        inside.setattr(Shaped, "lift", lambda *_: 0.0)
        assert replaced(before) == ["valvetrain.cam.shaped.Shaped.lift"]
    assert not replaced(before)
    assert (
        all(map(from_tests, (mock.Mock(), partial(lambda: 0), lambda: 0)))
        and not from_tests(Shaped)
        and not from_tests(partial(int))
    )
