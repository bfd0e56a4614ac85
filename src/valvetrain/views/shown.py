"""What terminal, page, JSON and notebook show of a result: findings, rows, figures, tables, and what to do next."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, cast

from valvetrain.findings.engine import Finding, Findings, Rule, judge
from valvetrain.findings.words import Words
from valvetrain.session import called_case
from valvetrain.units.reader import requested_system, shown_system
from valvetrain.views.table import Line, TextTable

if TYPE_CHECKING:  # a list of files loads none of these
    from valvetrain.findings.facts import Facts
    from valvetrain.solution.study import Study
    from valvetrain.views.motion.parts import Moving
    from valvetrain.views.style import FigureSpec

#: Topics of notes that are said in full; others stand in the table of findings alone.
SAID = ("M", "H", "W", "F", "N", "Q", "J", "Y")
#: Commands of next steps that take no ``--units``.
WITHOUT_UNITS = ("new", "cases", "compare-runs", "findings")


class Shown(ABC):
    """What terminal, page, JSON and notebook show of a result, whatever its class.

    A class of results names its own subclass in the registry (kind ``answers``), which is made from the result alone.
    """

    @property
    @abstractmethod
    def facts(self) -> Any:
        """The result as its rules and figures read it."""

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
    def models(self) -> TextTable | None:
        """Spring models side by side."""
        return None

    @property
    def paper(self) -> TextTable | None:
        """Printed values next to those computed here."""
        return None

    def figures(self) -> Mapping[str, FigureSpec]:
        """The figures by name, the one that opens the page first; each is made from :attr:`facts`."""
        return {}

    def tables(self) -> Mapping[str, TextTable]:
        """The folded tables of the page by name; those without rows are left out."""
        return {}

    def moving(self) -> Moving | None:
        """A picture that moves."""
        return None

    def picture(self) -> str:
        """A still picture (SVG) that opens the page in place of the first figure."""
        return ""

    def computed(self) -> Iterable[str]:
        """Sentences on how it was computed."""
        return ()

    @property
    def text(self) -> str:
        """The file that it was computed from."""
        return ""

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
        told = tuple(one.remark for one in self.lines if one.remark)
        rest = self.findings[1:]
        warned = [
            one
            for one in rest
            if one.level == "warns"
            and not (one.remark and any(remark.startswith(one.remark) for remark in told))
        ]
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
        return self._in_units(next((one for one in steps if one and one != self.again), ""))

    @property
    def further_step(self) -> str:
        """A command of a note, which answers another question."""
        steps = (one.step for one in self.findings if one.level == "notes")
        return self._in_units(next((one for one in steps if one.startswith("valvetrain ")), ""))

    def _in_units(self, step: str) -> str:
        """The command in the units that were requested, of several commands the last one."""
        program, _, command = step.rpartition("&& ")[2].partition(" ")
        if program != "valvetrain" or command.split()[0] in WITHOUT_UNITS:
            return step
        return step + f" --units {requested_system()}" * bool(requested_system())

    def for_reader(self) -> Shown:
        """The same in the units that the reader asked for, where it is in SI."""
        words = getattr(self, "words", None)
        if words is None or shown_system() == "si":
            return self
        return cast("Shown", replace(cast("Any", self), words=replace(words, units=shown_system())))


@dataclass(frozen=True)
class ShownByRules(Shown):
    """What is shown of a result whose findings are those of its ``rules``; ``words``: units of the reader."""

    rules: ClassVar[Sequence[Rule]]
    words: Words = field(default_factory=lambda: Words(case=called_case()), kw_only=True)

    def write(self, folder: Path) -> list[Path]:
        """Write the files of the result, but its page, to ``folder``."""
        return []

    @cached_property
    def findings(self) -> Findings:
        """All findings, the verdict first."""
        return judge(self.facts, self.rules, self.words)


class ShownStudy(Shown):
    """What tables read of the answer of a study."""

    study: Study
    words: Words

    @property
    @abstractmethod
    def facts(self) -> Facts:
        """The study as rules read it."""
