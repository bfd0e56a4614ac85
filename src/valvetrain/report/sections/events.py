"""Every event of every run but coil clashes, which stand with the answers: seatings, bounces, losses of contact."""

from __future__ import annotations

import numpy as np

from valvetrain.report.figures.common import looks
from valvetrain.report.page import Block, Cell, Details, Grid, SectionSpec
from valvetrain.report.words import number, speed_words
from valvetrain.solution.study import Study

#: Rows up to which the table stands open.
OPEN_ROWS = 24
MOST_ROWS = 400
HEADERS = ("run", "engine speed", "event", "place", "cam angle (deg)", "duration (ms)", "size", "unit", "cause")


def blocks(study: Study) -> tuple[Block, ...]:
    """A table with filters by run and kind; a sweep's events are in its file."""
    if study.over_speed:
        return ()
    known, rows = looks(study), []
    for run in study.solutions:
        for event in run.events:
            if event.kind != "clash":
                words, speed = known[run.label].words, speed_words(run.engine_speed)
                angle = float(np.degrees(event.cam_angle)) % 360
                numbers = [Cell(number(value), "number") for value in (angle, event.duration * 1e3, event.size)]
                cause = Cell(str(event.details.get("cause", "")), "quiet long")
                cells = (
                    Cell(words),
                    Cell(speed, "number"),
                    Cell(event.kind),
                    Cell(event.where),
                    *numbers,
                    Cell(event.unit, "quiet"),
                    cause,
                )
                rows.append((cells, (words, speed, event.kind)))
    if not rows:
        return ()
    caption = "" if len(rows) <= MOST_ROWS else f"The first {MOST_ROWS} of {len(rows)}; all of them are in events.csv."
    grid = Grid(HEADERS, tuple(rows[:MOST_ROWS]), ("run", "engine speed", "event"), caption)
    return (grid,) if len(rows) <= OPEN_ROWS else (Details(f"{len(rows)} events", (grid,)),)


SPEC = SectionSpec("events", "Seating and losses of contact", blocks)
