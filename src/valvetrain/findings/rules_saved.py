"""Rules on saved runs (J2): what a folder of them holds, and how two of them differ."""

from __future__ import annotations

import math
import shlex
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import RPM, Amount, Said, digits_text
from valvetrain.runs.differences import ResultDifference, RunDifferences
from valvetrain.runs.run_folders import ROOT, UnfinishedFolder
from valvetrain.runs.saved_runs import SavedRun
from valvetrain.solution.definition import is_defined, label_of, topics

#: Numbers that say how long the cam is kept, which decide before all others, and the least change (SI) that matters.
CONTROL = {
    "contact_loss_engine_speed": RPM, "float_engine_speed": RPM, "bounce_engine_speed": RPM, "loss_of_contact_duration": 1e-5,
    "loft_gap": 1e-5, "minimum_cam_contact_force": 1.0,
}  # fmt: skip
#: Likewise every number that decides a comparison of two runs, with those of each spring of a pair.
DECIDING = CONTROL | {
    "peak_spring_force": 1.0, "peak_retainer_force": 1.0, "peak_cam_contact_force": 1.0, "bounce_height": 1e-5,
    "seating_velocity": 0.01, "coil_bind_clearance": 1e-5, "peak_shear_stress": 1e6, "largest_amplitude_shear_stress": 1e6,
    "surge_amplitude_force": 1.0, "clash_count": 0.5, "preload": 1.0,
}  # fmt: skip


