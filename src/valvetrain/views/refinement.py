"""What ``refine`` shows: which numbers are resolved, each with its error bar and its range over contact constants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from textwrap import wrap

import plotly.graph_objects as go

from valvetrain.findings.rules_refine import RULES, RefineFacts, reach_of, share_of
from valvetrain.findings.words import UNRESOLVED, Amount, digits_text, percent
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.definition import label_of
from valvetrain.solution.uncertainty import Uncertainty
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import BAD, LEAD, SECOND, FigureSpec, styled
from valvetrain.views.table import Line

#: Rows of the first table and of the figure: the numbers that move most.
ROWS = 10
#: Letters of a line of a label in the figure, so that a phone shows all of them.
BREADTH = 24
#: Least share (per cent) that is drawn.
LEAST = 0.01


def _most(row: Uncertainty) -> float:
    return max(share_of(row), reach_of(row))


@dataclass(frozen=True)
class RefineAnswer(ShownByRules):
    """What is shown of a refinement, in the units of the reader by default."""

    rules = RULES

    study: UncertaintyStudy

    @property
    def title(self) -> str:
        """The case and what was varied."""
        meshes = ", ".join(map(str, self.study.elements_per_coil))
        varied = f"{meshes} elements per coil" if meshes else "finer steps and divisions"
        return f"{self.study.record.title or self.study.record.name}: {varied}, other contact constants"

    @property
    def facts(self) -> RefineFacts:
        """The refinement as rules read it."""
        return RefineFacts(self.study, self.words.case)

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["value", "error bar", "with other contact constants"]

    @cached_property
    def lines(self) -> list[Line]:
        """The numbers that move most."""
        return [
            Line(self._name(row), self._cells(row), "" if _most(row) < UNRESOLVED else "warn")
            for row in self._rows
        ]

    @property
    def _rows(self) -> list[Uncertainty]:
        rows = self.facts.rows
        widest = max(map(share_of, rows), default=0.0)  # of which the verdict speaks
        return sorted(rows, key=lambda row: (share_of(row) == widest, _most(row)), reverse=True)[
            :ROWS
        ]

    def _name(self, row: Uncertainty) -> str:
        return ", ".join(filter(None, (label_of(row.quantity), self.facts.place(row, "{}"))))

    def _cells(self, row: Uncertainty) -> tuple[str, ...]:
        unit = self.words.unit(row.quantity, row.value)
        value, bar = (digits_text(one / unit.size, 0, 4 - 2 * k) for k, one in enumerate((row.value, row.numerical)))  # fmt: skip
        reach = row.contact_range
        ends = "" if reach is None else self.words.span(Amount(row.quantity, reach.low), Amount(row.quantity, reach.high), 4)  # fmt: skip
        return f"{value} {unit.text}".strip(), f"± {bar}, {percent(share_of(row))}", ends

    def figures(self) -> Mapping[str, FigureSpec]:
        """The numbers that move most."""
        hint = "right of the dashed line a number is not resolved"
        return {"bars": FigureSpec("How far each number moves", hint, lambda _: self._bars())}

    def _bars(self) -> go.Figure | None:
        """Error bars and half ranges over contact constants as shares (per cent) of their numbers."""
        names = ["<br>".join(wrap(self._name(row), BREADTH)) for row in self._rows]
        fig = go.Figure()
        for share, name, colour in (
            (share_of, "numerics, ±", LEAD),
            (reach_of, "contact constants, ±", SECOND),
        ):
            shares = [max(100 * share(row), LEAST) for row in self._rows]
            marker = {"color": colour, "size": 10}
            fig.add_trace(go.Scatter(x=shares, y=names, mode="markers", marker=marker, name=name))
        fig.add_vline(100 * UNRESOLVED, line={"color": BAD, "width": 1, "dash": "dash"})
        styled(fig, "% of the number", ("",), 110 + 30 * len(names))
        fig.update_layout(hovermode="closest", margin={"l": 190})
        fig.update_xaxes(type="log", dtick=1)
        fig.update_yaxes(autorange="reversed", dtick=1, tickfont={"size": 11})
        return fig if names else None

    @property
    def text(self) -> str:
        """The case file."""
        return self.study.record.text

    def computed(self) -> Iterator[str]:
        """How error bars and ranges were found."""
        if self.study.elements_per_coil:
            yield "Error bars are 1.25 times the distance to the Richardson value of three meshes, and of a halved step."
        else:
            yield "Error bars are from a step halved twice, springs divided more finely and half the samples."
        yield "Contact stiffness is halved and doubled, and so is damping."
        yield from self.study.failures
