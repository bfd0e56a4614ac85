"""What a kept run says: its numbers, figures and tables as its report has them, and beside another run or test data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from valvetrain.workbench.kept import Run


@dataclass(frozen=True, slots=True)
class Number:
    """One quantity: ``name``, ``label``, ``value`` in ``unit`` (as shown), and the ``run`` it belongs to (label and rpm, or empty)."""

    name: str
    label: str
    value: float | None
    unit: str
    run: str = ""


@dataclass(frozen=True, eq=False)
class AnswerFigure:
    """A figure: ``key``, ``title``, ``caption``, and ``plotly`` with ``data`` and ``layout`` (and ``narrow``, the layout below 620 px)."""

    key: str
    title: str
    caption: str
    plotly: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class AnswerTable:
    """A table: ``headers`` and ``rows`` of words; ``right``: which columns hold numbers."""

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    right: tuple[bool, ...] = ()


@dataclass(frozen=True, eq=False)
class AnswerSection:
    """A section of the report: ``key``, ``title`` and its ``parts`` in order (figures, tables, sentences); ``tab``: the words of the tab
    that each part stands behind, empty for none."""

    key: str
    title: str
    parts: tuple[AnswerFigure | AnswerTable | str, ...]


@dataclass(frozen=True, eq=False)
class RunsCompared:
    """Two runs side by side: ``inputs`` that differ, ``results`` that differ."""

    inputs: AnswerTable
    results: AnswerTable


@dataclass(frozen=True, eq=False)
class Overlaid:
    """Test data over a run: a ``figure``, ``sentences`` on how they agree, and a ``table``."""

    figure: AnswerFigure | None
    sentences: tuple[str, ...]
    table: AnswerTable | None


def numbers(run: Run) -> list[Number]:
    """The numbers of a run, what is asked first in front."""
    return []


def sections(run: Run) -> list[AnswerSection]:
    """The sections of a run's report page: force, lift, clash map, orders, static curve, modes, stress, margins, as far as it has them."""
    return []


def compare(run_a: Run, run_b: Run) -> RunsCompared:
    """What differs between two runs, as ``valvetrain compare-runs`` tells it."""
    empty = AnswerTable("", (), ())
    return RunsCompared(empty, empty)


def overlay(run: Run, name: str, test_data: bytes) -> Overlaid:
    """Measured cycles over the curves of a run. Raises :class:`InputError` with the reader's sentence for a file that is none."""
    return Overlaid(None, (), None)
