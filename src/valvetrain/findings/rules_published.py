"""Rules on published values (H): what was fitted, how far the rest is off, and what a source prints otherwise."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable, Iterator

from valvetrain.findings.engine import Fields, Hit, Rule
from valvetrain.findings.facts import Facts
from valvetrain.findings.words import Amount, speed_text
from valvetrain.solution.definition import definition_of, label_of
from valvetrain.solution.uncertainty import Comparison

FITTED = "calibration"
FORCES, MOTIONS = ("force",), ("length", "velocity", "acceleration")
#: Median difference (per cent) below which no number is printed.
LEAST = 0.1
#: Verdict on a finding of a source that the runs do not show.
NOT_SEEN = "not seen"


def off(
    rows: Iterable[Comparison],
    dimensions: tuple[str, ...],
    computed: Callable[[Comparison], float | None] = lambda row: row.computed,
) -> str:
    """``6.4 % off (8)``: the median difference from the printed values of some dimensions, and how many; empty of none."""
    shares = [
        abs(value / row.published - 1)
        for row in rows
        if row.published and (value := computed(row)) is not None
        and definition_of(row.quantity).dimension in dimensions
    ]  # fmt: skip
    if not shares:
        return ""
    middle = 100 * statistics.median(shares)
    return f"{f'{middle:.2g}' if middle >= LEAST else f'less than {LEAST}'} % off ({len(shares)})"


def compared(facts: Facts) -> list[Comparison]:
    """The printed values that have a computed one and are not in doubt."""
    return [row for row in facts.study.comparisons if row.difference is not None and not row.doubt]


def published(facts: Facts) -> Iterator[Hit]:
    """Printed values: how many a case was fitted to, and how far the others are off."""
    rows = compared(facts)
    free = [row for row in rows if row.role != FITTED]
    doubt = sum(bool(row.doubt) for row in facts.study.comparisons)
    if rows:
        yield Hit(Amount("clash_count", len(rows)), fields={
            "fitted": str(len(rows) - len(free)), "count": str(len(facts.study.comparisons)),
            "forces": off(free, FORCES), "motions": off(free, MOTIONS), "doubt": str(doubt or ""),
        })  # fmt: skip


def blind(facts: Facts) -> Iterator[Hit]:
    """How far the case that was not fitted is off the same printed values."""
    rows = [row for row in compared(facts) if row.blind is not None]
    if forces := off(rows, FORCES, lambda row: row.blind):
        yield Hit(Amount("clash_count", len(rows)), fields={"forces": forces})


def contradicted(facts: Facts) -> Iterator[Hit]:
    """A finding of the source that the runs do not show."""
    for one in facts.study.findings:
        if one.verdict == NOT_SEEN:
            yield Hit(fields={"said": one.statement, "place": one.place})


def by_phase(facts: Facts) -> Iterator[Hit]:
    """A printed value rests on the phase of the samples of its source, which a range over all phases shows."""
    for row in compared(facts):
        if row.samples is not None and row.samples.low < row.published < row.samples.high:
            fields: Fields = {
                "label": label_of(row.quantity), "at": speed_text(row.engine_speed or 0.0),
                "low": Amount(row.quantity, row.samples.low), "high": Amount(row.quantity, row.samples.high),
                "share": f"{100 * row.samples.share:.0f} %", "printed": Amount(row.quantity, row.published),
            }  # fmt: skip
            spread = (row.samples.high - row.samples.low) / abs(row.published)
            yield Hit(Amount(row.quantity, row.computed or 0.0), None, None, fields, spread)


RULES = (
    Rule("H101", "notes", "fitted to {fitted} of {count} printed values[; forces not fitted {forces}][; motions {motions}]",
         published, reason="[{doubt} in doubt]", guide="evidence.md"),
    Rule("H102", "notes", "predicted blind: forces {forces}", blind, guide="beehive.md"),
    Rule("H104", "notes", "{label} at {at}: {low..high} by the phase of the samples, {share} of the phases above {printed}",
         by_phase, guide="beehive.md"),
    Rule("H103", "notes", "not as printed: {said}", contradicted, remark="[{place}]"),
)  # fmt: skip
