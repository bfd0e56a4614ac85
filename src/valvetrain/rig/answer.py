"""What ``rig`` shows of a recording: whether it can be used, the cycles of every channel, and how they were cut."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.arrays import Array
from valvetrain.findings.engine import Mark
from valvetrain.findings.words import RPM, Amount, Words, digits_text, speed_text
from valvetrain.measured.cycles import write_cycles
from valvetrain.measured.json import json_fields
from valvetrain.rig.result import Peak, RigChannelCycles, RigResult, peaks_of
from valvetrain.rig.rules import RULES, RigFacts
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_of
from valvetrain.views.files import csv_of
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import (
    ANGLE,
    BAD,
    LEAD,
    OTHER,
    RIGID,
    SECOND,
    FigureSpec,
    band,
    line,
    panels,
    styled,
)
from valvetrain.views.table import Line, TextTable
from valvetrain.views.tables import findings as findings_table

#: Scatter (cam deg) of the angle of an extreme above which the angle is that of no peak.
FLAT = 15.0
#: What the JSON answer has of an extreme.
FIGURES = "figure mean interval scatter cam_angle scatter_of_angle"


def angle_of(peak: Peak) -> float:
    """Cam angle (rad) of an extreme; NaN in the dwell, where it can be anywhere."""
    return np.nan if np.degrees(peak.scatter_of_angle) >= FLAT else peak.cam_angle


def data_of(result: RigResult) -> dict[str, Any]:
    """The answer for JSON, SI; ``quantities`` as every command names its numbers."""
    fit, retained = result.alignment, list(result.retained)
    return {
        "quantities": {
            f"{peak.figure}_{one.quantity}": {"value": peak.mean, "unit": one.unit}
            for channel in result.channels for one in (channel.cycles,) for peak in peaks_of(channel)
        },
        "command": "rig", "case": "", "completed": True, "file": result.name, "form": result.form, "synthetic": result.synthetic,
        "cycles": result.grid.cycles, "kept": [cycle + 1 for cycle in retained],
        "outliers": [{"cycle": cycle + 1, "why": why} for cycle, why in result.outliers],
        "cam_speed": {"value": float(np.mean(result.grid.cam_speeds[retained])), "unit": "rad/s"},
        "angles": len(result.grid.cam_angle),
        "offset": {"value": result.offset, "standard_uncertainty": result.offset_uncertainty, "unit": "rad"},
        "alignment": fit and {
            "opening": fit.opening, "closing": fit.closing, "gain": fit.gain, "residual": float(np.sqrt(np.mean(fit.residual**2)))
        },
        "angle_scatter": result.shaft.scatter,
        "channels": list(map(_channel, result.channels)),
        "notes": list(result.notes)
    }  # fmt: skip


def _channel(channel: RigChannelCycles) -> dict[str, Any]:
    whole = bool(np.isfinite(channel.spread).all())
    return {
        "quantity": channel.cycles.quantity, "unit": channel.cycles.unit, "channel": channel.raw.channel, "band": channel.band,
        "clipped": channel.clipped, "drift": channel.drift, "notes": list(channel.cycles.notes),
        "figures": [json_fields(peak, FIGURES) for peak in peaks_of(channel)], "spread_of_mean": float(np.median(channel.spread)) if whole else None
    }  # fmt: skip


def deviation(channel: RigChannelCycles) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Standard deviation over the cycles, shape (angles,); zero of a single one."""
    values = channel.cycles.values
    return np.std(values, axis=0, ddof=1) if len(values) > 1 else np.zeros(values.shape[1])


#: Cut marks that are drawn, at most.
MARKS = 40


