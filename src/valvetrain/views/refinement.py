"""What ``refine`` shows: which numbers are resolved, each with its error bar and its range over contact constants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import plotly.graph_objects as go

from valvetrain.findings.rules_refine import RULES, RefineFacts, share_of
from valvetrain.findings.words import UNRESOLVED, Amount, digits_text, speed_text
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.definition import label_of
from valvetrain.solution.uncertainty import Uncertainty
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import BAD, LEAD, FigureSpec, styled
from valvetrain.views.table import Line, TextTable

#: Rows of the first table and dots of the figure: the largest error bars.
ROWS, DOTS = 10, 30


@dataclass(frozen=True)
class RefineAnswer(ShownByRules):
    """What is shown of a refinement, in the units of the reader by default."""

    rules = RULES

    study: UncertaintyStudy

    @property
    def title(self) -> str:
        """The case and what was varied."""
        meshes = ", ".join(map(str, self.study.elements_per_coil))
        varied = f"{meshes} elements per coil" if meshes else "step, division and samples"
        return f"{self.study.record.title or self.study.record.name}, {varied} and contact constants varied"  # fmt: skip

    @property
    def facts(self) -> RefineFacts:
        """The refinement as rules read it."""
        return RefineFacts(self.study, self.words.case)

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["value", "error bar", "order", "contact constants"]

    @cached_property
    def lines(self) -> list[Line]:
        """The numbers with the largest error bars."""
        rows = sorted(self.facts.rows, key=share_of, reverse=True)[:ROWS]
        return [
            Line(", ".join(filter(None, (label_of(row.quantity), self._place(row)))), self._cells(row),
                 "" if share_of(row) < UNRESOLVED else "warn")
            for row in rows
        ]  # fmt: skip

    def _place(self, row: Uncertainty) -> str:
        """Speed and variant of a row, where there are several."""
        labels = len({one.label for one in self.study.rows if one.label}) > 1
        speeds = len({one.engine_speed for one in self.study.rows if one.engine_speed}) > 1
        speed = "" if row.engine_speed is None or not speeds else speed_text(row.engine_speed)
        return ", ".join(filter(None, (speed, row.label * labels)))

    def _cells(self, row: Uncertainty) -> tuple[str, ...]:
        unit = self.words.unit(row.quantity, row.value)
        value, bar = (digits_text(one / unit.size, 0, 4 - 2 * k) for k, one in enumerate((row.value, row.numerical)))  # fmt: skip
        order = "" if row.trusted_order is None else digits_text(row.trusted_order, 0, 2)
        reach = row.range
        ends = "" if reach is None else self.words.span(Amount(row.quantity, reach.low), Amount(row.quantity, reach.high), 4)  # fmt: skip
        return f"{value} {unit.text}".strip(), f"± {bar}", order, ends

    def tables(self) -> Mapping[str, TextTable]:
        """Every number."""
        rows = tuple(
            (label_of(row.quantity), self._place(row), *self._cells(row)) for row in self.study.rows
        )
        return {"error-bars": TextTable("Error bars", ("quantity", "where", *self.headings), rows)}

    def figures(self) -> Mapping[str, FigureSpec]:
        """The largest error bars."""
        hint = "right of the dashed line a number is not resolved"
        return {"bars": FigureSpec("Error bars", hint, lambda _: self._bars())}

    def _bars(self) -> go.Figure | None:
        """Error bars as shares (per cent) of their numbers, the largest first."""
        rows = sorted(self.facts.rows, key=share_of, reverse=True)[:DOTS]
        if not rows:
            return None
        names = [
            ", ".join(filter(None, (label_of(row.quantity), self._place(row)))) for row in rows
        ]
        shares = [max(100 * share_of(row), 1e-4) for row in rows]
        colours = [BAD if one >= 100 * UNRESOLVED else LEAD for one in shares]
        fig = go.Figure(
            go.Scatter(
                x=shares, y=names, mode="markers", marker={"color": colours, "size": 9}, name="error bar", showlegend=False,
            )
        )  # fmt: skip
        fig.add_vline(100 * UNRESOLVED, line={"color": BAD, "width": 1, "dash": "dash"})
        styled(fig, "error bar, % of the number", ("",), 120 + 22 * len(rows))
        fig.update_layout(hovermode="closest", margin={"l": 300})
        fig.update_xaxes(type="log", dtick=1)
        return fig.update_yaxes(autorange="reversed", dtick=1, automargin=True)

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
