"""The watch over replaced functions tells one left behind, and none that was put back."""

from __future__ import annotations

from package_watch import callables, replaced
from valvetrain.solution import read_apart


def test_a_function_left_replaced_is_told(monkeypatch):
    before = callables()
    with monkeypatch.context() as inside:
        inside.setattr(read_apart, "in_a_new_process", lambda *_: "not here")
        assert replaced(before) == replaced({}) == ["valvetrain.solution.read_apart.in_a_new_process"]
    assert not replaced(before) and not replaced({})
