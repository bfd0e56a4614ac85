"""The printed validation book, the tables of docs/data/validation, read back row by row."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from validation.__main__ import table_of
from validation.row import Row

DOCS = Path(__file__).resolve().parents[1] / "docs"
#: Share of a row's tolerance, or of its band, by which the printed number may stand off the one
#: computed now.
STALE = 0.25


@cache
def printed(topic: str) -> Mapping[str, Mapping[str, str]]:
    """The printed rows of a topic by name."""
    with (DOCS / table_of(topic)).open(encoding="utf-8", newline="") as stream:
        return {row["what"]: row for row in csv.DictReader(stream)}


def assert_page_holds(rows: Iterable[Row]) -> None:
    """Every row stands in its table, with its input, unit and the number that is computed now; else
    run ``make validate-all``.
    """
    stale = [words for row in rows if (words := _difference(row))]
    assert not stale, "docs/data/validation is stale:\n" + "\n".join(stale)


def _difference(row: Row) -> str:
    cells = printed(row.topic).get(row.name)
    if cells is None:
        return f"{row.topic}: {row.name} is missing"
    unit = "" if row.unit in ("-", "1") else row.unit
    if (cells["unit"], cells["input"]) != (unit, row.inputs):
        return f"{row.topic}: {row.name}: printed in {cells['unit']} of {cells['input']}, now in {row.unit} of {row.inputs}"
    expected, computed = float(cells["expected"]), float(cells["computed"])
    allowed = STALE * (
        row.tolerance if row.within or row.band is None else row.band[1] - row.band[0]
    )
    allowed += 1e-4 * abs(row.computed)  # five printed digits
    if (
        abs(expected - row.expected) > allowed
        or abs(computed - row.computed) > allowed
        or cells["status"] != row.status
    ):
        return f"{row.topic}: {row.name}: printed {computed:g} of {expected:g}, now {row.computed:g} of {row.expected:g}, {row.status}"
    return ""
