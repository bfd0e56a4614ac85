"""Figures over engine speed: where control is kept and what is lost, forces, cam orders of surge."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.engine import Mark
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_measured import LIMITED, limit_of
from valvetrain.findings.rules_sweep import stress_of
from valvetrain.findings.words import NOTHING, RPM
from valvetrain.solution.critical import NARROW
from valvetrain.solution.result import Solution
from valvetrain.units import to_unit
from valvetrain.units.reader import shown_system
from valvetrain.views.style import (
    BAD,
    LEAD,
    OK,
    SECOND,
    SPEEDS,
    FigureSpec,
    dots,
    line,
    panels,
    red_line,
    styled,
)

#: Kind of critical speed -> what is said of its bar, its colour, and the finding that explains it.
LOST = {
    "contact-loss": ("off the cam", BAD, "W121"),
    "float": ("floats", "#8c2d6b", "W122"),
    "bounce": ("bounces", "#d08a00", "W123"),
}
HELD, SILENT = "in control", "#8a8f98"
#: Cam orders of the map, from the first that a valve spring answers to.
ORDERS = range(3, 31)
Spans = list[tuple[float, float]]


@dataclass(frozen=True)
class Bar:
    """Ranges of engine speed (rad/s) over which one thing holds: ``word``, ``mark``, ``colour``, and the ``code`` of the
    finding that says why.
    """

    word: str
    spans: Spans
    mark: Mark
    colour: str
    code: str = ""


def reach(facts: Facts) -> tuple[float, float]:
    """Lowest and highest engine speed (rad/s) of a study over speed."""
    speeds = facts.study.engine_speeds
    return (speeds[0], speeds[-1]) if speeds else (math.nan, math.nan)


def bars(facts: Facts) -> list[Bar]:
    """What bars of control show: of one label where it is in control and each loss, of several where each is in control.

    Parameters
    ----------
    facts : of a study over engine speed

    Returns
    -------
    A bar for each, from the top; none where nothing was searched
    """
    if facts.run_up and len(facts.study.engine_speeds) > 1:
        return _of_revolutions(facts)
    if not (facts.searched and facts.train):
        return []
    first, last = reach(facts)
    if len(facts.lead_labels) > 1:
        names = names_of(facts).items()
        return [Bar(name, _free(facts, label, first, last), "ok", OK) for label, name in names]
    label = facts.first_label
    found = [Bar(HELD, _free(facts, label, first, last), "ok", OK)]
    for kind, (word, colour, code) in LOST.items():
        spans = _within(facts, label, kind, first, last)
        found.append(Bar(word, spans, "bad" if kind == "contact-loss" else "warn", colour, code))
    found.append(Bar("not known", _unknown(facts, label), "warn", SILENT, "W114"))
    found.append(Bar("either", _either(facts, label), "warn", SILENT, "W112"))
    return [one for one in found if one.spans or one.word == HELD]


def names_of(facts: Facts) -> dict[str, str]:
    """Labels of the runs that decide -> their spring sets, where these tell them apart."""
    sets = {run.label: run.spring_set or run.label for run in (*facts.runs, *facts.beyond)}
    return sets if len(set(sets.values())) == len(sets) else {one: one for one in sets}


def _within(facts: Facts, label: str, kind: str, first: float, last: float) -> Spans:
    spans = facts.control(label).spans(kind)
    return [
        (max(one.lower_engine_speed, first), min(one.upper_engine_speed, last)) for one in spans
    ]


def _either(facts: Facts, label: str) -> Spans:
    """Where control is kept by the motion of a rising speed and lost by that of a falling one."""
    contact = facts.control(label).contact
    both = None if contact is None else contact.both_motions
    return [] if both is None else [both]


def _unknown(facts: Facts, label: str) -> Spans:
    """Where runs say nothing of control, up to a loss that begins at the next speed that was run."""
    control, found = facts.control(label), Spans()
    for one in control.unknown:
        end = one.upper_engine_speed
        begins = (loss.begin for loss in control.losses if end <= loss.begin <= (1 + NARROW) * end)
        found.append((one.lower_engine_speed, min(begins, default=end)))
    return found


def _free(facts: Facts, label: str, first: float, last: float) -> Spans:
    """What no loss takes of the speeds searched, by the only motion that there is."""
    spans = (span for kind in LOST for span in _within(facts, label, kind, first, last))
    lost = sorted((*spans, *_unknown(facts, label), *_either(facts, label)))
    found, edge = Spans(), first
    for low, high in lost:
        if low > edge:
            found.append((edge, low))
        edge = max(edge, high)
    return [*found, (edge, last)] if edge < last else found


def _of_revolutions(facts: Facts) -> list[Bar]:
    """In control and off the cam by the revolutions of a run-up of the label that loses the cam first."""
    lead = next(
        (run.label for run in facts.runs if facts.value(run, "loft_gap") > 0), facts.runs[-1].label
    )
    runs = [run for run in (*facts.runs, *facts.beyond) if run.label == lead]
    speeds = np.array([run.engine_speed for run in runs])
    edges = np.concatenate((speeds[:1], (speeds[1:] + speeds[:-1]) / 2, speeds[-1:]))
    spans: dict[bool, Spans] = {False: [], True: []}
    for place, run in enumerate(runs):
        spans[facts.value(run, "loft_gap") > 0].append(
            (float(edges[place]), float(edges[place + 1]))
        )
    made = (Bar(HELD, spans[False], "ok", OK), Bar("off the cam", spans[True], "bad", BAD))
    return [one for one in made if one.spans]


def speeds(facts: Facts) -> go.Figure | None:
    """Bars of control over engine speed, with the least force on the cam and surge below."""
    shown = bars(facts)
    if not shown:
        return None
    fig = panels((0.12 + 0.06 * len(shown), 0.88 - 0.06 * len(shown)))
    first, last = (one / RPM for one in reach(facts))
    for bar in reversed(shown):
        low = [begin / RPM for begin, _ in bar.spans] or [first]
        width = [(end - begin) / RPM for begin, end in bar.spans] or [0.0]
        ends = [begin + size for begin, size in zip(low, width, strict=True)]
        fig.add_trace(go.Bar(
            y=[bar.word] * len(low), x=width, base=low, orientation="h", marker_color=bar.colour, width=0.62, showlegend=False,
            customdata=ends, hovertemplate="%{base:.0f} to %{customdata:.0f} rpm<extra></extra>",
        ), 1, 1)  # fmt: skip
    several = len(facts.lead_labels) > 1
    sets = names_of(facts)
    for label, colour in zip(facts.lead_labels, SPEEDS * len(facts.lead_labels), strict=False):
        whose = f", {sets[label]}" if several else ""
        other, dash = (colour, "dot") if several else (SECOND, "solid")
        for name, word, shade, style in (
            ("minimum_cam_contact_force", f"least on the cam{whose}", colour, "solid"),
            ("surge_amplitude_force", f"surge, 0 to peak{whose}", other, dash),
        ):
            fig.add_trace(_curve(facts, label, name, word, shade, style), 2, 1)
    red_line(fig, facts.red_line / RPM)
    styled(fig, "engine speed, rpm", ("", "N"), 430)
    fig.update_layout(
        barmode="overlay", hovermode="closest", margin={"l": 92, "b": 84},
        legend={"orientation": "h", "y": -0.2, "yanchor": "top", "x": 0},
    )  # fmt: skip
    fig.update_yaxes(rangemode="tozero", row=2, col=1)
    fig.update_yaxes(gridcolor="rgba(0,0,0,0)", automargin=True, row=1, col=1)
    return fig.update_xaxes(range=[first, last], tickformat="d")


def _curve(
    facts: Facts, label: str, name: str, word: str, colour: str, dash: str = "solid"
) -> go.Scatter:
    """A quantity of a label over engine speed (rpm), of all runs of a search where it kept it, else with a mark for each."""
    place = {"minimum_cam_contact_force": 1, "surge_amplitude_force": 2}.get(name, 0)
    if place and (curve := facts.curve(label)):
        return line(
            [one[0] / RPM for one in curve], [one[place] for one in curve], word, colour, dash
        )
    runs = facts.of_label(label)
    values = [facts.value(run, name) for run in runs]
    trace = line([run.engine_speed / RPM for run in runs], values, word, colour, dash)
    return trace.update(mode="lines+markers", marker={"size": 4})


def spin(facts: Facts) -> go.Figure | None:
    """Bounce and loft over engine speed as a spin rig shows them, with the limits of the case and what was measured."""
    test = facts.study.measured
    every = [run for label in facts.lead_labels for run in facts.of_label(label)]
    names = {
        name: word
        for name, (word, _) in LIMITED.items()
        if (test and name in test.values) or any(facts.value(run, name) > 0 for run in every)
    }
    if not (facts.train and names and len(facts.study.engine_speeds) > 1):
        return None
    unit = "mm" if shown_system() == "si" else "thou"
    fig, several = panels((1.0,) * len(names)), len(facts.lead_labels) > 1
    for row, (name, word) in enumerate(names.items(), start=1):
        for label, colour in zip(facts.lead_labels, SPEEDS * len(facts.lead_labels), strict=False):
            curve = _curve(facts, label, name, f"{word}{f', {label}' if several else ''}", colour)
            fig.add_trace(
                curve.update(y=to_unit(curve.y, unit), showlegend=row == 1 or not several), row, 1
            )
        if test and name in test.values:
            at = np.array(test.engine_speeds) / RPM
            fig.add_trace(
                dots(
                    at,
                    to_unit(np.array(test.values[name]), unit),
                    f"{word}, {test.source or 'test'}",
                    BAD,
                ).update(marker_size=7),
                row,
                1,
            )
        if math.isfinite(limit := limit_of(facts, name)):
            fig.add_hline(
                to_unit(limit, unit),
                line={"color": BAD, "width": 1.2, "dash": "dot"},
                row=row,
                col=1,
            )
    red_line(fig, facts.red_line / RPM)
    styled(
        fig,
        "engine speed, rpm",
        tuple(f"{word}, {unit}" for word in names.values()),
        200 + 130 * len(names),
    )
    return fig.update_yaxes(rangemode="tozero").update_xaxes(tickformat="d")


def forces(facts: Facts) -> go.Figure | None:
    """Largest and least force on the retainer over engine speed, of springs alone."""
    if facts.train:
        return None
    return _ends(facts, "N", lambda run, end: facts.value(run, f"{end}_retainer_force"))


def stresses(facts: Facts) -> go.Figure | None:
    """Largest and least stress of the wire over engine speed."""
    return _ends(facts, "MPa", lambda run, end: stress_of(facts, run, f"{end}_shear_stress"))


def _ends(facts: Facts, unit: str, value: Callable[[Solution, str], float]) -> go.Figure | None:
    """Two curves of each label over engine speed, of a value (SI) by run and by end, ``peak`` or ``minimum``."""
    fig = go.Figure()
    for label, dash in zip(
        facts.study.labels, cycle(("solid", "dot", "dash", "dashdot")), strict=False
    ):
        runs = facts.of_label(label)
        at = [run.engine_speed / RPM for run in runs]
        for word, end, colour in (("largest", "peak", LEAD), ("least", "minimum", SECOND)):
            values = to_unit(np.array([value(run, end) for run in runs]), unit)
            if len(runs) > 1 and np.isfinite(values).any():
                trace = line(at, values, f"{word}, {label}", colour, dash)
                fig.add_trace(trace.update(mode="lines+markers", marker={"size": 4}))
    if not fig.data:
        return None
    red_line(fig, facts.red_line / RPM)
    return styled(fig, "engine speed, rpm", (unit,), 430).update_xaxes(tickformat="d")


def order_map(facts: Facts) -> go.Figure | None:
    """Amplitude (N) of each cam order of the spring force over engine speed, with the line of the surge frequency."""
    label = facts.first_label
    runs = [run for run in facts.of_label(label) if "surge_order_3_force" in run.quantities]
    if len(runs) < 3:
        return None
    at = [run.engine_speed / RPM for run in runs]
    sizes = np.array(
        [[run.quantities.get(f"surge_order_{one}_force", np.nan) for run in runs] for one in ORDERS]
    )
    if not np.nanmax(sizes) > NOTHING:
        return None
    fig = go.Figure(go.Heatmap(
        x=at, y=list(ORDERS), z=sizes.astype(np.float32), colorscale="Blues", colorbar={"title": "N", "thickness": 12},
        hovertemplate="%{x:.0f} rpm, order %{y}: %{z:.3~g}<extra></extra>",
    ))  # fmt: skip
    modes = sorted({facts.value(run, "surge_frequency") for run in runs})
    for frequency in modes[:1] if modes and math.isfinite(modes[0]) else ():
        fine = np.linspace(at[0], at[-1], 60)
        order = frequency * 120 / fine  # cam orders turn at half the speed of the crank
        fig.add_trace(line(fine, order, "surge frequency", BAD, "dash"))
    styled(fig, "engine speed, rpm", ("cam order",), 400)
    fig.update_layout(hovermode="closest")
    return fig.update_yaxes(range=[ORDERS[0] - 0.5, ORDERS[-1] + 0.5]).update_xaxes(
        range=[at[0], at[-1]], tickformat="d"
    )


SPEEDS_FIGURE = FigureSpec(
    "Where control is lost", "bars: ranges of engine speed; below: forces of every run", speeds
)
SPIN = FigureSpec("Bounce and loft over engine speed", "dotted: limits", spin)
FORCES = FigureSpec("Forces over engine speed", "below 10 kHz", forces)
STRESSES = FigureSpec(
    "Stress of the wire over engine speed",
    "shear, by the force on the seat where the wire is not computed",
    stresses,
)
ORDER_MAP = FigureSpec(
    "Cam orders of surge over engine speed", "dashed: the surge frequency of the spring", order_map
)
