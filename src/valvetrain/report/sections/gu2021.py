"""Figures of one source, the beehive spring of gu2021: force by stages with published values, spikes close up,
nodes 1 and 2.
"""

from __future__ import annotations

import numpy as np

from valvetrain import registry
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.signal import fine_filtered, fine_series
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Marks, Panel, thin
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.run_charts import (
    ANGLE_LABEL,
    Array,
    by_speed,
    covered_by_source,
    line_styles,
    over_angle,
)
from valvetrain.report.text import number, speed_text
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

STUDY = "gu2021"
SPIKE_BANDWIDTH = 10e3
#: The close-up begins this far (cam deg) before the end of the lift event and ends this far after
#: it.
SPIKE_REACH = (8.0, 87.0)
#: Channel -> (part of a published name, unit shown, factor).
MOTIONS = {
    "axial_displacement": ("displacement", "mm", 1e3), "axial_velocity": ("velocity", "m/s", 1.0),
    "axial_acceleration": ("acceleration", "km/s²", 1e-3),
}  # fmt: skip
_NODES = {1: theme.SERIES[4], 2: theme.SERIES[0]}


def blocks(study: Study) -> tuple[Block, ...]:
    """Nothing for any other case, nor where the run is not that of the source: changed values,
    other speeds or models.
    """
    if study.record.study != STUDY or study.lift_event is None or not covered_by_source(study):
        return ()

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        speed = speed_text(engine_speed)
        found = figure_or_gap(
            f"Force by stages at {speed}", force_chart, study, runs, engine_speed, f"{key}-force"
        )
        found += figure_or_gap(
            f"Stage III at {speed}", spike_chart, study, runs, engine_speed, f"{key}-spikes"
        )
        for place, run in enumerate(runs, start=1):
            found += figure_or_gap(
                f"Nodes at {speed}", node_chart, study, run, f"{key}-nodes-{place}"
            )
        return found

    return by_speed(study, "gu2021", at)


def event_degrees(study: Study) -> tuple[float, float]:
    """Start and end of the lift event in cam degrees (zeros without one)."""
    event = study.lift_event
    return (
        (0.0, 0.0)
        if event is None
        else (float(np.degrees(event.start)), float(np.degrees(event.end)))
    )


def stage_bands(study: Study, worded: bool = True) -> tuple[Band, ...]:
    """The source's three stages; the second is the lift event."""
    edges = (0.0, *event_degrees(study), 360.0)
    names = ("Stage I", "Stage II", "Stage III")
    return tuple(
        Band(edges[n], edges[n + 1], names[n] if worded else "", shaded=n == 1) for n in range(3)
    )


def published_forces(study: Study, engine_speed: float) -> list[tuple[PublishedValue, float]]:
    """Published forces with their cam angle (deg): their own, else the one that another origin
    prints for the same quantity.
    """
    values = [
        value for value in study.record.published if same_speed(value.engine_speed, engine_speed)
    ]
    angles = {
        (value.model, value.quantity): value.value
        for value in values
        if value.quantity.endswith("_cam_angle")
    }
    found = []
    for value in values:
        if value.quantity.startswith("stage_") and value.quantity.endswith("_force"):
            angle_ = value.quantity.removesuffix("_force") + "_cam_angle"
            whose = [value.model, *(model for model, name in angles if name == angle_)]
            angle = next(
                (
                    float(np.degrees(angles[model, angle_]))
                    for model in whose
                    if (model, angle_) in angles
                ),
                None,
            )
            if value.quantity == "stage_2_end_force":
                angle = event_degrees(study)[1]
            if angle is not None:
                found.append((value, angle))
    return found


def _marks(found: list[tuple[PublishedValue, float]], factor: float = 1.0) -> list[Layer]:
    marks: list[Layer] = []
    for origin in dict.fromkeys(value.model for value, _ in found):
        mine = [(value, angle) for value, angle in found if value.model == origin]
        sign, label, colour, symbol = theme.origin_style(origin)
        labels = tuple(f"{sign} {number(value.value * factor)}" for value, _ in mine)
        x, y = (
            np.array([angle for _, angle in mine]),
            np.array([value.value * factor for value, _ in mine]),
        )
        marks.append(Marks(x, y, label, colour, symbol, labels))
    return marks


def _last(lines: list[Line]) -> list[Line]:
    """The reference model is drawn last, on top of the simpler ones."""
    return sorted(lines, key=lambda line: line.colour == theme.model_colour("finite-element"))


def force_chart(study: Study, runs: list[Solution], engine_speed: float, key: str) -> Chart | None:
    """Force on the lower seat (N) of every model over one cam cycle with the published values."""
    known, lines = line_styles(study), []
    for run in runs:
        found = over_angle(run, "seat_force")
        if found is not None:
            lines.append(
                Line(
                    *thin(*found),
                    known[run.label].label,
                    known[run.label].colour,
                    1.6,
                    known[run.label].dash,
                )
            )
    if not lines:
        return None
    layers: tuple[Layer, ...] = (*_last(lines), *_marks(published_forces(study, engine_speed)))
    panel = Panel(
        ANGLE_LABEL,
        "force on the lower seat (N)",
        layers,
        bands=stage_bands(study),
        x_range=(0, 360),
        x_step=30,
    )
    caption = "Stages of the source; open marks are its values: FE solid finite elements, AN analytical modal model, EX engine head test."
    return Chart(
        key, f"Force by stages at {speed_text(engine_speed)}", caption, (panel,), height=430
    )


