"""Figures of a film: space-time picture, displacements over the cam angle, peaks along the spring, spectrum, decay, the model beside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.film.cycles import mean_of
from valvetrain.measurements.film.result import CoilMotion
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, HeatMap, Layer, Line, Marks, Panel, Rule, thin
from valvetrain.studies.film_model import FilmedModel

Array = NDArray[np.float64]
#: Frames and stations of the space-time picture at most, dots of a coil at most, points of the spectrum at most.
FRAMES, STATIONS, DOTS, POINTS = 400, 300, 600, 1500
#: Turns of the cam that the space-time picture shows, and the grey ramp of it.
TURNS, GREYS = 3.0, ("#000000", "#a4acb5")
#: Colours of the tracks on the dark picture, in the order of the coils' own.
SEEN = tuple(theme.mix(colour, "#ffffff", 0.35) for colour in theme.SERIES)
#: What the film measured has the first colour wherever it stands beside the model's.
FILM, MODEL = theme.SERIES[0], theme.SERIES[1]


def coil_colour(coil: int) -> str:
    """Colour of a coil (counted from 0) where several stand in one panel."""
    return theme.SERIES[coil % len(theme.SERIES)]


def space_time_chart(motion: CoilMotion) -> Chart:
    """The line over time as the camera saw it, with the tracks on it."""
    last = len(motion.time)
    if motion.phase is not None:
        last = int(np.searchsorted(motion.phase.cam_angle, motion.phase.cam_angle[0] + TURNS * 2 * np.pi))
    last = int(np.clip(last, min(16, len(motion.time)), FRAMES))
    picture = motion.seen.picture[:last]
    number = motion.seen.number[:last]
    even = np.zeros((int(number[-1]) + 1, picture.shape[1]))
    even[number] = picture
    every = max(1, -(-picture.shape[1] // STATIONS))
    kept = picture.shape[1] // every * every
    shown = even[:, :kept].reshape(len(even), -1, every).mean(axis=2)
    shown = np.asarray(np.clip(shown - np.percentile(picture, 1), 0, None), dtype=float)
    milliseconds = np.asarray(1e3 * np.arange(len(even), dtype=float) / motion.seen.frame_rate, dtype=float)
    # The start of the line stands above, as on the picture.
    length = float(motion.seen.line.stations[-1])
    height = length - (np.arange(shown.shape[1])[::-1] * every + 0.5 * (every - 1))
    layers: list[Layer] = [HeatMap(milliseconds, height, shown.T[::-1], "brightness", "grey levels", 1.0, "px", colours=GREYS)]
    with_drift = motion.places + motion.drift[:, None]
    for coil in range(motion.coils):
        track = length - with_drift[:last, coil]
        layers.append(Line(1e3 * motion.time[:last], track, f"coil {coil + 1}", SEEN[coil % len(SEEN)], 1.4))
    panel = Panel(
        "time (ms)", "distance from the end of the line (px)", tuple(layers), x_range=(0.0, float(milliseconds[-1])), y_range=(0.0, length)
    )
    caption = "Coils are counted from the seat. " + ("The first turns of the cam." if last < len(motion.time) else "The whole film.")
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
        layers.append(Marks(angle[::every], 1e3 * dots, "", colour, size=2.5, filled=True, in_legend=False))
        layers.append(Line(np.degrees(cycles.cam_angle), 1e3 * mean_of(cycles.values), f"coil {coil + 1}", colour, 1.6))
    first, last = np.degrees(motion.dwell)
    bands: tuple[Band, ...] = (Band(first, min(last, 360.0), "valve closed"),)
    if last > 360:
        bands = (*bands, Band(0.0, last - 360.0, ""))
    panel = Panel(
        "cam angle (cam degrees)", "displacement towards the seat (mm)", tuple(layers), bands=bands, x_range=(0.0, 360.0), x_step=60.0
    )
    caption = "Lines: mean of the turns. Dots: single frames. Zero: rest with the valve closed."
    return Chart("displacement", "Displacement of the coil sections", caption, (panel,), 1, 460)


def peaks_chart(motion: CoilMotion, model: FilmedModel | None) -> Chart | None:
    """Mean peak displacement of every coil with the scatter of the turns, as figure 3 of vasilyev2016."""
    if not motion.peaks:
        return None
    coil = np.array([one.coil for one in motion.peaks], dtype=float)
    mean = 1e3 * np.array([one.mean for one in motion.peaks])
    scatter = 1e3 * np.array([one.scatter for one in motion.peaks])
    bars = np.stack([mean - scatter, mean + scatter, np.full_like(mean, np.nan)], axis=1).ravel()
    layers: list[Layer] = [
        Line(np.repeat(coil, 3), bars, "scatter of a turn (one standard deviation)", theme.MUTED, 3.0),
        Marks(coil, mean, "film, mean of the turns", FILM, filled=True, size=7.0),
    ]
    if model is not None:
        layers.append(Line(coil, 1e3 * model.peaks, f"model {theme.model_words(model.model)}", MODEL, 1.4, "dash"))
        layers.append(Marks(coil, 1e3 * model.peaks, "", MODEL, "diamond", in_legend=False, size=13.0))
    scatter = np.nan_to_num(scatter)
    top = 1.12 * max(float(np.max(mean + scatter)), 0.0 if model is None else 1e3 * float(model.peaks.max()))
    reach = (0.5, motion.coils + 0.5)
    panel = Panel("coil, counted from the seat", "mean peak displacement (mm)", tuple(layers), x_range=reach, x_step=1.0,
                  y_range=(min(0.0, float(np.min(mean - scatter))), top))  # fmt: skip
    return Chart("peaks", "Peak displacement along the spring", "", (panel,), 1, 380)


def overlay_chart(motion: CoilMotion, model: FilmedModel) -> Chart:
    """A panel per coil section: film and model over the cam angle."""
    panels = []
    degrees = np.degrees(model.cam_angle)
    for coil, cycles in enumerate(motion.cycles):
        layers: tuple[Layer, ...] = (
            Line(degrees, 1e3 * mean_of(cycles.values), "film, mean of the turns", FILM, 1.8),
            Line(degrees, 1e3 * model.displacement[:, coil], f"model {theme.model_words(model.model)}", MODEL, 1.4, "dash"),
        )
        title = f"coil {coil + 1} (turn {model.turns[coil]:.2f})"
        panels.append(Panel("cam angle (cam degrees)", "displacement (mm)", layers, title, x_range=(0.0, 360.0), x_step=90.0))
    columns = 2 if len(panels) > 1 else 1
    rows = -(-len(panels) // columns)
    caption = f"Same sections of the {model.spring} spring. Towards the seat, from rest with the valve closed."
    return Chart("overlay", "Film and model", caption, tuple(panels), columns, 120 + 210 * rows)


def spectrum_chart(motion: CoilMotion) -> Chart:
    """Amplitude over frequency of the whole film, with the lines of the decay."""
    hertz, micrometres = thin(motion.spectrum_frequency[1:], 1e6 * motion.spectrum_amplitude[1:], POINTS)
    lines = () if motion.surge is None else motion.surge.lines
    rules = tuple(Rule("x", one.natural_frequency, f"{one.natural_frequency:.0f} Hz") for one in lines)
    floor = 0.3 * float(np.median(micrometres))
    curve = Line(hertz, np.maximum(micrometres, floor), "", FILM, 1.2, in_legend=False)
    panel = Panel(
        "frequency (Hz)", "amplitude (µm), root mean square over coils", (curve,),
        rules=rules, x_range=(0.0, 0.5 * motion.seen.frame_rate), y_log=True,
    )  # fmt: skip
    words = "Whole film, Hann window. " + ("A turning cam makes lines at its multiples. " if motion.phase is not None else "")
    return Chart(
        "spectrum", "Spectrum with the surge lines", words + "Dotted: surge lines found in the decay.", (panel,), 1, 360, legend=False
    )


def decay_chart(motion: CoilMotion) -> Chart | None:
    """One decay as measured and as fitted, and the envelope of its first line."""
    surge = motion.surge
    if surge is None:
        return None
    milliseconds = 1e3 * surge.time
    layers: tuple[Layer, ...] = (
        Line(1e3 * surge.curve_time, 1e3 * surge.curve, "damped sines fitted to all coils and dwells", theme.INK, 1.3),
        Marks(milliseconds, 1e3 * surge.measured, "film", FILM, size=4.5, filled=True),
    )
    panel = Panel("time from the beginning of the dwell (ms)", "displacement (mm)", layers, f"coil {surge.coil}")
    caption = f"The coil that rings most. A place scatters by {1e6 * surge.scatter:.2g} µm about the fit of {surge.decays} decay" + (
        "s." if surge.decays != 1 else "."
    )
    return Chart("decay", "Free decay", caption, (panel,), 1, 360)
