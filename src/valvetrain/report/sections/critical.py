"""Where a train loses control over engine speed: brackets from rest, with rising and with falling speed."""

from __future__ import annotations

from valvetrain.report.critical_words import critical_notes, critical_rows, searched
from valvetrain.report.figures.common import looks
from valvetrain.report.page import Block, Cell, Grid, SectionSpec, text
from valvetrain.solution.study import Study


def blocks(study: Study) -> tuple[Block, ...]:
    """A table of critical speeds, a column per label, and how they were searched."""
    if not searched(study) or not len(study.critical_speeds):
        return ()
    known, labels = looks(study), study.labels
    rows = tuple(
        ((Cell(row.words if row.main else f"\u2003{row.words}"), *(Cell(cell, "number") for cell in row.cells)), ())
        for row in critical_rows(study, labels)
    )
    headers = ("engine speed (rpm)", *(known[label].words if label in known else label for label in labels))
    return (Grid(headers, rows), *(text(words, "note") for words in critical_notes(study)))


SPEC = SectionSpec("critical-speeds", "Critical speeds", blocks)
