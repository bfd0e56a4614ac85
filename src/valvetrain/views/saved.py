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
from valvetrain.findings.words import Amount, Words
from valvetrain.parameters.summary import number, percent, unit_text
from valvetrain.runs.differences import ResultDifference, RunDifferences
from valvetrain.runs.run_folders import UnfinishedFolder
from valvetrain.runs.saved_runs import SavedRun
from valvetrain.solution.definition import is_defined, label_of
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
        return ["digest", "asked", "models", "rpm"]

    @cached_property
    def lines(self) -> list[Line]:
        """The newest runs, finished or not."""
        both: list[SavedRun | UnfinishedFolder] = [*self.listed.runs, *self.listed.unfinished]
        both.sort(key=lambda one: one.created_at, reverse=True)
        return [
            _finished(one, self.words) if isinstance(one, SavedRun)
            else Line(_label(one), ("", "", "", ""), "" if one.living else "warn",
                      f"{'in progress' if one.living else 'killed'} after {count_text(one.finished, 'run')}")
            for one in both[:ROWS]
        ]  # fmt: skip


def _label(one: SavedRun | UnfinishedFolder) -> str:
    return f"{one.created_at[5:16].replace('T', ' ')} {one.case}"


def _finished(run: SavedRun, words: Words) -> Line:
    """A saved run with its verdict, or the number that stands for it."""
    speeds, models, best = run.engine_speeds, run.models, run.headline
    rpm = "" if not speeds else f"{speeds[0]:g}" + (f"–{speeds[-1]:g}" if len(speeds) > 1 else "")
    text, mark = run.verdict.get("text", ""), run.verdict.get("mark", "")
    if best and not text:
        amount = words.amount(Amount(best["quantity"], best["value"]))
        text = f"{label_of(best['quantity'])} {amount}"
    if run.state != "completed":
        text, mark = ": ".join(filter(None, (run.state, text))), "bad"
    model = models[0] + (f" +{len(models) - 1}" if len(models) > 1 else "") if models else ""
    return Line(
        _label(run),
        (run.digest, run.command, model, rpm),
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
        return [
            Line(_where(row, self.facts), self._cells(row), "", "within its error bar" * (abs(row.difference or 0.0) <= row.bar))
            for row in [*dict.fromkeys((*self.facts.deciding, *self.facts.changed))][:ROWS]
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


def _where(row: ResultDifference, facts: DifferenceFacts) -> str:
    """A number with its run, where several runs have it."""
    several = len({one.run for one in facts.changed if one.quantity == row.quantity}) > 1
    return f"{name_of(row)}, {row.run}" if several and row.run else name_of(row)
