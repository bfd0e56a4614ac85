"""What ``compare-test`` shows: whether the model agrees with the test, both curves, and where they differ."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from valvetrain.compare_test import tables
from valvetrain.compare_test.adequacy import LEVEL
from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest
from valvetrain.compare_test.rules import OFF, RULES, AgainstTest, furthest, phase
from valvetrain.findings.engine import Mark
from valvetrain.findings.words import Amount, digits_text, speed_text
from valvetrain.measured.value_table import ValueTable
from valvetrain.solution.definition import label_of
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.views.columns import table_of
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import (
    ANGLE,
    BAD,
    OTHER,
    RIGID,
    SPEEDS,
    FigureSpec,
    band,
    line,
    panels,
    styled,
)
from valvetrain.views.table import Line, TextTable
from valvetrain.views.tables import findings as findings_table

#: Runs that are drawn and stand side by side, and values in the first table, at most.
MAX_RUNS, MAX_VALUES = 4, 10


@dataclass(frozen=True)
class AgainstTestAnswer(ShownByRules):
    """What is shown of a ``result`` of :func:`compare_with_test`; ``test``: its options on the command line."""

    rules = RULES

    result: ModelAgainstTest
    test: str = "--test FILE"

    @cached_property
    def facts(self) -> AgainstTest:
        """The comparison as rules read it."""
        return AgainstTest(self.result, self.words.case, self.test)

    @property
    def title(self) -> str:
        """The case and what was measured."""
        record, test = self.result.study.record, self.result.test
        if isinstance(test, ValueTable):
            what = f"{len(test.values)} values"
        else:
            speed = f", {speed_text(2 * test.cam_speed)}" if test.cam_speed else ""
            what = f"{label_of(test.quantity)}, {len(test.values)} cycles{speed}"
        return f"{record.title or record.name}, model against test: {what}{', synthetic' * test.synthetic}"

    @property
    def runs(self) -> tuple[RunAgainstTest, ...]:
        """Runs that stand side by side, the nearest first."""
        return self.result.runs[:MAX_RUNS]

    @property
    def headings(self) -> list[str]:
        """The test, then the models."""
        return ["test", *(one.label for one in self.runs)]

    @cached_property
    def lines(self) -> list[Line]:
        """Differences by stretch of the turn, or the values that are furthest off, and Fisher's test."""
        if not self.runs:
            return []
        rows = [*self._cycle_lines()] if self.facts.cycles is not None else [*self._value_lines()]
        if (test := self.runs[0].adequacy) is not None:
            both = (one.adequacy for one in self.runs)
            ratios = ("" if one is None else digits_text(one.ratio) for one in both)
            mark: Mark = "ok" if test.adequate else "bad"
            allowed = f"{digits_text(test.critical)} allowed"
            rows.append(Line("F, variance ratio", ("1", *ratios), mark, allowed))
        return rows

    def _say(self, value: float, digits: int = 3) -> str:
        return self.words.amount(self.facts.amount(value), digits)

    def _cycle_lines(self) -> Iterator[Line]:
        runs, cycles = self.runs, self.facts.cycles
        test, near = runs[0].adequacy, [one.agreement for one in runs if one.agreement is not None]
        assert cycles is not None
        mark: Mark = "" if test is None else "ok" if test.adequate else "bad"
        scatter = "" if math.isnan(near[0].scatter) else f"± {self._say(near[0].scatter)}"
        reach = "" if test is None else f"{self._say(test.refutable)} allowed"
        yield Line("difference, rms", (scatter, *(self._say(one.rms) for one in near)), mark, reach)
        yield Line("model − test, largest", ("", *map(self._worst, runs)))
        peaks = (float(one.curve.max()) for one in runs if one.curve is not None)
        yield Line(
            "largest value", tuple(self._say(one, 4) for one in (float(cycles.mean.max()), *peaks))
        )
        late: Mark = "bad" if self.findings.by("T202") else ""
        shifts = (self._later(one.shift, one.shift_reach) for one in near)
        yield Line("model comes later by", ("", *shifts), late, "cam angles as in the file")
        for place, stage in enumerate(runs[0].stages):
            share = stage.share_outside
            where = f"off at {100 * share:.0f} % of angles" if share > LEVEL else ""
            yield Line(
                f"{phase(stage.name)}, rms",
                ("", *(self._say(one.stages[place].rms) for one in runs)),
                "bad" if where else "",
                where,
            )

    def _later(self, shift: float, reach: float) -> str:
        if not math.isfinite(shift + reach):  # a level has none
            return ""
        if abs(shift) <= 2 * reach:
            return f"0 ± {digits_text(math.degrees(reach), 0, 1)} deg"
        return self.words.amount(Amount("cam_angle", shift, reach)).replace("cam ", "")

    def _worst(self, run: RunAgainstTest) -> str:
        """The largest difference and its cam angle."""
        off, angle = self.facts.worst(run)
        return f"{'+' if off.value > 0 else '−'}{self._say(abs(off.value))} at {math.degrees(angle.value):.0f} deg"

    def _value_lines(self) -> Iterator[Line]:
        best = self.runs[0]
        chosen = furthest(best)[:MAX_VALUES]
        for place, row in enumerate(best.values):
            if row in chosen:
                numbers = (row.test, *(one.values[place].model for one in self.runs))
                name, off = tables.value_quantity(row), abs(row.in_scatters)
                cells = (self._value(name, one) for one in numbers)
                label = f"{tables.value_name(row)}, {speed_text(row.engine_speed)}"
                yield Line(
                    label,
                    tuple(cells),
                    "bad" if off > OFF else "ok",
                    f"{digits_text(off, 0, 2)} scatters off",
                )

    def _value(self, name: str, value: float) -> str:
        text = "–" if math.isnan(value) else self.words.amount(Amount(name, value), 4)
        return text.replace("cam ", "")

    @property
    def rests_on(self) -> list[str]:
        """How the angles were placed, and which errors were not stated."""
        return [one.remark for one in self.findings.by("T29")]

    def tables(self) -> Mapping[str, TextTable]:
        """Every number of the comparison, a table a topic and model."""
        name, runs = self.result.quantity, self.result.runs
        near = [one for one in runs if one.agreement]
        made = {
            "findings": findings_table(self),
            "nearness": table_of("How near", tables.agreement_columns(name), near, self.words),
        }
        for place, one in enumerate(runs):
            values = table_of(f"Values, {one.label}", tables.VALUES, one.values, self.words)
            made[f"values-{place}"] = values
        return made

    def write(self, folder: Path) -> list[Path]:
        """Curves or values as CSV."""
        return tables.write_compare_test(self.result, folder)

    def figures(self) -> Mapping[str, FigureSpec]:
        """Both curves with their difference, or the values in scatters."""
        if self.facts.cycles is None:
            hint = "between the dashed lines a value is met"
            return {"values": FigureSpec("Values of model and test", hint, values_figure)}
        limit = self.runs[0].band if self.runs else None
        off = limit is not None and bool(limit.outside.any())
        hint = "grey: what the scatter of the test explains" + "; red: where the model is off" * off
        return {"curves": FigureSpec("Model, test and their difference", hint, curves_figure)}

    def computed(self) -> Iterator[str]:
        """What F means, what was assumed, and where the test comes from."""
        for test in [one.adequacy for one in self.result.runs if one.adequacy is not None][:1]:
            yield (
                "F compares how far the model is from the mean of the repeats with how far the repeats are from each other. A true model has "
                f"about 1; scatter alone gives more than {digits_text(test.critical)} in {100 * LEVEL:g} of 100 tests, and a model with more is "
                f"refuted. {test.places} places count as {digits_text(test.independent)}, for neighbours scatter together."
            )
        yield from (f"{note[:1].upper()}{note[1:]}." for note in dict.fromkeys(self.result.notes))
        yield f"Test: {self.result.test.source}."

    @property
    def text(self) -> str:
        """The case file."""
        return self.result.study.record.text


