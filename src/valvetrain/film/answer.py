"""What ``film`` shows: doubts, how far a model is from the film or what moves most, peaks and surge lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.film.cycles import TURN, mean_of
from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.film.rules import RULES, FilmFacts, displacement, frequency, nearest, ratio, rpm
from valvetrain.film.surge import BAND
from valvetrain.findings.words import digits_text
from valvetrain.measured.cycles import MeasuredCycles, write_cycles
from valvetrain.measured.json import json_estimate, json_fields
from valvetrain.solution.atomic import write_text
from valvetrain.views.columns import RowColumn, csv_row, json_row, table_of
from valvetrain.views.files import csv_of
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import (
    ANGLE,
    LEAD,
    RIGID,
    SECOND,
    SPEEDS,
    FigureSpec,
    dots,
    line,
    styled,
)
from valvetrain.views.table import Line, TextTable

#: Quantity in whose unit displacements are read.
LENGTH = "maximum_lift"


PEAK_COLUMNS: list[RowColumn] = [
    RowColumn("coil", value="coil", key="coil", csv="coil"),
    RowColumn("mean peak", None, "mean", "mean", "mean peak displacement [mm]", 1e3, quantity=LENGTH),
    RowColumn("95 %, ±", None, lambda peak: BAND * peak.spread, quantity=LENGTH),
    RowColumn("", None, "spread", "standard_deviation", "standard deviation of the mean [mm]", 1e3),
    RowColumn("scatter of a turn", None, "scatter", "scatter", "scatter of a turn [mm]", 1e3, quantity=LENGTH),
    RowColumn(value="cycles", key="turns", csv="turns")
]  # fmt: skip
LINE_COLUMNS: list[RowColumn] = [
    RowColumn(
        "frequency", lambda row: f"{digits_text(row.natural_frequency, row.frequency_spread, 7)} Hz",
        lambda row: json_estimate((row.natural_frequency, row.frequency_spread)), "frequency"
    ),
    RowColumn("95 %, ±", lambda row: f"{digits_text(BAND * row.frequency_spread, 0, 2)} Hz"),
    RowColumn(
        "damping ratio", lambda row: digits_text(row.damping_ratio, row.damping_spread, 7),
        lambda row: json_estimate((row.damping_ratio, row.damping_spread)), "damping_ratio"
    ),
    RowColumn("95 %, ±", lambda row: digits_text(BAND * row.damping_spread, 0, 2)),
    RowColumn("decay rate", lambda row: f"{digits_text(row.decay_rate)} 1/s", "decay_rate", "decay_rate"),
    RowColumn("amplitude", None, "amplitude", "amplitude", quantity=LENGTH)
]  # fmt: skip


#: Coils and surge lines in the first table at most.
COILS, LINES = 7, 2


@dataclass(frozen=True)
class FilmAnswer(ShownByRules):
    """What is shown of a film, and of the run that is compared with it; ``synthetic``: it was computed; ``folder``
    of its files, which the next step names.
    """

    rules = RULES

    motion: CoilMotion
    model: FilmedModel | None = None
    synthetic: bool = False
    folder: Path = Path()

    @property
    def facts(self) -> FilmFacts:
        """The film as rules read it."""
        return FilmFacts(self.motion, self.model, str(self.folder))

    @property
    def title(self) -> str:
        """The film, and the case that is compared with it."""
        model = self.model
        beside = (
            "" if model is None else f", {model.spring} spring of {model.case} by {model.model}"
        )
        return f"Film {self.motion.seen.name}{', synthetic' * self.synthetic}{beside}"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return [""] if self.model is None else ["film", "model", "apart (rms)"]

    @cached_property
    def lines(self) -> list[Line]:
        """Peaks of the coils that move most, surge lines, and how well the film shows them."""
        motion, words = self.motion, self.words
        place = float(np.nanmedian(motion.spread))
        within = words.amount(displacement(place * motion.metres_per_pixel), 2)
        rows = [
            *self._coils(), *self._surge(), ("frames", f"{len(motion.places)} at {motion.seen.frame_rate:g} a second"),
            ("place of a coil", f"{place:.2g} px, {within}")
        ]  # fmt: skip
        if motion.phase is not None:
            rows.insert(
                -2, ("cam speed", f"{rpm(motion.phase.cam_speed)}, by the {motion.phase.by}")
            )
        blank = ("",) * 3
        return [Line(label, (*cells, *blank)[: len(self.headings)]) for label, *cells in rows]

    def _coils(self) -> Iterator[tuple[str, ...]]:
        for top in sorted(self.motion.peaks, key=lambda top: -top.mean)[:COILS]:
            peak, bar, *more = (self.words.amount(displacement(float(value)), digits) for value, digits in (
                (top.mean, 4), (BAND * top.spread, 2),
                *(() if self.model is None else ((self.model.peaks[top.coil - 1], 4), (self.model.apart[top.coil - 1], 2)))
            ))  # fmt: skip
            yield f"coil {top.coil}", f"{peak} ± {bar}", *more

    def _surge(self) -> Iterator[tuple[str, ...]]:
        for place, ring in enumerate(self.facts.lines[:LINES], 1):
            pair = (ring, nearest(self.model, ring))
            yield f"surge line {place}", *(f"{self.words.said(frequency(two), 5)}, damping {ratio(two)}" for two in pair if two)  # fmt: skip

    def tables(self) -> Mapping[str, TextTable]:
        """All surge lines, by the columns that JSON has; all peaks are in ``peaks.csv``."""
        return {"surge": table_of("Surge lines", LINE_COLUMNS, self.facts.lines, self.words)}

    def write(self, folder: Path) -> list[Path]:
        """``displacement-coil-N.csv`` (measured cycles), ``peaks.csv``, ``tracks.csv`` and, with a
        model, ``model.csv``.
        """
        motion, model = self.motion, self.model
        files = [
            write_cycles(folder / f"displacement-coil-{coil}.csv", cycles)
            for coil, cycles in enumerate(named_cycles(motion, model), start=1)
        ]
        coils = range(1, motion.coils + 1)
        columns = [
            1e3 * motion.time,
            *(() if motion.phase is None else (np.degrees(motion.phase.cam_angle),)),
        ]
        heads = ["time [ms]", *(() if motion.phase is None else ("cam angle [deg]",))]
        kinds = (
            ("displacement of coil", "mm"),
            ("place of coil", "px"),
            ("standard deviation of coil", "px"),
        )
        heads += [f"{word} {coil} [{unit}]" for word, unit in kinds for coil in coils]
        tracks = np.column_stack(
            [*columns, 1e3 * motion.displacement, motion.places, motion.spread]
        )
        tables: dict[str, tuple[Sequence[str], Sequence[Sequence[float]]]] = {}
        tables["tracks.csv"] = heads, tracks.tolist()
        if motion.peaks:
            head = [column.csv for column in PEAK_COLUMNS if column.csv]
            rows = [csv_row(PEAK_COLUMNS, peak) for peak in motion.peaks]
            tables["peaks.csv"] = head, rows
        if model is not None:
            named = (
                f"coil {coil}, turn {turn:.2f} [mm]"
                for coil, turn in zip(coils, model.turns, strict=True)
            )
            curves = np.column_stack([np.degrees(model.cam_angle), 1e3 * model.displacement])
            tables["model.csv"] = ("cam angle [deg]", *named), curves.tolist()
        return files + [
            write_text(folder / name, csv_of(*table, 9)) for name, table in tables.items()
        ]

    def figures(self) -> Mapping[str, FigureSpec]:
        """The coils over the cam angle, of a cam that does not turn the decay first."""
        shaded = "shaded: valve closed; " + ("mean of the turns" if self.model is None else "dashed: the model")  # fmt: skip
        return {
            "coils": FigureSpec("Motion of the coils", shaded, coils_figure),
            "decay": FigureSpec("Free decay", "the coil that rings most", decay_figure),
            "space-time": FigureSpec("Space-time picture with the tracks", "", space_time_figure)
        }  # fmt: skip

    def computed(self) -> Iterator[str]:
        """What was found and done."""
        yield "Coils are followed by the glare line on each of them and counted from the seat. Displacements are along the picture, towards the seat."
        yield "The damping of a free decay goes into your case: name it in place of job-t."
        for note in (*self.motion.notes, *(() if self.model is None else self.model.notes)):
            yield f"{note[:1].upper()}{note[1:]}."


def answer_of_model(model: FilmedModel) -> FilmAnswer:
    """What is shown of a run that is compared with a film."""
    return FilmAnswer(model.motion, model)


def named_cycles(motion: CoilMotion, model: FilmedModel | None) -> tuple[MeasuredCycles, ...]:
    """Measured cycles of every coil; as a run has them, under the names that the same curves have there."""
    if model is None:
        return motion.cycles
    return tuple(
        replace(cycles, quantity=name)
        for cycles, name in zip(motion.cycles, model.quantities, strict=True)
    )


def film_json(motion: CoilMotion, model: FilmedModel | None) -> dict[str, Any]:
    """The JSON answer, SI."""
    line = motion.seen.line
    data: dict[str, Any] = {
        "command": "film", "case": "" if model is None else model.case, "completed": True, "frames": len(motion.places),
        "coils": motion.coils,
        "frame_rate": motion.seen.frame_rate, "line": {"start": list(line.start), "end": list(line.end), "unit": "px"},
        "metres_per_pixel": json_estimate((motion.metres_per_pixel, motion.scale_spread)),
        "place_standard_deviation": {"value": float(np.nanmedian(motion.spread)), "unit": "px"},
        "camera_drift": {"value": float(np.ptp(motion.drift)), "unit": "px"},
        "cam_speed": None if motion.phase is None else {
            "value": motion.phase.cam_speed, "standard_deviation": motion.phase.spread, "by": motion.phase.by},
        "dwell": None if motion.dwell is None else list(motion.dwell),
        "peaks": [json_row(PEAK_COLUMNS, peak) for peak in motion.peaks],
        "surge_lines": [json_row(LINE_COLUMNS, row) for row in FilmFacts(motion).lines],
        "notes": list(motion.notes)
    }  # fmt: skip
    if model is not None:
        data["model"] = {
            **json_fields(model, "model spring turns quantities peaks apart surge_frequency shift notes"),
            "surge_lines": [json_fields(line, "natural_frequency damping_ratio") for line in (() if model.surge is None else model.surge.lines)]
        }  # fmt: skip
    return data


#: Frames and stations of the space-time picture at most, and cam revolutions that it shows.
FRAMES, STATIONS, TURNS = 400, 300, 3.0


def coils_figure(facts: FilmFacts) -> go.Figure | None:
    """Displacement (mm) of every coil over the cam angle, mean of the turns; dashed: the model."""
    motion, model, fig = facts.motion, facts.model, go.Figure()
    if motion.dwell is None:
        return None
    for coil, cycles in enumerate(motion.cycles):
        colour = SPEEDS[coil % len(SPEEDS)]
        mean = 1e3 * mean_of(cycles.values)
        fig.add_trace(line(np.degrees(cycles.cam_angle), mean, f"coil {coil + 1}", colour))
        if model is not None:
            moved = 1e3 * model.displacement[:, coil]
            fig.add_trace(line(np.degrees(model.cam_angle), moved, "model", colour, "dash", showlegend=coil == 0))  # fmt: skip
    first, last = np.degrees(motion.dwell)
    for begin, end in ((first, min(last, 360.0)), (0.0, last - 360.0)):
        if end > begin:
            fig.add_vrect(begin, end, fillcolor=RIGID, opacity=0.2, line_width=0)
    styled(fig, ANGLE, ("displacement towards the seat, mm",), 420)
    return fig.update_xaxes(range=[0, 360], dtick=60)


def decay_figure(facts: FilmFacts) -> go.Figure | None:
    """One decay (mm over ms) as filmed and as fitted, of the coil that rings most."""
    surge = facts.motion.surge
    if surge is None:
        return None
    fig = go.Figure([
        line(1e3 * surge.curve_time, 1e3 * surge.curve, "damped sines fitted", LEAD),
        dots(1e3 * surge.time, 1e3 * surge.measured, f"coil {surge.coil}", SECOND)
    ])  # fmt: skip
    return styled(fig, "time from the beginning of the decay, ms", ("displacement, mm",))


def space_time_figure(facts: FilmFacts) -> go.Figure:
    """Brightness along the line (px) over time (ms) as the camera saw it, with the tracks of the coils."""
    motion, last = facts.motion, min(FRAMES, len(facts.motion.time))
    if motion.phase is not None:
        turned = motion.phase.cam_angle - motion.phase.cam_angle[0]
        last = min(last, max(16, int(np.searchsorted(turned, TURNS * TURN))))
    top = motion.seen.picture.shape[1] - 1
    every = -(-motion.seen.picture.shape[1] // STATIONS)
    picture, time = motion.seen.picture[:last, ::every], 1e3 * motion.time[:last]
    dark, bright = np.percentile(picture, (1, 99.9))
    grey = np.clip(255 * (picture - dark) / max(bright - dark, 1e-9), 0, 255).astype(np.uint8)
    fig = go.Figure(
        go.Heatmap(
            x=time,
            y=top - every * np.arange(grey.shape[1]),
            z=grey.T,
            colorscale="gray",
            showscale=False,
        )
    )
    for coil, place in enumerate((motion.places + motion.drift[:, None])[:last].T):
        fig.add_trace(line(time, top - place, f"coil {coil + 1}", SPEEDS[coil % len(SPEEDS)]))
    return styled(fig, "time, ms", ("from the end of the line, px",), 460)
