"""What is shown of branches of motion: a picture over engine speed, and a table of ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.rules_branches import RULES, BranchFacts, spans_text
from valvetrain.findings.words import RPM, Amount
from valvetrain.solution.branches import Branches, BranchPoint
from valvetrain.solution.definition import definition_of, label_of
from valvetrain.units import unit_factor
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import BAD, LEAD, OTHER, SECOND, FigureSpec, dots, line, styled
from valvetrain.views.table import Line, TextTable

HINT = "Lines attract: blue as the speed rises, orange as it falls. Red marks repel; grey dots are revolutions of motion that never repeats."


@dataclass(frozen=True)
class BranchesAnswer(ShownByRules):
    """What is shown of branches, in the units of the reader by default."""

    rules = RULES

    branches: Branches

    @property
    def title(self) -> str:
        """The run and what is drawn."""
        return f"{self.branches.label}: branches of {label_of(self.branches.quantity)}"

    @property
    def facts(self) -> BranchFacts:
        """The branches as rules read them."""
        return BranchFacts(self.branches)

    @property
    def lines(self) -> list[Line]:
        """Each kind of motion with its speeds, and how large the quantity is there."""
        rows = list[Line]()
        for motion in dict.fromkeys(one.motion for one in self.branches.points):
            values = [v for one in self.branches.points if one.motion == motion for v in one.values if math.isfinite(v)]  # fmt: skip
            most = (
                self.words.amount(Amount(self.branches.quantity, max(values)), 3) if values else ""
            )
            rows.append(Line(motion, (f"{spans_text(self.branches.ranges(motion))} rpm", most)))
        return rows

    @property
    def headings(self) -> list[str]:
        """Speeds, and the largest value."""
        return ["engine speed", f"largest {label_of(self.branches.quantity)}"]

    def figures(self) -> Mapping[str, FigureSpec]:
        """The picture of branches."""
        return {"branches": FigureSpec("Branches of motion", HINT, picture)}

    def tables(self) -> Mapping[str, TextTable]:
        """Every point."""
        rows = tuple(
            (
                f"{one.engine_speed / RPM:.6g} rpm",
                "rising" if one.rising else "falling",
                one.motion,
                self.words.amount(Amount(self.branches.quantity, max(one.values)), 4),
                f"{one.multiplier:.3f}" if math.isfinite(one.multiplier) else "",
                f"{one.exponent:.2f}" if math.isfinite(one.exponent) else "",
            )
            for one in sorted(self.branches.points, key=lambda point: point.engine_speed)
        )
        columns = ("engine speed", "march", "motion", "largest", "multiplier", "Lyapunov exponent")
        return {"points": TextTable("Every point", columns, rows)}

    def computed(self) -> tuple[str, ...]:
        """How the march went."""
        return (
            f"Each speed starts from the motion of the one before; {self.branches.revolutions} revolutions.",
            "An orbit whose cycles come ten times nearer each attracts; of others the largest multiplier is computed.",
            "Unstable orbits are those that the search of a march meets; parts behind a fold are not followed.",
        )


def picture(facts: BranchFacts) -> go.Figure | None:
    """The quantity over engine speed: motions that repeat as lines, rising and falling, others as dots."""
    branches = facts.branches
    shown = definition_of(branches.quantity).shown_unit
    factor = 1 / unit_factor(shown)
    fig = go.Figure()

    def add(points: list[BranchPoint], name: str, colour: str) -> None:
        pairs = [(one.engine_speed / RPM, factor * value) for one in points for value in one.values]
        if pairs:
            speeds, values = np.array(pairs).T
            fig.add_trace(dots(speeds, values, name, colour))

    add([one for one in branches.points if not (one.period or one.repels)], "never repeats", OTHER)
    for rising, name, colour in ((True, "rising", LEAD), (False, "falling", SECOND)):
        motions = branches.attracting(rising)
        alone = [one.values[0] if one.period == 1 else math.nan for one in motions]
        speeds = np.array([one.engine_speed for one in motions]) / RPM
        if len(motions):
            fig.add_trace(line(speeds, factor * np.array(alone), name, colour, connectgaps=False))
        add([one for one in motions if one.period > 1], f"{name}, several revolutions", colour)
    add([one for one in branches.points if one.repels], "repels", BAD)
    label = f"{label_of(branches.quantity)}, {shown}"
    return styled(fig, "engine speed, rpm", (label,), 420) if fig.data else None
