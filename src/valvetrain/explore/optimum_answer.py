"""What ``optimise`` shows: the best design next to the case, what limits it, and how far to trust it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.explore.optimum import Design, Optimum, case_text
from valvetrain.explore.optimum_rules import RULES, SearchFacts, card_values
from valvetrain.explore.results import (
    ExploreAnswer,
    Write,
    csv_writer,
    fields_of,
    range_text,
    rows_of,
    varied_of,
)
from valvetrain.explore.search import Trial
from valvetrain.findings.engine import Mark
from valvetrain.findings.words import Amount, digits_text
from valvetrain.solution.atomic import write_text
from valvetrain.views.json import uncertainty_object
from valvetrain.views.style import LEAD, OK, OTHER, FigureSpec, panels, styled
from valvetrain.views.table import Line, TextTable
from valvetrain.views.tables import findings as findings_table

#: Rows of the first table, and designs of a front that are listed; case file of the best design.
ROWS, DESIGNS, BEST = 12, 40, "best.toml"


@dataclass(frozen=True)
class OptimumAnswer(ExploreAnswer):
    """What is shown of a search, in the units of the reader."""

    rules = RULES

    result: Optimum

    @property
    def facts(self) -> SearchFacts:
        """The search as rules read it, with the case file of its best design."""
        there = self.folder is not None and self.result.best is not None
        written = there and self.result.plan.case is not None
        file = str(self.folder / BEST) if written and self.folder else ""
        return SearchFacts(self.result, file, self.words.case)

    @property
    def title(self) -> str:
        """Title of the search, and how many designs it tried."""
        result = self.result
        return f"{result.plan.title}, {len(result.trials) - 1} designs and the case, {result.feasible} meet every bound"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["case", self.facts.name, "bound or range"]

    @property
    def lines(self) -> list[Line]:
        """Objectives, varied quantities, what follows of a spring card, and bounds."""
        return self._rows[:ROWS]

    @cached_property
    def _rows(self) -> list[Line]:
        trial = self.facts.trial
        return [] if trial is None else [*self._objectives(trial), *self._varied(trial), *self._bounds(trial)]  # fmt: skip

    def _cells(self, kind: str, place: int, *trials: Trial) -> tuple[str, ...]:
        """A number of trials: an objective or a constraint by its place."""
        one = getattr(trials[0].plan, kind)[place].measure
        values = ((float(getattr(each, kind)[place]), each) for each in trials)
        return tuple(self.words.said(self.facts.said(one, value, each), 4) for value, each in values)  # fmt: skip

    def _objectives(self, trial: Trial) -> Iterator[Line]:
        for place, goal in enumerate(self.result.plan.objectives):
            before, after = (float(one.objectives[place]) for one in (self.result.case, trial))
            bar = self.facts.bar(goal.measure, after, trial)
            remarks = [f"{100 * (after / before - 1):+.2g} %".replace("-", "−")] if before and np.isfinite(after / before) else []  # fmt: skip
            remarks += [f"error bar {self.words.said(self.facts.said(goal.measure, bar), 2)}"] if bar else []  # fmt: skip
            reach = "most" if goal.maximise else "least"
            yield Line(goal.measure.label, (*self._cells("objectives", place, self.result.case, trial), reach), "", ", ".join(remarks))  # fmt: skip
            yield from self._others("objectives", place)

    def _others(self, kind: str, place: int) -> Iterator[Line]:
        """The same number by other models."""
        for one in self.result.confirmed:
            yield Line(f"by {one.label}", (*self._cells(kind, place, one.case, one.design), ""))

    def _varied(self, trial: Trial) -> Iterator[Line]:
        plan, facts = self.result.plan, self.facts
        for place, one in enumerate(plan.varied):
            values = (float(each.values[place]) for each in (self.result.case, trial))
            cells = (one.value_text(value, 4) if np.isfinite(value) else "" for value in values)
            mark: Mark = "warn" if place in facts.ends else ""
            remark = "end of its range" if mark else f"{alike} as good" if (alike := facts.alike(place)) else ""  # fmt: skip
            yield Line(one.shown_name, (*cells, range_text(one)), mark, remark)
        for label, name, *pair in card_values(self.result, trial):
            yield Line(label, (*(self.words.amount(Amount(name, value), 4) for value in pair), ""))

    def _bounds(self, trial: Trial) -> Iterator[Line]:
        active = self.result.active(trial)
        for place, bound in enumerate(self.result.plan.constraints):
            miss = float(trial.missed[place])
            mark: Mark = "bad" if miss > 0 else "ok"
            remark = "missed" if miss > 0 else "limits it" if place in active else f"{digits_text(-100 * miss, 0, 2)} % to spare"  # fmt: skip
            limit = f"{'at most' if bound.upper else 'at least'} {self.words.said(self.facts.said(bound.measure, bound.bound), 4)}"
            if np.isfinite(miss):
                yield Line(bound.measure.label, (*self._cells("constraints", place, self.result.case, trial), limit), mark, remark)  # fmt: skip
                yield from self._others("constraints", place)

    def figures(self) -> Mapping[str, FigureSpec]:
        """The designs that were computed, which show the verdict."""
        return {"designs": FigureSpec("Designs that were computed", "", _designs)}

    def tables(self) -> Mapping[str, TextTable]:
        """Findings, all rows of a long table, and the front."""
        rows = [(one.label, *one.cells, one.remark) for one in self._rows if len(self._rows) > ROWS]
        return {
            "findings": findings_table(self), "values": TextTable("All values", ("", *self.headings, ""), tuple(rows)),
            "front": self._front(),
        }  # fmt: skip

    def _front(self) -> TextTable:
        """Designs of the front of several objectives."""
        goals, varied, front = (
            self.result.plan.objectives,
            self.result.plan.varied,
            self.result.front,
        )
        rows = []
        for one in front[:: -(-len(front) // DESIGNS)] if self.facts.several and front else ():
            values = (self.words.said(self.facts.objective(one, k), 4) for k in range(len(goals)))
            moved = (each.value_text(float(value), 4) for each, value in zip(varied, one.values, strict=True))  # fmt: skip
            rows.append((str(one.number), *values, *moved))
        heads = (*(one.measure.label for one in goals), *(one.shown_name for one in varied))
        return TextTable("Designs of the front", ("trial", *heads), tuple(rows))

    @property
    def stopped(self) -> bool:
        """Whether it was stopped before its end."""
        return not self.result.finished

    @property
    def failures(self) -> tuple[str, ...]:
        """The verdict where no design meets every bound."""
        return () if self.stopped or self.result.best is not None else (str(self.verdict),)

    def data(self) -> dict[str, Any]:
        """Plan, designs and trials."""
        result, plan = self.result, self.result.plan
        return {
            "case": plan.case_name, "title": plan.title, "method": plan.search.method, "seed": plan.search.seed, "trials": len(result.trials),
            "feasible_trials": result.feasible, "computed": result.computed, "varied": varied_of(plan.varied),
            "objectives": fields_of(plan.objectives), "constraints": fields_of(plan.constraints),
            "of_case": fields_of(result.case), "designs": fields_of(result.designs), "front": [one.number for one in result.front],
            "confirmed": fields_of(result.confirmed),
            "uncertainties": [uncertainty_object(one) for one in result.error_bars],
            "completed": result.finished and result.best is not None, **rows_of(result.to_pandas()),
        }  # fmt: skip

    def files(self) -> Mapping[str, Write]:
        """Every trial as CSV, and case files of the designs, the best first."""
        result = self.result
        made: dict[str, Write] = {"trials.csv": csv_writer(result.to_pandas())}
        for place, design in enumerate(result.designs if result.plan.case is not None else ()):
            name = BEST if place == 0 else f"design-{place + 1}.toml"
            made[name] = partial(_write_case, result, design)
        return made

    def computed(self) -> Iterator[str]:
        """Method, runs, where numbers are taken, and what could not be computed."""
        result, search = self.result, self.result.plan.search
        yield f"{result.computed} runs in {result.seconds:.0f} s by {search.method}, seed {search.seed}."
        failures = [one.failure for one in result.trials if one.failure]
        if failures:
            yield f"{len(failures)} designs could not be computed (trials.csv), such as: {failures[0]}"
        if result.plan.description:
            yield result.plan.description


def _write_case(result: Optimum, design: Design, path: Path) -> Path:
    return write_text(path, case_text(result, design))


def _designs(facts: SearchFacts) -> go.Figure | None:
    """Two objectives of the designs; else the objective over the one quantity that was varied, in colour over two, or over the trials."""
    result, plan, several = facts.result, facts.result.plan, facts.several
    trials = [one for one in result.trials if np.all(np.isfinite([*one.values, *one.objectives]))]
    goals = [
        (_axis(facts, k), [facts.number(each.measure, float(one.objectives[k])) for one in trials])
        for k, each in enumerate(plan.objectives)
    ]
    axes = [
        (each.axis_label, [each.shown(float(one.values[k])) for one in trials])
        for k, each in enumerate(plan.varied)
    ]  # fmt: skip
    if len(trials) < 2:
        return None
    if len(axes) > 2:
        axes = [("trial", [float(one.number) for one in trials])]
    (across, x), (up, y) = goals[:2] if several else [*axes, *goals][:2]
    fig, met = panels((1.0,)), np.array([one.feasible for one in trials])
    for name, at, colour in (("misses a bound", ~met, "#c9ced4"), ("meets every bound", met, LEAD)):
        marker: dict[str, Any] = {"color": colour, "size": 6}
        if len(axes) == 2 and not several and colour == LEAD:
            label, heights = goals[0]
            marker |= {"color": np.array(heights)[at], "colorscale": "Viridis", "colorbar": {"title": {"text": label, "side": "right"}}}  # fmt: skip
        if at.any():
            fig.add_scatter(x=np.array(x)[at], y=np.array(y)[at], name=name, mode="markers", marker=marker)  # fmt: skip
    if several and result.best is not None:
        order = [trials.index(one) for one in result.front]
        fig.add_scatter(x=[x[k] for k in order], y=[y[k] for k in order], name="front", mode="lines", line={"color": LEAD})  # fmt: skip
    for name, trial, colour, symbol in (("case", result.case, OTHER, "diamond"), (facts.name, facts.trial, OK, "star")):  # fmt: skip
        if trial in trials:
            k = trials.index(trial)
            fig.add_scatter(x=[x[k]], y=[y[k]], name=name, mode="markers", marker={"color": colour, "size": 13, "symbol": symbol})  # fmt: skip
    return styled(fig, across, (up,), 380).update_layout(hovermode="closest")


def _axis(facts: SearchFacts, place: int = 0) -> str:
    one = facts.result.plan.objectives[place].measure
    return f"{one.label}, {one.unit}".rstrip(", ") if facts.result.plan.case is not None else one.label  # fmt: skip
