"""What ``spring-card`` shows: the spring next to its card or its table of forces, and what was assumed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.words import Amount, percent
from valvetrain.measured.force_height import MIN_STATIONS
from valvetrain.solution.definition import label_of
from valvetrain.spring_card.card import weight
from valvetrain.spring_card.fit import CardDeviation, SpringFit, forces_at
from valvetrain.spring_card.rules import MISSED, RULES, CardFacts, apart
from valvetrain.spring_card.tester import TesterFit
from valvetrain.springs.stress import nominal_stress_per_force
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import LEAD, SECOND, FigureSpec, line, panels, styled
from valvetrain.views.table import Line, TextTable

#: Points of the curve of a card's spring.
POINTS = 25


@dataclass(frozen=True)
class CardAnswer(ShownByRules):
    """What is shown of a ``spring`` that has a card or a table of forces."""

    rules = RULES

    spring: CardFacts

    @property
    def facts(self) -> CardFacts:
        """The spring as rules read it."""
        return self.spring

    @property
    def title(self) -> str:
        """The spring and what it is known by."""
        source = "a catalogue card" if self.facts.by_card else "a table of forces"
        wire = self.facts.wire
        return (
            f"{wire.name}, wire from {source}"
            if wire
            else f"{self.facts.fit.spring.name}, from {source}"
        )

    @property
    def headings(self) -> list[str]:
        """Card and wire."""
        return ["card", "wire"] if self.facts.by_card else [""]

    @cached_property
    def lines(self) -> list[Line]:
        """Numbers of the card next to those of the wire, or those of a table with their intervals; then surge and stress."""
        fit, wire = self.facts.fit, self.facts.wire
        if isinstance(fit, SpringFit):
            rows, force = [self._beside(one) for one in fit.held], fit.card.open_load.force
        else:
            rows = [
                Line(label, (self.words.between(amount),))
                for label, amount in _measured(fit).items()
            ]
            force = float(fit.table.forces[-1])
        if wire is None:
            return rows
        numbers = self.facts.quantities
        more = {
            "surge frequency": Amount("surge_frequency", numbers["estimated_surge_frequency"]),
            "stress at the largest load": Amount("stress", nominal_stress_per_force(wire) * force),
            "stress at coil bind": Amount("stress", numbers["solid_nominal_shear_stress"]),
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
        """What was assumed and noted, and the pitch law of a table."""
        notes = tuple((str(one),) for one in self.findings.by("Z1") if one.level == "notes")
        law = self.facts.stations
        stations = () if law is None else zip(law.coil, law.pitch, 2 * law.spread, strict=True)
        pitch = tuple((f"{coil:.2f}", self.words.between(Amount("length", *bars))) for coil, *bars in stations)  # fmt: skip
        return {
            "assumed": TextTable("Assumptions and notes", ("",), notes),
            "pitch": TextTable("Pitch law behind the table", ("coil", "pitch"), pitch),
        }

    def figures(self) -> Mapping[str, FigureSpec]:
        """Force over height with the points that were given."""
        line = "the line is the finite-element rod" if self.facts.wire else "stations of the table"
        return {"force": FigureSpec("Force and rate over height", line, _force)}

    def computed(self) -> Iterator[str]:
        """How the spring was found."""
        yield "Numbers of a table are those of its stations, with 95 % intervals. Half of the loop between loading and unloading counts as doubt."
        yield "Active turns and free length, or a pitch law, are changed until the finite-element rod has the given forces."
        yield "Copy the spring of spring.toml into your case, or compare it there by compare-springs."
        yield "Heights are between the seats. Stress is nominal shear by EN 13906-1 (Bergsträsser)."


def _measured(fit: TesterFit) -> dict[str, Amount]:
    """Results of a table of forces with half of their 95 % intervals."""
    height, wire = fit.table.measured_from != "travel", fit.wire
    place = "at the installed height" if height else "at a quarter of the travel"
    between: dict[str, tuple[str, tuple[float, float] | None]] = {
        "installed height": ("height", (fit.height, 0.0) if height else None),
        f"rate {place}": ("rate", fit.rate), f"force {place}": ("force", fit.preload),
        "free length": ("length", fit.free_length),
        "solid height" if fit.bound else "solid height, by the turns": ("height", fit.solid_height),
        "active turns": ("active_coil_count", wire.active_coils if wire else None),
        "wire off the table, at most": ("force", (wire.worst_by_rod, 0.0) if wire else None),
        "scatter of a station": ("force", (fit.table.curve.scatter, 0.0)),
        "mass on the scales": ("mass", (weight(wire.definition), 0.0) if wire else None),
    }  # fmt: skip
    if len(fit.table.heights) < MIN_STATIONS:
        for label, count in (("all", 0), ("the last three", -3)):
            line = np.polyfit(-fit.table.heights[count:], fit.table.forces[count:], 1)
            between[f"rate through {label} stations"] = ("rate", (float(line[0]), 0.0))
    return {label: Amount(name, bars[0], 2 * bars[1]) for label, (name, bars) in between.items() if bars}  # fmt: skip


def _force(facts: CardFacts) -> go.Figure:
    """Force (N) and rate (N/mm) over height (mm): the wire with the loads of the card or the stations of the table, or these alone."""
    fit, wire = facts.fit, facts.wire
    if isinstance(fit, SpringFit):
        wire, loads = fit.definition, (fit.card.installed_load, fit.card.open_load)
        points = np.array([(one.height, one.force) for one in loads]).T
        near, far = (wire.solid_height + share * wire.solid_compression for share in (0.03, 0.1))
        even = np.linspace(wire.free_length - 1e-4, max(near, min(loads[1].height, far)), POINTS)
        heights = np.unique([*even, *points[0]])[::-1]  # the line meets both loads
        forces = np.array(forces_at(wire, heights.tolist()))
    else:
        points = np.array([fit.table.heights, fit.table.forces])
        heights, forces = points if fit.wire is None else fit.wire.by_rod.T[[0, 2]]
    fig = panels((0.65, 0.35))
    fig.add_trace(line(1e3 * heights, forces, "wire" if wire else "table", LEAD), 1, 1)
    marker = {"size": 10 if facts.by_card else 5, "color": SECOND}
    fig.add_trace(go.Scatter(x=1e3 * points[0], y=points[1], name="given", mode="markers", marker=marker), 1, 1)  # fmt: skip
    rate = -1e-3 * np.gradient(forces, heights)
    fig.add_trace(line(1e3 * heights, rate, "rate", LEAD, showlegend=False), 2, 1)
    fig.update_yaxes(range=[0, min(1.15 * np.max(rate), 6 * np.median(rate))], row=2)
    return styled(fig, "height between the seats, mm", ("force, N", "rate, N/mm"), 440)


def answer_of_spring(fit: SpringFit | TesterFit) -> CardAnswer:
    """What is shown of a spring that has a card or a table of forces."""
    return CardAnswer(CardFacts(fit))