@dataclass(frozen=True)
class RigAnswer(ShownByRules):
    """What is shown of a ``result`` of :func:`rig_cycles`; ``folder``: of its files."""

    rules = RULES

    result: RigResult
    folder: Path = Path()

    @cached_property
    def facts(self) -> RigFacts:
        """The recording as rules read it."""
        return RigFacts(self.result, self.words.case, self.folder)

    @property
    def title(self) -> str:
        """The file and its form."""
        return f"{self.result.name}, recording of a test rig ({self.result.form}){', synthetic' * self.result.synthetic}"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["largest", "scatter", "at", "smallest"]

    @cached_property
    def lines(self) -> list[Line]:
        """Channels, then cycles, speed and angle."""
        result, speeds, fit = self.result, self.facts.speeds, self.result.alignment
        count, every = len(result.retained), result.grid.cycles
        span = f"{speed_text(speeds.min(), '')} to {speed_text(speeds.max())}"
        degrees, error, jitter = np.degrees(
            (result.offset, 2 * result.offset_uncertainty, result.shaft.scatter)
        )
        at, gain = (
            f"{digits_text(degrees, error)} deg",
            f"lift {100 * fit.gain:.1f} % of the case" if fit else "as stated",
        )
        place: tuple[str, Mark, str] = (
            (at, "ok", gain) if result.placed else ("", "warn", "not related to the cam")
        )
        return [
            *map(self._channel, result.channels),
            Line("cycles", (f"{count} of {every}", "", "", ""), "ok" if count == every else "warn", "outliers are left out" * (count < every)),
            Line("cam speed", (speed_text(speeds.mean()), "", "", ""), "warn" if self.findings.by("T104") else "ok", span),
            Line("angle readings", (f"{result.shaft.readings:.0f} a turn", _within(jitter), "", ""), "", f"{len(result.grid.cam_angle)} a turn"),
            Line("mark of the rig", ("", _within(error), place[0], ""), *place[1:])
        ]  # fmt: skip

    def _channel(self, channel: RigChannelCycles) -> Line:
        name, (top, least) = channel.cycles.quantity, peaks_of(channel)
        mean, bar, angle = channel.top
        high, low = (
            self.words.amount(Amount(name, *one), 4)
            for one in ((mean, bar), (least.mean, np.nan_to_num(least.interval)))
        )
        at = "" if math.isnan(angle_of(top)) else f"{digits_text(math.degrees(angle), 0, 4)} deg"
        scatter = f"± {self.words.amount(Amount(name, top.scatter), 2)}" if top.scatter > 0 else ""
        mark: Mark = (
            "bad" if channel.clipped else "warn" if channel in self.facts.drifting() else "ok"
        )
        remark = {"bad": "clipped", "warn": "drifts", "ok": f"band {channel.band / 1e3:.4g} kHz"}[
            mark
        ]
        return Line(label_of(name), (high, scatter, at, low), mark, remark)

    def tables(self) -> Mapping[str, TextTable]:
        """The findings."""
        return {"findings": findings_table(self)}

    def write(self, folder: Path) -> list[Path]:
        """``<quantity>.csv`` with the cycles of each channel, ``means.csv`` with means, scatter and bands."""
        result = self.result
        files = [write_cycles(folder / f"{one.quantity}.csv", one) for one in result.cycles]
        columns = [("cam angle [deg]", np.degrees(result.grid.cam_angle))]
        for channel in result.channels:
            one = channel.cycles
            columns += [
                (f"{one.quantity} [{one.unit}]", one.mean),
                (f"standard deviation of {one.quantity} [{one.unit}]", deviation(channel)),
                (f"95 % of the mean of {one.quantity} within [{one.unit}]", channel.spread),
            ]
        names, values = zip(*columns, strict=True)
        head = "# synthetic: computed, not measured\n" * result.synthetic
        text = csv_of(names, np.column_stack(values).tolist(), 9)
        return [*files, write_text(folder / "means.csv", head + text)]

    def figures(self) -> Mapping[str, FigureSpec]:
        """Cycles of every channel, the lift on that of the case, speed, and the recording."""
        hint = "Grey: two scatters of a cycle."
        cycles = {
            f"cycles-{channel.cycles.quantity}": FigureSpec(
                f"Cycles: {label_of(channel.cycles.quantity)}",
                hint,
                partial(cycles_figure, channel),
            )
            for channel in self.result.channels
        }
        return cycles | {
            "alignment": FigureSpec("Lift of the rig and of the case", "", alignment_figure),
            "speed": FigureSpec("Speed of the cam", "", speed_figure),
            "raw": FigureSpec(
                "As recorded", "Upright lines: where cycles were cut; red: left out.", raw_figure
            ),
        }

    def computed(self) -> Iterator[str]:
        """How it was read."""
        yield from (
            f"{note[:1].upper()}{note[1:]}." for one in self.result.cycles for note in one.notes
        )
        yield from (f"{note[:1].upper()}{note[1:]}." for note in self.result.notes)


def _within(degrees: float) -> str:
    return f"± {digits_text(degrees, 0, 2)} deg" if degrees else ""


