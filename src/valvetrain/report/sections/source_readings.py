"""Figures of a case that re-runs a published study: the force by the study's windows with its values, the
force close up after the lift event, and the motion of its points on the wire.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from valvetrain import registry
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.forces import within_cycle
from valvetrain.quantities.signal import fine_filtered, fine_series, window_bounds
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Marks, Panel, thin
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.run_charts import (
    ANGLE_LABEL,
    by_speed,
    covered_by_source,
    line_styles,
    over_angle,
    unit_of_channel,
)
from valvetrain.report.text import number, speed_text
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.sources.contract import SourceStudy
from valvetrain.sources.readings import angle_of

FORCE_LABEL = "force on the lower seat (N)"
#: Cut-off (Hz) of the dashed lines close up, which reach from before to after the end of the event (cam deg).
BANDWIDTH, REACH = 10e3, (-8.0, 87.0)


def blocks(study: Study) -> tuple[Block, ...]:
    """Nothing for a case of one's own, for a study without windows, and where its values are not compared."""
    if not study.record.study or study.lift_event is None or not covered_by_source(study):
        return ()
    source: SourceStudy = registry.find("sources", study.record.study)

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        title = f"Force by windows at {speed_text(engine_speed)}"
        close = f"After the lift event at {speed_text(engine_speed)}"
        found = figure_or_gap(title, force_chart, study, source, runs, f"{key}-force")
        found += figure_or_gap(close, close_up, study, source, runs, f"{key}-spikes")
        for place, run in enumerate(runs, start=1):
            name = f"{key}-points-{place}"
            found += figure_or_gap("Points on the wire", point_chart, study, source, run, name)
        return found

    return by_speed(study, "source", at) if source.windows else ()


def window_bands(study: Study, source: SourceStudy) -> tuple[Band, ...]:
    """The windows of the study about the lift event, by its names; the event is shaded."""
    assert study.lift_event is not None
    bounds = {word: np.degrees(window_bounds(study.lift_event, word)) for word in source.windows}
    return tuple(
        Band(float(first), float(last), source.windows[word], shaded=word == "event")
        for word, (first, last) in bounds.items()
    )


def marks(
    study: Study, engine_speed: float, names: Collection[str], factor: float = 1.0
) -> list[Layer]:
    """The published values of ``names`` at one engine speed, at the cam angle that their origin, else another
    one, prints; a value without any angle is not drawn.
    """
    values = [one for one in study.record.published if same_speed(one.engine_speed, engine_speed)]
    printed = {(one.model, one.quantity): one.value for one in values}
    found: list[Layer] = []
    for origin in dict.fromkeys(one.model for one in values):
        sign, label, colour, symbol = theme.origin_style(origin)
        x, y = [], []
        for one in values:
            angle = angle_of(one.quantity)
            other = next((value for (_, name), value in printed.items() if name == angle), None)
            place = printed.get((origin, angle), other)
            if one.model == origin and one.quantity in names and place is not None:
                x.append(float(np.degrees(place)))
                y.append(factor * one.value)
        if x:
            labels = tuple(f"{sign} {number(value)}" for value in y)
            found.append(Marks(np.array(x), np.array(y), label, colour, symbol, labels))
    return found


def force_names(source: SourceStudy) -> set[str]:
    """Quantities that the study reads from the seat force."""
    return {
        name for one in source.readings if "seat_force" in one.channel and not one.point
        for name in one.names
    }  # fmt: skip


def force_chart(study: Study, source: SourceStudy, runs: list[Solution], key: str) -> Chart | None:
    """Force on the lower seat (N) of every model over one cam cycle with the published values."""
    styles, lines = line_styles(study), list[Layer]()
    for run in runs:
        look, found = styles[run.label], over_angle(run, "seat_force")
        if found is not None:
            lines.append(Line(*thin(*found), look.label, look.colour, 1.6, look.dash))
    if not lines:
        return None
    speed, bands = runs[0].engine_speed, window_bands(study, source)
    layers = (*lines, *marks(study, speed, force_names(source)))
    panel = Panel(ANGLE_LABEL, FORCE_LABEL, layers, bands=bands, x_range=(0, 360), x_step=30)
    caption = "Windows of the source; open marks are its values."
    return Chart(key, f"Force by windows at {speed_text(speed)}", caption, (panel,), height=430)


