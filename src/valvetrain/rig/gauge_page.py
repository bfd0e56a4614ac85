"""The page of a gauge: true and recorded traces, table of both peaks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.measured.sensor import Sensor
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Marks, Panel, thin
from valvetrain.report.files import FreeNames
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, text
from valvetrain.report.text import number, speed_text
from valvetrain.rig.gauge import SeenChannel
from valvetrain.rig.page import shown_unit
from valvetrain.solution.atomic import write_text

#: Headings of the table of peaks.
HEAD = (
    "run",
    "channel",
    "true peak",
    "recorded peak",
    "by sampling phase",
    "unit",
    "recorded over true",
)
#: Figures of a page, the channels that lose most first; points of a drawn trace; shares of the
#: window about the peak.
MAX_FIGURES, POINTS, WINDOW = 8, 1500, 12


def _run_of(one: SeenChannel) -> str:
    return f"{one.label}{', ' if one.label else ''}{speed_text(one.engine_speed)}"


def seen_rows(found: Sequence[SeenChannel]) -> list[tuple[str, ...]]:
    """One row a run and channel, as :data:`HEAD` says."""
    rows: list[tuple[str, ...]] = []
    for one in found:
        unit, factor = shown_unit(one.channel, one.unit)
        low, high = one.seen.peaks
        middle = (low + high) / 2
        rows.append(
            (
                _run_of(one),
                one.channel.replace("_", " "),
                number(one.true_peak * factor, 5),
                number(middle * factor, 5),
                f"±{number((high - low) / 2 * factor, 2)}" if high > low else "",
                unit,
                f"{100 * sum(one.share) / 2:.1f} %",
            )
        )
    return rows


def notes_of(found: Sequence[SeenChannel]) -> tuple[str, ...]:
    """What a reader must know of the traces."""
    notes = [
        "The recorded peak is the middle of what the phases of the sampling give, with half their range beside"
    ]
    coarse = [one for one in found if one.coarse]
    if coarse:
        names = ", ".join(sorted({one.channel.replace("_", " ") for one in coarse}))
        step = 1e6 * max(one.spacing for one in coarse)
        notes.append(
            f"{names}: a point every {step:.3g} us is coarse for this gauge; a spike may lie between points"
        )
    return tuple(notes)


def sensor_words(sensor: Sensor) -> str:
    """The gauge in one line."""
    words = []
    if sensor.resonance is not None:
        words.append(
            f"resonance at {sensor.resonance / 1e3:.4g} kHz with damping ratio {sensor.damping_ratio:g}"
        )
    if sensor.bandwidth is not None:
        kind = f"{sensor.filter.capitalize()} low-pass of order {sensor.order} at {float(sensor.bandwidth) / 1e3:.4g} kHz"
        words.append(kind + (", forward and backward" if sensor.zero_phase else ""))
    if sensor.sampling_rate is not None:
        words.append(f"sampled at {float(sensor.sampling_rate) / 1e3:.4g} kHz")
    if sensor.resolution:
        words.append(f"in steps of {sensor.resolution:g}")
    return "; ".join(words) or "ideal"


def seen_page(title: str, found: Sequence[SeenChannel], sensor: Sensor) -> Page:
    """The whole page."""
    rows = tuple(
        (
            tuple(
                Cell(word, "number" if place in (2, 3, 4, 6) else "")
                for place, word in enumerate(row)
            ),
            (),
        )
        for row in seen_rows(found)
    )
    worst = sorted(found, key=lambda one: one.share[0])[:MAX_FIGURES]
    sentences: tuple[Block, ...] = tuple(text(f"{note}.", "note") for note in notes_of(found))
    sections = (
        Section("peaks", "True and recorded peaks", (Grid(HEAD, rows), *sentences)),
        Section(
            "traces",
            "About the true peak",
            tuple(Figure(seen_chart(one, place)) for place, one in enumerate(worst)),
        ),
    )
    facts = (
        ("gauge", sensor_words(sensor)),
        ("runs", str(len({_run_of(one) for one in found}))),
        ("channels", str(len(found))),
    )
    lead = "What the model computes, and what this gauge would record of it; channels that lose most are drawn first."
    return Page(
        title, "Seen by a gauge", lead, facts, sections, "Times are from the begin of the cam turn."
    )


def seen_chart(one: SeenChannel, place: int) -> Chart:
    """True trace, what leaves the gauge, and its samples, about the true peak."""
    unit, factor = shown_unit(one.channel, one.unit)
    middle = float(one.time[int(np.argmax(one.values))])
    half = (one.time[-1] - one.time[0]) / (2 * WINDOW)
    reach = max(middle - half, float(one.time[0])), min(middle + half, float(one.time[-1]))
    true, recorded = ((at >= reach[0]) & (at <= reach[1]) for at in (one.time, one.seen.time))
    at, values = 1e3 * one.seen.time[recorded], one.seen.values[recorded] * factor
    line = Line(
        *thin(1e3 * one.time[true], one.values[true] * factor, POINTS), "true", theme.INK, 1.1
    )
    over = Line(*thin(at, values, POINTS), "recorded", theme.SERIES[1], 1.6)
    layers: tuple[Line | Marks, ...] = (line, over)
    if len(at) <= 400:
        layers = (*layers, Marks(at, values, "samples", theme.SERIES[1], size=3.5, filled=True))
    label = f"{one.channel.replace('_', ' ')} ({unit})"
    panel = Panel("time (ms)", label, layers, x_range=(1e3 * reach[0], 1e3 * reach[1]))
    caption = f"True peak {number(one.true_peak * factor, 5)} {unit}; {number(one.seen.peak * factor, 5)} {unit} as the samples fall here."
    return Chart(
        f"seen-{place + 1}",
        f"{one.channel.replace('_', ' ').capitalize()}, {_run_of(one)}",
        caption,
        (panel,),
        1,
        340,
    )


def write_seen(found: Sequence[SeenChannel], folder: Path) -> list[Path]:
    """``seen-RUN-CHANNEL.csv``: what the gauge records, over time."""
    files, names = [], FreeNames()
    for one in found:
        rows = (
            f"{time:.9g},{value:.9g}"
            for time, value in zip(one.seen.time.tolist(), one.seen.values.tolist(), strict=True)
        )
        name = names.free(f"seen-{_run_of(one)}-{one.channel}")
        files.append(
            write_text(
                folder / f"{name}.csv",
                "\n".join([f"time [s],{one.channel} as recorded [{one.unit}]", *rows]) + "\n",
            )
        )
    return files


def data_of(found: Sequence[SeenChannel], sensor: Sensor, case: str) -> dict[str, Any]:
    """The same for JSON, SI."""
    gauge = {name: getattr(sensor, name) for name in Sensor.__dataclass_fields__} | {
        "resonance": sensor.resonance
    }
    named: dict[str, dict[str, Any]] = {}
    for one in found:
        peaks = (("true", one.true_peak), ("recorded", sum(one.seen.peaks) / 2))
        named.setdefault(_run_of(one), {}).update(
            {
                f"{word}_peak_{one.channel}": {"value": peak, "unit": one.unit}
                for word, peak in peaks
            }
        )
    return {
        "command": "rig",
        "case": case,
        "completed": True,
        "gauge": gauge,
        "quantities_by_label": named,
        "seen": [
            {
                "run": one.label,
                "engine_speed": one.engine_speed,
                "channel": one.channel,
                "unit": one.unit,
                "true_peak": one.true_peak,
                "recorded_peak": sum(one.seen.peaks) / 2,
                "recorded_peaks": list(one.seen.peaks),
                "step": one.spacing,
                "coarse": one.coarse,
            }
            for one in found
        ],
    }
