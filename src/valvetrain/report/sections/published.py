"""Computed and given values values, only where there are any: one dot plot, one table with filters,
findings, notes behind them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.page import (
    Block,
    Cell,
    Details,
    Grid,
    SectionSpec,
    figure_or_gap,
    prose,
    text,
)
from valvetrain.report.table import comparison_grid
from valvetrain.report.text import in_unit, number, speed_text, unit_text
from valvetrain.report.uncertainty_section import firmness, lead, uncertainty_grid
from valvetrain.runs.error_bars import Uncertainty
from valvetrain.runs.uncertainty_file import fresh_uncertainty, load_uncertainty, meshes_of
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.definition import label_of
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.study import Study

#: Ends of the ratio axis; what lies beyond is drawn at the end as a triangle, its number on hover.
AXIS = (0.5, 1.5)
#: Rows up to which each is named at the side; more are named on hover and in the table.
NAMED_ROWS = 40


def published_blocks(study: Study) -> tuple[Block, ...]:
    """Nothing for a study without comparisons, findings and notes."""
    found: list[Block] = []
    if study.comparisons:
        found += figure_or_gap("Computed over given values", ratio_chart, study)
        found.append(comparison_grid(study.comparisons))
    if study.findings:
        rows = tuple(
            (
                tuple(
                    Cell(sentence)
                    for sentence in (one.place, one.statement, one.computed, one.verdict)
                ),
                (),
            )
            for one in study.findings
        )
        found.append(
            Grid(("place in the source", "finding of the source", "computed here", "verdict"), rows)
        )
    return (*found, *prose(study.notes, "Notes on these values")) if found else ()


def ratios(rows: tuple[Comparison, ...]) -> list[tuple[Comparison, float]]:
    """Rows with their computed over given value, by engine speed; those without either, or with a
    given zero, are left out.
    """
    known = [
        (row, row.computed / row.published)
        for row in rows
        if row.computed is not None and row.published
    ]
    return sorted(
        ((row, ratio) for row, ratio in known if np.isfinite(ratio)),
        key=lambda pair: pair[0].engine_speed or 0.0,
    )


def ratio_chart(study: Study) -> Chart | None:
    """One row per given value: computed over given, bars for stated tolerance and numerical
    uncertainty; None without a ratio.
    """
    known = ratios(study.comparisons)[::-1]  # the first stands on top
    if not known:
        return None
    height = np.arange(len(known), dtype=float)
    unsure = {
        (row.quantity, round(row.engine_speed or 0.0, 3)): row
        for row in load_uncertainty(study.record)
        if not row.label
    }
    allowed = [
        None if row.tolerance is None else row.tolerance / abs(row.published) for row, _ in known
    ]
    layers: list[Layer] = [
        *_spans("stated tolerance", theme.RULE, 5.0, [(1.0, half) for half in allowed]),
        *_spans(
            "numerical uncertainty",
            theme.MUTED,
            1.6,
            [(ratio, _half(row, unsure)) for row, ratio in known],
        ),
        *_dots(known, height),
    ]
    named = len(known) <= NAMED_ROWS
    sides = (
        [label_of(row.quantity) for row, _ in known]
        if named
        else _group_labels([row for row, _ in known])
    )
    value_text_at = tuple(
        (float(place), label) for place, label in zip(height, sides, strict=True) if label
    )
    span = (-1.0, float(len(known)))
    panel = Panel(
        "computed / given value (ratio)",
        "one row per value",
        tuple(layers),
        rules=(Rule("x", 1.0),),
        x_range=AXIS,
        y_range=span,
        y_tick_labels=value_text_at,
    )
    left = len(study.comparisons) - len(known)
    caption = "Each mark is a computed value over the given one; name, engine speed and source show on it. Triangles stand beyond the axis."
    caption += f" {left} values without a ratio are in the table only." if left else ""
    size = int(np.clip((17 if named else 7) * len(known), 120, 1100)) + 90
    return Chart("ratios", "Computed over given values", caption, (panel,), height=size)


def _spans(
    label: str, colour: str, width: float, spans: list[tuple[float, float | None]]
) -> list[Line]:
    """Level strokes of half width about a centre, one per row where a half width is known."""
    known = [(place, centre, half) for place, (centre, half) in enumerate(spans) if half]
    x = (
        np.array([[centre - half, centre + half, np.nan] for _, centre, half in known])
        .clip(*AXIS)
        .ravel()
    )
    return (
        [Line(x, np.repeat([float(place) for place, _, _ in known], 3), label, colour, width)]
        if known
        else []
    )


def _dots(known: list[tuple[Comparison, float]], height: np.ndarray) -> list[Marks]:
    found: list[Marks] = []
    beyond = np.array([not AXIS[0] <= ratio <= AXIS[1] for _, ratio in known])
    for origin in dict.fromkeys(row.origin for row, _ in known):
        _, label, colour, symbol = theme.origin_style(origin)
        for outside in (False, True):
            mine = np.array([row.origin == origin for row, _ in known]) & (beyond == outside)
            chosen = [known[place] for place in np.flatnonzero(mine)]
            x, hints = (
                np.array([ratio for _, ratio in chosen]).clip(*AXIS),
                tuple(_hint(row, ratio) for row, ratio in chosen),
            )
            alone = outside and not (found and found[-1].colour == colour)
            name, sign = (
                (f"{label}, beyond", "triangle")
                if outside
                else (label, "square" if symbol == "triangle" else symbol)
            )
            if chosen:
                found.append(
                    Marks(
                        x,
                        height[mine],
                        name,
                        colour,
                        sign,
                        in_legend=not outside or alone,
                        filled=True,
                        size=7,
                        hints=hints,
                    )
                )
    return found


def _hint(row: Comparison, ratio: float) -> str:
    speed = "at rest" if row.engine_speed is None else speed_text(row.engine_speed)
    computed, given = (
        number(in_unit(value, row.unit)) for value in (row.computed or 0.0, row.published)
    )
    source = row.source or row.origin
    return f"{label_of(row.quantity)}, {speed}: computed {computed}, given {given} {unit_text(row.unit)}, ratio {ratio:.3f}; {source}"


def _half(row: Comparison, unsure: Mapping[tuple[str, float], Uncertainty]) -> float | None:
    """Half width of the numerical uncertainty as a share of the given value, where one was computed
    for this number.
    """
    held = unsure.get((row.quantity, round(row.engine_speed or 0.0, 3)))
    fits = (
        held is not None
        and row.model == "finite-element"
        and same_speed(held.engine_speed, row.engine_speed)
    )
    return abs(held.numerical / row.published) if held is not None and fits else None


def _group_labels(rows: list[Comparison]) -> list[str]:
    """The engine speed, at the first row (from the top) of each."""
    label = [
        "at rest" if row.engine_speed is None else speed_text(row.engine_speed) for row in rows
    ]
    return [
        word if place == len(label) - 1 or label[place + 1] != word else ""
        for place, word in enumerate(label)
    ]


PUBLISHED_SPEC = SectionSpec("published", "Computed and given values", published_blocks)


#: Rows of a table beyond which it is folded, so that the figures below stay near.
ONE_SCREEN = 30


def uncertainty_blocks(study: Study) -> tuple[Block, ...]:
    """Nothing for a case that was changed, one of one's own, or numbers that another version or
    other engine speeds gave.
    """
    rows, fresh = load_uncertainty(study.record), fresh_uncertainty(study)
    if not fresh:
        return ()
    left = f"{len(rows) - len(fresh)} stored rows are left out: this run computes other values or other speeds."
    notes = (text(left, "note"),) if len(fresh) < len(rows) else ()
    grid: Block = uncertainty_grid(fresh)
    if len(fresh) > ONE_SCREEN:
        grid = Details(f"All {len(fresh)} numbers with their error bars", (grid,))
    return (text(firmness(fresh)), grid, text(lead(meshes_of(study.record)), "quiet"), *notes)


UNCERTAINTY_SPEC = SectionSpec("uncertainty", "Numbers with error bars", uncertainty_blocks)
