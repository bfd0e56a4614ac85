"""The page of a film: how the coils moved, their peaks, surge lines with damping, the compared model,
what was found and done.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.film.cycles import mean_of
from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.film.surge import BAND
from valvetrain.film.tables import (
    LINE_COLUMNS,
    PEAK_COLUMNS,
    line_table,
    peak_columns,
    peak_table,
)
from valvetrain.measured.cycles import MeasuredCycles, write_cycles
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, HeatMap, Layer, Line, Marks, Panel, Rule, thin
from valvetrain.report.page import Block, Cell, Grid, Page, Section, figure_or_gap, text
from valvetrain.report.study import StudyFiles, with_page
from valvetrain.report.text import number
from valvetrain.report.verdict import verdict_of
from valvetrain.solution.atomic import write_text
from valvetrain.views.columns import csv_row, grid, json_row

Array = NDArray[np.float64]
#: Frames and stations of the space-time picture at most, dots of a coil at most, points of the
#: spectrum at most.
FRAMES, STATIONS, DOTS, POINTS = 400, 300, 600, 1500
#: Cam revolutions that the space-time picture shows, and the grey ramp of it.
TURNS, GREYS = 3.0, ("#000000", "#a4acb5")
#: Colours of the tracks on the dark picture, in the order of the coils' own.
SEEN = tuple(theme.mix(colour, "#ffffff", 0.35) for colour in theme.SERIES)
#: What the film measured has the first colour wherever it is shown with the model's.
FILM, MODEL = theme.SERIES[0], theme.SERIES[1]
#: Share of the largest motion below which a coil counts as fixed.
STILL = 0.02


def coil_colour(coil: int) -> str:
    """Colour of a coil (counted from 0) where several are in one panel."""
    return theme.SERIES[coil % len(theme.SERIES)]


def space_time_chart(motion: CoilMotion) -> Chart:
    """The line over time as the camera saw it, with the tracks on it."""
    last = len(motion.time)
    if motion.phase is not None:
        last = int(
            np.searchsorted(motion.phase.cam_angle, motion.phase.cam_angle[0] + TURNS * 2 * np.pi)
        )
    last = int(np.clip(last, min(16, len(motion.time)), FRAMES))
    picture = motion.seen.picture[:last]
    number = motion.seen.number[:last]
    even = np.zeros((int(number[-1]) + 1, picture.shape[1]))
    even[number] = picture
    every = max(1, -(-picture.shape[1] // STATIONS))
    whole_columns = picture.shape[1] // every * every
    shown = even[:, :whole_columns].reshape(len(even), -1, every).mean(axis=2)
    shown = np.asarray(np.clip(shown - np.percentile(picture, 1), 0, None), dtype=float)
    milliseconds = np.asarray(
        1e3 * np.arange(len(even), dtype=float) / motion.seen.frame_rate, dtype=float
    )
    # The start of the line is above, as on the picture.
    length = float(motion.seen.line.stations[-1])
    height = length - (np.arange(shown.shape[1])[::-1] * every + 0.5 * (every - 1))
    layers: list[Layer] = [
        HeatMap(
            milliseconds,
            height,
            shown.T[::-1],
            "brightness",
            "grey levels",
            1.0,
            "px",
            colours=GREYS,
        )
    ]
    with_drift = motion.places + motion.drift[:, None]
    for coil in range(motion.coils):
        track = length - with_drift[:last, coil]
        layers.append(
            Line(1e3 * motion.time[:last], track, f"coil {coil + 1}", SEEN[coil % len(SEEN)], 1.4)
        )
    panel = Panel(
        "time (ms)",
        "distance from the end of the line (px)",
        tuple(layers),
        x_range=(0.0, float(milliseconds[-1])),
        y_range=(0.0, length),
    )
    caption = "Coils are counted from the seat. " + (
        "The first cam revolutions." if last < len(motion.time) else "The whole film."
    )
    return Chart("space-time", "Space-time picture with the tracks", caption, (panel,), 1, 520)


def displacement_chart(motion: CoilMotion) -> Chart | None:
    """Every coil section over the cam angle: mean of the turns, and every frame as a dot."""
    if motion.phase is None or motion.dwell is None:
        return None
    layers: list[Layer] = []
    angle = np.degrees(np.mod(motion.phase.cam_angle, 2 * np.pi))
    every = max(1, len(angle) // DOTS)
    for coil, cycles in reversed(list(enumerate(motion.cycles))):
        colour = coil_colour(coil)
        dots = motion.displacement[::every, coil]
        layers.append(
            Marks(angle[::every], 1e3 * dots, "", colour, size=2.5, filled=True, in_legend=False)
        )
        layers.append(
            Line(
                np.degrees(cycles.cam_angle),
                1e3 * mean_of(cycles.values),
                f"coil {coil + 1}",
                colour,
                1.6,
            )
        )
    first, last = np.degrees(motion.dwell)
    bands: tuple[Band, ...] = (Band(first, min(last, 360.0), "valve closed"),)
    if last > 360:
        bands = (*bands, Band(0.0, last - 360.0, ""))
    panel = Panel(
        "cam angle (cam degrees)",
        "displacement towards the seat (mm)",
        tuple(layers),
        bands=bands,
        x_range=(0.0, 360.0),
        x_step=60.0,
    )
    caption = "Lines: mean of the turns. Dots: single frames. Zero: rest with the valve closed."
    return Chart("displacement", "Displacement of the coil sections", caption, (panel,), 1, 460)


def peaks_chart(motion: CoilMotion, model: FilmedModel | None) -> Chart | None:
    """Mean peak displacement of every coil with the scatter of the turns, as figure 3 of
    vasilyev2016.
    """
    if not motion.peaks:
        return None
    coil = np.array([one.coil for one in motion.peaks], dtype=float)
    mean = 1e3 * np.array([one.mean for one in motion.peaks])
    scatter = 1e3 * np.array([one.scatter for one in motion.peaks])
    bars = np.stack([mean - scatter, mean + scatter, np.full_like(mean, np.nan)], axis=1).ravel()
    layers: list[Layer] = [
        Line(
            np.repeat(coil, 3), bars, "scatter of a turn (one standard deviation)", theme.MUTED, 3.0
        ),
        Marks(coil, mean, "film, mean of the turns", FILM, filled=True, size=7.0),
    ]
    if model is not None:
        layers.append(
            Line(
                coil,
                1e3 * model.peaks,
                f"model {theme.model_label(model.model)}",
                MODEL,
                1.4,
                "dash",
            )
        )
        layers.append(
            Marks(coil, 1e3 * model.peaks, "", MODEL, "diamond", in_legend=False, size=13.0)
        )
    scatter = np.nan_to_num(scatter)
    top = 1.12 * max(
        float(np.max(mean + scatter)), 0.0 if model is None else 1e3 * float(model.peaks.max())
    )
    reach = (0.5, motion.coils + 0.5)
    panel = Panel(
        "coil, counted from the seat",
        "mean peak displacement (mm)",
        tuple(layers),
        x_range=reach,
        x_step=1.0,
        y_range=(min(0.0, float(np.min(mean - scatter))), top),
    )
    return Chart("peaks", "Peak displacement along the spring", "", (panel,), 1, 380)


def overlay_chart(motion: CoilMotion, model: FilmedModel) -> Chart:
    """A panel per coil section, the one that moves most first: film and model over the cam angle."""
    panels = []
    degrees = np.degrees(model.cam_angle)
    largest = [1e3 * float(np.ptp(mean_of(cycles.values))) for cycles in motion.cycles]
    for coil in np.argsort(-np.array(largest), kind="stable").tolist():
        cycles = motion.cycles[coil]
        still = largest[coil] < STILL * max(largest)
        layers: tuple[Layer, ...] = (
            Line(degrees, 1e3 * mean_of(cycles.values), "film, mean of the turns", FILM, 1.8),
            Line(
                degrees,
                1e3 * model.displacement[:, coil],
                f"model {theme.model_label(model.model)}",
                MODEL,
                1.4,
                "dash",
            ),
        )
        title = f"coil {coil + 1} (turn {model.turns[coil]:.2f})"
        panels.append(
            Panel(
                "cam angle (cam degrees)",
                "displacement (mm)",
                layers,
                title,
                x_range=(0.0, 360.0),
                x_step=90.0,
                # what hardly moves is noise, which a scale of its own would make a motion
                y_range=(-STILL * max(largest), STILL * max(largest)) if still else None,
            )
        )
    columns = 2 if len(panels) > 1 else 1
    rows = -(-len(panels) // columns)
    caption = f"Same sections of the {model.spring} spring. Towards the seat, from rest with the valve closed."
    return Chart("overlay", "Film and model", caption, tuple(panels), columns, 120 + 210 * rows)


def spectrum_chart(motion: CoilMotion) -> Chart:
    """Amplitude over frequency of the whole film, with the lines of the decay."""
    hertz, micrometres = thin(
        motion.spectrum_frequency[1:], 1e6 * motion.spectrum_amplitude[1:], POINTS
    )
    lines = () if motion.surge is None else motion.surge.lines
    rules = tuple(
        Rule("x", one.natural_frequency, f"{one.natural_frequency:.0f} Hz") for one in lines
    )
    floor = 0.3 * float(np.median(micrometres))
    curve = Line(hertz, np.maximum(micrometres, floor), "", FILM, 1.2, in_legend=False)
    panel = Panel(
        "frequency (Hz)",
        "amplitude (µm), root mean square over coils",
        (curve,),
        rules=rules,
        x_range=(0.0, 0.5 * motion.seen.frame_rate),
        y_log=True,
    )
    sentence = "Whole film, Hann window. " + (
        "A turning cam makes lines at its multiples. " if motion.phase is not None else ""
    )
    return Chart(
        "spectrum",
        "Spectrum with the surge lines",
        sentence + "Dotted: surge lines found in the decay.",
        (panel,),
        1,
        360,
        legend=False,
    )


def decay_chart(motion: CoilMotion) -> Chart | None:
    """One decay as measured and as fitted, and the envelope of its first line."""
    surge = motion.surge
    if surge is None:
        return None
    milliseconds = 1e3 * surge.time
    layers: tuple[Layer, ...] = (
        Line(
            1e3 * surge.curve_time,
            1e3 * surge.curve,
            "damped sines fitted to all coils and dwells",
            theme.INK,
            1.3,
        ),
        Marks(milliseconds, 1e3 * surge.measured, "film", FILM, size=4.5, filled=True),
    )
    panel = Panel(
        "time from the beginning of the dwell (ms)",
        "displacement (mm)",
        layers,
        f"coil {surge.coil}",
    )
    caption = (
        f"The coil that rings most. A place scatters by {1e6 * surge.scatter:.2g} µm about the fit of {surge.decays} decay"
        + ("s." if surge.decays != 1 else ".")
    )
    return Chart("decay", "Free decay", caption, (panel,), 1, 360)


def model_rows(motion: CoilMotion, model: FilmedModel) -> list[tuple[str, str, str, str]]:
    """Each surge line of the film and the nearest that the run shows, taken in the same way."""
    lines = () if motion.surge is None else motion.surge.lines
    rows = []
    for one in lines:
        others = () if model.surge is None else model.surge.lines
        near = min(
            others, key=lambda two: abs(two.natural_frequency - one.natural_frequency), default=None
        )
        if near is None or abs(near.natural_frequency / one.natural_frequency - 1) > 0.1:
            rows.append((f"{one.natural_frequency:.4g} Hz", f"{one.damping_ratio:.3g}", "–", "–"))
            continue
        rows.append(
            (
                f"{one.natural_frequency:.4g} Hz",
                f"{one.damping_ratio:.3g}",
                f"{near.natural_frequency:.4g} Hz",
                f"{near.damping_ratio:.3g}",
            )
        )
    return rows


def film_page(
    motion: CoilMotion, model: FilmedModel | None = None, synthetic: bool = False
) -> Page:
    """The whole page of a film."""
    moved = figure_or_gap("Displacement of the coil sections", displacement_chart, motion)
    picture = (
        moved if model is None else figure_or_gap("Film and model", overlay_chart, motion, model)
    )
    sections = [
        Section(
            "motion",
            "How the coils moved",
            (
                *(() if model is None else moved),
                *figure_or_gap("Space-time picture", space_time_chart, motion),
            ),
        )
    ]
    if motion.peaks:
        drawn = figure_or_gap("Peak displacement along the spring", peaks_chart, motion, model)
        sections.append(
            Section(
                "peaks",
                "Peaks along the spring",
                (*drawn, grid(peak_columns(model), peak_table(motion, model))),
            )
        )
    if model is not None:
        lines = _grid(
            ("line of the film", "its damping ratio", "line of the run", "its damping ratio"),
            model_rows(motion, model),
        )
        blocks = (
            lines,
            _apart(model),
            *_sentences(model.notes),
        )
        sections.append(Section("model", f"Compared with the case {model.case}", blocks))
    decay = figure_or_gap("Free decay", decay_chart, motion)
    lines_found = () if motion.surge is None else (grid(LINE_COLUMNS, line_table(motion)),)
    surge: tuple[Block, ...] = (
        *(decay if picture else ()),  # of a cam that does not turn it opens the page
        *lines_found,
        *figure_or_gap("Spectrum", spectrum_chart, motion),
    )
    sections.append(Section("surge", "Surge lines and damping", surge))
    sections.append(
        Section("found", "What was found and done", _sentences(motion.notes), folded=True)
    )
    lead = "Coils are followed by the glare line on each of them; displacements are of that line, along the picture."
    if synthetic:
        lead += " The film is synthetic: it was computed, not taken."
    return Page(
        motion.seen.name,
        "Film of a valve spring",
        lead,
        film_facts(motion),
        tuple(sections),
        "Angles are cam degrees.",
        verdict=verdict_of(motion) if model is None else verdict_of(model),
        picture=(picture or decay)[:1],
    )


def film_facts(motion: CoilMotion) -> tuple[tuple[str, str], ...]:
    """The line under the title."""
    rows, columns = motion.seen.size
    place = float(np.nanmedian(motion.spread))
    facts = [
        ("film", f"{len(motion.places)} frames of {columns} x {rows} px, {motion.seen.frame_rate:g} a second"),
        ("coils", str(motion.coils)), ("place of a coil within", f"{place:.2g} px = {1e6 * motion.metres_per_pixel * place:.2g} µm"),
    ]  # fmt: skip
    if motion.phase is None:
        return (*facts, ("cam", "does not turn"))
    spread = (
        f" ±{number(BAND * 30 / np.pi * motion.phase.spread, 2)}" if motion.phase.spread else ""
    )
    speed = f"{30 / np.pi * motion.phase.cam_speed:.6g}{spread} rpm, by the {motion.phase.by}"
    return (
        *facts,
        ("cam speed", speed),
        ("turns", str(max((one.cycles for one in motion.peaks), default=0))),
    )


def _apart(model: FilmedModel) -> Block:
    worst = int(np.nanargmax(model.apart))
    sentence = ", ".join(f"{1e3 * value:.3g}" for value in model.apart)
    return text(
        f"Film less model, root mean square over the turn by coil: {sentence} mm; most at coil {worst + 1}.",
        "note",
    )


def _grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Grid:
    return Grid(
        tuple(head),
        tuple((tuple(Cell(word, "number") for word in row), ()) for row in rows),
    )


def _sentences(notes: Sequence[str]) -> tuple[Block, ...]:
    return tuple(text(one[:1].upper() + one[1:] + ".", "note") for one in notes)


def named_cycles(motion: CoilMotion, model: FilmedModel | None) -> tuple[MeasuredCycles, ...]:
    """Measured cycles of every coil; as a run has them, under the names that the same curves have there."""
    if model is None:
        return motion.cycles
    return tuple(
        replace(one, quantity=name)
        for one, name in zip(motion.cycles, model.quantities, strict=True)
    )


def write_film(motion: CoilMotion, model: FilmedModel | None, folder: Path) -> list[Path]:
    """``displacement-coil-N.csv`` (measured cycles), ``peaks.csv``, ``tracks.csv``,
    ``spectrum.csv`` and, with a model, ``model.csv``.
    """
    files = [
        write_cycles(folder / f"displacement-coil-{coil}.csv", [one])
        for coil, one in enumerate(named_cycles(motion, model), start=1)
    ]
    coils = range(1, motion.coils + 1)
    columns = [
        1e3 * motion.time,
        *(() if motion.phase is None else (np.degrees(motion.phase.cam_angle),)),
    ]
    heads = ["time [ms]", *(() if motion.phase is None else ("cam angle [deg]",))]
    kinds = (
        ("displacement of coil", "mm"),
        ("place of coil", "px"),
        ("standard deviation of coil", "px"),
    )
    heads += [f"{word} {coil} [{unit}]" for word, unit in kinds for coil in coils]
    tracks = np.column_stack([*columns, 1e3 * motion.displacement, motion.places, motion.spread])
    files.append(write_text(folder / "tracks.csv", _csv(heads, tracks)))
    files.append(
        write_text(
            folder / "spectrum.csv",
            _csv(
                ("frequency [Hz]", "amplitude [um]"),
                np.column_stack([motion.spectrum_frequency, 1e6 * motion.spectrum_amplitude]),
            ),
        )
    )
    if motion.peaks:
        head = [column.csv for column in PEAK_COLUMNS if column.csv]
        rows = np.array([csv_row(PEAK_COLUMNS, row) for row in peak_table(motion, None)])
        files.append(write_text(folder / "peaks.csv", _csv(head, rows)))
    if model is not None:
        heads = [
            "cam angle [deg]",
            *(
                f"coil {coil}, turn {turn:.2f} [mm]"
                for coil, turn in zip(coils, model.turns, strict=True)
            ),
        ]
        files.append(
            write_text(
                folder / "model.csv",
                _csv(
                    heads, np.column_stack([np.degrees(model.cam_angle), 1e3 * model.displacement])
                ),
            )
        )
    return files


def _csv(head: Iterable[str], rows: Array) -> str:
    # A head with a comma in it is quoted, as CSV has it.
    first = ",".join(f'"{one}"' if "," in one else one for one in head)
    lines = (",".join("" if np.isnan(value) else f"{value:.7g}" for value in row) for row in rows)
    return "\n".join([first, *lines]) + "\n"


def film_json(motion: CoilMotion, model: FilmedModel | None) -> dict[str, Any]:
    """The JSON answer, SI."""
    line = motion.seen.line
    data: dict[str, Any] = {
        "command": "film", "case": "" if model is None else model.case, "completed": True, "frames": len(motion.places),
        "coils": motion.coils,
        "frame_rate": motion.seen.frame_rate, "line": {"start": list(line.start), "end": list(line.end), "unit": "px"},
        "metres_per_pixel": {"value": motion.metres_per_pixel, "standard_deviation": motion.scale_spread},
        "place_standard_deviation": {"value": float(np.nanmedian(motion.spread)), "unit": "px"},
        "camera_drift": {"value": float(np.ptp(motion.drift)), "unit": "px"},
        "cam_speed": None if motion.phase is None else {
            "value": motion.phase.cam_speed, "standard_deviation": motion.phase.spread, "by": motion.phase.by},
        "dwell": None if motion.dwell is None else list(motion.dwell),
        "peaks": [json_row(PEAK_COLUMNS, row) for row in peak_table(motion, None)],
        "surge_lines": [json_row(LINE_COLUMNS, row) for row in line_table(motion)],
        "notes": list(motion.notes),
    }  # fmt: skip
    if model is not None:
        data["model"] = {
            "model": model.model, "spring": model.spring, "turns": model.turns, "quantities": list(model.quantities),
            "peaks": model.peaks, "root_mean_square_apart": model.apart,
            "surge_frequency": model.surge_frequency, "cam_angle_shift": model.shift, "notes": list(model.notes),
            "surge_lines": [{"frequency": one.natural_frequency, "damping_ratio": one.damping_ratio}
                            for one in (() if model.surge is None else model.surge.lines)],
        }  # fmt: skip
    return data


def report_film(motion: CoilMotion, folder: Path, model: FilmedModel | None = None) -> StudyFiles:
    """The page of a film and the files of :func:`write_film`."""
    return with_page(film_page(motion, model), folder, write_film(motion, model, folder))
