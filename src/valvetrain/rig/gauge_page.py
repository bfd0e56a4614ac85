"""A run as a gauge records it, for readers: table of both peaks, page, CSV and JSON."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.measured.sensor import Sensor
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Marks, Panel, thin
from valvetrain.report.files import FreeNames
from valvetrain.report.page import Figure, Page, Section, text
from valvetrain.report.text import number, speed_text
from valvetrain.rig.gauge import ChannelResponse
from valvetrain.rig.page import shown_unit
from valvetrain.solution.atomic import write_text
from valvetrain.views.columns import RowColumn, grid, json_row

#: Figures of a page, the channels that lose most first; points of a drawn trace; part of the
#: revolution that is drawn about the peak.
MAX_FIGURES, POINTS, WINDOW = 8, 1500, 12
#: Share within which a peak is recorded whole; share by which what is recorded about the true peak is
#: below what is recorded elsewhere.
WHOLE, ELSEWHERE = 0.005, 0.1


def _run_label(one: ChannelResponse) -> str:
    return f"{one.label}{', ' if one.label else ''}{speed_text(one.engine_speed)}"


def _channel_label(one: ChannelResponse) -> str:
    return one.channel.replace("_", " ")


def _shown(value: float, one: ChannelResponse, digits: int = 5) -> str:
    return number(value * shown_unit(one.channel, one.unit)[1], digits)


def _phase_text(one: ChannelResponse) -> str:
    low, high = one.recorded.peaks
    return f"±{_shown((high - low) / 2, one, 2)}" if high > low else ""


#: The table of peaks: a row per run and channel.
COLUMNS = (
    RowColumn("run", _run_label, "label", "run", number=False),
    RowColumn(value="engine_speed", key="engine_speed"),
    RowColumn("channel", _channel_label, "channel", "channel", number=False),
    RowColumn("true peak", lambda one: _shown(one.true_peak, one), "true_peak", "true_peak"),
    RowColumn(
        "recorded peak",
        lambda one: _shown(one.recorded_peak, one),
        "recorded_peak",
        "recorded_peak",
    ),
    RowColumn(
        "by sampling phase", _phase_text, lambda one: list(one.recorded.peaks), "recorded_peaks"
    ),
    RowColumn(
        "unit", lambda one: shown_unit(one.channel, one.unit)[0], "unit", "unit", number=False
    ),
    RowColumn("recorded over true", lambda one: f"{100 * sum(one.share) / 2:.1f} %"),
    RowColumn(value="spacing", key="step"),
    RowColumn(value="coarse", key="coarse"),
)


def notes_of(responses: Sequence[ChannelResponse]) -> tuple[str, ...]:
    """What a reader must know of the traces."""
    notes = [
        "The recorded peak is the middle of the peaks at all phases of the sampling, followed by half their range"
    ]
    coarse = [one for one in responses if one.coarse]
    if coarse:
        names = ", ".join(sorted({_channel_label(one) for one in coarse}))
        step = 1e6 * max(one.spacing for one in coarse)
        notes.append(
            f"{names}: a point every {step:.3g} us is coarse for this gauge; a spike may be between points"
        )
    return tuple(notes)


def sensor_text(sensor: Sensor) -> str:
    """The gauge in one line."""
    parts = []
    if sensor.resonance is not None:
        parts.append(
            f"resonance at {sensor.resonance / 1e3:.4g} kHz with damping ratio {sensor.damping_ratio:g}"
        )
    if sensor.bandwidth is not None:
        kind = f"{sensor.filter.capitalize()} low-pass of order {sensor.order} at {float(sensor.bandwidth) / 1e3:.4g} kHz"
        parts.append(kind + (", forward and backward" if sensor.zero_phase else ""))
    if sensor.sampling_rate is not None:
        parts.append(f"sampled at {float(sensor.sampling_rate) / 1e3:.4g} kHz")
    if sensor.resolution:
        parts.append(f"in steps of {sensor.resolution:g}")
    return "; ".join(parts) or "ideal"


def sensor_page(title: str, responses: Sequence[ChannelResponse], sensor: Sensor) -> Page:
    """The whole page."""
    worst = sorted(responses, key=lambda one: one.share[0])[:MAX_FIGURES]
    notes = (text(f"{note}.", "note") for note in notes_of(responses))
    sections = (
        Section("peaks", "True and recorded peaks", (grid(COLUMNS, responses), *notes)),
        Section(
            "traces",
            "About the true peak",
            tuple(Figure(trace_chart(one, count)) for count, one in enumerate(worst[1:], start=2)),
        ),
    )[: 1 + (len(worst) > 1)]
    facts = (
        ("gauge", sensor_text(sensor)),
        ("runs", str(len({_run_label(one) for one in responses}))),
        ("channels", str(len(responses))),
    )
    lead = "What the model computes, and what this gauge would record of it; channels that lose most are drawn first."
    footer = "Times are from the start of the cam revolution."
    picture = tuple(Figure(trace_chart(one, 1)) for one in worst[:1])
    said = sensor_verdict(worst[0]) if worst else ""
    return Page(title, "Recorded by a gauge", lead, facts, sections, footer, said, picture)


def sensor_verdict(worst: ChannelResponse) -> str:
    """One sentence on the channel of which a gauge loses most."""
    unit, _ = shown_unit(worst.channel, worst.unit)
    peaks = f"{_shown(worst.recorded_peak, worst, 4)} of {_shown(worst.true_peak, worst, 4)} {unit}"
    share = sum(worst.share) / 2
    least = f"least of the {_channel_label(worst)}, {_run_label(worst)}: {peaks.strip()}"
    if abs(share - 1) < WHOLE:
        return f"The gauge records every peak within {100 * WHOLE:g} %; {least}."
    first, last = _about_peak(worst)
    there = (worst.recorded.time >= first) & (worst.recorded.time <= last)
    near = float(np.max(worst.recorded.values[there], initial=-np.inf))
    elsewhere = ""
    if np.isfinite(near) and near < (1 - ELSEWHERE) * worst.recorded.peak:
        elsewhere = f", and that at another angle: about the true peak it records {_shown(near, worst, 4)} {unit}".rstrip()
    return f"The gauge records at least {100 * share:.0f} % of each peak; {least}{elsewhere}."


def _about_peak(one: ChannelResponse) -> tuple[float, float]:
    """First and last time (s) of what is drawn about the true peak."""
    middle = float(one.time[int(np.argmax(one.values))])
    half = (one.time[-1] - one.time[0]) / (2 * WINDOW)
    return max(middle - half, float(one.time[0])), min(middle + half, float(one.time[-1]))


def trace_chart(one: ChannelResponse, count: int) -> Chart:
    """True trace, output of the gauge, and its samples, about the true peak."""
    unit, factor = shown_unit(one.channel, one.unit)
    recorded = one.recorded
    first, last = _about_peak(one)
    drawn, sampled = ((at >= first) & (at <= last) for at in (one.time, recorded.time))
    at, values = 1e3 * recorded.time[sampled], recorded.values[sampled] * factor
    layers: list[Line | Marks] = [
        Line(
            *thin(1e3 * one.time[drawn], one.values[drawn] * factor, POINTS), "true", theme.INK, 1.1
        ),
        Line(*thin(at, values, POINTS), "recorded", theme.SERIES[1], 1.6),
    ]
    if len(at) <= 400:
        layers.append(Marks(at, values, "samples", theme.SERIES[1], size=3.5, filled=True))
    label = f"{_channel_label(one)} ({unit})"
    panel = Panel("time (ms)", label, tuple(layers), x_range=(1e3 * first, 1e3 * last))
    caption = f"True peak {_shown(one.true_peak, one)} {unit}; {_shown(recorded.peak, one)} {unit} as the samples fall here."
    title = f"{_channel_label(one).capitalize()}, {_run_label(one)}"
    return Chart(f"seen-{count}", title, caption, (panel,), 1, 340)


def write_responses(responses: Sequence[ChannelResponse], folder: Path) -> list[Path]:
    """``seen-RUN-CHANNEL.csv``: what the gauge records, over time."""
    files, names = [], FreeNames()
    for one in responses:
        samples = np.column_stack([one.recorded.time, one.recorded.values]).tolist()
        lines = [
            f"time [s],{one.channel} as recorded [{one.unit}]",
            *(f"{time:.9g},{value:.9g}" for time, value in samples),
        ]
        name = names.free(f"seen-{_run_label(one)}-{one.channel}")
        files.append(write_text(folder / f"{name}.csv", "\n".join(lines) + "\n"))
    return files


def data_of(responses: Sequence[ChannelResponse], sensor: Sensor, case: str) -> dict[str, Any]:
    """The same for JSON, SI."""
    quantities: dict[str, dict[str, Any]] = {}
    for one in responses:
        quantities.setdefault(_run_label(one), {}).update(
            {
                f"{kind}_peak_{one.channel}": {"value": peak, "unit": one.unit}
                for kind, peak in (("true", one.true_peak), ("recorded", one.recorded_peak))
            }
        )
    return {
        "command": "rig",
        "case": case,
        "completed": True,
        "gauge": {name: getattr(sensor, name) for name in Sensor.__dataclass_fields__}
        | {"resonance": sensor.resonance},
        "quantities_by_label": quantities,
        "seen": [json_row(COLUMNS, one) for one in responses],
    }
