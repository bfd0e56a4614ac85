"""What ``spring-card`` shows: the spring next to its card or its table of forces, and what was assumed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.engine import Findings, judge
from valvetrain.findings.words import Amount, Words, percent
from valvetrain.solution.definition import label_of
from valvetrain.spring_card.card import weight
from valvetrain.spring_card.fit import CardDeviation, SpringFit, forces_at
from valvetrain.spring_card.rules import MISSED, RULES, CardFacts, apart
from valvetrain.spring_card.tester import TesterFit
from valvetrain.springs.stress import nominal_stress_per_force
from valvetrain.units.reader import shown_system
from valvetrain.views.shown import Shown
from valvetrain.views.style import LEAD, OTHER, SECOND, FigureSpec, line, panels, styled
from valvetrain.views.table import Line, TextTable

#: Points of the curve of a card's spring.
POINTS = 25


@dataclass(frozen=True)
class CardAnswer(Shown):
    """What is shown of a ``spring`` that has a card or a table of forces."""

    spring: CardFacts
    words: Words = field(default_factory=lambda: Words(shown_system()))

    @property
    def facts(self) -> CardFacts:
        """The spring as rules read it."""
        return self.spring

    @property
    def title(self) -> str:
        """The spring and what it is known by."""
        source = "a catalogue card" if self.facts.by_card else "a table of forces"
        return f"{self.facts.wire.name}, wire from {source}"

    @cached_property
    def findings(self) -> Findings:
        """All findings, the verdict first."""
        return judge(self.facts, RULES, self.words)

    @property
    def headings(self) -> list[str]:
        """Card and wire."""
        return ["card", "wire"] if self.facts.by_card else [""]

    @cached_property
    def lines(self) -> list[Line]:
        """Numbers of the card next to those of the wire, or those of a table with their intervals; then surge and stress."""
        fit, found = self.facts.fit, self.facts.quantities
        if isinstance(fit, SpringFit):
            rows, force = [self._beside(one) for one in fit.held], fit.card.open_load.force
        else:
            rows = [
                Line(label, (self.words.between(amount),))
                for label, amount in _measured(fit).items()
            ]
            force = float(fit.by_rod[-1, 1])
        more = {
            "surge frequency": Amount("surge_frequency", found["estimated_surge_frequency"]),
            "stress at the largest load": Amount("stress", nominal_stress_per_force(self.facts.wire) * force),
            "stress at coil bind": Amount("stress", found["solid_nominal_shear_stress"]),
        }  # fmt: skip
        blank = ("",) * (len(self.headings) - 1)
        return rows + [
            Line(name, (*blank, self.words.amount(one, 4))) for name, one in more.items()
        ]

    def _beside(self, one: CardDeviation) -> Line:
        card, wire = (Amount(one.quantity, value) for value in (one.requested or 0.0, one.found))
        texts = self.words.fill("[{card:4}]", {"card": card}), self.words.amount(wire, 4)
        if abs(apart(one)) > MISSED:
            return Line(label_of(one.quantity), texts, "warn", percent(apart(one)))
        return Line(label_of(one.quantity), texts, "ok" if one.requested else "")

    @property
    def rests_on(self) -> list[str]:
        """What card or table leave open."""
        return [one.remark for one in self.findings if one.remark]

    def tables(self) -> Mapping[str, TextTable]:
        """What was assumed and noted, the pitch law of a table, and every number of the spring."""
        notes = tuple((str(one),) for one in self.findings.by("Z1") if one.level == "notes")
        law = self.facts.fit.stations if isinstance(self.facts.fit, TesterFit) else None
        stations = () if law is None else zip(law.coil, law.pitch, 2 * law.spread, strict=True)
        pitch = tuple((f"{coil:.2f}", self.words.between(Amount("length", *bars))) for coil, *bars in stations)  # fmt: skip
        numbers = tuple((label_of(name), self.words.amount(Amount(name, value), 4)) for name, value in self.facts.quantities.items())  # fmt: skip
        return {
            "assumed": TextTable("Assumptions and notes", ("",), notes),
            "pitch": TextTable("Pitch law behind the table", ("coil", "pitch"), pitch),
            "numbers": TextTable("Numbers of the spring", ("quantity", "value"), numbers),
        }

    def figures(self) -> Mapping[str, FigureSpec]:
        """Force over height with the points that were given, and the pitch."""
        return {
            "force": FigureSpec("Force and rate over height", "the line is the finite-element rod", _force),
            "pitch": FigureSpec("Pitch over the coils", "rise of the wire per turn, unloaded", _pitch),
        }  # fmt: skip

    def computed(self) -> Iterator[str]:
        """How the spring was found."""
        yield "Active turns and free length, or a pitch law, are changed until the finite-element rod has the given forces."
        yield "Copy the spring of spring.toml into your case, or compare it there by compare-springs."
        yield "Heights are between the seats. Stress is nominal shear by EN 13906-1 (Bergsträsser)."


def _measured(fit: TesterFit) -> dict[str, Amount]:
    """Results of a table of forces with half of their 95 % intervals."""
    between = {
        "rate at the installed height": ("rate", fit.rate), "force at the installed height": ("force", fit.preload),
        "free length": ("length", fit.free_length), "active turns": ("active_coil_count", fit.active_coils),
        "coil bind begins at": ("height", (fit.coil_bind or 0.0, 0.0)), "solid height": ("height", (fit.definition.solid_height, 0.0)),
        "wire off the table, at most": ("force", (fit.worst_by_rod, 0.0)), "scatter of a station": ("force", (fit.scatter, 0.0)),
        "mass on the scales": ("mass", (weight(fit.definition), 0.0)),
    }  # fmt: skip
    return {label: Amount(name, value, 2 * spread) for label, (name, (value, spread)) in between.items() if value}  # fmt: skip


def _force(facts: CardFacts) -> go.Figure:
    """Force (N) and rate (N/mm) of the wire over height (mm), with the loads of the card or the stations of the table."""
    fit, wire = facts.fit, facts.wire
    if isinstance(fit, SpringFit):
        loads = (fit.card.installed_load, fit.card.open_load)
        points = np.array([(one.height, one.force) for one in loads]).T
        near, far = (wire.solid_height + share * wire.solid_compression for share in (0.03, 0.1))
        even = np.linspace(wire.free_length - 1e-4, max(near, min(loads[1].height, far)), POINTS)
        heights = np.unique([*even, *points[0]])[::-1]  # the line meets both loads
        forces = np.array(forces_at(wire, heights.tolist()))
    else:
        points = np.array([fit.table.heights, fit.table.forces])
        heights, _, forces = fit.by_rod.T
    fig = panels((0.65, 0.35))
    fig.add_trace(line(1e3 * heights, forces, "wire", LEAD), 1, 1)
    marker = {"size": 10 if facts.by_card else 5, "color": SECOND}
    fig.add_trace(go.Scatter(x=1e3 * points[0], y=points[1], name="given", mode="markers", marker=marker), 1, 1)  # fmt: skip
    rate = -1e-3 * np.gradient(forces, heights)
    fig.add_trace(line(1e3 * heights, rate, "rate", LEAD, showlegend=False), 2, 1)
    fig.update_yaxes(range=[0, min(1.15 * np.max(rate), 6 * np.median(rate))], row=2)
    return styled(fig, "height between the seats, mm", ("force, N", "rate, N/mm"), 440)


def _pitch(facts: CardFacts) -> go.Figure:
    """Pitch and wire diameter (mm) over the coils; of a table the stations of the law with their intervals."""
    wire, fig = facts.wire, go.Figure()
    coil = np.linspace(0.0, wire.total_coils, 601)
    fig.add_trace(line(coil, 1e3 * wire.pitch.value(coil), "pitch", LEAD))
    fig.add_trace(line(coil, 1e3 * wire.wire_diameter.value(coil), "wire diameter: coils closed", OTHER, "dash"))  # fmt: skip
    if isinstance(facts.fit, TesterFit):
        law = facts.fit.stations
        bars, marker = {"array": 2e3 * law.spread}, {"color": SECOND}
        fig.add_trace(go.Scatter(x=law.coil, y=1e3 * law.pitch, error_y=bars, name="stations, 95 %", mode="markers", marker=marker))  # fmt: skip
    return styled(fig, "coil, from the lower tip", ("pitch, mm",), 320).update_yaxes(
        rangemode="tozero"
    )


def answer_of_spring(fit: SpringFit | TesterFit) -> CardAnswer:
    """What is shown of a spring that has a card or a table of forces."""
    return CardAnswer(CardFacts(fit))
