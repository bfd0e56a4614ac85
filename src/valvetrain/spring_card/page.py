"""The page of a spring from its card or from a table of forces: what was requested, what the spring
has, what was left open.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import design_quantities
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, text
from valvetrain.report.text import number, percent, unit_text
from valvetrain.report.verdict import verdict_of
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.spring_card.card import weight
from valvetrain.spring_card.fit import CardDeviation, SpringFit, forces_at
from valvetrain.spring_card.tester import TesterFit

Array = NDArray[np.float64]
#: Quantity of a card -> its words, unit and factor from SI.
ROWS = {
    "installed_load": ("force at the first height", "N", 1.0), "open_load": ("force at the second height", "N", 1.0),
    "rate": ("rate between the two", "N/mm", 1e-3), "solid_height": ("solid height", "mm", 1e3), "mass": ("mass on the scales", "g", 1e3),
    "free_length": ("free length", "mm", 1e3), "total_coils": ("turns in all", "", 1.0),
}  # fmt: skip
#: Quantities of the found spring that a user looks at, in this order.
LOOKED_AT = (
    "active_coil_count", "estimated_surge_frequency", "smallest_index_ratio", "coil_bind_lift", "solid_force", "solid_nominal_shear_stress",
    "largest_pitch", "wire_length",
)  # fmt: skip
#: Heights at which the curve of a card's spring is drawn.
POINTS = 25


def held_rows(held: Sequence[CardDeviation]) -> list[tuple[str, str, str, str, str]]:
    """Words, value of the card, value of the spring, unit, and the difference."""
    rows = []
    for one in held:
        label, unit, factor = ROWS[one.quantity]
        requested = "" if one.requested is None else number(one.requested * factor, 4)
        apart = "" if one.requested is None else percent(one.found / one.requested - 1)
        rows.append((label, requested, number(one.found * factor, 4), unit, apart))
    return rows


def spring_rows(spring: InstalledSpring) -> list[tuple[str, str, str]]:
    """Words, value and unit of what a user looks at in a spring he was given."""
    found = design_quantities(spring)
    rows = []
    for name in LOOKED_AT:
        if name in found:
            rows.append(
                (
                    label_of(name),
                    number(float(shown(name, found[name])[0]), 4),
                    unit_text(definition_of(name).unit_word),
                )
            )
    return rows


def card_page(fit: SpringFit) -> Page:
    """The page of a spring that meets a catalogue card."""
    head = ("", "card", "spring", "", "difference")
    requested = Grid(
        head,
        tuple(
            (
                tuple(Cell(word, "number" if k in (1, 2, 4) else "") for k, word in enumerate(row)),
                (),
            )
            for row in held_rows(fit.held)
        ),
    )
    sections = (
        Section("card", "The card and the spring that meets it", (requested,)),
        Section("curve", "Pitch", (Figure(_pitch_chart(fit.spring)),)),
        Section("spring", "What the spring is", (_grid(fit.spring), text(f"{fit.in_engine}."))),
        Section("free", "What the card left open", _sentences(fit.free), folded=True),
    )
    lead = "Active turns and free length give the finite-element rod both loads of the card; the rest follows from its other values."
    return Page(
        fit.definition.name,
        "Spring from a catalogue card",
        lead,
        _facts(fit.spring),
        sections,
        "Heights are between the seats.",
        verdict=verdict_of(fit),
        picture=(Figure(_card_chart(fit)),),
    )


def tester_rows(fit: TesterFit) -> list[tuple[str, str, str, str]]:
    """Words, value, twice its standard deviation and unit of the results of a table of forces."""
    rows = [
        ("active turns", number(fit.active_coils[0], 4), number(2 * fit.active_coils[1], 2), ""),
        (
            "free length",
            number(1e3 * fit.free_length[0], 5),
            number(2e3 * fit.free_length[1], 2),
            "mm",
        ),
        (
            "force at the installed height",
            number(fit.preload[0], 4),
            number(2 * fit.preload[1], 2),
            "N",
        ),
        (
            "rate at the installed height",
            number(1e-3 * fit.rate[0], 4),
            number(2e-3 * fit.rate[1], 2),
            "N/mm",
        ),
        ("scatter of a station", number(fit.scatter, 2), "", "N"),
        ("rod against the table, at most", number(fit.worst_by_rod, 2), "", "N"),
        ("mass on the scales", number(1e3 * weight(fit.definition), 4), "", "g"),
    ]
    if fit.coil_bind is not None:
        rows.append(("coil bind begins at", number(1e3 * fit.coil_bind, 4), "", "mm"))
    if fit.table.hysteresis > 0:
        rows.append(
            ("loading against unloading, at most", number(2 * fit.table.hysteresis, 3), "", "N")
        )
    return rows


def tester_page(fit: TesterFit) -> Page:
    """The page of a spring behind a table of forces."""
    rows = tuple(
        (
            (
                Cell(label[:1].upper() + label[1:]),
                Cell(value, "number"),
                Cell(spread and f"±{spread}", "number quiet"),
                Cell(unit),
            ),
            (),
        )
        for label, value, spread, unit in tester_rows(fit)
    )
    found: tuple[Block, ...] = (
        Grid(("", "value", "95 %", ""), rows), *(text(note[:1].upper() + note[1:] + ".", "note") for note in fit.table.notes),
    )  # fmt: skip
    sections = (
        Section("found", "What the table gives", found),
        Section("pitch", "The pitch law behind it", (Figure(_pitch_chart(fit.spring, fit)),)),
        Section("spring", "What the spring is", (_grid(fit.spring),)),
        Section("free", "What the table left open", _sentences(fit.free), folded=True),
    )
    lead = "Active turns and pitch are fitted so that the coils close where the table stiffens; the finite-element rod is the check."
    return Page(
        fit.definition.name,
        "Spring from a table of forces",
        lead,
        _facts(fit.spring),
        sections,
        "Heights are between the seats.",
        verdict=verdict_of(fit),
        picture=(Figure(_tester_chart(fit)),),
    )


def _sentences(free: Sequence[str]) -> tuple[Block, ...]:
    return tuple(text(one[:1].upper() + one[1:] + ".", "note") for one in free)


def _grid(spring: InstalledSpring) -> Grid:
    rows = tuple(
        ((Cell(label[:1].upper() + label[1:]), Cell(value, "number"), Cell(unit)), ())
        for label, value, unit in spring_rows(spring)
    )
    return Grid(("quantity", "value", ""), rows)


def _facts(spring: InstalledSpring) -> tuple[tuple[str, str], ...]:
    wire = spring.wire
    assert wire is not None
    coil = np.linspace(0.0, wire.total_coils, 101)
    return (
        ("wire", f"{1e3 * float(wire.wire_diameter.value(0.0)):.4g} mm"),
        ("outer diameter", f"{1e3 * float(np.max(wire.outer_diameter(coil))):.4g} mm"),
        ("material", wire.material.name),
        ("turns", f"{wire.total_coils:.3f}"),
    )


def _card_chart(fit: SpringFit) -> Chart:
    card, wire = fit.card, fit.definition
    lowest = max(
        wire.solid_height + 0.03 * wire.solid_compression,
        min(card.open_load.height, wire.solid_height + 0.1 * wire.solid_compression),
    )
    loads = (card.installed_load, card.open_load)
    even = np.linspace(wire.free_length - 1e-4, lowest, POINTS)
    heights = np.unique([*even, *(one.height for one in loads)])[::-1]  # the line meets both loads
    marks = Marks(
        np.array([1e3 * one.height for one in loads]),
        np.array([one.force for one in loads]),
        "loads of the card",
        theme.INK,
        filled=True,
    )
    layers: tuple[Layer, ...] = (
        Line(
            1e3 * heights,
            np.array(forces_at(wire, heights.tolist())),
            "finite-element rod",
            theme.SERIES[0],
        ),
        marks,
    )
    panel = Panel("height between the seats (mm)", "force (N)", layers)
    return Chart(
        "spring-force",
        "Force over height",
        "The line ends shortly before the coils are solid.",
        (panel,),
        1,
        380,
    )


def _pitch_chart(spring: InstalledSpring, fit: TesterFit | None = None) -> Chart:
    wire = spring.wire
    assert wire is not None
    coil = np.linspace(0.0, wire.total_coils, 601)
    pitch = Line(coil, 1e3 * wire.pitch.value(coil), "pitch", theme.SERIES[0])
    closed = Line(
        coil,
        1e3 * wire.wire_diameter.value(coil),
        "wire diameter (coils closed)",
        theme.MUTED,
        1.0,
        "dash",
    )
    layers: list[Layer] = [pitch, closed]
    if fit is not None:
        found = fit.stations
        for sign in (-1.0, 1.0):
            edge = np.maximum(1e3 * (found.pitch + sign * 2 * found.spread), 0.0)
            layers.append(
                Line(
                    found.coil,
                    edge,
                    "95 % of what the table allows",
                    theme.MUTED,
                    0.9,
                    "dot",
                    sign < 0,
                )
            )
        layers.append(
            Marks(
                found.coil,
                1e3 * found.pitch,
                "station of the law",
                theme.INK,
                size=4.0,
                filled=True,
            )
        )
    top = 1.25 * 1e3 * float(np.max(wire.pitch.value(coil)))
    panel = Panel(
        "coil, from the lower tip (turns)", "pitch (mm per turn)", tuple(layers), y_range=(0.0, top)
    )
    return Chart(
        "spring-pitch",
        "Pitch over the coils",
        "Rise of the wire per turn, unloaded.",
        (panel,),
        1,
        340,
    )


def _tester_chart(fit: TesterFit) -> Chart:
    table, heights, forces = fit.table, fit.by_rod[:, 0], fit.by_rod[:, 2]
    measured = Marks(
        1e3 * table.heights, table.forces, "station of the table", theme.INK, size=3.5, filled=True
    )
    rod = Line(1e3 * heights, forces, "finite-element rod", theme.SERIES[0])
    rates = [
        (_middle(high), _slope(high, force))
        for high, force in ((heights, forces), (table.heights, table.forces))
    ]
    between = Marks(*rates[1], "between stations of the table", theme.INK, size=3.0, filled=True)
    top = 1.1 * float(np.max(table.forces))
    largest = max(float(np.max(rate)) for _, rate in rates)
    most = min(1.15 * largest, 6 * float(np.median(rates[1][1])))
    ends = (1e3 * float(np.min(heights)), 1e3 * float(np.max(heights)))
    panels = (
        Panel("height between the seats (mm)", "force (N)", (rod, measured), x_range=ends, y_range=(0.0, top)),
        Panel(
            "height between the seats (mm)", "rate (N/mm)",
            (Line(*rates[0], "finite-element rod", theme.SERIES[0], in_legend=False), between), x_range=ends, y_range=(0.0, most),
        ),
    )  # fmt: skip
    caption = "Rate between neighbouring stations carries the scatter of both."
    return Chart("tester-force", "Force and rate over height", caption, panels, 1, 620)


def _middle(heights: Array) -> Array:
    middle: Array = 5e2 * (heights[1:] + heights[:-1])
    return middle


def _slope(heights: Array, forces: Array) -> Array:
    slope: Array = -1e-3 * np.diff(forces) / np.diff(heights)
    return slope
