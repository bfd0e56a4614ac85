"""What is shown of branches of motion: a picture over engine speed, and a table of ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.rules_branches import RULES, BranchFacts, spans_text
from valvetrain.findings.words import RPM, Amount
from valvetrain.solution.branches import UNRESOLVED, Branches, BranchPoint
from valvetrain.solution.definition import definition_of, label_of
from valvetrain.units import unit_factor
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import BAD, LEAD, OTHER, SECOND, FigureSpec, dots, line, styled
from valvetrain.views.table import Line

HINT = "A stable motion has a point for each revolution until it repeats; motions that never repeat scatter. The train leaves unstable ones."
#: First words of a motion -> how it is called.
CALLED = {
    "period 1": "repeats every revolution",
    "period": "repeats every {} revolutions",
    "repels": "unstable, by a {}",
    UNRESOLVED: "repeats every revolution, stability not resolved",
}


@dataclass(frozen=True)
class BranchesAnswer(ShownByRules):
    """What is shown of branches, in the units of the reader by default."""

    rules = RULES

    branches: Branches

    @property
    def title(self) -> str:
        """The run and what is drawn."""
        return (
            f"{self.branches.label}: {label_of(self.branches.quantity)} of rising and falling speed"
        )

    @property
    def facts(self) -> BranchFacts:
        """The branches as rules read them."""
        return BranchFacts(self.branches)

    @property
    def lines(self) -> list[Line]:
        """Each kind of motion with its speeds, and how large the quantity is there; one row where revolutions are alike."""
        rows, shown = list[Line](), self.facts.shown
        for motion in sorted({one.motion for one in shown.points}):
            values = [v for one in shown.points if one.motion == motion for v in one.values if math.isfinite(v)]  # fmt: skip
            ends = (Amount(shown.quantity, end(values)) for end in (min, max)) if values else ()
            called = CALLED.get(motion) or CALLED.get(motion.split()[0], motion)
            cells = (
                f"{spans_text(shown.ranges(motion))} rpm",
                self.words.span(*ends) if values else "",
            )
            rows.append(Line(called.format(motion.split()[-1]), cells))
        return rows

    @property
    def headings(self) -> list[str]:
        """Speeds and values."""
        return ["engine speed", label_of(self.branches.quantity)]

    def figures(self) -> Mapping[str, FigureSpec]:
        """The picture of branches."""
        return {"branches": FigureSpec("Branches of motion", HINT, picture)}

    def computed(self) -> tuple[str, ...]:
        """How the march went."""
        return (
            f"Each speed starts from the motion of the one before; {self.branches.revolutions} revolutions.",
            "Unstable orbits are those that the search of a march meets; parts behind a fold are not followed.",
        )


def picture(facts: BranchFacts) -> go.Figure | None:
    """The quantity over engine speed: motions that repeat as lines, rising and falling, others as dots."""
    branches = facts.shown
    shown = definition_of(branches.quantity).shown_unit
    factor = 1 / unit_factor(shown)
    fig = go.Figure()

    def add(points: Sequence[BranchPoint], name: str, colour: str, size: int) -> None:
        pairs = [(one.engine_speed / RPM, factor * value) for one in points for value in one.values]
        if pairs:
            speeds, values = np.array(pairs).T
            fig.add_trace(dots(speeds, values, name, colour).update(marker_size=size))

    for rising, name, colour, size in (
        (True, "stable, rising", LEAD, 9),
        (False, "stable, falling", SECOND, 5),
    ):
        motions = branches.attracting(rising)
        add([one for one in motions if one.period], name, colour, size)
        alone = [factor * one.values[0] if one.period == 1 else math.nan for one in motions]
        speeds = [one.engine_speed / RPM for one in motions]
        fig.add_trace(line(speeds, alone, name, colour, connectgaps=False, showlegend=False))
    add([one for one in branches.points if one.repels], "unstable or not resolved", BAD, 7)
    add([one for one in branches.points if not (one.period or one.repels)], "scatter", OTHER, 4)
    label = f"{label_of(branches.quantity)}, {shown}"
    styled(fig, "engine speed, rpm", (label,), 380)
    return (
        fig.update_layout(hovermode="closest").update_yaxes(automargin=True)
        if branches.points
        else None
    )
