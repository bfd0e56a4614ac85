"""What ``rig`` shows of a run as a gauge records it: whether peaks are recorded whole, both peaks, and the traces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.words import Amount, Words, speed_text
from valvetrain.measured.sensor import Sensor
from valvetrain.rig.gauge import ChannelResponse
from valvetrain.rig.rules import GAUGE_RULES, WHOLE, GaugeFacts
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_of
from valvetrain.views.columns import RowColumn, csv_text, json_row, table_of
from valvetrain.views.files import FreeNames
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import LEAD, OTHER, FigureSpec, line, styled
from valvetrain.views.table import Line, TextTable

#: Channels that are drawn and stand in the first table, those first that lose most.
FIGURES, ROWS = 8, 12


def run_label(response: ChannelResponse) -> str:
    """Model and engine speed of a run."""
    return ", ".join(filter(None, (response.label, speed_text(response.engine_speed))))


#: The table of peaks: a row per run and channel.
COLUMNS = (
    RowColumn("run", run_label, "label", "run"),
    RowColumn(value="engine_speed", key="engine_speed"),
    RowColumn("channel", lambda response: label_of(response.channel), "channel", "channel"),
    *(RowColumn(key.replace("_", " "), value=key, key=key, quantity=lambda row: str(row.channel)) for key in ("true_peak", "recorded_peak")),
    RowColumn(value=lambda response: list(response.recorded.peaks), key="recorded_peaks"),
    *(RowColumn(value=value, key=key) for value, key in (("unit", "unit"), ("spacing", "step"), ("coarse", "coarse")))
)  # fmt: skip


@dataclass(frozen=True)
class GaugeAnswer(ShownByRules):
    """What is shown of the ``responses`` of runs of a case to the gauge ``sensor``."""

    rules = GAUGE_RULES

    name: str
    responses: Sequence[ChannelResponse]
    sensor: Sensor

    @cached_property
    def facts(self) -> GaugeFacts:
        """The responses as rules read them."""
        return GaugeFacts(self.responses, self.words.case or self.name)

    @property
    def title(self) -> str:
        """The case and the gauge."""
        return f"{self.name}, recorded by a gauge: {sensor_text(self.sensor)}"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return ["true peak", "recorded", "by sampling phase", "share"]

    @cached_property
    def lines(self) -> list[Line]:
        """Runs and channels, those first that lose most."""
        return [self._line(response) for response in self.facts.worst[:ROWS]]

    def _line(self, response: ChannelResponse) -> Line:
        low, high = response.recorded.peaks
        true, seen = (
            self.words.amount(Amount(response.channel, value), 4)
            for value in (response.true_peak, response.recorded_peak)
        )
        phase = (
            f"± {self.words.amount(Amount(response.channel, (high - low) / 2), 2)}"
            if high > low
            else ""
        )
        share = sum(response.share) / 2
        whole = abs(share - 1) < WHOLE
        remark = "too coarse" if response.coarse else ""
        return Line(
            f"{label_of(response.channel)}, {run_label(response)}",
            (true, seen, phase, f"{100 * share:.1f} %"),
            "ok" if whole else "bad",
            remark,
        )

    def tables(self) -> Mapping[str, TextTable]:
        """Every run and channel."""
        return {"peaks": table_of("Both peaks", COLUMNS, self.responses, self.words)}

    def figures(self) -> Mapping[str, FigureSpec]:
        """Traces about the true peak."""
        return {
            f"trace-{place}": FigureSpec(
                f"About the peak: {label_of(response.channel)}, {run_label(response)}",
                "",
                partial(trace_figure, response),
            )
            for place, response in enumerate(self.facts.worst[:FIGURES], 1)
        }

    def computed(self) -> Sequence[str]:
        """How the recorded peak is meant."""
        return (
            "The recorded peak is the middle of the peaks at all phases of the sampling, followed by half their range.",
        )


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


def trace_figure(response: ChannelResponse, facts: GaugeFacts) -> go.Figure:
    """True trace and what the gauge records of it, a sixth of the revolution about the true peak."""
    unit, fig = Words().unit(response.channel, response.true_peak), go.Figure()
    middle, half = (
        response.time[np.argmax(response.values)],
        float(response.time[-1] - response.time[0]) / 12,
    )
    seen = response.recorded
    for time, values, name, colour in (
        (response.time, response.values, "true", OTHER),
        (seen.time, seen.values, "recorded", LEAD),
    ):
        there = abs(time - middle) < half
        fig.add_trace(line(1e3 * time[there], values[there] / unit.size, name, colour))
    title = f"{label_of(response.channel)}, {unit.text}"
    return styled(fig, "time from the start of the cam revolution, ms", (title,))


def write_responses(responses: Sequence[ChannelResponse], folder: Path) -> list[Path]:
    """``seen-RUN-CHANNEL.csv``: what the gauge records, over time."""
    files, names = [], FreeNames()
    for response in responses:
        heads = ("time [s]", f"{response.channel} as recorded [{response.unit}]")
        samples = np.column_stack([response.recorded.time, response.recorded.values]).tolist()
        name = names.free(f"seen-{run_label(response)}-{response.channel}")
        files.append(write_text(folder / f"{name}.csv", csv_text(heads, samples)))
    return files


def data_of(responses: Sequence[ChannelResponse], sensor: Sensor, case: str) -> dict[str, Any]:
    """The answer for JSON, SI."""
    quantities: dict[str, dict[str, Any]] = {}
    for response in responses:
        both = (("true", response.true_peak), ("recorded", response.recorded_peak))
        peaks = {
            f"{kind}_peak_{response.channel}": {"value": peak, "unit": response.unit}
            for kind, peak in both
        }
        quantities.setdefault(run_label(response), {}).update(peaks)
    gauge = {name: getattr(sensor, name) for name in Sensor.__dataclass_fields__}
    return {
        "command": "rig", "case": case, "completed": True, "gauge": gauge | {"resonance": sensor.resonance},
        "quantities_by_label": quantities, "seen": [json_row(COLUMNS, response) for response in responses]
    }  # fmt: skip
