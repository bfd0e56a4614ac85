"""Values of the case with status and source, how the runs were computed, and papers to cite."""

from __future__ import annotations

import math
from collections.abc import Mapping

from valvetrain.report import theme
from valvetrain.report.json import unit_of_number
from valvetrain.report.page import Block, Cell, Details, Grid, Listing, SectionSpec, prose, text
from valvetrain.report.run_charts import covered_by_source, line_styles
from valvetrain.report.text import number, speed_text, unit_text
from valvetrain.solution.provenance import CaseValue
from valvetrain.solution.study import Study


def case_blocks(study: Study) -> tuple[Block, ...]:
    """Changed values, then a table of all values with a filter by status."""
    record = study.record
    found: list[Block] = []
    if record.changed:
        found.append(text(f"Changed for this run: {', '.join(record.changed)}.", "note"))
    if record.values:
        rows = tuple((_cells(one), (one.status,)) for one in record.values)
        found.append(Grid(("value of the case", "", "status", "source"), rows, ("status",)))
    if covered_by_source(study):
        found += prose(record.remarks, "Remarks on the case")
    if record.text:
        found.append(Details("The case file, resolved", (Listing(record.text),)))
    return tuple(found)


def _cells(one: CaseValue) -> tuple[Cell, ...]:
    name = one.path.replace(".", " / ").replace("_", " ")
    return (
        Cell(name, "", one.path),
        Cell(one.text, "long"),
        Cell(one.status, "tag" if one.status else ""),
        Cell(one.source, "quiet long"),
    )


CASE_SPEC = SectionSpec("case", "Values of the case", case_blocks, folded=True)


#: Rows up to which the table is open.
OPEN_ROWS = 12


def runs_blocks(study: Study) -> tuple[Block, ...]:
    """A row per run and per spring at rest, then the versions behind them."""
    known, rows = line_styles(study), []
    for run in study.solutions:
        state = Cell(run.status.sentence(), "good" if run.status.completed else "bad")
        options = Cell(_facts({**run.provenance.options, **run.statistics}), "quiet long")
        rows.append(
            (
                (
                    Cell(known[run.label].label),
                    Cell(speed_text(run.engine_speed), "number"),
                    state,
                    options,
                ),
                (),
            )
        )
    for one in study.rest:
        parts = [part.status for part in (one.curve, one.modes) if part is not None]
        ended = next(
            (status for status in parts if not status.completed), parts[0] if parts else None
        )
        state = Cell(
            "" if ended is None else ended.sentence(),
            "good" if ended is None or ended.completed else "bad",
        )
        facts = {**one.facts, "wall time (s)": one.wall_time} if one.wall_time else one.facts
        rows.append(
            (
                (
                    Cell(theme.model_label(one.model)),
                    Cell(f"at rest, {one.spring}", "number"),
                    state,
                    Cell(_facts(facts), "quiet long"),
                ),
                (),
            )
        )
    source = next((run.provenance for run in study.solutions), study.provenance)
    versions = {
        "valvetrain": source.package_version,
        "Python": source.python_version,
        **source.dependencies,
    }
    listed = (
        ", ".join(f"{name} {version}" for name, version in versions.items() if version)
        or "not recorded"
    )
    digest = study.record.digest if study.record.text else source.case_digest
    label = (
        f"Versions: {listed}."
        + (f" Case digest {digest}." if digest else "")
        + (f" Computed {source.created_at}." if source.created_at else "")
    )
    grid = Grid(("run", "engine speed", "ended", "options and statistics"), tuple(rows))
    shown: tuple[Block, ...] = (
        (grid,)
        if len(rows) <= OPEN_ROWS
        else (Details(f"Options and statistics of {len(rows)} runs", (grid,)),)
    )
    return (*(shown if rows else ()), text(label, "quiet"))


def _facts(facts: Mapping[str, float | int | str | bool | None]) -> str:
    return ", ".join(
        f"{key.replace('_', ' ')} {_plain(key, value)}"
        for key, value in facts.items()
        if value is not None
    )


def _plain(key: str, value: object) -> str:
    """A number with its SI unit, the output step in degrees; text and booleans unchanged."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value).lower() if isinstance(value, bool) else str(value)
    unit = unit_of_number(key)
    shown, value = (
        ("deg", math.degrees(value)) if unit == "rad" else ("" if unit == "1" else unit, value)
    )
    return f"{number(value) if isinstance(value, float) else value} {unit_text(shown)}".strip()


RUNS_SPEC = SectionSpec("runs", "Runs and versions", runs_blocks, folded=True)


def references_blocks(study: Study) -> tuple[Block, ...]:
    """Each work once, those of the case first."""
    every = (
        *study.record.citations,
        *study.provenance.citations,
        *(one for run in study.solutions for one in run.cite()),
    )
    return tuple(text(reference, "reference") for reference in dict.fromkeys(every))


REFERENCES_SPEC = SectionSpec("references", "Papers to cite", references_blocks, folded=True)
