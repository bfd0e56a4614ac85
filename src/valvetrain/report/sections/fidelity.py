"""Which spring model is good enough where: verdicts by quantity, and maps of the differences over
engine speed.
"""

from __future__ import annotations

import math

from valvetrain.report import theme
from valvetrain.report.fidelity_words import (
    fidelity_notes,
    reach_rows,
    reason_for,
    share,
    speed_axis,
)
from valvetrain.report.page import Block, Cell, Grid, SectionSpec, Tabs, text
from valvetrain.solution.definition import label_of
from valvetrain.solution.fidelity import GOOD, MISSING, OPEN, POOR, FidelityMap, FidelityRow
from valvetrain.solution.study import Study


def blocks(study: Study) -> tuple[Block, ...]:
    """The recommendation, up to where each model reaches, and the maps."""
    found = study.fidelity
    if not len(found):
        return ()
    return (
        _recommended(found),
        _reaches(found),
        *_maps(found),
        *(text(words, "note") for words in fidelity_notes(found)),
    )


def _recommended(found: FidelityMap) -> Grid:
    rows = tuple(
        (
            (
                Cell(row.words),
                Cell(theme.model_words(row.cheapest), "", row.cheapest),
                Cell(reason_for(found, row.quantity), "quiet long"),
            ),
            (),
        )
        for row in reach_rows(found)
    )
    return Grid(("quantity", "cheapest model that is good enough", "why"), rows)


def _reaches(found: FidelityMap) -> Grid:
    costs, reference = dict(found.costs), dict(found.costs)[found.reference]
    rows = [
        (
            (
                Cell(row.words),
                *(Cell(cell, "number good" if cell == "all" else "number") for cell in row.cells),
            ),
            (),
        )
        for row in reach_rows(found)
    ]
    rows.append(
        (
            (
                Cell("Time of a run, the reference's being 1"),
                *(Cell(f"{costs[m] / reference:.2g}", "number") for m in found.models),
            ),
            (),
        )
    )
    return Grid(
        ("good enough (rpm)", *(theme.model_words(model) for model in found.models)), tuple(rows)
    )


def _maps(found: FidelityMap) -> tuple[Block, ...]:
    """A table per quantity: difference to the reference by model and engine speed, in the tone of
    its verdict.
    """
    maps = tuple(
        (label_of(name)[:1].upper() + label_of(name)[1:], (_map(found, name),))
        for name in found.quantities
    )
    return (Tabs(maps, "fidelity-map"),) if len(maps) > 1 else maps[0][1]


def _map(found: FidelityMap, name: str) -> Grid:
    rows = []
    for model in found.models:
        cells = [_cell(row, row.verdict(found.tolerance)) for row in found.of(name, model)]
        rows.append(((Cell(theme.model_words(model), "", model), *cells), ()))
    caption = (
        f"{label_of(name)[:1].upper() + label_of(name)[1:]}: difference to {theme.model_words(found.reference)} in per cent of its largest "
        "value, by engine speed (rpm). Green: good enough; red: not; grey: the error bars leave it open."
    )
    return Grid(
        ("model", *(f"{speed:.6g}" for speed in speed_axis(found))), tuple(rows), caption=caption
    )


def _cell(row: FidelityRow, verdict: str) -> Cell:
    if verdict == MISSING:
        return Cell("–", "number quiet", "not told, or no result")
    if not math.isfinite(row.reference):
        return Cell("?", "number quiet", "no value of the reference: open")
    size = f"{abs(100 * row.difference):.{0 if abs(row.difference) >= 0.0995 else 1}f}"
    words = size if float(size) == 0 else f"{'+' if row.difference > 0 else '−'}{size}"
    tone = {GOOD: "good", POOR: "bad", OPEN: "quiet"}[verdict]
    bar = f"± {share(row.doubt) or 'unknown'}: " if row.doubt > 0 else ""
    return Cell(words, f"number {tone}", f"{bar}{verdict}")


SPEC = SectionSpec("fidelity", "Which model is good enough", blocks)