def curves_figure(facts: AgainstTest) -> go.Figure | None:
    """Test with two scatters and the models; below, their difference, red where the band leaves zero out."""
    cycles = facts.cycles
    runs = [one for one in facts.result.runs if one.curve is not None][:MAX_RUNS]
    if cycles is None or not runs:
        return None
    unit, factor = SHOWN_UNITS.get(cycles.unit, (cycles.unit, 1.0))
    angle, mean = np.degrees(cycles.cam_angle), cycles.mean * factor
    fig = panels((0.6, 0.4))
    if len(cycles.values) > 1:
        scatter = 2 * cycles.values.std(axis=0, ddof=1) * factor
        fig.add_traces(
            band(angle, mean - scatter, mean + scatter, "two scatters of a cycle"),
            rows=[1, 1],
            cols=[1, 1],
        )
    limit = runs[0].band
    if limit is not None:
        half = limit.half_width * factor
        fig.add_traces(
            band(angle, -half, half, "explained by the scatter", RIGID), rows=[2, 2], cols=[1, 1]
        )
    fig.add_trace(line(angle, mean, "test", OTHER), 1, 1)
    for one, colour in zip(runs, SPEEDS, strict=False):
        assert one.curve is not None
        off = one.curve * factor - mean
        fig.add_trace(
            line(angle, one.curve * factor, one.label, colour, legendgroup=one.label), 1, 1
        )
        fig.add_trace(
            line(angle, off, one.label, colour, legendgroup=one.label, showlegend=False), 2, 1
        )
        if one is runs[0] and limit is not None and limit.outside.any():
            fig.add_trace(
                line(angle, np.where(limit.outside, off, np.nan), "model is off", BAD), 2, 1
            )
    name = label_of(cycles.quantity)
    return styled(
        fig, ANGLE, (f"{name}, {unit}".rstrip(", "), f"model minus test, {unit}".rstrip(", ")), 440
    )


def values_figure(facts: AgainstTest) -> go.Figure | None:
    """The difference of every value in scatters, a mark a run."""
    runs = facts.result.runs[:MAX_RUNS]
    if not runs:
        return None
    names = [f"{tables.value_name(one)}, {speed_text(one.engine_speed)}" for one in runs[0].values]
    fig = go.Figure()
    for one, colour in zip(runs, SPEEDS, strict=False):
        off = [row.in_scatters for row in one.values]
        fig.add_trace(
            go.Scatter(
                x=off, y=names, mode="markers", marker={"color": colour, "size": 9}, name=one.label
            )
        )
    for place in (-OFF, OFF):
        fig.add_vline(place, line={"color": BAD, "width": 1, "dash": "dash"})
    styled(fig, "model minus test, scatters", ("",), 130 + 22 * len(names))
    fig.update_layout(hovermode="closest", margin={"l": 300})
    fig.update_yaxes(autorange="reversed", tickvals=names)
    return fig
