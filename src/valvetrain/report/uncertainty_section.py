"""How firm the headline numbers are: their numerical uncertainty and what the contact constants move, as a table and a page."""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.report.page import Block, Cell, Grid, Page, Section, text
from valvetrain.report.table import Table, table
from valvetrain.report.words import number, rpm, speed_words
from valvetrain.solution.definition import label_of
from valvetrain.solution.quantity import Quantity
from valvetrain.studies.uncertainty import Range, Uncertainty, UncertaintyStudy

#: SI unit -> unit shown and factor; the rest is shown as it is.
_SHOWN = {"rad": ("deg", 57.29577951308232), "N s": ("mN s", 1e3), "Pa": ("MPa", 1e-6)}
_HEADERS = (
    "quantity", "value", "± numerical", "", "unit", "order", "extrapolated", "contact stiffness × 0.35 to 2.5", "contact damping × 0 to 2",
)  # fmt: skip


def lead(meshes: Sequence[int]) -> str:
    """What the table shows."""
    return (
        f"Numerical uncertainty from meshes of {', '.join(map(str, meshes))} elements per coil and a halved step (grid convergence index, "
        "1.25 times the distance to the Richardson value; a wide bound from the range of the three, marked –, where they do not converge "
        "evenly). "
        "The last columns are physical: what the value does over a range of contact constants, which were not published."
    )


def uncertainty_grid(rows: Sequence[Uncertainty]) -> Grid:
    """One line per quantity, grouped by engine speed."""
    lines: list[tuple[tuple[Cell, ...], tuple[str, ...]]] = []
    for speed in dict.fromkeys(row.engine_speed for row in rows):
        lines.append(((Cell("Statics and modes" if speed is None else f"Engine speed {speed_words(speed)}"),), ()))
        lines += [(_cells(row), ()) for row in rows if row.engine_speed == speed]
    return Grid(_HEADERS, tuple(lines))


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
    head = (("quantity", "", [row.quantity for row in rows]), ("engine speed", "rpm", speeds), ("unit", "", units))
    return table(*head, *((name, "", values) for name, values in numbers.items()))


def uncertainty_page(study: UncertaintyStudy) -> Page:
    """The page of ``valvetrain refine``."""
    case = study.record
    failed = (text(words, "alert") for words in study.failures)
    blocks: tuple[Block, ...] = (text(lead(study.elements_per_coil), "quiet"), uncertainty_grid(study.rows), *failed)
    facts = (("case", case.name), ("elements per coil", ", ".join(map(str, study.elements_per_coil))))
    footer = "Angles are cam degrees. Engine speed is crank speed."
    section = Section("uncertainty", "Numbers with error bars", blocks)
    return Page(f"{case.title or case.name}: uncertainty", "Refinement study", case.description, facts, (section,), footer)


def _cells(row: Uncertainty) -> tuple[Cell, ...]:
    unit = Quantity(row.quantity).unit
    words, factor = _SHOWN.get(unit, (unit, 1.0))
    share = "" if unit == "rad" or row.value == 0 else f"{100 * row.numerical / abs(row.value):.2g} %"
    order = "–" if row.observed_order is None or row.observed_order < 0.5 else f"{row.observed_order:.1f}"

    def between(values: Range) -> str:
        low, high = (number(value * factor, 5) for value in values)
        return low if low == high else f"{low} to {high}"

    return (
        Cell(label_of(row.quantity), hint=row.quantity), Cell(number(row.value * factor, 5), "number"),
        Cell(number(row.numerical * factor, 2), "number"), Cell(share, "number quiet"), Cell(words, "quiet"), Cell(order, "number quiet"),
        Cell(number(row.extrapolated * factor, 5), "number"), Cell(between(row.contact_stiffness), "number"),
        Cell(between(row.contact_damping), "number"),
    )  # fmt: skip
