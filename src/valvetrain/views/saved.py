"""What ``runs`` shows of a folder of saved runs, and ``compare-runs`` of two of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from valvetrain.findings.engine import MARKS
from valvetrain.findings.rules_saved import (
    DIFFERENT,
    SAVED,
    DifferenceFacts,
    SavedFacts,
    count_text,
    name_of,
    value_text,
)
from valvetrain.findings.words import Amount
from valvetrain.parameters.summary import number, percent, unit_text
from valvetrain.runs.differences import ResultDifference, RunDifferences
from valvetrain.runs.run_folders import UnfinishedFolder
from valvetrain.runs.saved_runs import SavedRun
from valvetrain.solution.definition import is_defined
from valvetrain.views.shown import ShownByRules
from valvetrain.views.table import Line, TextTable

#: Rows of the first table.
ROWS = 12


@dataclass(frozen=True)
class SavedAnswer(ShownByRules):
    """What is shown of a folder of runs."""

    rules = SAVED

    listed: SavedFacts

    @property
    def facts(self) -> SavedFacts:
        """The runs as rules read them."""
        return self.listed

    @property
    def title(self) -> str:
        """The folder, and the case that was asked for."""
        of = f" of {self.listed.name}" if self.listed.name else ""
        return f"Runs{of} under '{self.listed.folder}', newest first"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["digest", "asked", "rpm"]

    @cached_property
    def lines(self) -> list[Line]:
        """The newest runs, finished or not."""
        both: list[SavedRun | UnfinishedFolder] = [*self.listed.runs, *self.listed.unfinished]
        both.sort(key=lambda one: one.created_at, reverse=True)
        return [
            _finished(one) if isinstance(one, SavedRun)
            else Line(_label(one), ("", "", ""), "" if one.living else "warn",
                      f"{'in progress' if one.living else 'killed'} after {count_text(one.finished, 'run')}")
            for one in both[:ROWS]
        ]  # fmt: skip


def _label(one: SavedRun | UnfinishedFolder) -> str:
    return f"{one.created_at[5:16].replace('T', ' ')} {one.case}"


def _finished(run: SavedRun) -> Line:
    """A saved run with its verdict."""
    speeds = run.engine_speeds
    rpm = "–".join(dict.fromkeys(f"{one:.0f}" for one in (*speeds[:1], *speeds[-1:])))
    text, mark = run.verdict.get("text", ""), run.verdict.get("mark", "")
    if run.state != "completed":
        text, mark = ": ".join(filter(None, (run.state, text))), "bad"
    return Line(
        _label(run),
        (run.digest, run.command, rpm),
        mark if mark in (*MARKS.values(), "ok") else "",
        text,
    )


@dataclass(frozen=True)
class DifferenceAnswer(ShownByRules):
    """What is shown of two saved runs next to each other, in the units of the reader by default."""

    rules = DIFFERENT

    both: RunDifferences

    @cached_property
    def facts(self) -> DifferenceFacts:
        """The differences as rules read them."""
        return DifferenceFacts(self.both)

    @property
    def title(self) -> str:
        """The folders of the runs."""
        return f"A {self.both.a.folder}, B {self.both.b.folder}"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["A", "B", "change"]

    @cached_property
    def lines(self) -> list[Line]:
        """What decides, then other headline numbers that differ, then the largest changes."""
        facts = self.facts
        return [
            Line(", ".join(filter(None, (name_of(row), facts.run_of(row)))), self._cells(row), "",
                 "within its error bar" * (abs(row.difference or 0.0) <= row.bar))
            for row in [*dict.fromkeys((*facts.deciding, *facts.changed))][:ROWS]
        ]  # fmt: skip

    def _cells(self, row: ResultDifference) -> tuple[str, str, str]:
        texts = []
        for value in (row.a or 0.0, row.b or 0.0):
            named = is_defined(row.quantity)
            plain = f"{number(value)} {unit_text(row.unit)}".strip()
            texts.append(self.words.amount(Amount(row.quantity, value), 4) if named else plain)
        return texts[0], texts[1], "" if row.relative is None else percent(row.relative)

    def tables(self) -> Mapping[str, TextTable]:
        """Inputs and results that differ."""
        inputs = tuple((key, value_text(a), value_text(b)) for key, a, b in self.both.inputs)
        results = tuple(
            (name_of(row), row.run.replace("_", " "), *self._cells(row))
            for row in self.facts.changed
        )
        return {
            "inputs": TextTable("Inputs that differ", ("input", "A", "B"), inputs),
            "results": TextTable("Results that differ", ("result", "run", *self.headings), results),
        }
