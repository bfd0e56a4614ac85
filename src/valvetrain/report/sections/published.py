"""Computed and given values values, only where there are any: one dot plot, one table with filters,
findings, notes behind them.
"""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.report.model_charts import error_bar_chart
from valvetrain.report.page import (
    Block,
    Cell,
    Figure,
    Grid,
    Page,
    Section,
    text,
)
from valvetrain.report.table import Table, table
from valvetrain.report.text import number, rpm, speed_text
from valvetrain.report.verdict import verdict_of
from valvetrain.runs.error_bars import (
    STIFFNESS_FACTORS,
    UncertaintyStudy,
    grouped,
)
from valvetrain.solution.critical import DAMPING_FACTORS
from valvetrain.solution.definition import label_of
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.solution.quantity import Quantity
from valvetrain.solution.uncertainty import CONSTANTS, NOT_RESOLVED, Range, Uncertainty

#: Ends of the ratio axis; values beyond are drawn at the end as a triangle, its number on hover.
AXIS = (0.5, 1.5)


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
