"""Values of the case with their status and source, remarks, and the resolved case file."""

from __future__ import annotations

from valvetrain.report.figures.common import told_by_source
from valvetrain.report.page import Block, Cell, Details, Grid, Listing, SectionSpec, prose, text
from valvetrain.solution.record import CaseValue
from valvetrain.solution.study import Study


def blocks(study: Study) -> tuple[Block, ...]:
    """Table with a filter by status; what was changed is said first."""
    record = study.record
    found: list[Block] = []
    if record.changed:
        found.append(text(f"Changed for this run: {', '.join(record.changed)}.", "note"))
    if record.values:
        rows = tuple((_cells(one), (one.status,)) for one in record.values)
        found.append(Grid(("value of the case", "", "status", "source"), rows, ("status",)))
    if told_by_source(study):
        found += prose(record.remarks, "Remarks on the case")
    if record.text:
        found.append(Details("The case file, resolved", (Listing(record.text),)))
    return tuple(found)


def _cells(one: CaseValue) -> tuple[Cell, ...]:
    name = one.path.replace(".", " / ").replace("_", " ")
    return Cell(name, "", one.path), Cell(one.words, "long"), Cell(one.status, "tag" if one.status else ""), Cell(one.source, "quiet long")


SPEC = SectionSpec("case", "Values of the case", blocks)
