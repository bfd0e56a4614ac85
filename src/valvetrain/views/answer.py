"""The answer of a command on a study: findings, rows, what it rests on and what to do next, in one set of words.

Terminal, page and JSON show an :class:`Answer` and compute nothing of their own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property

from valvetrain.findings.engine import Finding, Findings
from valvetrain.findings.facts import Facts
from valvetrain.findings.table import findings_of
from valvetrain.findings.words import Words, speed_text
from valvetrain.session import called_case
from valvetrain.solution.study import Study
from valvetrain.units.reader import shown_system
from valvetrain.views.models import ModelTable, model_table
from valvetrain.views.published import PaperTable, paper_table
from valvetrain.views.rows import first_rows, headings
from valvetrain.views.table import Line

#: Topics of notes that are said in full; others stand in the table of findings alone.
SAID = ("M", "H", "W", "D", "F", "N", "Q")


class Shown(ABC):
    """What terminal, page and JSON show of a result, whatever its class."""

    @property
    @abstractmethod
    def findings(self) -> Findings:
        """All findings, the verdict first."""

    @property
    @abstractmethod
    def title(self) -> str:
        """What was computed."""

    @property
    @abstractmethod
    def lines(self) -> list[Line]:
        """The rows of the first table."""

    @property
    def headings(self) -> list[str]:
        """What tells the columns of the first table apart."""
        return [""]

    @property
    def models(self) -> ModelTable | None:
        """Spring models side by side."""
        return None

    @property
    def paper(self) -> PaperTable | None:
        """Printed values next to those computed here."""
        return None

    @property
    def verdict(self) -> Finding | None:
        """The finding that decides; None of a result that shows nothing."""
        return self.findings.verdict

    @property
    def headline(self) -> tuple[str, str]:
        """The verdict in two parts: the fact, and the rest with the reason."""
        if self.verdict is None:
            return "", ""
        text, reason = self.verdict.text, self.verdict.reason
        place = next((at for mark in (": ", ", ") if (at := text.find(mark)) > 0), len(text))
        return text[:place], text[place:] + (f": {reason}" if reason else "")

    @property
    def bullets(self) -> list[Finding]:
        """What is said besides verdict and rows: warnings, then models and published values."""
        told = {one.remark for one in self.lines if one.remark}
        rest = self.findings[1:]
        warned = [one for one in rest if one.level == "warns" and one.remark not in told]
        decided = [one for one in rest if one.level == "decides" and one.mark != "ok"]
        in_table = ("M110", "M111") if self.models is not None else ()
        notes = [
            one
            for one in rest
            if one.level == "notes" and one.code.startswith(SAID) and one.code not in in_table
        ]
        return [*decided, *warned, *notes]

    @property
    def rests_on(self) -> list[str]:
        """The assumptions, a few words each."""
        return [one.remark for one in self.findings.by("A") if one.remark]

    @property
    def again(self) -> str:
        """The command that was called, which is no next step."""
        return ""

    @property
    def next_step(self) -> str:
        """What to run or do next: that of the first finding besides notes that has one, but not this command again."""
        steps = (one.step for one in self.findings if one.level != "notes")
        return next((one for one in steps if one and one != self.again), "")


@dataclass(frozen=True)
class Answer(Shown):
    """What is shown of a ``study``, in the units of the reader by default.

    >>> import valvetrain as vt
    >>> answer = Answer(vt.simulate("job-t", "2000 rpm", spring_models=["massless"]))
    >>> answer.verdict.code, len(answer.lines) > 4
    ('K104', True)
    """

    study: Study
    words: Words = field(default_factory=lambda: Words(shown_system(), case=called_case()))

    @cached_property
    def facts(self) -> Facts:
        """The study as rules read it."""
        return Facts(self.study)

    @cached_property
    def findings(self) -> Findings:
        """All findings, the verdict first."""
        return findings_of(self.study, self.words)

    @property
    def title(self) -> str:
        """What was run: ``LS 6.0, 6600 rpm (red line 7000)``."""
        record, speeds = self.study.record, self.study.engine_speeds
        where = f", {speed_text(speeds[0])}" if len(speeds) == 1 else ""
        if self.study.over_speed and len(speeds) > 1:
            where = f", {speed_text(speeds[0], '')} to {speed_text(speeds[-1])}"
        line = f" (red line {speed_text(record.red_line, '')})" if record.red_line else ""
        return f"{record.title or record.name}{where}{line}"

    @cached_property
    def lines(self) -> list[Line]:
        """The rows of the first table."""
        return first_rows(self.facts, self.findings, self.words)

    @property
    def headings(self) -> list[str]:
        """What tells the columns of the first table apart."""
        return headings(self.facts)

    @cached_property
    def models(self) -> ModelTable | None:
        """Spring models side by side, of a comparison of them."""
        return model_table(self.facts, self.words) if self.study.command == "compare" else None

    @cached_property
    def paper(self) -> PaperTable | None:
        """Printed values next to those computed here; None without a published source."""
        return paper_table(self.study.comparisons)

    @property
    def again(self) -> str:
        """The command that was called, which is no next step."""
        return f"valvetrain {self.study.command} {self.words.case or self.facts.case}"
