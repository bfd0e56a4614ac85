"""The page of a film: how the coils moved, their peaks, surge lines with damping, the model beside them, what was found and done."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.measurements.film.result import CoilMotion
from valvetrain.measurements.film.surge import BAND
from valvetrain.report.film_charts import (
    decay_chart,
    displacement_chart,
    overlay_chart,
    peaks_chart,
    space_time_chart,
    spectrum_chart,
)
from valvetrain.report.page import Block, Cell, Grid, Page, Section, figure_or_gap, text
from valvetrain.report.words import number, percent
from valvetrain.studies.film_model import FilmedModel

#: Heads of the tables on page and terminal.
PEAKS = ("coil", "mean peak (mm)", "95 %", "scatter of a turn (mm)")
PEAKS_WITH_MODEL = (*PEAKS, "model (mm)", "model less film")
LINES = ("line", "frequency", "95 %", "damping ratio", "95 %", "decay rate", "log. decrement", "amplitude")


def peak_rows(motion: CoilMotion, model: FilmedModel | None) -> list[tuple[str, ...]]:
    """Words of the peaks along the spring; mm."""
    rows: list[tuple[str, ...]] = []
    for one in motion.peaks:
        cells = (
            str(one.coil),
            f"{1e3 * one.mean:.3f}",
            f"±{1e3 * BAND * one.spread:.3f}",
            "–" if np.isnan(one.scatter) else f"{1e3 * one.scatter:.3f}",
        )
        if model is None:
            rows.append(cells)
            continue
        peak = float(model.peaks[one.coil - 1])
        share = percent(peak / one.mean - 1) if one.mean > 20 * max(one.spread, 1e-6) else "–"
        rows.append((*cells, f"{1e3 * peak:.3f}", share))
    return rows


def line_rows(motion: CoilMotion) -> list[tuple[str, ...]]:
    """Words of the surge lines."""
    lines = () if motion.surge is None else motion.surge.lines
    return [
        (
            str(place), f"{one.natural_frequency:.{digits(BAND * one.frequency_spread)}f} Hz", f"±{number(BAND * one.frequency_spread, 2)}",
            f"{one.damping_ratio:.{digits(BAND * one.damping_spread)}f}", f"±{number(BAND * one.damping_spread, 2)}",
            f"{one.decay_rate:.3g} 1/s", f"{one.logarithmic_decrement:.3g}", f"{1e6 * one.amplitude:.3g} µm",
        )
        for place, one in enumerate(lines, start=1)
    ]  # fmt: skip


def digits(width: float) -> int:
    """Decimals of a value that is known within ``width``."""
    return int(np.clip(1 - np.floor(np.log10(width)), 0, 7)) if width > 0 and np.isfinite(width) else 4


def model_rows(motion: CoilMotion, model: FilmedModel) -> list[tuple[str, str, str, str]]:
    """Each surge line of the film beside the nearest that the run shows, taken in the same way."""
    lines = () if motion.surge is None else motion.surge.lines
    rows = []
    for one in lines:
        others = () if model.surge is None else model.surge.lines
        near = min(others, key=lambda two: abs(two.natural_frequency - one.natural_frequency), default=None)
        if near is None or abs(near.natural_frequency / one.natural_frequency - 1) > 0.1:
            rows.append((f"{one.natural_frequency:.4g} Hz", f"{one.damping_ratio:.3g}", "–", "–"))
            continue
        rows.append(
            (f"{one.natural_frequency:.4g} Hz", f"{one.damping_ratio:.3g}", f"{near.natural_frequency:.4g} Hz", f"{near.damping_ratio:.3g}")
        )
    return rows


def film_page(motion: CoilMotion, model: FilmedModel | None = None, synthetic: bool = False) -> Page:
    """The whole page of a film."""
    sections = [Section("motion", "How the coils moved", (*figure_or_gap("Displacement of the coil sections", displacement_chart, motion),
                                                          *figure_or_gap("Space-time picture", space_time_chart, motion)))]  # fmt: skip
    if motion.peaks:
        head = PEAKS if model is None else PEAKS_WITH_MODEL
        drawn = figure_or_gap("Peak displacement along the spring", peaks_chart, motion, model)
        sections.append(Section("peaks", "Peaks along the spring", (*drawn, _grid(head, peak_rows(motion, model)))))
    if model is not None:
        lines = _grid(("line of the film", "its damping ratio", "line of the run", "its damping ratio"), model_rows(motion, model))
        blocks = (*figure_or_gap("Film and model", overlay_chart, motion, model), lines, _apart(model), *_sentences(model.notes))
        sections.append(Section("model", f"Beside the case {model.case}", blocks))
    surge: tuple[Block, ...] = (*figure_or_gap("Free decay", decay_chart, motion), *figure_or_gap("Spectrum", spectrum_chart, motion))
    if motion.surge is not None:
        surge = (surge[0], _grid(LINES, line_rows(motion)), *surge[1:])
    sections.append(Section("surge", "Surge lines and damping", surge))
    sections.append(Section("found", "What was found and done", _sentences(motion.notes)))
    lead = "Coils are followed by the glare line on each of them; displacements are of that line, along the picture."
    if synthetic:
        lead += " The film is synthetic: it was computed, not taken."
    return Page(motion.seen.name, "Film of a valve spring", lead, film_facts(motion), tuple(sections), "Angles are cam degrees.")


def film_facts(motion: CoilMotion) -> tuple[tuple[str, str], ...]:
    """What stands under the title."""
    rows, columns = motion.seen.size
    place = float(np.nanmedian(motion.spread))
    facts = [
        ("film", f"{len(motion.places)} frames of {columns} x {rows} px, {motion.seen.frame_rate:g} a second"),
        ("coils", str(motion.coils)), ("place of a coil within", f"{place:.2g} px = {1e6 * motion.metres_per_pixel * place:.2g} µm"),
    ]  # fmt: skip
    if motion.phase is None:
        return (*facts, ("cam", "does not turn"))
    spread = f" ±{number(BAND * 30 / np.pi * motion.phase.spread, 2)}" if motion.phase.spread else ""
    speed = f"{30 / np.pi * motion.phase.cam_speed:.6g}{spread} rpm, by the {motion.phase.by}"
    return (*facts, ("cam speed", speed), ("turns", str(max((one.cycles for one in motion.peaks), default=0))))


def _apart(model: FilmedModel) -> Block:
    worst = int(np.nanargmax(model.apart))
    words = ", ".join(f"{1e3 * value:.3g}" for value in model.apart)
    return text(f"Film less model, root mean square over the turn by coil: {words} mm; most at coil {worst + 1}.", "note")


def _grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Grid:
    return Grid(
        tuple(head),
        tuple((tuple(Cell(word, "number") for word in row), ()) for row in rows),
    )


def _sentences(notes: Sequence[str]) -> tuple[Block, ...]:
    return tuple(text(one[:1].upper() + one[1:] + ".", "note") for one in notes)
