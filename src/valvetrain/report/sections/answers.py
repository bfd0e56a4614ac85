"""Answers of a study: headline quantities by topic, largest clashes, and which model is good
enough.
"""

from __future__ import annotations

import numpy as np

from valvetrain.report.fact_texts import study_notes
from valvetrain.report.headlines import (
    NAMED_CLASHES,
    HeadlineRow,
    clash_size,
    clashes_of,
    headline_columns,
    headline_rows,
    largest_clash_rows,
    limit_sentences,
)
from valvetrain.report.page import (
    Block,
    Card,
    Cards,
    Cell,
    Details,
    Grid,
    SectionSpec,
    sentences,
    text,
)
from valvetrain.report.run_charts import line_styles
from valvetrain.report.text import (
    clash_pair,
    number,
    peak_angle,
    rpm_text,
    speed_text,
    unit_text,
)
from valvetrain.solution.critical import KINDS
from valvetrain.solution.definition import topics
from valvetrain.solution.status import Event
from valvetrain.solution.study import Study
from valvetrain.units.reader import reader_text

#: Runs shown side by side in one table; of more, a table per question, one below the other.
MAX_COLUMNS = 8
#: Runs of which several clashes are listed at once; of more the largest of each, and the others
#: behind a word to click.
OPEN_LISTS = 2
#: Letters of a note that is shown in full.
LONG_NOTE = 140
_CLASH_HEADERS = (
    "coils",
    "first touch (cam deg)",
    "hardest (cam deg)",
    "impulse (mN s)",
    "energy (mJ)",
    "peak force (N)",
)
#: What the angles of a clash are.
_CLASH_ANGLES = "They begin at the first touch; hardest is the angle of the peak force, which the verdict gives."


def answers_blocks(study: Study) -> tuple[Block, ...]:
    """Failures, headline quantities by topic, notes, then the clashes of each run."""
    control = set(KINDS.values()) if len(study.critical_speeds) else set()
    rows = [row for row in headline_rows(study) if row.name not in control]  # in their own section
    across = _columns(study)
    by_topic = {topic: [row for row in rows if row.topic == topic] for topic in topics()}
    if len(across) <= MAX_COLUMNS:
        cards = (
            [
                _side_by_side(
                    study, across, {topic: found for topic, found in by_topic.items() if found}
                )
            ]
            if rows
            else []
        )
    else:
        cards = [_below(topic, across, found) for topic, found in by_topic.items() if found]
    passed = (f"! {sentence}" for sentence in limit_sentences(study))
    failed = tuple(text(sentence, "alert") for sentence in (*study.failures, *passed))
    own = (
        ()
        if study.comparisons or study.findings
        else tuple(block for one in study_notes(study) for block in folded_note(one))
    )
    return (*failed, *((Cards(tuple(cards)),) if cards else ()), *own, *_clashes(study))


def folded_note(note: str) -> tuple[Block, ...]:
    """A note; a long one by its beginning, with the whole behind it."""
    note = reader_text(note)
    if len(note) <= LONG_NOTE:
        return (text(note, "note"),)
    first = sentences(note)[0]
    head = first if len(first) <= LONG_NOTE else first[:LONG_NOTE].rpartition(" ")[0] + " …"
    return (Details(head, (text(note, "note"),)),)


def _columns(study: Study) -> list[str]:
    known = line_styles(study)
    return [
        (known[one.label].label if one.label in known else one.label)
        + (f", {speed_text(one.engine_speed)}" if one.engine_speed is not None else "")
        for one in headline_columns(study)
    ]


def _side_by_side(study: Study, across: list[str], topics: dict[str, list[HeadlineRow]]) -> Card:
    """All topics in one table with a column per run; a heading above each topic."""
    lines: list[tuple[str, tuple[str, ...]]] = []
    largest = largest_clash_rows(study, headline_columns(study))
    for topic, rows in topics.items():
        lines.append((topic, ()))
        for row in rows:
            if row.name != "largest_clash_impulse" or not largest:
                lines.append((_name(row.label, row.unit), _values(row)))
            if row.beyond is not None:
                lines.append((f"\u2003{row.beyond.label}", _values(row.beyond)))
            if row.name == "clash_count":
                lines += [(_name(f"\u2003{label}", unit), cells) for label, unit, cells in largest]
    return Card("", tuple(across), tuple(lines))


def _below(topic: str, across: list[str], rows: list[HeadlineRow]) -> Card:
    """One topic with a row per run; runs without any value are left out."""
    values = list(zip(*map(_values, rows), strict=True))
    lines = [
        (run, cells)
        for run, cells in zip(across, values, strict=True)
        if any(cell != "–" for cell in cells)
    ]
    return Card(topic, tuple(_name(row.label, row.unit) for row in rows), tuple(lines))


def _name(label: str, unit: str) -> str:
    return f"{label} ({unit_text(unit)})".replace("N s)", "N\u00a0s)") if unit else label


def _values(row: HeadlineRow) -> tuple[str, ...]:
    pairs = zip(row.values, row.engine_speeds, strict=True)
    return row.cells or tuple(
        number(value) + row.mark(place) + ("" if speed is None else f" at {rpm_text(speed)} rpm")
        for place, (value, speed) in enumerate(pairs)
    )


def _clashes(study: Study) -> tuple[Block, ...]:
    """The largest clashes: several of one run or two, else one of each, and a folded table of more."""
    known = line_styles(study)
    found = [
        (f"{known[run.label].label}, {speed_text(run.engine_speed)}", clashes_of(run))
        for label in study.labels
        for run in study.runs(label)
        if not study.over_speed
    ]
    found = [(caption, events) for caption, events in found if events]
    if not found:
        return ()
    rows: list[tuple[tuple[Cell, ...], tuple[str, ...]]] = []
    for caption, events in found:
        rows.append(
            ((Cell(f"{caption}: {min(len(events), NAMED_CLASHES)} of {len(events)} clashes"),), ())
        )
        rows += [(_clash_cells(event), ()) for event in events[:NAMED_CLASHES]]
    several = Grid(
        _CLASH_HEADERS,
        tuple(rows),
        caption=f"Largest coil clashes by energy. {_CLASH_ANGLES}",
    )
    if len(found) <= OPEN_LISTS:
        return (several,)
    first = tuple(((Cell(caption), *_clash_cells(events[0])), ()) for caption, events in found)
    largest = Grid(
        ("largest clash", *_CLASH_HEADERS),
        first,
        caption=f"Largest coil clash of each run by energy. {_CLASH_ANGLES}",
    )
    return (largest, Details(f"The {NAMED_CLASHES} largest clashes of each run", (several,)))


def _clash_cells(event: Event) -> tuple[Cell, ...]:
    angle = float(np.degrees(event.cam_angle)) % 360
    energies = (clash_size(event, name) for name in ("impulse", "energy"))
    sizes = (angle, peak_angle(event), *energies, event.size)
    return (Cell(clash_pair(event)), *(Cell(number(value), "number") for value in sizes))


ANSWERS_SPEC = SectionSpec("answers", "Answers", answers_blocks)
