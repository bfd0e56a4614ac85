"""First on the page: what a user asks of his spring, one card per question, and the largest clashes by name."""

from __future__ import annotations

import numpy as np

from valvetrain.report.figures.common import looks
from valvetrain.report.headlines import NAMED_CLASHES, TOPICS, HeadlineRow, clashes_of, headline_columns, headline_rows
from valvetrain.report.page import Block, Card, Cards, Cell, Details, Grid, SectionSpec, text
from valvetrain.report.words import number, rpm, speed_words, unit_words
from valvetrain.solution.event import Event
from valvetrain.solution.study import Study

#: Runs whose clashes are listed open; those of more runs stand behind a word to click.
OPEN_LISTS = 2
_CLASH_HEADERS = ("coils", "cam angle (deg)", "impulse (mN s)", "energy (mJ)", "peak force (N)")


def blocks(study: Study) -> tuple[Block, ...]:
    """What failed, a card per question in the order of :data:`TOPICS`, then the clashes of each run."""
    rows = headline_rows(study)
    cards = [
        _card(study, topic, [row for row in rows if row.topic == topic]) for topic in TOPICS if any(row.topic == topic for row in rows)
    ]
    failed = tuple(text(words, "alert") for words in study.failures)
    return (*failed, *((Cards(tuple(cards)),) if cards else ()), *_clashes(study))


def _card(study: Study, topic: str, rows: list[HeadlineRow]) -> Card:
    """Quantities down and runs across; turned where there are more than three runs."""
    known = looks(study)
    across = [
        (known[one.label].words if one.label in known else one.label)
        + (f", {speed_words(one.engine_speed)}" if one.engine_speed is not None else "")
        for one in headline_columns(study)
    ]
    names = [f"{row.words} ({unit_words(row.unit)})" if row.unit else row.words for row in rows]
    values = [[_shown(value, speed) for value, speed in zip(row.values, row.engine_speeds, strict=True)] for row in rows]
    if len(across) > 3:
        kept = [place for place in range(len(across)) if any(column[place] != "–" for column in values)]
        return Card(topic, tuple(names), tuple((across[place], tuple(column[place] for column in values)) for place in kept))
    return Card(topic, tuple(across), tuple(zip(names, map(tuple, values), strict=True)))


def _shown(value: float | None, engine_speed: float | None) -> str:
    return number(value) if engine_speed is None else f"{number(value)} at {rpm(engine_speed):.6g} rpm"


def _clashes(study: Study) -> tuple[Block, ...]:
    known, runs = looks(study), 0
    rows: list[tuple[tuple[Cell, ...], tuple[str, ...]]] = []
    for run in (run for label in study.labels for run in study.runs(label)) if study.command != "sweep" else ():
        found = clashes_of(run)
        if found:
            runs += 1
            head = f"{known[run.label].words}, {speed_words(run.engine_speed)}: {min(len(found), NAMED_CLASHES)} of {len(found)} clashes"
            rows.append(((Cell(head),), ()))
            rows += [(_clash_cells(event), ()) for event in found[:NAMED_CLASHES]]
    if not rows:
        return ()
    grid = Grid(_CLASH_HEADERS, tuple(rows), caption="Largest coil clashes by energy, of each run.")
    return (grid,) if runs <= OPEN_LISTS else (Details(f"The {NAMED_CLASHES} largest clashes of each run", (grid,)),)


def _clash_cells(event: Event) -> tuple[Cell, ...]:
    detail = event.details
    pair = "–".join(number(float(detail[name]), 3) for name in ("lower_coil", "upper_coil") if name in detail) or event.where
    angle = float(np.degrees(float(detail.get("peak_cam_angle", event.cam_angle)))) % 360
    sizes = [float(detail[name]) * 1e3 if name in detail else None for name in ("impulse", "energy")]
    where = f"{event.where}, " if event.where and "lower_coil" in detail else ""
    return (Cell(where + pair), *(Cell(number(value), "number") for value in (angle, *sizes, event.size)))


SPEC = SectionSpec("answers", "Answers", blocks)
