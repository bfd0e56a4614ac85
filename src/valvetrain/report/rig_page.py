"""The page of a recording: figures first, then what was recorded, how it was cut and laid on the cam."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.rig_result import RigChannelCycles, RigResult
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Panel, Rule, thin
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, text
from valvetrain.report.rig_words import HEAD, NUMBERS, RPM, channel_rows, facts_of, sentences_of, shown_unit

Array = NDArray[np.float64]
#: Points of a drawn channel, single cycles that are drawn, cut marks that are drawn.
POINTS, CYCLES, MARKS = 1500, 12, 40
#: Degrees over which the scatter is drawn.
SMOOTH = 2
#: Samples of the longest piece a spectrum is taken of.
PIECE = 16_384


def rig_page(title: str, result: RigResult) -> Page:
    """The whole page."""
    rows = tuple(
        (tuple(Cell(word, "number" if place in NUMBERS else "") for place, word in enumerate(row)), ()) for row in channel_rows(result)
    )
    sections = [
        Section("figures", "Figures of the cycles", (Grid(HEAD, rows),)),
        Section("cycles", "Cycles over the cam angle", tuple(Figure(cycles_chart(one)) for one in result.channels)),
    ]
    if result.alignment is not None:
        sections.append(Section("alignment", "Laid on the cam by its lift", (Figure(alignment_chart(result)),)))
    sections += [
        Section("speed", "Speed of the cam", (Figure(speed_chart(result)),)),
        Section("raw", "As recorded", (Figure(raw_chart(result)),)),
        Section("spectra", "Spectrum before and after the low-pass", tuple(Figure(spectrum_chart(one, result)) for one in result.channels)),
        Section("notes", "How it was read", _sentences(result)),
    ]  # fmt: skip
    lead = "Means over the kept cycles. The dashed line below each figure holds 95 % of such means: scatter of cycles, and of the angle."
    if result.synthetic:
        lead = f"Synthetic recording: computed, not measured. {lead}"
    return Page(title, "Rig data", lead, facts_of(result), tuple(sections), "Angles are cam degrees.")


def _sentences(result: RigResult) -> tuple[Block, ...]:
    return tuple(text(one[:1].upper() + one[1:] + ".", "note") for one in sentences_of(result))


def _label(quantity: str, unit: str) -> str:
    return f"{quantity.replace('_', ' ')} ({unit})" if unit else quantity.replace("_", " ")


def cycles_chart(one: RigChannelCycles) -> Chart:
    """Single cycles, their mean with its band, and the scatter over cycles."""
    unit, factor = shown_unit(one.cycles.quantity, one.cycles.unit)
    degrees, values = np.degrees(one.cycles.cam_angle), one.cycles.values * factor
    mean = values.mean(axis=0)
    scatter = values.std(axis=0, ddof=1) if len(values) > 1 else np.zeros(len(mean))
    single = [
        Line(*thin(degrees, cycle, POINTS), "single cycles", theme.RULE, 0.9, in_legend=not place)
        for place, cycle in enumerate(values[:CYCLES])
    ]
    layers: list[Layer] = [*single, Line(*thin(degrees, mean, POINTS), "mean", theme.SERIES[0], 1.7)]
    below: list[Layer] = [Line(*_smooth(degrees, scatter), "standard deviation over cycles", theme.SERIES[1], 1.3)]
    if np.isfinite(one.spread).all():
        below.append(Line(*_smooth(degrees, one.spread * factor), "95 % of the mean within", theme.INK, 1.2, "dash"))
    name = one.cycles.quantity
    panels = (
        Panel("cam angle (cam degrees)", _label(name, unit), tuple(layers), x_range=(0.0, 360.0), x_step=60.0),
        Panel("cam angle (cam degrees)", f"scatter ({unit})" if unit else "scatter", tuple(below), x_range=(0.0, 360.0), x_step=60.0),
    )
    more = f"; the first {CYCLES} of {len(values)} cycles are drawn" if len(values) > CYCLES else ""
    caption = f"Kept up to {one.band / 1e3:.4g} kHz{more}. Scatter is drawn as its root mean square over {SMOOTH} cam degrees."
    return Chart(f"cycles-{name}", name.replace("_", " ").capitalize(), caption, panels, 1, 560)


def _smooth(degrees: Array, values: Array) -> tuple[Array, Array]:
    """Root mean squares over pieces of :data:`SMOOTH` degrees: single angles scatter too much to be read."""
    count = max(1, len(degrees) * SMOOTH // 360)
    whole = len(degrees) // count * count
    return degrees[:whole].reshape(-1, count).mean(axis=1), np.sqrt(np.mean(values[:whole].reshape(-1, count) ** 2, axis=1))


def alignment_chart(result: RigResult) -> Chart:
    """Measured lift over the lift of the case, and what is left."""
    one = result.alignment
    assert one is not None
    degrees, reach = np.degrees(one.cam_angle), (0.0, 360.0)
    fitted = one.base + one.gain * one.model
    panels = (
        Panel(
            "cam angle (cam degrees)", "valve lift (mm)",
            (Line(*thin(degrees, 1e3 * one.measured, POINTS), "measured, median of the cycles", theme.SERIES[0], 1.8),
             Line(*thin(degrees, 1e3 * fitted, POINTS), "lift of the case, with gain and base", theme.INK, 1.1, "dash")),
            x_range=reach, x_step=60.0,
        ),
        Panel(
            "cam angle (cam degrees)", "measured minus case (µm)",
            (Line(*thin(degrees, 1e6 * one.residual, POINTS), "measured minus case", theme.SERIES[1], 1.1, in_legend=False),),
            x_range=reach, x_step=60.0,
        ),
    )  # fmt: skip
    caption = (
        f"Offset of the mark {np.degrees(result.offset):.3f} ± {2 * np.degrees(result.offset_uncertainty):.2g} cam degrees (95 %), gain "
        f"{one.gain:.4f}, base {1e6 * one.base:.3g} µm."
    )
    return Chart("alignment", "Lift of the rig and of the case", caption, panels, 1, 520)


def speed_chart(result: RigResult) -> Chart:
    """Speed of the cam over time, as the spline through the told angles has it."""
    cuts = result.grid.cut_times
    times: Array = np.linspace(cuts[0], cuts[-1], POINTS)
    speed = Line(times, result.shaft.cam_speed(times) * RPM, "by the spline", theme.SERIES[0], 1.2)
    middle = (cuts[1:] + cuts[:-1]) / 2
    mean = Line(middle, result.grid.cam_speeds * RPM, "mean of each cycle", theme.INK, 1.2, "dash")
    panel = Panel("time (s)", "cam speed (rpm)", (speed, mean), x_range=(float(cuts[0]), float(cuts[-1])))
    return Chart("speed", "Speed over time", f"The angle was recorded {result.shaft.told:.0f} times a cam turn.", (panel,), 1, 340)


def raw_chart(result: RigResult) -> Chart:
    """Every channel as recorded, cut marks as lines, cycles that were left out shaded."""
    cuts = result.grid.cut_times
    every = max(1, len(cuts) // MARKS)
    rules = tuple(Rule("x", float(cut)) for cut in cuts[::every])
    out = [place for place, _ in result.outliers if place not in result.kept][:MARKS]
    bands = tuple(Band(float(cuts[place]), float(cuts[place + 1]), "left out") for place in out)
    panels = []
    for one in result.channels:
        unit, factor = shown_unit(one.cycles.quantity, one.cycles.unit)
        times: Array = one.raw.start + one.raw.step * np.arange(len(one.raw.values), dtype=np.float64)
        line = Line(
            *thin(times, one.raw.values * factor, POINTS), one.cycles.quantity.replace("_", " "), theme.SERIES[0], 1.0, in_legend=False
        )
        panels.append(
            Panel(
                "time (s)", _label(one.cycles.quantity, unit), (line,), bands=bands, rules=rules,
                x_range=(float(times[0]), float(times[-1])),
            )
        )  # fmt: skip
    caption = "Upright lines: where cycles were cut" + (f" (one in {every})." if every > 1 else ".")
    return Chart("raw", "Channels over time", caption, tuple(panels), 1, 120 + 230 * len(panels))


def spectrum_chart(one: RigChannelCycles, result: RigResult) -> Chart:
    """Amplitudes before the low-pass (samples over time) and after it (cycles on the grid of angles)."""
    unit, factor = shown_unit(one.cycles.quantity, one.cycles.unit)
    before = _amplitudes(one.raw.values[np.isfinite(one.raw.values)] * factor, 1 / one.raw.step)
    rate = len(one.cycles.cam_angle) * one.cycles.cam_speed / (2 * np.pi)
    after = _amplitudes(one.cycles.values.ravel() * factor, rate)
    top = max(float(before[1].max()), 1e-300)
    panel = Panel(
        "frequency (kHz)", f"amplitude ({unit})" if unit else "amplitude",
        (Line(1e-3 * before[0], np.maximum(before[1], 1e-7 * top), "as recorded", theme.MUTED, 1.0),
         Line(1e-3 * after[0], np.maximum(after[1], 1e-7 * top), "over the cam angle", theme.SERIES[0], 1.1)),
        bands=(Band(0.0, 1e-3 * one.band, "kept"),), x_range=(0.0, 0.5e-3 / one.raw.step), y_log=True,
        y_range=(1e-5 * top, 2 * top),
    )  # fmt: skip
    caption = (
        "Hann window, largest of neighbouring lines. What lies beyond the band is cut before the grid of angles, so it cannot fold back."
    )
    return Chart(f"spectrum-{one.cycles.quantity}", one.cycles.quantity.replace("_", " ").capitalize(), caption, (panel,), 1, 340)


def _amplitudes(values: Array, rate: float) -> tuple[Array, Array]:
    """Frequencies (Hz) and amplitudes, averaged over pieces of the record; largest of neighbours where there are many."""
    piece = min(PIECE, len(values))
    window = np.hanning(piece)
    parts = [values[first : first + piece] for first in range(0, len(values) - piece + 1, piece)][:64]
    power = np.mean([np.abs(np.fft.rfft((part - part.mean()) * window)) ** 2 for part in parts], axis=0)
    amplitude = 2 * np.sqrt(power) / window.sum()
    count = max(1, -(-len(amplitude) // (POINTS // 2)))
    whole = len(amplitude) // count * count
    frequency = np.fft.rfftfreq(piece, 1 / rate)[:whole].reshape(-1, count).mean(axis=1)
    return frequency, amplitude[:whole].reshape(-1, count).max(axis=1)
