"""Common parts of figures: line style of a label, channels over the cam angle, panels by engine
speed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.forces import within_cycle
from valvetrain.quantities.signal import extreme_series
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Panel, Rule, thin
from valvetrain.report.page import Block, Tabs
from valvetrain.report.text import speed_text
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

Array = NDArray[np.float64]
ANGLE_LABEL = "cam angle (cam degrees)"
#: SI unit of a channel -> unit shown and factor: those of all results, but a turning speed over the
#: cycle is that of a lever.
CHANNEL_UNITS = {**SHOWN_UNITS, "rad/s": ("deg/s", 180 / np.pi), "m/s2": ("m/s²", 1.0)}
STATIC_LABEL = "at rest, same lift"
#: Lines in one panel before it is parted.
MAX_LINES = 4


@dataclass(frozen=True, slots=True)
class LineStyle:
    """Colour, dash and label of the lines of one label of a study."""

    colour: str
    dash: str
    label: str


def covered_by_source(study: Study) -> bool:
    """Whether statements of the case's source apply to these runs: always for a case of one's own,
    else where values were compared.
    """
    return not study.record.study or bool(study.comparisons or study.findings)


def line_styles(study: Study) -> dict[str, LineStyle]:
    """Label -> line style: colour by model where each label has a colour of its own, else by label;
    dash by spring set.
    """
    first = {
        label: next(run for run in study.solutions if run.label == label) for label in study.labels
    }
    sets = list(dict.fromkeys(run.spring_set for run in first.values()))
    dashes = ("solid", "dashdot", "dot")
    found = {
        label: LineStyle(
            theme.model_colour(run.model),
            dashes[sets.index(run.spring_set) % 3],
            _label(label, run),
        )
        for label, run in first.items()
    }
    if (
        study.command != "compare-springs"
        and len({look.colour for look in found.values()}) == len(found)
        and (len(found) > 1 or (all((label == run.model for label, run in first.items()))))
    ):
        return found
    plain = study.command == "compare-springs"
    return {
        label: LineStyle(
            theme.SERIES[n % len(theme.SERIES)],
            "solid" if plain else found[label].dash,
            _label(label, run),
        )
        for n, (label, run) in enumerate(first.items())
    }


def _label(label: str, run: Solution) -> str:
    return theme.model_label(label) if label == run.model else label


def with_between(study: Study, label: str, name: str) -> tuple[Array, Array]:
    """A quantity of a label over engine speed (rad/s), SI; that of the runs between the swept speeds too, which the
    verdict is of.
    """
    speeds, values = study.series(label, name)
    known = dict(zip(speeds.tolist(), values.tolist(), strict=True))
    for run in study.between:
        if run.label == label:
            known.setdefault(run.engine_speed, run.quantities.get(name, np.nan))
    ordered = sorted(known)
    return np.array(ordered), np.array([known[one] for one in ordered], dtype=float)


def set_and_model(study: Study, label: str, in_prose: bool = False) -> str:
    """A label with the spring model, as pages call it ``in_prose``, where it is the name of a spring set alone."""
    run = next((one for one in study.solutions if one.label == label), None)
    if run is None or label != run.spring_set:
        return label
    return f"{label}, {theme.model_label(run.model) if in_prose else run.model}"


def drawable(run: Solution) -> bool:
    """Whether a run has channels with enough samples to draw."""
    return bool(run.arrays.variables) and len(run.time) > 4


def runs_at(study: Study, engine_speed: float) -> list[Solution]:
    """Runs that can be drawn at one engine speed (rad/s)."""
    return [
        run
        for run in study.solutions
        if same_speed(run.engine_speed, engine_speed) and drawable(run)
    ]


def over_angle(run: Solution, channel: str) -> tuple[Array, Array] | None:
    """Cam angle (deg, from 0) and a channel (SI) over the reported cycle; None where the run has no
    such channel.
    """
    if not drawable(run) or not run.has(channel):
        return None
    cycle = reported_cycle(run)
    return np.degrees(cycle.cam_angle), cycle.channel(channel)


def with_extremes(run: Solution, channel: str) -> tuple[Array, Array] | None:
    """:func:`over_angle` with the highest and lowest value of every step between the samples, of forces
    of which the run has them: those are what its peak and minimum are.
    """
    found = over_angle(run, channel)
    if found is None or not run.has(f"{channel}_highest"):
        return found
    angles, values, cycle = [np.radians(found[0])], [found[1]], reported_cycle(run)
    for kind in ("highest", "lowest"):
        angle, extreme = extreme_series(run, channel, kind)
        mine, begin = within_cycle(cycle, angle)
        angles.append(angle[mine] - begin)
        values.append(extreme[mine])
    order = np.argsort(angle := np.concatenate(angles), kind="stable")
    return np.degrees(angle[order]), np.concatenate(values)[order]


def unit_of_channel(run: Solution, channel: str) -> tuple[str, float]:
    """Unit in which a channel is shown, and the factor from SI."""
    unit = run.unit(channel)
    return CHANNEL_UNITS.get(unit, (unit, 1.0))


def event_bands(study: Study) -> tuple[Band, ...]:
    """The main lift event, shaded."""
    event = study.lift_event
    return (
        ()
        if event is None
        else (Band(float(np.degrees(event.start)), float(np.degrees(event.end)), "lift event"),)
    )


def angle_panels(
    study: Study,
    runs: Sequence[Solution],
    channel: str,
    name: str,
    title: str = "",
    still: str = "",
    static_label: str = STATIC_LABEL,
) -> list[Panel]:
    """A channel over the cam angle, one line per run, at most :data:`MAX_LINES` a panel; ``still``:
    a channel next to it, dashed, once.
    """
    known, panels, label = line_styles(study), [], name
    shown = [(run, *found) for run in runs if (found := with_extremes(run, channel)) is not None]
    for start in range(0, len(shown), MAX_LINES):
        layers: list[Layer] = []
        part = shown[start : start + MAX_LINES]
        for run, angle, values in part:
            unit, factor = unit_of_channel(run, channel)
            label, look = f"{name} ({unit})" if unit else name, known[run.label]
            layers.append(
                Line(*thin(angle, values * factor), look.label, look.colour, 1.5, look.dash)
            )
        reference = next(
            (run for run, _, _ in part if still and over_angle(run, still) is not None), None
        )
        slow = None if reference is None else over_angle(reference, still)
        if reference is not None and slow is not None:
            x, y = thin(slow[0], slow[1] * unit_of_channel(reference, still)[1])
            layers.insert(0, Line(x, y, static_label, theme.MUTED, 1.2, "dash"))
        panels.append(
            Panel(
                ANGLE_LABEL,
                label,
                tuple(layers),
                title,
                event_bands(study),
                x_range=(0, 360),
                x_step=30,
            )
        )
    return panels


def from_zero(panel: Panel) -> Panel:
    """A panel of contact force, whose axis begins at the loss of contact."""
    every = np.concatenate([np.asarray(one.y, dtype=float) for one in panel.layers])
    low, high = min(float(np.nanmin(every)), 0.0), max(float(np.nanmax(every)), 1.0)
    room = 0.07 * (high - low)
    # on the base circle no contact is lost, so the line has no name
    rules = (*panel.rules, Rule("y", 0.0))
    return replace(panel, rules=rules, y_range=(low - room, high + room))


def panels_chart(
    key: str, title: str, caption: str, panels: Sequence[Panel], height: int = 240
) -> Chart | None:
    """Panels one above the other, or in two columns where there are more than three; None without
    panels.
    """
    if not panels:
        return None
    columns = 1 if len(panels) <= 3 else 2
    rows = -(-len(panels) // columns)
    return Chart(
        key,
        title,
        caption,
        tuple(panels),
        columns,
        height * rows + 70,
        any(len(panel.layers) > 1 for panel in panels),
    )


def by_speed(
    study: Study, key: str, blocks_at: Callable[[float, list[Solution], str], tuple[Block, ...]]
) -> tuple[Block, ...]:
    """Blocks of each engine speed, behind tabs where there are several; ``blocks_at`` takes speed,
    its runs and a part of a key.
    """
    items = []
    for place, engine_speed in enumerate(study.engine_speeds):
        runs = runs_at(study, engine_speed)
        blocks = blocks_at(engine_speed, runs, f"{key}-{place + 1}") if runs else ()
        if blocks:
            items.append((speed_text(engine_speed), blocks))
    return (items[0][1] if items else ()) if len(items) < 2 else (Tabs(tuple(items), key),)


def bars(x: Array, y: Array, place: int, count: int) -> tuple[Array, Array]:
    """Strokes at ``x`` moved aside, so that those of ``count`` series are side by side; see
    :func:`valvetrain.report.chart.stems`.
    """
    from valvetrain.report.chart import stems

    return stems(np.asarray(x, dtype=float) + 0.7 * ((place + 0.5) / count - 0.5), y)
