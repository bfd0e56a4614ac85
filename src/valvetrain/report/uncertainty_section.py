"""How firm the headline numbers are: their numerical uncertainty and what the contact constants
move, as a table and a page.
"""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.report.page import Block, Cell, Grid, Page, Section, text
from valvetrain.report.table import Table, table
from valvetrain.report.text import number, rpm, speed_text
from valvetrain.runs.error_bars import (
    CONTACT_FACTORS,
    DAMPING_FACTORS,
    STIFFNESS_FACTORS,
    Range,
    Uncertainty,
    UncertaintyStudy,
)
from valvetrain.solution.definition import label_of
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.solution.quantity import Quantity

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
    for speed, label in dict.fromkeys((row.engine_speed, row.label) for row in rows):
        caption = (
            "Statics and modes"
            if speed is None
            else f"Engine speed {speed_text(speed)}{f', {label}' if label else ''}"
        )
        lines.append(((Cell(caption),), ()))
        lines += [
            (_cells(row), ()) for row in rows if (row.engine_speed, row.label) == (speed, label)
        ]
    stiffness, damping = (
        (CONTACT_FACTORS,) * 2
        if any(row.label for row in rows)
        else (STIFFNESS_FACTORS, DAMPING_FACTORS)
    )
    ranges = (
        f"contact {word} × {least:g} to {most:g}"
        for word, (least, most) in (("stiffness", stiffness), ("damping", damping))
    )
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
        f"{label_of(row.quantity)}{_whose(row)} {_per_cent(share[row])} %" for row in loose[:3]
    ]
    return f"{firm}; the least firm: {', '.join(named)}."


def _per_cent(share: float) -> str:
    return f"{100 * share:.0f}" if share >= 0.1 else f"{100 * share:.2g}"


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
        "least over contact damping": [row.contact_damping[0] for row in rows],
        "largest over contact damping": [row.contact_damping[1] for row in rows],
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
    section = Section("uncertainty", "Numbers with error bars", blocks)
    return Page(
        f"{case.title or case.name}: uncertainty",
        "Refinement study",
        case.description,
        facts,
        (section,),
        footer,
    )


def _cells(row: Uncertainty) -> tuple[Cell, ...]:
    unit = Quantity(row.quantity).unit
    label, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    share = (
        "" if unit == "rad" or row.value == 0 else f"{100 * row.numerical / abs(row.value):.2g} %"
    )
    order = (
        "–"
        if row.observed_order is None or row.observed_order < 0.5
        else f"{row.observed_order:.1f}"
    )

    def between(values: Range) -> str:
        low, high = (number(value * factor, 5) for value in values)
        return low if low == high else f"{low} to {high}"

    return (
        Cell(label_of(row.quantity), hint=row.quantity),
        Cell(number(row.value * factor, 5), "number"),
        Cell(number(row.numerical * factor, 2), "number"),
        Cell(share, "number quiet"),
        Cell(label, "quiet"),
        Cell(order, "number quiet"),
        Cell(number(row.extrapolated * factor, 5), "number"),
        Cell(between(row.contact_stiffness), "number"),
        Cell(between(row.contact_damping), "number"),
    )
