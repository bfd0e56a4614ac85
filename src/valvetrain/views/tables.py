"""Whole tables of a study, folded on its page: findings, numbers, events, printed values, error bars, springs at rest."""

from __future__ import annotations

import math

from valvetrain.findings.facts import LOST, TURN
from valvetrain.findings.rules_train import CAUSES as WHY_LOST
from valvetrain.findings.words import COARSE, Amount, digits_text, speed_text
from valvetrain.solution.definition import is_defined, label_of, topics
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause
from valvetrain.views.shown import Shown, ShownStudy
from valvetrain.views.side_by_side import model_table
from valvetrain.views.table import TextTable

#: Runs that stand side by side; more are rows. Events of a run that are listed, the largest.
SIDE_BY_SIDE, EVENTS = 8, 12
#: Kinds of events by which control is lost, which a table of events has first.
CONTROL = (*LOST, "float", "bounce")
#: Unit of the size of an event -> a quantity of its kind, which gives digits and the reader's unit.
SIZES = {"N": "peak_clash_force", "m": "loft_gap", "m/s": "seating_velocity", "s": "loft_duration"}
#: Cause of an event -> its words.
CAUSES: dict[str, str] = {
    **WHY_LOST,
    Cause.COILS_STRIKE: "coils meet under surge",
    Cause.COILS_REST: "coils come to rest on each other as the spring closes",
    Cause.FLANK_ENDS: "the lift ends",
    Cause.BOUNCE_ENDS: "end of a bounce",
    Cause.REBOUND: "rebound from the seat",
    Cause.REBOUND_IN_SURGE: "rebound with the spring force lowered by surge",
}


def findings(answer: Shown) -> TextTable:
    """All findings by importance."""
    rows = tuple(
        (one.code, one.mark, one.text, one.reason, one.step, one.guide) for one in answer.findings
    )
    return TextTable("Findings", ("code", "mark", "finding", "why", "next", "guide"), rows)


def numbers(answer: ShownStudy) -> TextTable:
    """Headline quantities by topic; few runs side by side, of many a row each."""
    facts, words = answer.facts, answer.words
    runs = [*facts.runs, *facts.beyond, *facts.others]
    units, rows = dict[str, str](), list[tuple[str, ...]]()
    for topic, chosen in topics().items():
        first = True
        for name in chosen:
            amounts = [facts.amount(run, name) for run in runs]
            if any(amounts):
                most = max(abs(one.value) for one in amounts if one)
                unit = words.unit(name, most)
                units[name] = f"{label_of(name)}{f', {unit.text}' if unit.text else ''}"
                if first:
                    rows.append((topic,))
                cells = ("" if one is None else _short(one, unit.size) for one in amounts)
                rows.append((units[name], *cells))
                first = False
    heads = [_head(answer, run) for run in runs]
    title = "Numbers of every run"
    if any(cell.endswith(" *") for row in rows for cell in row):
        rows.append(("* contact constants, which nobody knows, decide these numbers",))
    if len(runs) <= SIDE_BY_SIDE:
        return TextTable(title, ("", *heads), tuple(rows))
    numbers = [row for row in rows if len(row) > 1]
    across = zip(heads, *(row[1:] for row in numbers), strict=True)
    return TextTable(title, ("", *(row[0] for row in numbers)), tuple(across))


def _head(answer: ShownStudy, run: Solution) -> str:
    several = answer.facts.several or bool(answer.facts.others)
    speed = speed_text(run.engine_speed)
    return f"{run.label}, {speed}" if several else speed


def _short(one: Amount, size: float) -> str:
    """A value with its bar where that is coarse: ``1910 ± 1000``."""
    text = digits_text(one.value / size, one.bar / size, 4)
    coarse = one.bar > COARSE * abs(one.value)
    text = f"{text} ± {digits_text(one.bar / size, one.bar / size)}" if coarse else text
    return f"{text} *" if one.rests_on else text


def source(answer: ShownStudy) -> TextTable:
    """What a source states in words, and what the runs show."""
    rows = tuple((one.place, one.statement, one.computed) for one in answer.study.findings)
    return TextTable("What the source states", ("place", "the source", "here"), rows)


def events(answer: ShownStudy) -> TextTable:
    """The largest events of each run that decides: where, when, how large, and why."""
    rows = []
    for run in answer.facts.runs:
        lead = [one for one in run.events if one.kind != "seating" or one.details.get("touch") == 1]
        lead.sort(key=lambda one: (one.kind not in CONTROL or not one.counts, -one.size))
        for one in sorted(lead[:EVENTS], key=lambda one: one.cam_angle):
            angle = Amount("loft_cam_angle", one.cam_angle % TURN)
            size = Amount(SIZES.get(one.unit, "clash_count"), one.size)
            lasts = Amount("loft_duration", one.duration)
            texts = (answer.words.amount(each) for each in (angle, size, lasts))
            kind, why = one.kind.replace("-", " "), CAUSES.get(str(one.details.get("cause")), "")
            rows.append((_head(answer, run), kind, one.where.replace("_", " "), *texts, why))
    heads = ("run", "event", "where", "begins", "size", "lasts", "cause")
    return TextTable("Events", heads, tuple(rows))


def critical(answer: ShownStudy) -> TextTable:
    """Critical engine speeds of every run: from where control is lost, to where, and why."""
    rows = [
        (one.label, one.kind.replace("-", " "), one.text, one.later_text, CAUSES.get(one.cause, ""))
        for one in answer.study.critical_speeds
    ]
    heads = ("run", "loss", "from, rpm", "to", "cause")
    return TextTable("Critical engine speeds", heads, tuple(rows))


def models(answer: ShownStudy) -> TextTable | None:
    """Spring models side by side, where the first screen does not show them."""
    return None if answer.models is not None else model_table(answer.facts, answer.words)


def error_bars(answer: ShownStudy) -> TextTable:
    """Numbers with their error bars."""
    rows = []
    for one in answer.study.error_bars.rows:
        unit = answer.words.unit(one.quantity, one.value)
        speed = "" if one.engine_speed is None else speed_text(one.engine_speed)
        numbers = [digits_text(value / unit.size) for value in (one.value, one.numerical)]
        reach = one.contact_range
        ends = "" if reach is None else " to ".join(digits_text(v / unit.size) for v in reach[:2])
        rows.append((label_of(one.quantity), one.label, speed, unit.text, *numbers, ends))
    heads = (
        "quantity",
        "run",
        "engine speed",
        "unit",
        "value",
        "error bar",
        "over contact constants",
    )
    return TextTable("Error bars", heads, tuple(rows))


def rest(answer: ShownStudy) -> TextTable:
    """Springs and lift before anything moves."""
    rows = tuple(
        (owner, label_of(name), answer.words.amount(Amount(name, value), 4))
        for owner, values in answer.study.still.items()
        for name, value in values.items()
        if math.isfinite(value) and is_defined(name)
    )
    return TextTable("At rest", ("of", "quantity", "value"), rows)
