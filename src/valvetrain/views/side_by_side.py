"""Spring models side by side: numbers of each, how far it is off the one that decides, and to which speed it is good."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import plotly.graph_objects as go

from valvetrain.findings.facts import Facts, over_turn, trust
from valvetrain.findings.rules_train import CONTACT
from valvetrain.findings.words import RPM, Words, digits_text, fields_of, speed_text
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.solution.result import Solution
from valvetrain.solution.uncertainty import Comparison
from valvetrain.springs.spec import spring_model
from valvetrain.units.reader import shown_system
from valvetrain.views.shown import ShownStudy
from valvetrain.views.style import (
    BAD,
    LEAD,
    OTHER,
    RIGID,
    SPEEDS,
    FigureSpec,
    angle_title,
    degrees,
    line,
    styled,
    window,
)
from valvetrain.views.table import TextTable

#: Share of the largest force up to which a model is good.
GOOD = 0.05
#: Heading -> template of a cell, of a train and of a spring alone.
CELLS = {
    True: {"on the cam": "{minimum_cam_contact_force..peak_cam_contact_force}", "off the cam": "[{loft_gap}]",
           "spring": "{minimum_spring_force..peak_spring_force}", "surge": "{surge_amplitude_force}"},
    False: {"on the retainer": "{minimum_retainer_force..peak_retainer_force}", "surge": "{surge_amplitude_force}",
            "coil on coil": "{surge_clash_peak_force}", "first mode": "{surge_frequency}"},
}  # fmt: skip
#: Forces by which a model is judged, of a train and of a spring alone.
JUDGED = {
    True: ("peak_cam_contact_force", CONTACT[0], "peak_spring_force"),
    False: ("peak_retainer_force", "minimum_retainer_force"),
}


def model_table(facts: Facts, words: Words) -> TextTable | None:
    """Every spring model of a comparison at the highest speed, the one that decides first.

    Parameters
    ----------
    facts : of a study
    words : units and language

    Returns
    -------
    The table; None of a study by one model
    """
    if not facts.models:
        return None
    brief, cells = replace(words, brief=True), CELLS[facts.train]
    several = len(facts.speeds) > 1
    rows = []
    for run in facts.models:
        texts = [
            brief.cell(
                text, {name: one for name in fields_of(text) if (one := facts.amount(run, name))}
            )
            for text in cells.values()
        ]
        lead = run is facts.models[0]
        off, judged = deviation(facts, run, facts.models[0]), ""
        if math.isfinite(off):
            judged = f"{'good' if off <= GOOD else 'poor'}, {max(100 * off, 0.1):.2g} % off"
        judged = "decides" if lead else judged
        good = [] if not several else ["" if lead else good_to(facts, run.model)]
        rows.append((run.model, *texts, judged, *good, spring_model(run.model).leaves_out))
    speed = speed_text(facts.speeds[-1])
    columns = (f"at {speed}", *cells, "forces", *(["good to"] if several else []), "leaves out")
    filled = [k for k in range(len(columns)) if any(row[k] for row in rows)]
    return TextTable(
        "Spring models",
        tuple(columns[k] for k in filled),
        tuple(tuple(row[k] for k in filled) for row in rows),
    )


def deviation(facts: Facts, run: Solution, lead: Solution) -> float:
    """Largest difference of the judged forces of two runs, as a share of the largest force of the one that decides; NaN
    where neither can be compared or the force that decides is not resolved.
    """
    names = JUDGED[facts.train]
    amounts = [(facts.amount(run, name), facts.amount(lead, name)) for name in names]
    pairs = [
        (one, other) for one, other in amounts if one and other and one.resolved and other.resolved
    ]
    most = max((abs(other.value) for _, other in pairs), default=0.0)
    return max(abs(one.value - other.value) for one, other in pairs) / most if most else math.nan


def good_to(facts: Facts, model: str) -> str:
    """The highest speed up to which a model is within :data:`GOOD` of the one that decides, at all lower ones too."""
    reached = ""
    for lead in sorted(facts.runs, key=lambda run: run.engine_speed):
        mine = [
            one
            for one in facts.others
            if one.model == model and math.isclose(one.engine_speed, lead.engine_speed)
        ]
        if not mine or not deviation(facts, mine[0], lead) <= GOOD:
            return reached or "no speed"
        reached = speed_text(lead.engine_speed)
    return reached


def models(facts: Facts) -> go.Figure | None:
    """Force on the cam, or on the retainer of a spring alone, over the cam angle by every model of a comparison."""
    name = "cam_contact_force" if facts.train else "retainer_force"
    least = CONTACT[0] if facts.train else "peak_retainer_force"
    runs = [run for run in facts.models if run.has(name, "valve_lift")]
    if len(runs) < 2:
        return None
    fig, lead = go.Figure(), runs[0]
    rigid = "rigid_contact_force" if facts.train else "static_retainer_force"
    if lead.has(rigid):
        word = "rigid parts" if facts.train else "at rest"
        fig.add_trace(line(degrees(lead), over_turn(lead, rigid), word, RIGID, "dash"))
    colours = (LEAD, *SPEEDS[1:], OTHER)
    words = Words(brief=True)
    for run, colour in sorted(zip(runs, colours * 2, strict=False), key=lambda one: trust(one[0])):
        amount = facts.amount(run, least)
        said = f", {'least' if facts.train else 'largest'} {words.amount(amount)}" if amount else ""
        width = 2.4 if run is lead else 1.4
        trace = line(degrees(run), over_turn(run, name), f"{run.model}{said}", colour)
        fig.add_trace(trace.update(line={"width": width}))
    if facts.train:
        fig.add_hline(0, line={"color": BAD, "width": 1})
    styled(
        fig,
        angle_title(facts, lead),
        ("on the cam, N" if facts.train else "on the retainer, N",),
        430,
    )
    fig.update_layout(
        legend={"orientation": "h", "y": -0.16, "yanchor": "top", "x": 0}, margin={"t": 12}
    )
    return fig.update_xaxes(range=window(lead))


MODELS = FigureSpec("What each model says", "click a name to hide its line", models)


#: Rows of a source that the first screen shows, and engine speeds that make it worth a table.
LEAST_ROWS, LEAST_SPEEDS = 3, 2
ROLES = {"calibration": "fitted", "check": "not fitted", "prediction": "predicted"}


def paper_table(comparisons: Sequence[Comparison]) -> TextTable | None:
    """Peak forces here, in the paper and by the case that was not fitted (``778/818/817``), by engine speed; of the paper's first
    method.

    Parameters
    ----------
    comparisons : those of a study

    Returns
    -------
    The table; None where the source prints fewer than three peak forces, or one engine speed
    """
    known = [
        row
        for row in comparisons
        if row.quantity.endswith("peak_force") and row.engine_speed and row.computed is not None and not row.doubt
    ]  # fmt: skip
    origin = known[0].origin if known else ""
    rows = {(row.quantity, row.engine_speed or 0.0): row for row in known if row.origin == origin}
    texts = {
        key: "/".join(
            filter(None, (value_text(row, one) for one in (row.computed, row.published, row.blind)))
        )
        for key, row in rows.items()
    }
    speeds = sorted({speed for _, speed in rows})
    if len(rows) < LEAST_ROWS or len(speeds) < LEAST_SPEEDS:
        return None
    blind = any(row.blind is not None for row in rows.values())
    unit = definition_of(known[0].quantity).shown_unit
    lines = [
        (
            label_of(name).removesuffix(" force"),
            *(texts.get((name, speed), "") for speed in speeds),
        )
        for name in dict.fromkeys(quantity for quantity, _ in rows)
    ]
    head = f"here/paper{'/blind' * blind}, {unit}"
    return TextTable("Here and in the paper", (head, *map(speed_text, speeds)), tuple(lines))


def value_text(row: Comparison, value: float | None) -> str:
    """A value (SI) with as many decimals as the printed one has, in units other than its own three digits; empty for
    None.
    """
    if value is None:
        return ""
    if shown_system() != "si":
        return digits_text(float(shown(row.quantity, value)[0]))
    printed = f"{float(shown(row.quantity, row.published)[0]):.10g}"
    places = min(len(printed.partition(".")[2]), 4)
    return f"{float(shown(row.quantity, value)[0]):.{places}f}".replace("-", "−")


def published(answer: ShownStudy) -> TextTable:
    """Every printed value next to those computed here and blind."""
    rows: list[tuple[str, ...]] = []
    for row in answer.study.comparisons:
        share = row.relative_difference
        off = "" if share is None else f"{100 * share:+.0f} %".replace("-", "−")
        speed = "" if row.engine_speed is None else f"{row.engine_speed / RPM:.0f}"
        here, paper, blind = (
            value_text(row, one) for one in (row.computed, row.published, row.blind)
        )
        unit = definition_of(row.quantity).shown_unit.replace("^2", "²")
        used = ROLES.get(row.role, row.role)
        rows.append(
            (
                label_of(row.quantity),
                speed,
                row.origin,
                unit,
                paper,
                here or "–",
                blind,
                off,
                used,
                row.doubt,
            )
        )
    heads = (
        "quantity", "rpm", "method", "unit", "paper", "here", "blind", "off", "used", "doubt",
    )  # fmt: skip
    return TextTable("Here and in the paper", heads, tuple(rows))
