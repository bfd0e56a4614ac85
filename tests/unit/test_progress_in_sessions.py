"""Unit: progress and compilation are shown at a prompt and below the cell of a notebook, where
nobody asked for another, and nowhere else.
"""

from __future__ import annotations

import builtins
import sys
from types import ModuleType, SimpleNamespace

import pytest

import valvetrain as vt
from valvetrain import session
from valvetrain.runs.stopping import shows_progress


class ZMQInteractiveShell:
    """By this name libraries know the kernel of a notebook."""


@pytest.fixture
def cell(monkeypatch) -> list[dict[str, str]]:
    """A notebook's kernel; the list receives what is drawn below its cell."""
    drawn: list[dict[str, str]] = []

    def display(data, *, raw, display_id):
        drawn.append(data)
        return SimpleNamespace(update=lambda data, raw: drawn.append(data))

    module = ModuleType("IPython.display")
    module.display = display
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    monkeypatch.setattr(builtins, "get_ipython", ZMQInteractiveShell, raising=False)
    monkeypatch.setattr(sys, "ps1", "In : ", raising=False)
    monkeypatch.delenv(session.PROGRESS_VARIABLE, raising=False)
    return drawn


def three(**options):
    """The shortest call that shows its progress."""
    return vt.map(str, range(3), workers=1, **options)


def test_a_sweep_in_a_cell_shows_its_share_and_leaves_nothing(cell):
    found = vt.sweep("job-t", "3000 rpm", models="massless", workers=1)
    assert len(found.solutions) == 1
    assert cell[0] == {"text/plain": "sweep"} and "<progress" in cell[1]["text/html"]
    assert cell[-1] == {"text/html": "", "text/plain": ""}


def test_calls_inside_a_call_draw_no_second_bar(cell):
    vt.map(lambda _: three(), range(2), workers=1)
    assert cell.count({"text/plain": "map"}) == 1


def test_a_callback_takes_its_place(cell):
    heard = []
    three(progress=lambda done, total: heard.append(done / total))
    assert heard[-1] == 1.0 and not cell


def test_scripts_workers_and_a_silenced_session_show_nothing(cell, monkeypatch):
    monkeypatch.setenv(session.PROGRESS_VARIABLE, "off")
    three()
    monkeypatch.delenv(session.PROGRESS_VARIABLE)
    monkeypatch.setattr(session, "parent_process", lambda: object())
    three()
    monkeypatch.undo()
    assert not session.interactive()
    three()
    assert not cell


def test_a_prompt_without_a_terminal_shows_nothing(monkeypatch, capsys):
    monkeypatch.setattr(sys, "ps1", ">>> ", raising=False)
    three()
    assert "map" not in capsys.readouterr().err


def test_an_error_ends_the_bar(cell):
    @shows_progress("broken")
    def broken(*, progress=None):
        progress(0.5, "half")
        raise ValueError("no")

    for _ in range(2):
        with pytest.raises(ValueError):
            broken()
    assert cell.count({"text/plain": "broken"}) == 2 and cell[-1]["text/html"] == ""