def spike_series(study: Study, run: Solution) -> tuple[Array, Array, Array] | None:
    """Cam angle (deg), force as finely as the run holds it and below 10 kHz (N; nan where samples
    are too few), about the event's end.
    """
    if not run.has("seat_force") or study.lift_event is None:
        return None
    end, cycle = event_degrees(study)[1], reported_cycle(run)
    turn = run.cam_angle[cycle.samples][0] - cycle.cam_angle[0]
    _, angle, values = fine_series(run)
    smooth = fine_filtered(run, SPIKE_BANDWIDTH) if run.has("coil_contact_force") else None
    degrees = np.degrees(angle - turn)
    near = (degrees >= end - SPIKE_REACH[0] - 1e-9) & (
        degrees <= min(end + SPIKE_REACH[1], 360.0) + 1e-9
    )
    return (
        degrees[near],
        values[near],
        np.full(int(near.sum()), np.nan) if smooth is None else smooth[near],
    )


def spike_chart(study: Study, runs: list[Solution], engine_speed: float, key: str) -> Chart | None:
    """The same force close up after the event, raw and below 10 kHz (N)."""
    known, lines = line_styles(study), []
    for run in runs:
        found, look = spike_series(study, run), known[run.label]
        if found is not None and len(found[0]):
            lines.append(Line(*thin(found[0], found[1]), look.label, look.colour, 1.4))
            if np.any(np.isfinite(found[2])):
                # Darker than the raw line, so that the two part where they coincide.
                dark = theme.mix(look.colour, theme.INK, 0.75)
                lines.append(
                    Line(
                        *thin(found[0], found[2]), f"{look.label}, below 10 kHz", dark, 1.4, "dash"
                    )
                )
    if not lines:
        return None
    end = event_degrees(study)[1]
    layers: tuple[Layer, ...] = (*_last(lines), *_marks(published_forces(study, engine_speed)))
    reach = (end - SPIKE_REACH[0], min(end + SPIKE_REACH[1], 360.0))
    panel = Panel(ANGLE_LABEL, "force on the lower seat (N)", layers, x_range=reach, x_step=10)
    caption = (
        "A spike's height depends on the bandwidth it is seen in. Dashed: through a zero-phase low pass, 6 dB down at 10 kHz; solid: every "
        "instant recorded."
    )
    return Chart(key, f"Stage III at {speed_text(engine_speed)}", caption, (panel,), height=380)


def node_chart(study: Study, run: Solution, key: str) -> Chart | None:
    """Motion of the wire at the ends of coils 1 and 2, published extremes marked; None for a run
    without wire points.
    """
    cycle = reported_cycle(run)
    panels: list[Panel] = []
    angle, coils = (
        np.degrees(cycle.cam_angle),
        {
            int(name[-1]): coil
            for name, coil in {
                **registry.find("sources", STUDY).points,
                **dict(study.record.points),
            }.items()
        },
    )
    for channel, (word, unit, factor) in MOTIONS.items():
        layers: list[Layer] = []
        for node, colour in _NODES.items():
            values = cycle.at_coil(channel, coils[node])
            # In the source the displacement of node 2 counts from where coil 2 touches coil 1.
            gap = (
                cycle.at_coil("coil_gap", coils[2])
                if (channel, node) == ("axial_displacement", 2)
                else None
            )
            values = gap if gap is not None and np.all(np.isfinite(gap)) else values
            if values is not None:
                place = f"end of coil {node}" if coils[node] == node else f"coil {coils[node]:g}"
                layers.append(
                    Line(*thin(angle, values * factor), f"node {node} ({place})", colour, width=1.3)
                )
        if layers:
            layers += _marks(_published_motion(study, run.engine_speed, word), factor)
            bands = stage_bands(study, worded=not panels)
            panels.append(
                Panel(
                    ANGLE_LABEL,
                    f"{word} ({unit})",
                    tuple(layers),
                    bands=bands,
                    x_range=(0, 360),
                    x_step=30,
                )
            )
    title = f"Nodes 1 and 2: {line_styles(study)[run.label].label}, {speed_text(run.engine_speed)}"
    caption = "Axial motion, seat to retainer positive. Node 2 counts from where coil 2 touches coil 1, node 1 from the installed state."
    return Chart(key, title, caption, tuple(panels), height=720) if panels else None


def _published_motion(
    study: Study, engine_speed: float, word: str
) -> list[tuple[PublishedValue, float]]:
    values = {
        (value.model, value.quantity): value
        for value in study.record.published
        if same_speed(value.engine_speed, engine_speed)
    }
    found = []
    for (model, name), value in values.items():
        angle = values.get((model, f"{name}_cam_angle"))
        if angle is not None and name.startswith("node_") and name.endswith(f"_{word}"):
            found.append((value, float(np.degrees(angle.value))))
    return found


SPEC = SectionSpec("gu2021", "Stages and nodes of the source", blocks)
