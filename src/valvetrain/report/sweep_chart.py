"""The first picture of a sweep: least cam force and regimes over engine speed, or the forces and
the surge of a spring alone, with the speeds of the verdict marked.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.control import control_of, first_losses
from valvetrain.report.run_charts import MAX_LINES, Array, from_zero, line_styles, with_between
from valvetrain.report.sweep_verdict import runs_over_speed, surge_in_use, worst_label
from valvetrain.report.text import rpm
from valvetrain.solution.critical import CriticalSpeed
from valvetrain.solution.definition import label_of, shown
from valvetrain.solution.study import Study

#: Regimes from the top of the lower panel down: kind of critical speed ("" for none) -> label, colour.
REGIMES = {
    "": ("controlled", "#1c6b3c"),
    "contact-loss": ("contact loss", "#d9772b"),
    "float": ("float", "#b3261e"),
    "bounce": ("bounce", "#7a4fa0"),
}
#: Height of the panel of regimes next to that of the curves.
REGIMES_WEIGHT = 0.6
#: Words of the marks across the upper panel.
_MARKS = {"contact-loss": "contact", "float": "float", "bounce": "bounce"}


def regime_chart(study: Study) -> Chart | None:
    """Panels over engine speed; None where no run gives a force."""
    name = "minimum_cam_contact_force"
    train = any(name in run.quantities for run in study.solutions)
    label = worst_label(study)
    several = study.command == "compare-springs"
    marks = tuple(
        mark
        for one in (study.labels if several else (label,))
        for mark in _marks(study, one, train)
    )
    if study.record.red_line is not None and train:
        red_line = rpm(study.record.red_line)
        marks += (Rule("x", red_line, f"red line {red_line:.6g}"),)
    panels = [
        _curves(study, (name,) if train else ("peak_spring_force", "minimum_spring_force"), marks)
    ]
    found = [one for one in study.critical_speeds]
    if found:
        labels = [one for one in study.labels if any(row.label == one for row in found)]
        panels += [_regimes(study, one, len(labels) > 1) for one in labels[:MAX_LINES]]
    elif not train:
        bare = tuple(replace(one, label="") for one in marks)  # named in the panel above
        panels.append(_curves(study, ("surge_amplitude_force",), bare))
    if not panels[0].layers:
        return None
    if train:
        panels[0] = from_zero(panels[0])
    drawn = [panel for panel in panels if panel.layers]
    title = f"Least cam force{' and control' if found else ''} over engine speed"
    title = title if train else "Forces over engine speed"
    whose = f", those of {label}" if len(study.labels) > 1 and not several else ""
    caption = f" Dotted: the speeds of the verdict{whose}." if marks else ""
    if found:
        caption += (
            " Bars: speeds at which contact is lost, the valve floats or bounces; thin: where that begins with another "
            "damping of the springs, a finer mesh or half the time step. The curve holds the runs of that search too. Open marks: the motion "
            "did not settle."
        )
    rows = sum(panel.weight for panel in drawn)
    return Chart(
        "opening",
        title,
        caption.strip(),
        tuple(drawn),
        1,
        round((200 if rows < 2 else 165) * rows + 40 * len(drawn)),
        len(study.labels) > 1,
    )


def _marks(study: Study, label: str, train: bool) -> tuple[Rule, ...]:
    """The speeds of the verdict as lines across a panel, of two springs with the name of theirs."""
    name = f"{study.runs(label)[0].spring_set} " if study.command == "compare-springs" else ""
    marked = [
        (one.kind, one.engine_speed)
        for one in study.critical_speeds
        if one.label == label and one.found
    ]
    control = control_of(study, label)
    if control.islands:  # the loss that stays has a mark too
        stays = [one for one in control.losses if one.row is control.contact]
        marked += [("contact-loss", one.begin) for one in stays]
    rules = [
        Rule("x", rpm(speed), f"{name}{_MARKS[kind]} {rpm(speed):.0f}") for kind, speed in marked
    ]
    runs = runs_over_speed(study, label)
    if train and not study.critical_speeds:
        rules += [
            Rule("x", rpm(run.engine_speed), f"{name}{_MARKS[kind]} {rpm(run.engine_speed):.0f}")
            for kind, run in first_losses(runs).items()
        ]
    surge = surge_in_use(study, runs)
    if surge is not None:
        order = f", order {surge.order}" if surge.order else ""
        rules.append(Rule("x", rpm(surge.run.engine_speed), f"{name}surge{order}"))
    return tuple(rules)


def _curves(study: Study, names: tuple[str, ...], rules: tuple[Rule, ...]) -> Panel:
    """Quantities over engine speed, a line per label, the second and further ones dashed."""
    known, layers, unit = line_styles(study), list[Layer](), ""
    worst = worst_label(study)  # its speeds are marked, so its curve is among those drawn
    some = [worst, *(one for one in study.labels if one != worst)][:MAX_LINES]
    for label in (one for one in study.labels if one in some):
        for place, name in enumerate(names):
            speeds, found = _with_searched(study, label, name)
            values, unit = shown(name, found)
            if not np.any(np.isfinite(values)):
                continue
            x = np.array([rpm(one) for one in speeds])
            look = known[label]
            title = f"{look.label}, {label_of(name)}" if place else look.label
            dash = "dash" if place else look.dash
            layers.append(Line(x, values, title, look.colour, 1.8, dash, in_legend=not place))
            layers += _restless(study, label, x, values, f"{title}, not settled", look.colour)
    axis = (
        "minimum cam force while open" if names[0].startswith("minimum_cam") else label_of(names[0])
    )
    axis = "spring force: peak, dashed the minimum" if len(names) > 1 else axis
    return Panel(
        "engine speed (rpm)",
        f"{axis} ({unit})" if unit else axis,
        tuple(layers),
        rules=rules,
        x_range=_reach(study),
    )


def _with_searched(study: Study, label: str, name: str) -> tuple[Array, Array]:
    """A quantity over engine speed (rad/s), of the cam force with the runs of the search: where control is lost
    the curve has to show it.
    """
    speeds, values = with_between(study, label, name)
    row = study.critical_speeds.of("contact-loss", label)
    if row is None or not name.startswith("minimum_cam"):
        return speeds, values
    known = dict(row.curve) | dict(zip(speeds.tolist(), values.tolist(), strict=True))
    ordered = sorted(known)
    return np.array(ordered), np.array([known[one] for one in ordered])


def _restless(
    study: Study, label: str, x: Array, values: Array, name: str, colour: str
) -> list[Layer]:
    """Open marks where the motion of a swept speed did not settle."""
    restless = [rpm(run.engine_speed) for run in study.runs(label) if not run.status.completed]
    some = np.isin(x, restless) & np.isfinite(values)
    return (
        [Marks(x[some], values[some], name, colour, size=6, in_legend=False)] if some.any() else []
    )


def _reach(study: Study) -> tuple[float, float]:
    first, last = rpm(study.engine_speeds[0]), rpm(study.engine_speeds[-1])
    return (first, last) if last > first else (first - 100.0, last + 100.0)


def _regimes(study: Study, label: str, several: bool) -> Panel:
    """A bar per regime of a label over the speeds at which it holds, its name above it."""
    layers: list[Layer] = []
    first, last = _reach(study)
    rows = {kind: study.critical_speeds.of(kind, label) for kind in REGIMES}
    searched = {kind: row for kind, row in rows.items() if not kind or row is not None}
    labels = []
    for level, (kind, row) in enumerate(reversed(searched.items())):
        name, colour = REGIMES[kind]
        spans = _controlled(study, label) if row is None else _spans(row, last)
        labels.append((float(level), name if spans else f"no {name}"))
        x = np.array([value for low, high in spans for value in (low, high, math.nan)])
        y = np.where(np.isnan(x), np.nan, float(level))
        layers += [Line(x, y, name, colour, 7.0, in_legend=False)] if spans else []
        if row is not None and row.found and row.span is not None:
            low, high = rpm(row.span.lower_engine_speed), rpm(row.span.upper_engine_speed)
            ends = np.array([max(low, first), min(high, last)])
            name = f"{name}, range"
            layers.append(Line(ends, np.full(2, float(level)), name, colour, 2.0, in_legend=False))
    return Panel(
        "engine speed (rpm)",
        "",
        tuple(reversed(layers)),
        label if several else "",
        x_range=(first, last),
        y_range=(-0.35, len(searched) - 0.2),
        row_labels=tuple(labels),
        weight=REGIMES_WEIGHT,
    )


def _controlled(study: Study, label: str) -> list[tuple[float, float]]:
    """Speeds (rpm) at which a label is controlled, the short ranges of lost contact left out."""
    (first, last), control = _reach(study), control_of(study, label)
    gaps = [(rpm(one.lower_engine_speed), rpm(one.upper_engine_speed)) for one in control.islands]
    ends = [low for low, _ in gaps], [high for _, high in gaps]
    return list(zip([first, *ends[1]], [*ends[0], min(rpm(control.limit), last)], strict=True))


def _spans(row: CriticalSpeed, last: float) -> list[tuple[float, float]]:
    """Speeds (rpm) at which a kind of loss holds: the first range, then the further ones."""
    if not row.found:
        return []
    start = (
        row.first_engine_speed
        if row.begins is None and not math.isfinite(row.nominal_engine_speed)
        else row.engine_speed
    )
    end = last if row.ends is None else rpm(row.ends.from_rest.lower_engine_speed)
    further = [(rpm(one.lower_engine_speed), rpm(one.upper_engine_speed)) for one in row.again]
    return [(rpm(start), end), *further]
