"""The answer of a command on a study: findings, rows, what it rests on and what to do next, in one set of words.

Terminal, page and JSON show an :class:`Answer` and compute nothing of their own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from valvetrain.findings.engine import Findings, judge
from valvetrain.findings.facts import Facts
from valvetrain.findings.table import rules
from valvetrain.findings.words import Words, digits_text, speed_text
from valvetrain.registry import members
from valvetrain.session import called_case
from valvetrain.solution.study import Study
from valvetrain.views.rows import first_rows, headings
from valvetrain.views.shown import ShownStudy
from valvetrain.views.side_by_side import model_table, paper_table
from valvetrain.views.table import Line, TextTable

if TYPE_CHECKING:
    from valvetrain.views.motion.parts import Moving
    from valvetrain.views.style import FigureSpec


@dataclass(frozen=True)
class Answer(ShownStudy):
    """What is shown of a ``study``, in the units of the reader by default.

    >>> import valvetrain as vt
    >>> answer = Answer(vt.simulate("job-t", "2000 rpm", models=["massless"]))
    >>> answer.verdict.code, len(answer.lines) > 4
    ('K104', True)
    """

    study: Study
    words: Words = field(default_factory=lambda: Words(case=called_case()))

    @cached_property
    def facts(self) -> Facts:
        """The study as rules read it."""
        return Facts(self.study)

    @cached_property
    def findings(self) -> Findings:
        """All findings, the verdict first."""
        return judge(self.facts, rules(self.facts.kinds), self.words)

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
        """The rows of the first table; none next to a table of models."""
        return [] if self.models else first_rows(self.facts, self.findings, self.words)

    @property
    def headings(self) -> list[str]:
        """What tells the columns of the first table apart."""
        return headings(self.facts, self.findings)

    @cached_property
    def models(self) -> TextTable | None:
        """Spring models side by side, of a comparison of them."""
        return model_table(self.facts, self.words) if self.study.command == "compare" else None

    @cached_property
    def paper(self) -> TextTable | None:
        """Printed values next to those computed here; None without a published source."""
        return paper_table(self.study.comparisons)

    def figures(self) -> Mapping[str, FigureSpec]:
        """Those that the registry lists (kind ``figures``) for such a study, those of packages last."""
        return dict(members("figures", self.facts.kinds))

    def tables(self) -> Mapping[str, TextTable]:
        """Those that the registry lists (kind ``tables``) for such a study and that have rows."""
        made = ((key, make(self)) for key, make in members("tables", self.facts.kinds))
        return {key: one for key, one in made if one is not None and one.rows}

    def moving(self) -> Moving | None:
        """The runs in motion, the one that decides first."""
        from valvetrain.views.figures import worst_run
        from valvetrain.views.motion.scene import moving_picture

        return moving_picture(self.study, worst=worst_run(self.facts))

    def computed(self) -> Iterator[str]:
        """Models, step, error bars, notes, version, papers."""
        study, step = self.study, "time_step_duration"
        for run in {run.model: run for run in study.solutions}.values():
            value = run.quantities.get(step, run.statistics.get("time_step", math.nan))
            text = (
                f", step {digits_text(1e6 * float(value))} µs" if isinstance(value, float) else ""
            )
            yield f"{run.model}: {run.statistics.get('integrator', 'no integrator')}{text}."
        yield from study.notes
        if missing := [
            f"{one.label} at {speed_text(one.engine_speed)}" for one in study.error_bars.missing
        ]:
            yield f"No error bars: {', '.join(missing)}."
        record, made = study.record, study.provenance
        zero = f" Zero of the cam angle: {record.zero_of_angle}." if record.zero_of_angle else ""
        yield f"Cam angles are cam degrees, engine speed is that of the crank.{zero}"
        yield f"valvetrain {made.package_version}, case {record.name} ({record.digest[:12]})."
        yield from dict.fromkeys((*record.citations, *made.citations))

    @property
    def text(self) -> str:
        """The case file."""
        return self.study.record.text

    @property
    def again(self) -> str:
        """The command that was called, which is no next step."""
        return f"valvetrain {self.study.command} {self.words.case or self.facts.case}"