def _axis(quantity: str, values: Array) -> tuple[str, float]:
    """Title of the axis of a channel, and the size of its unit (SI)."""
    unit = Words().unit(quantity, max(float(np.nanmax(np.abs(values))), 1e-3))
    return ", ".join(filter(None, (label_of(quantity), unit.text))), unit.size


def cycles_figure(channel: RigChannelCycles, facts: RigFacts) -> go.Figure:
    """The mean cycle with two scatters; below, the scatter and the half width of the band of the mean, over two degrees each."""
    angle, mean, scatter = (
        np.degrees(channel.cycles.cam_angle),
        channel.cycles.mean,
        deviation(channel),
    )
    title, size = _axis(channel.cycles.quantity, mean)
    count = max(1, len(angle) // 180)
    whole = len(angle) // count * count
    fig = panels((0.65, 0.35))
    fig.add_traces(
        band(
            angle,
            (mean - 2 * scatter) / size,
            (mean + 2 * scatter) / size,
            "two scatters of a cycle",
        ),
        rows=[1, 1],
        cols=[1, 1],
    )
    fig.add_trace(line(angle, mean / size, "mean cycle", LEAD), 1, 1)
    below = (
        (scatter, "scatter of a cycle", SECOND),
        (channel.spread, "95 % of the mean within", OTHER),
    )
    for values, name, colour in below if np.isfinite(channel.spread).all() else below[:1]:
        pieces = np.sqrt(np.mean(values[:whole].reshape(-1, count) ** 2, axis=1))
        fig.add_trace(line(angle[:whole:count], pieces / size, name, colour), 2, 1)
    return styled(
        fig, ANGLE, (title, f"scatter{title[len(label_of(channel.cycles.quantity)) :]}"), 440
    )


def alignment_figure(facts: RigFacts) -> go.Figure | None:
    """The measured lift on that of the case, and the rest."""
    fit = facts.result.alignment
    if fit is None:
        return None
    angle, fig = np.degrees(fit.cam_angle), panels((0.65, 0.35))
    fig.add_trace(line(angle, 1e3 * fit.measured, "measured", LEAD), 1, 1)
    fig.add_trace(
        line(
            angle,
            1e3 * (fit.base + fit.gain * fit.model),
            "case, with gain and base",
            OTHER,
            "dash",
        ),
        1,
        1,
    )
    fig.add_trace(line(angle, 1e3 * fit.residual, "measured less case", SECOND), 2, 1)
    return styled(fig, ANGLE, ("valve lift, mm", "difference, mm"), 420)


def speed_figure(facts: RigFacts) -> go.Figure:
    """The cam speed over time, and its mean over each cycle."""
    cuts = facts.result.grid.cut_times
    times = np.linspace(cuts[0], cuts[-1], 1500)
    fig = go.Figure(line(times, facts.result.shaft.cam_speed(times) / RPM, "cam speed", LEAD))
    fig.add_trace(
        line(
            (cuts[1:] + cuts[:-1]) / 2,
            facts.result.grid.cam_speeds / RPM,
            "mean of each cycle",
            OTHER,
            "dash",
        )
    )
    return styled(fig, "time, s", ("cam speed, rpm",))


def raw_figure(facts: RigFacts) -> go.Figure:
    """Every channel over time with the cut marks, cycles that were left out in red."""
    result = facts.result
    cuts = result.grid.cut_times
    fig = panels((1.0,) * len(result.channels))
    titles = []
    for place, channel in enumerate(result.channels, 1):
        title, size = _axis(channel.cycles.quantity, channel.cycles.mean)
        titles.append(title)
        times = channel.raw.start + channel.raw.step * np.arange(len(channel.raw.values))
        fig.add_trace(
            line(
                times,
                channel.raw.values / size,
                label_of(channel.cycles.quantity),
                LEAD,
                showlegend=False,
            ),
            place,
            1,
        )
    for cut in cuts[:: max(1, len(cuts) // MARKS)]:
        fig.add_vline(float(cut), line={"color": RIGID, "width": 1})
    for cycle in [cycle for cycle, _ in result.outliers if cycle not in result.retained][:MARKS]:
        fig.add_vrect(
            float(cuts[cycle]), float(cuts[cycle + 1]), fillcolor=BAD, opacity=0.15, line_width=0
        )
    return styled(fig, "time, s", tuple(titles), 120 + 180 * len(titles))
