"""The page of a scanned spring: what was measured, with figures, and the design beside it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from valvetrain.measurements.spring_scan.result import ScannedSpring
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, figure_or_gap, text
from valvetrain.report.scan_charts import (
    cloud_chart,
    curves_chart,
    difference_chart,
    force_chart,
    motion_chart,
    residual_chart,
    section_chart,
)
from valvetrain.report.words import number, percent, speed_words, unit_words
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.studies.scan_against_design import ComparedNumber, ScanComparison

#: Quantities of a run that are compared where both have them, in this order: force spikes first.
IN_MOTION = (
    "peak_spring_force", "minimum_spring_force", "stage_2_peak_force", "stage_3_peak_force", "main_clash_peak_force",
    "main_clash_below_10_khz_peak_force", "peak_clash_force", "clash_count", "clash_energy", "surge_amplitude_force", "peak_shear_stress",
    "nominal_peak_shear_stress", "coil_bind_clearance",
)  # fmt: skip


def scan_rows(scan: ScannedSpring) -> list[tuple[str, str, str, str]]:
    """Words, value, twice its standard deviation and unit of what a scan tells."""
    section, curves = scan.section, scan.curves
    rows = [_row("free length", scan.free_length, 1e3, "mm"), _row("turns, tip to tip", scan.total_coils, 1.0, "")]
    if section.ovate:
        rows += [_row("wire, long axis", section.long_axis, 1e3, "mm"), _row("wire, short axis", section.short_axis, 1e3, "mm"),
                 _row("round wire that stands for it", section.diameter, 1e3, "mm")]  # fmt: skip
    else:
        rows.append(_row("wire diameter", section.diameter, 1e3, "mm"))
    known = np.where(curves.mean_diameter_spread < 3 * np.median(curves.mean_diameter_spread), curves.mean_diameter, np.nan)
    for words, place in (("largest", int(np.nanargmax(known))), ("smallest", int(np.nanargmin(known)))):
        pair = float(curves.mean_diameter[place]) + section.diameter[0], float(curves.mean_diameter_spread[place])
        rows.append(_row(f"{words} outer diameter", pair, 1e3, "mm"))
    place = int(curves.pitch.argmax())
    rows.append(_row("largest pitch", (float(curves.pitch[place]), float(curves.pitch_spread[place])), 1e3, "mm"))
    rows.append(("hand", scan.hand, "", ""))
    for word, end, coil in (("lower", scan.lower_end, scan.definition.lower_end), ("upper", scan.upper_end, scan.definition.upper_end)):
        rows.append((f"{word} end", end.kind.replace("-", " and "), "", ""))
        if end.face_points:
            rows.append((f"{word} end, ground turns", f"{coil.ground_coils:.3f}", "", ""))
            rows.append((f"{word} face against the axis", f"{57.29578 * end.face_lean:.2f}", "", "deg"))
    rows.append(("noise of a point", f"{1e6 * scan.noise:.1f}", "", "µm"))
    return rows


def _row(words: str, pair: tuple[float, float], factor: float, unit: str) -> tuple[str, str, str, str]:
    value, spread = factor * pair[0], 2 * factor * pair[1]
    return words, f"{value:.4g}" if spread <= 0 else f"{value:.3f}", "" if spread <= 0 else f"{max(spread, 0.001):.3f}", unit


def compared_rows(found: ScanComparison) -> list[tuple[str, str, str, str, str, str]]:
    """Words, run, design, scan, unit and difference of what is compared."""
    still = [one for one in found.numbers if one.engine_speed is None]
    moving = [one for name in IN_MOTION for one in found.numbers if one.quantity == name and one.engine_speed is not None]
    moving.sort(key=lambda one: (one.engine_speed or 0.0, one.label))
    return [_compared(one) for one in (*still, *moving)]


def _compared(one: ComparedNumber) -> tuple[str, str, str, str, str, str]:
    design, scanned = (float(shown(one.quantity, value)[0]) for value in (one.design, one.scanned))
    run = "" if one.engine_speed is None else f"{one.label}, {speed_words(one.engine_speed)}"
    apart = percent(one.scanned / one.design - 1) if one.design else ""
    return label_of(one.quantity), run, number(design, 4), number(scanned, 4), unit_words(definition_of(one.quantity).shown_unit), apart


def scan_page(scan: ScannedSpring, found: ScanComparison | None = None) -> Page:
    """The page of a scanned spring; ``found``: its design beside it."""
    design = None if found is None else found.cases[0].springs[0].wire
    told = Grid(
        ("", "value", "95 %", ""),
        tuple(((Cell(words[:1].upper() + words[1:]), Cell(value, "number"), Cell(spread and f"±{spread}", "number quiet"), Cell(unit)), ())
              for words, value, spread, unit in scan_rows(scan)),
    )  # fmt: skip
    drawn: list[Block] = [*figure_or_gap("cloud", cloud_chart, scan), *figure_or_gap("curves", curves_chart, scan, design)]
    sections = [Section("curves", "Cloud and curves", tuple(drawn))]
    if found is not None and design is not None:
        sections.append(Section("design", "Design against scan", _design_blocks(found, scan)))
    fits = (*figure_or_gap("section", section_chart, scan), *figure_or_gap("residuals", residual_chart, scan))
    sections += [
        Section("found", "What the scan gives", (told,)), Section("fits", "Section and residuals", fits),
        Section("notes", "What was found and assumed", tuple(text(one[:1].upper() + one[1:] + ".", "note") for one in scan.notes)),
    ]  # fmt: skip
    facts = (
        ("read as", f"{scan.form}, {scan.unit}"), ("points", f"{scan.points_read}, {scan.points_on_wire} on the wire"),
        ("turns", f"{scan.total_coils[0]:.2f}, {scan.hand} hand"), ("noise of a point", f"{1e6 * scan.noise:.0f} µm"),
    )  # fmt: skip
    lead = (
        "The surface of a tube whose axis is a smooth curve is fitted to the points. Intervals hold for points whose errors do not depend "
        "on each other; a scanner that is out by a share of the length puts all sizes out by that share."
    )
    return Page(scan.source, "Spring from a scan", lead, facts, tuple(sections), "Coils are counted from the lower tip.")


def _design_blocks(found: ScanComparison, scan: ScannedSpring) -> tuple[Block, ...]:
    design = found.cases[0].springs[0].wire
    assert design is not None
    blocks: list[Block] = [*figure_or_gap("difference", difference_chart, scan, design), *figure_or_gap("force", force_chart, found)]
    for chart in motion_charts(found):
        blocks.append(chart)
    rows: list[tuple[tuple[Cell, ...], tuple[str, ...]]] = []
    for run, group in groupby(compared_rows(found), key=lambda row: row[1]):
        rows.append(((Cell(run or "at rest"),), ()))
        for words, _, *numbers, unit, apart in group:
            cells = Cell(words[:1].upper() + words[1:]), *(Cell(one, "number") for one in numbers), Cell(unit), Cell(apart, "number")
            rows.append((cells, ()))
    blocks.append(Grid(("quantity", "design", "scan", "", "scan/design"), tuple(rows)))
    blocks += [text(sentence, "alert") for sentence in found.failures]
    return tuple(blocks)


def motion_charts(found: ScanComparison) -> Sequence[Block]:
    """The force of both at every speed, by every model."""
    if found.runs is None:
        return ()
    pairs = dict.fromkeys((one.engine_speed, one.label) for one in found.runs[0].solutions)
    charts = (motion_chart(found, engine_speed, label) for engine_speed, label in pairs)
    return [Figure(chart) for chart in charts if chart is not None]