def count_text(number: int, noun: str) -> str:
    """``1 run``, ``3 runs``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


@dataclass(frozen=True)
class SavedFacts(Subject):
    """Saved and unfinished runs under a ``folder``, newest first, of the case ``name`` where one was given."""

    runs: tuple[SavedRun, ...]
    unfinished: tuple[UnfinishedFolder, ...]
    folder: Path = ROOT
    name: str = ""

    @property
    def killed(self) -> list[UnfinishedFolder]:
        """Those that no process goes on with."""
        return [one for one in self.unfinished if not one.living]

    @property
    def pair(self) -> str:
        """The newest two runs of one case, command and speed with different inputs, as ``compare-runs`` takes them."""
        newest: dict[object, str] = {}
        for run in self.runs:
            digest = newest.setdefault((run.case, run.command, run.engine_speeds), run.digest)
            if digest != run.digest:
                place = "" if self.folder == ROOT else f" --folder {shlex.quote(str(self.folder))}"
                return f"{run.digest} {digest}{place}"
        return ""


def nothing(facts: SavedFacts) -> Hits:
    """No run is saved, and none was begun."""
    if not facts.runs and not facts.unfinished:
        yield Hit(fields={"folder": str(facts.folder), "of": facts.name})


def killed(facts: SavedFacts) -> Hits:
    """A run was killed before its end."""
    for one in facts.killed[:1]:
        yield Hit(fields={
            "count": str(len(facts.killed)), "of": one.case, "ended": count_text(one.finished, "run"), "folder": str(one.folder),
            "command": one.command,
        })  # fmt: skip


def not_completed(facts: SavedFacts) -> Hits:
    """The newest run failed or was interrupted."""
    for run in facts.runs[:1]:
        if run.state != "completed":
            yield Hit(fields={
                "count": count_text(len(facts.runs), "run"), "state": run.state, "of": run.case,
                "said": run.failures[0] if run.failures else "", "command": run.command_line if run.state == "interrupted" else "",
            })  # fmt: skip


def saved(facts: SavedFacts) -> Hits:
    """Runs are saved or in progress."""
    said = f"{facts.runs[0].case}, {facts.runs[0].verdict.get('text', '')}" if facts.runs else ""
    fields: dict[str, Said] = {
        "count": count_text(len(facts.runs), "run"), "newest": said.removesuffix(", "),
        "running": str(len(facts.unfinished) or ""), "step": "",
    }  # fmt: skip
    if facts.runs:
        run = facts.runs[0]
        step = str(run.verdict.get("step", ""))
        fields["step"] = f"valvetrain compare-runs {facts.pair}" if facts.pair else step
    yield Hit(fields=fields)


@dataclass(frozen=True)
class DifferenceFacts(Subject):
    """Two saved runs and what differs between them, as rules read it."""

    both: RunDifferences

    @cached_property
    def changed(self) -> list[ResultDifference]:
        """Numbers of both runs that differ: headline numbers first in the order of their topics, then the largest change."""
        order = [*(name for some in topics().values() for name in some)]
        place = {name: index for index, name in enumerate(order)}
        both = (row for row in self.both.results if row.difference is not None)
        return sorted(both, key=lambda row: place.get(row.quantity, len(order)))

    @cached_property
    def deciding(self) -> list[ResultDifference]:
        """Headline numbers that differ by more than their error bars: control first, then the largest change."""
        rows = [row for row in self.changed if self._decides(row)]
        return sorted(rows, key=lambda row: (row.quantity not in CONTROL, -share_of(row)))

    def _decides(self, row: ResultDifference) -> bool:
        name = row.quantity.removeprefix("outer_").removeprefix("inner_")
        return abs(row.difference or 0.0) > max(DECIDING.get(name, math.inf), row.bar)

    def run_of(self, row: ResultDifference) -> str:
        """The run of a number; empty where no other run has a number of that name."""
        runs = {one.run for one in self.changed if one.quantity == row.quantity}
        return row.run if len(runs) > 1 else ""

    @property
    def input(self) -> tuple[str, Any, Any] | None:
        """The input that differs and matters most: a value of the case, else an option, else a version."""
        ranks = (
            ("versions.", "choices.", "command", "case"),
            ("versions.", "choices.models"),  # a set brings its model
        )
        return min(self.both.inputs, key=lambda row: [*map(row[0].startswith, ranks)], default=None)


def share_of(row: ResultDifference) -> float:
    """The size of a change as a share of the value in run A; 1 from or to zero."""
    return 1.0 if row.relative is None else abs(row.relative)


def name_of(row: ResultDifference) -> str:
    """What a number is called."""
    return label_of(row.quantity) if is_defined(row.quantity) else row.quantity.replace("_", " ")


def cause(facts: DifferenceFacts) -> dict[str, Said]:
    """The input that differs, as fields."""
    row, step = facts.input, facts.both.b.verdict.get("step", "")
    if row is None:
        return {"input": "the inputs are the same", "step": step}
    key, a, b = row
    more = len(facts.both.inputs) - 1
    said = f"{key.removeprefix('choices.')} {value_text(a)} became {value_text(b)}"
    return {"input": said, "more": count_text(more, "more input") if more else "", "step": step}


def value_text(value: object) -> str:
    """The value of an input, cut where it is long."""
    text = "–" if value is None else ", ".join(map(str, value)) if isinstance(value, list) else str(value)  # fmt: skip
    return text if len(text) <= 40 else text[:37] + "..."


def change(facts: DifferenceFacts) -> Hits:
    """A headline number differs by more than its error bars; without error bars by more than a thousandth."""
    for row in facts.deciding[:1]:
        a, b = row.a or 0.0, row.b or 0.0
        yield Hit(Amount(row.quantity, b), fields={
            "name": name_of(row), "way": "rises" if b > a else "falls", "a": Amount(row.quantity, a), "run": facts.run_of(row),
            "share": "" if row.relative is None else f"{digits_text(100 * share_of(row), 0, 2)} %", **cause(facts),
        })  # fmt: skip


def small(facts: DifferenceFacts) -> Hits:
    """Numbers differ, but no headline number by more than its error bars."""
    if facts.changed:
        yield Hit(fields=cause(facts))


def same(facts: DifferenceFacts) -> Hits:
    """Every number that both runs have is the same."""
    whole = all(run.state == "completed" for run in (facts.both.a, facts.both.b))
    lacks = bool(facts.both.results) or not whole
    yield Hit(fields={"there": "that both have" if lacks else "", **cause(facts)})


def failed(facts: DifferenceFacts) -> Hits:
    """A part of either run failed."""
    for letter, run in (("A", facts.both.a), ("B", facts.both.b)):
        if run.failures:
            yield Hit(fields={"letter": letter, "said": run.failures[0]})


SAVED = (
    Rule("J201", "decides", "no runs are saved", nothing, (), "'{folder}' holds none[ of {of}]", "valvetrain cases", mark=""),
    Rule("J202", "decides", "killed before its end: {count}, the last of {of} after {ended}", killed, (),
         "what it finished is in {folder}; delete it to remove it",
         "[{command}]", mark="warn"),
    Rule("J203", "decides", "{count} saved, the newest {state}: {of}", not_completed, (), "[{said}]", "[{command}]", mark="bad",
         unless=("J20",)),
    Rule("J204", "decides", "{count} saved[, {running} in progress]", saved, (), "[newest {newest}]", "[{step}]", mark="ok",
         unless=("J20",)),
)  # fmt: skip
DIFFERENT = (
    Rule("J221", "decides", "{name} {way} [{share}, ]from {a..value}[ ({run})]", change, (), "{input}[, {more}]", "[{step}]",
         mark=""),
    Rule("J222", "decides", "no headline number differs by more than its error bar", small, (), "{input}[, {more}]", "[{step}]", mark="",
         unless=("J221",)),
    Rule("J223", "decides", "the results[ {there}] are the same", same, (), "{input}[, {more}]", "[{step}]", mark="", unless=("J22",)),
    Rule("J230", "warns", "run {letter} failed: {said}", failed),
)  # fmt: skip
RULES = (*SAVED, *DIFFERENT)
