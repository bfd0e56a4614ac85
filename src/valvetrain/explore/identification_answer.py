"""What ``identify`` shows: each unknown with its start, its value and its interval, and how well the data are met."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.explore.identification_rules import (
    RULES,
    IdentificationFacts,
    data_name,
    few,
    off_text,
    plain_name,
)
from valvetrain.explore.identified import Branch, Identified, Predicted, si_unit
from valvetrain.explore.least_squares import MET
from valvetrain.explore.results import ExploreAnswer, Write, fields_of, value_text
from valvetrain.explore.study_answer import rows_figure
from valvetrain.findings.engine import Mark
from valvetrain.findings.words import joined
from valvetrain.solution.atomic import write_text
from valvetrain.views.style import BAD, LEAD, OTHER, SECOND, FigureSpec
from valvetrain.views.table import Line, TextTable
from valvetrain.views.tables import findings

#: Unknowns among the first rows: those in doubt before the others; case file with the values.
ROWS, CASE = 9, "identified.toml"
#: Rows of a figure, and least scatters that it reaches to.
DRAWN, NEAR = 24, 4.0


@dataclass(frozen=True)
class IdentificationAnswer(ExploreAnswer):
    """What is shown of an identification."""

    rules = RULES

    result: Identified

    @cached_property
    def facts(self) -> IdentificationFacts:
        """The identification as rules read it, with the path of the case file with its values."""
        return IdentificationFacts(self.result, str(self.folder / CASE) if self.folder else "")

    @property
    def title(self) -> str:
        """The file, and how many values were fitted."""
        counts = f"measured: {len(self.facts.data(True))}, unknown: {len(self.result.unknowns)}"
        return f"{self.result.name or 'Identification'} ({counts})"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["start", "identified", "95 % interval"]

    @cached_property
    def lines(self) -> list[Line]:
        """The unknowns, those in doubt first where there are many, then the data used and not used."""
        places = list(range(len(self.result.unknowns)))
        if len(places) > ROWS:
            places.sort(key=lambda at: self.facts.states[self.result.names[at]] == "determined")
        rows = [self._unknown(place) for place in places[:ROWS]]
        return [*rows, *(self._data(used) for used in (True, False) if self.facts.data(used))]

    def _unknown(self, place: int) -> Line:
        facts, one = self.facts, self.result.unknowns[place]
        state, others = facts.states[one.title], range(1, len(self.result.branches))
        remark = {
            "tied": f"only together with {few(facts.partners(place))}", "open": "the data say little",
            "bound": "on the bound of its prior", "determined": "",
        }[state]  # fmt: skip
        if others and state == "determined":
            remark = f"or {joined([facts.value(one, branch) for branch in others], 'or')}"
        start = self.result.start.get(one.title, np.nan)
        value = "not determined" if state in ("tied", "open") else facts.value(one)
        doubt = others or state != "determined" or {"I101", "I102"} & set(self.findings.codes)
        sure: Mark = "warn" if doubt else "" if "I112" in self.findings.codes else "ok"
        return Line(plain_name(one.title), (value_text(one.unit, start), value, facts.interval(one)), sure, remark)  # fmt: skip

    def _data(self, used: bool) -> Line:
        """How many values are met at the start and in the end, and how far the worst one is off."""
        data = self.facts.data(used)
        counts = [
            sum(abs(one.datum.deviation(getattr(one, name))) <= MET for one in data)
            for name in ("start", "best")
        ]
        cells = (
            *(f"{one} of {len(data)} met" for one in counts),
            f"up to {off_text(data[0])} scatters off",
        )
        return Line(f"data {'' if used else 'not '}used", cells, "ok" if counts[1] == len(data) else "warn")  # fmt: skip

    def figures(self) -> Mapping[str, FigureSpec]:
        """The figure of what the verdict is about first."""
        specs = {
            "unknowns": FigureSpec(
                "What the data leave of each unknown", "width of the figure: the prior; bars: 95 % intervals; red: not determined", unknowns
            ),
            "data": FigureSpec("Computed less measured", "bars: 95 % of the computed values; dashed: two scatters; orange: met, not used", data),
        }  # fmt: skip
        first = "data" if "I102" in self.findings.codes else "unknowns"
        return {first: specs.pop(first)} | specs

    def tables(self) -> Mapping[str, TextTable]:
        """Every unknown and value, and further numbers."""
        result = self.result
        heads = ("unknown", "start", "identified", "95 % interval", "prior", "source", "learned from data, %")  # fmt: skip
        unknowns: list[tuple[str, ...]] = []
        for number, branch in enumerate(result.branches, 1):
            if len(result.branches) > 1:
                words = (
                    f"solution {number}: probability {branch.share:.2f}, misfit {branch.misfit:.3g}"
                )
                unknowns.append((words,))
            unknowns += self._unknowns(branch)
        measured = ("measured", "value", "scatter", "start", "identified", "95 % interval", "scatters off", "percentile", "use")  # fmt: skip
        further = tuple(
            (plain_name(one.key), *_numbers(one.unit, one)) for one in result.predictions
        )
        return {
            "unknowns": TextTable("Unknowns", heads, tuple(unknowns)),
            "data": TextTable("Measured and computed", measured, tuple(map(self._datum, result.predicted))),
            "predictions": TextTable("Computed, not measured", ("quantity", "identified", "95 % interval"), further),
            "findings": findings(self),
        }  # fmt: skip

    def _unknowns(self, branch: Branch) -> Iterator[tuple[str, ...]]:
        for one, told in zip(self.result.unknowns, branch.information.determined, strict=True):
            interval, prior = branch.quantities[one.title], one.prior
            yield (
                plain_name(one.title), value_text(one.unit, self.result.start.get(one.title, np.nan)), *_numbers(one.unit, interval),
                f"{value_text(one.unit, *prior.at([0.005, 0.995]).tolist())}, {prior.kind}", prior.source, f"{100 * told:.0f}",
            )  # fmt: skip

    def _datum(self, one: Predicted) -> tuple[str, ...]:
        datum = one.datum
        given = (value_text(datum.unit, value) for value in (datum.value, datum.scatter, one.start))
        return (
            data_name(datum), *given, *_numbers(datum.unit, one), f"{one.off:+.2f}", f"{one.percentile:.1f}",
            "used" if datum.used else "compared",
        )  # fmt: skip

    @property
    def stopped(self) -> bool:
        """Whether it was stopped before its end."""
        return not self.result.whole

    def data(self) -> dict[str, Any]:
        """Method, branches, and data with their predictions."""
        result = self.result
        names = (
            "name", "method", "whole", "start", "branches", "predicted", "predictions", "log_evidence",
            "evidence_kind", "note", "evaluations", "reused",
        )  # fmt: skip
        units = {one.title: si_unit(one.unit) for one in result.unknowns}
        data = {name: fields_of(getattr(result, name)) for name in names}
        return {**data, "units": units, "completed": result.whole}

    def files(self) -> Mapping[str, Write]:
        """The draws, and the case with the likeliest values."""
        made: dict[str, Write] = {"draws.nc": self.result.save}
        if text := self.result.case_file:
            made[CASE] = lambda path: write_text(path, text)
        return made

    def computed(self) -> Iterator[str]:
        """How the values were found, and what the intervals hold."""
        result = self.result
        yield f"Method {result.method}: {result.evaluations} points computed, {result.reused} of an earlier start."
        yield f"Logarithm of the evidence {result.log_evidence:.2f} {result.evidence_kind}."
        if (fit := result.fit) is not None:
            yield f"Chi-square {fit.chi_square:.4g} for {fit.freedom:.3g} degrees of freedom, p {fit.p_value:.2g}."
            yield f"The intervals are those of {fit.widening:.2g} times the scatter."
        yield "Intervals hold 95 % of what data and priors leave open, if model and scatter are right."

    @property
    def text(self) -> str:
        """The identification file."""
        return self.result.text


def _numbers(unit: str, one: Any) -> tuple[str, str]:
    """The likeliest value of an unknown or a number and its 95 % interval in five digits."""
    return value_text(unit, one.best, digits=5), value_text(unit, one.low, one.high, digits=5)


def unknowns(facts: IdentificationFacts) -> go.Figure:
    """Start, value and interval of each unknown as shares (per cent) of the range of its prior, the vaguest first."""
    result = facts.result
    order = np.argsort(facts.first.information.determined, kind="stable")[:DRAWN].tolist()
    rows, colours = [], []
    for one in (result.unknowns[place] for place in order):
        low, high = one.prior.work_bounds if one.prior.flat else one.prior.work(one.prior.at([0.005, 0.995]))  # fmt: skip
        found = facts.first.quantities[one.title]
        values = np.array([found.best, found.low, found.high, result.start.get(one.title, np.nan)])
        rows.append(100 * (one.prior.work(values) - low) / (high - low))
        colours.append(BAD if facts.states[one.title] in ("tied", "open") else LEAD)
    names = [plain_name(result.names[place]) for place in order]
    return rows_figure(names, np.array(rows), colours, "share of the range of the prior, %", (-3, 103))  # fmt: skip


def data(facts: IdentificationFacts) -> go.Figure:
    """Computed less measured in scatters, at the start too, those that are missed most first."""
    chosen = sorted(facts.data(True) + facts.data(False), key=lambda one: -abs(one.off))[:DRAWN]
    off = np.array([one.datum.deviation(np.array([one.best, one.low, one.high, one.start])) for one in chosen])  # fmt: skip
    reach = max(1.15 * abs(chosen[0].off), NEAR)
    colours = [BAD if abs(one.off) > MET else LEAD if one.datum.used else SECOND for one in chosen]
    names = [data_name(one.datum) for one in chosen]
    fig = rows_figure(names, off, colours, "computed less measured, scatters", (-reach, reach))
    for at in (-MET, MET):
        fig.add_vline(at, line={"color": OTHER, "width": 1, "dash": "dash"})
    return fig
