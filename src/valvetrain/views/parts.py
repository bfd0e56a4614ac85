"""What is shown of ranked parts: a table by the engine speed that each gains, and bars with their ranges."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import plotly.graph_objects as go

from valvetrain.findings.engine import Mark
from valvetrain.findings.rules_parts import (
    LOST,
    RULES,
    PartFacts,
    gain_text,
    range_text,
    reached_text,
)
from valvetrain.findings.rules_sweep import DOES
from valvetrain.findings.words import Amount
from valvetrain.solution.critical import RPM
from valvetrain.solution.part_ranking import PartChange, PartRanking
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import BAD, LEAD, OTHER, FigureSpec, styled
from valvetrain.views.table import Line

HINT = "bars: rpm of control gained by each change alone, pale where not sure; lines: range by damping, spring model, step and mesh"


@dataclass(frozen=True)
class PartsAnswer(ShownByRules):
    """What is shown of ranked parts, in the units of the reader by default."""

    rules = RULES

    ranking: PartRanking

    @property
    def title(self) -> str:
        """The train and what is ranked."""
        return f"{self.ranking.case}, {self.ranking.label}: parts by the engine speed of control that each gains"

    @property
    def facts(self) -> PartFacts:
        """The ranking as rules read it."""
        return PartFacts(self.ranking)

    @property
    def stressed(self) -> bool:
        """Whether a change of stress is known."""
        return any(math.isfinite(one.stress_change) for one in self.ranking.changes)

    @property
    def headings(self) -> list[str]:
        """Speed, gain with its range, and what changes with it."""
        stress = ["wire stress"] * self.stressed
        return ["control to, rpm", "gained", "range", "lift lost", "seat load", *stress]

    @property
    def lines(self) -> list[Line]:
        """The train as it is, and every change with its price."""
        load = self.words.amount(Amount("preload", self.ranking.seat_load))
        speed = reached_text(self.ranking.engine_speed, self.ranking)
        lost = self._lost(self.ranking.lift_loss)
        cells = (speed, "", "", lost, load, *[""] * self.stressed)
        lines = [Line("as it is", cells, "", _then(self.ranking.loss))]
        return [*lines, *map(self._line, self.ranking.changes)]

    def _line(self, change: PartChange) -> Line:
        if change.refusal:
            return Line(change.part, ("–",) * len(self.headings), "warn", change.refusal)
        marks: tuple[Mark, ...] = ("", "ok", "bad")
        doubts = [one for one in self.findings.by("W311") if one.fields["part"] == change.part]
        mark = marks[change.sign] if change.chosen else "warn" if doubts else ""
        then = "" if change.loss == self.ranking.loss else _then(change.loss)
        price = "; ".join(filter(None, ("" if change.sign else "not sure", then, change.price)))
        price = doubts[0].remark if doubts else price
        if change.near_bind:
            mark = "bad" if change.sign < 0 else "warn"
            left = self.words.amount(Amount("coil_bind_clearance", change.bind_clearance))
            price = f"only {left} left to coil bind; {price}"
        stress = self._signed("peak_shear_stress", change.stress_change)
        cells = (
            reached_text(change.engine_speed, self.ranking), gain_text(change), range_text(change), self._lost(change.lift_loss),
            self._signed("preload", change.seat_load_change), *[stress] * self.stressed,
        )  # fmt: skip
        return Line(change.part, cells, mark, price)

    def _lost(self, value: float) -> str:
        """Lift (m) that flex takes; empty where it is unknown."""
        return self.words.fill("[{lost:2}]", {"lost": Amount(LOST[0], value)} if value >= 0 else {})

    def _signed(self, name: str, value: float) -> str:
        """A change with its sign; empty for none."""
        text = self.words.amount(Amount(name, value)) if math.isfinite(value) else ""
        return "" if text.startswith(("0 ", "−0 ")) or abs(value) < 1e-3 else f"{'+' * (value > 0)}{text}"  # fmt: skip

    def figures(self) -> Mapping[str, FigureSpec]:
        """The gains."""
        return {"parts": FigureSpec("Engine speed gained", HINT, picture)}

    @property
    def text(self) -> str:
        """The case file."""
        return self.ranking.text

    def computed(self) -> Iterator[str]:
        """How gains and ranges were computed."""
        yield "Each train is searched for its critical speeds; it is controlled up to the lowest at which control stays lost."
        yield "A range is made of the differences of both trains with the same thing changed: damping, spring model, step, mesh."
        yield "Gains do not add up: change the case and rank again."


def _then(loss: str) -> str:
    """What the valve does first beyond the speed of control, by the kind of the critical speed."""
    return f"then it {DOES[loss].format(place='cam')}" if loss else ""


def picture(facts: PartFacts) -> go.Figure | None:
    """Bars of the gains, the largest on top, with their ranges."""
    rows = [one for one in facts.ranking.changes if not one.refusal]
    if not rows:
        return None
    gains = [one.gain / RPM for one in rows]
    fig = go.Figure(go.Bar(
        x=gains, y=[one.part for one in rows], orientation="h", width=0.62, showlegend=False,
        marker_opacity=[0.35 if one.chosen and not one.sign else 1.0 for one in rows],
        marker_color=[(BAD if one.gain < 0 else LEAD) if one.chosen else OTHER for one in rows],
        error_x={
            "type": "data", "symmetric": False, "thickness": 1.4, "color": "#333",
            "array": [(one.largest_gain - one.gain) / RPM for one in rows],
            "arrayminus": [(one.gain - one.least_gain) / RPM for one in rows],
        },
        hovertemplate="%{y}: %{x:+.0f} rpm<extra></extra>",
    ))  # fmt: skip
    styled(fig, "engine speed gained, rpm", ("",), 120 + 26 * len(rows))
    fig.update_layout(hovermode="closest")
    fig.update_xaxes(zeroline=True, zerolinecolor="#333")
    return fig.update_yaxes(autorange="reversed", dtick=1, automargin=True)
