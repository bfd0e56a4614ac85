"""Computed and given values values, only where there are any: one dot plot, one table with filters,
findings, notes behind them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.fact_texts import error_bar_notes, study_notes
from valvetrain.report.model_charts import error_bar_chart
from valvetrain.report.page import (
    Block,
    Cell,
    Details,
    Figure,
    Grid,
    Page,
    Section,
    SectionSpec,
    figure_or_gap,
    prose,
    text,
)
from valvetrain.report.table import Table, comparison_grid, table
from valvetrain.report.text import in_unit, number, rpm, speed_text, unit_text
from valvetrain.report.verdict import verdict_of
from valvetrain.runs.error_bars import (
    STIFFNESS_FACTORS,
    UncertaintyStudy,
    grouped,
)
from valvetrain.runs.stored_error_bars import ROD, load_uncertainty, meshes_of
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.critical import DAMPING_FACTORS
from valvetrain.solution.definition import label_of
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.solution.quantity import Quantity, same_speed
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import CONSTANTS, NOT_RESOLVED, Range, Uncertainty

#: Ends of the ratio axis; values beyond are drawn at the end as a triangle, its number on hover.
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
    return (*found, *prose(study_notes(study), "Notes on these values")) if found else ()


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
    known = ratios(study.comparisons)[::-1]  # the first is on top
    if not known:
        return None
    height = np.arange(len(known), dtype=float)
    unsure = {
        (row.quantity, round(row.engine_speed or 0.0, 3)): row
        for row in study.error_bars.rows
        if row.label == ROD
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
    caption = "Each mark is a computed value over the given one; name, engine speed and source show on it. Triangles mark values beyond the axis."
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
    rows, fresh = load_uncertainty(study.record), study.error_bars.rows
    if not fresh:
        return ()
    left = f"{len(rows) - len(fresh)} stored rows are left out: this run computes other values or other speeds."
    notes = (text(left, "note"),) if len(fresh) < len(rows) else ()
    grid: Block = uncertainty_grid(fresh)
    if len(fresh) > ONE_SCREEN:
        grid = Details(f"All {len(fresh)} numbers with their error bars", (grid,))
    own = error_bar_notes(study.error_bars)
    computed = {row.label for row in study.error_bars.rows}
    others = any(row.label not in computed for row in fresh)
    shipped = (lead(meshes_of(study.record)),) if others else ()
    return (
        text(firmness(fresh)),
        grid,
        *(text(one, "quiet") for one in (*shipped, *own[:1])),
        *notes,
    )


UNCERTAINTY_SPEC = SectionSpec("uncertainty", "How exact the numbers are", uncertainty_blocks)


#: Share of a value that its numerical uncertainty may be for it to count as firm.
FIRM = 0.01
_HEADERS = ("quantity", "value", "± numerical", "", "unit", "order", "extrapolated")


def lead(meshes: Sequence[int]) -> str:
    """What the table shows of a spring on ``meshes``, or of a train (none)."""
    if not meshes:
        return (
            "Numerical uncertainty from a step halved twice (grid convergence index; a wide bound, marked –, where the three values do "
            "not converge evenly), springs divided 1.5 and 2.25 times as finely, half the samples per cycle, and the scatter of motions "
            "that do not repeat. The last columns are physical: what the value does where all contacts are half or twice as stiff, or "
            "damped so."
        )
    return (
        f"Numerical uncertainty from meshes of {', '.join(map(str, meshes))} elements per coil and a halved step (grid convergence index, "
        "1.25 times the distance to the Richardson value; a wide bound from the range of the three, marked –, where they do not converge "
        "evenly). "
        "The last columns are physical: what the value does over a range of contact constants, which were not published."
    )


def uncertainty_grid(rows: Sequence[Uncertainty]) -> Grid:
    """One line per quantity, grouped by engine speed and variant."""
    lines: list[tuple[tuple[Cell, ...], tuple[str, ...]]] = []
    for (speed, label), group in grouped(rows).items():
        caption = (
            "Statics and modes"
            if speed is None
            else f"Engine speed {speed_text(speed)}{f', {label}' if label else ''}"
        )
        lines += [((Cell(caption),), ()), *((_cells(row), ()) for row in group)]
    factors = zip(CONSTANTS, (STIFFNESS_FACTORS, DAMPING_FACTORS), strict=True)
    ranges = tuple(f"{word} × {least:g} to {most:g}" for word, (least, most) in factors)
    if all(row.range is None for row in rows):  # of one further run: neither constants nor orders
        shown_columns = (0, 1, 2, 3, 4)
        lines = [
            (cells if len(cells) == 1 else tuple(cells[n] for n in shown_columns), more)
            for cells, more in lines
        ]
        return Grid(tuple(_HEADERS[n] for n in shown_columns), tuple(lines))
    return Grid((*_HEADERS, *ranges), tuple(lines))


def firmness(rows: Sequence[Uncertainty]) -> str:
    """How many numbers are firm to :data:`FIRM`, and which are the least so, in a sentence."""
    share = {
        row: abs(row.numerical / row.value)
        for row in rows
        if row.value != 0 and Quantity(row.quantity).unit != "rad"
    }
    loose = sorted((row for row in share if share[row] > FIRM), key=lambda row: -share[row])
    firm = f"{len(share) - len(loose)} of {len(share)} numbers that are not zero are firm to {100 * FIRM:g} %"
    if not loose:
        return f"{firm}."
    named = [
        f"{label_of(row.quantity)}{_whose(row)} {_per_cent(share[row]) if row.resolved else NOT_RESOLVED}"
        for row in loose[:3]
    ]
    return f"{firm}; the least firm: {', '.join(named)}."


def _per_cent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def _whose(row: Uncertainty) -> str:
    label = [
        word
        for word in (row.label, "" if row.engine_speed is None else speed_text(row.engine_speed))
        if word
    ]
    return f" ({', '.join(label)})" if label else ""


def uncertainty_table(rows: Sequence[Uncertainty]) -> Table:
    """All rows in SI for ``uncertainty.csv``; speed in rpm of the crank, nan for statics and modes."""
    numbers = {
        "value": [row.value for row in rows], "numerical uncertainty": [row.numerical for row in rows],
        "observed order": [float("nan") if row.observed_order is None else row.observed_order for row in rows],
        "extrapolated": [row.extrapolated for row in rows], "part of the step": [row.step_part for row in rows],
        "least over contact stiffness": [row.contact_stiffness[0] for row in rows],
        "largest over contact stiffness": [row.contact_stiffness[1] for row in rows],
        "least over damping": [row.damping[0] for row in rows],
        "largest over damping": [row.damping[1] for row in rows],
    }  # fmt: skip
    speeds = [float("nan") if row.engine_speed is None else rpm(row.engine_speed) for row in rows]
    units = [Quantity(row.quantity).unit for row in rows]
    variant = (
        (("variant", "", [row.label for row in rows]),) if any(row.label for row in rows) else ()
    )
    head = (
        ("quantity", "", [row.quantity for row in rows]),
        *variant,
        ("engine speed", "rpm", speeds),
        ("unit", "", units),
    )
    return table(*head, *((name, "", values) for name, values in numbers.items()))


def levels_table(study: UncertaintyStudy) -> Table:
    """Every number (SI) of every run behind the error bars for ``levels.csv``, as
    :func:`uncertainty_table`.
    """
    found = [
        (level, speed, name, value)
        for level, by_speed in study.values.items()
        for speed, numbers in by_speed.items()
        for name, value in numbers.items()
    ]
    speeds = [float("nan") if speed is None else rpm(speed) for _, speed, _, _ in found]
    names = [name for _, _, name, _ in found]
    return table(
        ("level", "", [level for level, _, _, _ in found]),
        ("engine speed", "rpm", speeds),
        ("quantity", "", names),
        ("unit", "", [Quantity(name).unit for name in names]),
        ("value", "", [value for _, _, _, value in found]),
    )


def uncertainty_page(study: UncertaintyStudy) -> Page:
    """The page of ``valvetrain refine``."""
    case = study.record
    failed = (text(sentence, "alert") for sentence in study.failures)
    blocks: tuple[Block, ...] = (
        text(lead(study.elements_per_coil), "quiet"),
        uncertainty_grid(study.rows),
        *failed,
    )
    meshes = (
        (("elements per coil", ", ".join(map(str, study.elements_per_coil))),)
        if study.elements_per_coil
        else ()
    )
    facts = (("case", case.name), *meshes)
    footer = "Angles are cam degrees. Engine speed is crank speed."
    section = Section("uncertainty", "How exact the numbers are", blocks)
    chart = error_bar_chart(study.rows)
    return Page(
        f"{case.title or case.name}: uncertainty",
        "Refinement study",
        case.description,
        facts,
        (section,),
        footer,
        verdict_of(study),
        () if chart is None else (Figure(chart),),
    )


def _cells(row: Uncertainty) -> tuple[Cell, ...]:
    unit = Quantity(row.quantity).unit
    label, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    bare = unit == "rad" or row.value == 0 or not row.resolved
    share = "" if bare else f"{100 * row.numerical / abs(row.value):.2g} %"
    order = "–" if row.trusted_order is None else f"{row.trusted_order:.1f}"

    def between(values: Range) -> str:
        low, high = (number(value * factor, 5) for value in values)
        return low if low == high else f"{low} to {high}"

    return (
        Cell(label_of(row.quantity), hint=row.quantity),
        Cell(number(row.value * factor, 5), "number"),
        Cell(number(row.numerical * factor, 2) if row.resolved else NOT_RESOLVED, "number"),
        Cell(share, "number quiet"),
        Cell(label, "quiet"),
        Cell(order, "number quiet"),
        Cell(number(row.extrapolated * factor, 5), "number"),
        Cell(between(row.contact_stiffness), "number"),
        Cell(between(row.damping), "number"),
    )