def close_up(study: Study, source: SourceStudy, runs: list[Solution], key: str) -> Chart | None:
    """The same force after the event, at every instant recorded and below 10 kHz (N)."""
    assert study.lift_event is not None
    styles, lines = line_styles(study), list[Layer]()
    end = float(np.degrees(study.lift_event.end))
    reach = (end + REACH[0], min(end + REACH[1], 360.0))
    for run in runs if all(one.has("seat_force") for one in runs) else ():
        look, (_, angle, values) = styles[run.label], fine_series(run)
        _, begin = within_cycle(reported_cycle(run), angle)
        degrees = np.degrees(angle - begin)
        near = (degrees >= reach[0] - 1e-9) & (degrees <= reach[1] + 1e-9)
        lines.append(Line(*thin(degrees[near], values[near]), look.label, look.colour, 1.4))
        smooth = fine_filtered(run, BANDWIDTH) if run.has("coil_contact_force") else None
        if smooth is not None:
            # darker than the raw line, so that the two part where they coincide
            dark, name = theme.mix(look.colour, theme.INK, 0.75), f"{look.label}, below 10 kHz"
            lines.append(Line(*thin(degrees[near], smooth[near]), name, dark, 1.4, "dash"))
    if not lines:
        return None
    speed = runs[0].engine_speed
    layers = (*lines, *marks(study, speed, force_names(source)))
    panel = Panel(ANGLE_LABEL, FORCE_LABEL, layers, x_range=reach, x_step=10)
    caption = "A spike's height depends on its bandwidth. Dashed: zero-phase low pass, 6 dB down at 10 kHz."
    title = f"After the lift event at {speed_text(speed)}"
    return Chart(key, title, caption, (panel,), height=380)


def point_chart(study: Study, source: SourceStudy, run: Solution, key: str) -> Chart | None:
    """What the study reads at its points on the wire, with its values; None for a run without such points."""
    cycle, panels = reported_cycle(run), list[Panel]()
    coils = {**source.points, **dict(study.record.points)}
    for channel in dict.fromkeys(one.channel for one in source.readings if one.point):
        mine = [one for one in source.readings if one.point and one.channel == channel]
        unit, factor = unit_of_channel(run, channel[0]) if run.has(channel[0]) else ("", 1.0)
        layers: list[Layer] = []
        for place, point in enumerate(dict.fromkeys(one.point for one in mine)):
            values = cycle.at_coil(channel[0], coils[point])
            if values is not None and np.all(np.isfinite(values)):
                line, name = factor * values, f"{point.replace('_', ' ')} (coil {coils[point]:g})"
                x, y = thin(np.degrees(cycle.cam_angle), line)
                layers.append(Line(x, y, name, theme.SERIES[place], width=1.3))
        if layers:
            names = {name for one in mine for name in one.names}
            layers += marks(study, run.engine_speed, names, factor)
            label, bands = f"{channel[0].replace('_', ' ')} ({unit})", window_bands(study, source)
            panel = Panel(
                ANGLE_LABEL, label, tuple(layers), bands=bands, x_range=(0, 360), x_step=30
            )
            panels.append(panel)
    who = f"{line_styles(study)[run.label].label}, {speed_text(run.engine_speed)}"
    caption = "Axial motion, seat to retainer positive."
    title = f"Points on the wire: {who}"
    return Chart(key, title, caption, tuple(panels), height=720) if panels else None


SPEC = SectionSpec("source-readings", "Windows and points of the source", blocks)
