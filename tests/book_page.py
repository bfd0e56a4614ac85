"""The printed validation book, docs/validation.md, read back row by row."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from validation.row import Row

PAGE = Path(__file__).resolve().parents[1] / "docs" / "validation.md"
#: Share of a row's tolerance, or of its band, by which the printed number may stand off the one
#: computed now.
STALE = 0.25


@cache
def printed() -> Mapping[tuple[str, str], tuple[str, ...]]:
    """(chapter, name of the row) -> its cells."""
    found, chapter = {}, ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            chapter = line[3:].lower()
        elif chapter and line.startswith("| ") and not line.startswith("| what "):
            cells = tuple(cell.strip() for cell in line.strip("| ").split(" | "))
            found[chapter, cells[0]] = cells
    return found


def assert_page_holds(rows: Iterable[Row]) -> None:
    """Every row stands on the page, with its input, unit and the number that is computed now; else
    run ``make validate``.
    """
    stale = [words for row in rows if (words := _difference(row))]
    assert not stale, "docs/validation.md is stale, run make validate:\n" + "\n".join(stale)


def _difference(row: Row) -> str:
    cells = printed().get((row.topic, row.name.replace("|", "/")))
    if cells is None:
        return f"{row.topic}: {row.name} is missing"
    expected, computed = (float(cell.split()[0]) for cell in cells[3:5])
    units = {cell.partition(" ")[2] for cell in cells[3:5]}
    if units != {"" if row.unit in ("-", "1") else row.unit} or cells[1] != row.inputs.replace(
        "|", "/"
    ):
        return f"{row.topic}: {row.name}: printed in {units} of {cells[1]}, now in {row.unit} of {row.inputs}"
    allowed = STALE * (
        row.tolerance if row.within or row.band is None else row.band[1] - row.band[0]
    )
    allowed += 1e-4 * abs(row.computed)  # five printed digits
    if (
        abs(expected - row.expected) > allowed
        or abs(computed - row.computed) > allowed
        or cells[-1] != row.status
    ):
        return f"{row.topic}: {row.name}: printed {computed:g} of {expected:g}, now {row.computed:g} of {row.expected:g}, {row.status}"
    return ""
