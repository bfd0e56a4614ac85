"""Timing at 0.050 in and 1 mm, power of the cam, and why contact is lost or the valve bounces."""

from __future__ import annotations

import math
from collections.abc import Sequence

from valvetrain.quantities.table import EVENT_LIFTS, OPENERS
from valvetrain.report.clauses import quantity_text
from valvetrain.report.page import Block, Card, Cards, Cell, Details, Grid, SectionSpec, text
from valvetrain.report.run_charts import line_styles
from valvetrain.report.text import CAUSES, amount, number, speed_text
from valvetrain.solution.critical import places_text
from valvetrain.solution.definition import label_of
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event
from valvetrain.solution.study import Study

#: Numbers of the cam's drive, in order.
POWER = ("mean_cam_power", "mean_cam_torque", "peak_cam_torque", "minimum_cam_torque")
#: Runs shown side by side; of more, those of the highest speed of each label.
MAX_RUNS = 4
#: Rows of the table of causes that are open.
OPEN_ROWS = 8


def timing_blocks(study: Study) -> tuple[Block, ...]:
    """Power and timing of the runs side by side, then the causes of events; nothing without a train."""
    runs = [run for run in study.solutions if "mean_cam_power" in run.quantities]
    if not runs:
        return ()
    return (*_numbers(study, shown_runs(runs)), *cause_blocks(study, runs))


def shown_runs(runs: Sequence[Solution]) -> list[Solution]:
    """All runs where there are few, else the fastest that completed of each label."""
    if len(runs) <= MAX_RUNS:
        return list(runs)
    chosen: dict[str, Solution] = {}
    for run in sorted(runs, key=lambda one: (one.status.completed, one.engine_speed)):
        chosen[run.label] = run
    return list(chosen.values())[:MAX_RUNS]


def _numbers(study: Study, runs: Sequence[Solution]) -> tuple[Block, ...]:
    known = line_styles(study)
    power = [
        (_begun(label_of(name)), tuple(_quantity(study, run, name) for run in runs))
        for name in POWER
    ]
    timing = [
        (
            f"{_begun(label)}, {EVENT_LIFTS[lift]}",
            tuple(_timing(study, run, f"{name}_{lift}") for run in runs),
        )
        for name, (label, lifts, _) in OPENERS.items()
        for lift in lifts
        if lift != "lash" or name == "valve"
    ]
    lines = [
        ("Power of the cam", ()),
        *(line for line in power if set(line[1]) != {"–"}),
        ("Opens, closes (cam degrees), open for (crank degrees)", ()),
        *(line for line in timing if set(line[1]) != {"–"}),
    ]
    heads = tuple(f"{known[run.label].label}, {speed_text(run.engine_speed)}" for run in runs)
    note = "Lift at the valve for the valve, at the lobe for the lobe; the rigid valve is that of stiff parts."
    return (Cards((Card("", heads, tuple(lines)),)), text(note, "quiet"))


def _value(study: Study, run: Solution, name: str) -> float:
    """A quantity of a run, or of its case at rest; NaN where neither has it."""
    if name in run.quantities:
        return run.quantities[name]
    places = (study.still.get(label, {}) for label in (run.label, run.spring_set, run.model, ""))
    return next((one[name] for one in places if name in one), math.nan)


def _quantity(study: Study, run: Solution, name: str) -> str:
    value = _value(study, run, name)
    return quantity_text(name, value) if math.isfinite(value) else "–"


def _timing(study: Study, run: Solution, name: str) -> str:
    """``172.5, 294.3, 243.7``: opening, closing, duration; a dash where the lift is not reached."""
    ends = ("opening_cam_angle", "closing_cam_angle", "open_crank_angle_range")
    values = [math.degrees(_value(study, run, f"{name}_{end}")) for end in ends]
    if not all(map(math.isfinite, values)):
        return "–"
    return ", ".join(number(value, 4) for value in values)


def _begun(label: str) -> str:
    return label[:1].upper() + label[1:]


def cause_blocks(study: Study, runs: Sequence[Solution]) -> tuple[Block, ...]:
    """How often and why a contact is lost, the valve floats or bounces, by run, kind and cause."""
    known = line_styles(study)
    groups: dict[tuple[str, float, str, str, str], list[Event]] = {}
    for run in runs:
        for event in run.events:
            cause = str(event.details.get("cause", ""))
            if cause and event.kind != "seating":
                key = (run.label, run.engine_speed, event.kind, event.where, cause)
                groups.setdefault(key, []).append(event)
    rows = tuple(
        (
            (
                Cell(known[label].label),
                Cell(speed_text(speed), "number"),
                Cell(f"{kind.replace('-', ' ')}, {places_text(where)}"),
                Cell(str(len(events)), "number"),
                Cell(_largest(events), "number"),
                Cell(CAUSES.get(cause, cause), "long"),
            ),
            (known[label].label,),
        )
        for (label, speed, kind, where, cause), events in groups.items()
    )
    if not rows:
        return ()
    heads = ("run", "engine speed", "event", "times", "largest", "cause")
    caption = "Why contact is lost, the valve floats or bounces, in one revolution."
    grid = Grid(heads, rows, ("run",), caption)
    title = f"Why contact is lost: {len(rows)} kinds of events with their causes"
    return (grid,) if len(rows) <= OPEN_ROWS else (Details(title, (grid,)),)


def _largest(events: Sequence[Event]) -> str:
    one = max(events, key=lambda event: event.size)
    return (
        amount(1e6 * one.size, "um", 3) if one.unit == "m" else f"{number(one.size, 3)} {one.unit}"
    )


SPEC = SectionSpec("timing", "Timing, cam power and causes", timing_blocks)
