"""A recording for readers: table of peaks, facts and sentences, page with figures, CSV and JSON."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from valvetrain.measured.cycles import write_cycles
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Panel, Rule, thin
from valvetrain.report.page import Figure, Page, Section, text
from valvetrain.report.study import StudyFiles, with_page
from valvetrain.report.text import number, unit_text
from valvetrain.report.verdict import verdict_of
from valvetrain.rig.result import RigChannelCycles, RigResult, student
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import BY_LAST_WORD
from valvetrain.units import unit_factor
from valvetrain.views.columns import RowColumn, grid, json_row

Array = NDArray[np.float64]
RPM = 30 / np.pi
#: Scatter (cam deg) of the angle of an extreme above which the angle is not shown.
FLAT = 15.0
#: Points of a drawn channel, single cycles that are drawn, cut marks that are drawn.
POINTS, CYCLES, MARKS = 1500, 12, 40
#: Degrees over which the scatter is averaged where it is drawn.
SMOOTH = 2
#: Samples of the longest segment of a spectrum, and segments that are averaged, at most.
SEGMENT, MAX_SEGMENTS = 16_384, 64
#: Values of a channel above which its cycles are written as NetCDF alone, not as text too.
MAX_IN_TEXT = 2_000_000
_ANGLE = "cam angle (cam degrees)"


def shown_unit(quantity: str, unit: str) -> tuple[str, float]:
    """Unit in which a quantity is shown, and the factor from SI."""
    if quantity == "strain":
        return "µm/m", 1e6
    _, shown = BY_LAST_WORD.get(quantity.rsplit("_", 1)[-1], ("", ""))
    if shown:
        return unit_text(shown), 1 / unit_factor(shown)
    return "" if unit == "1" else unit_text(unit), 1.0


class Peak(NamedTuple):
    """An extreme of the cycles of a channel, SI and rad: mean, half width of its 95 % interval, and
    standard deviation over the cycles; its angle and the scatter of that. NaN: none.
    """

    quantity: str
    unit: str
    figure: str
    mean: float
    interval: float
    scatter: float
    cam_angle: float
    scatter_of_angle: float

    def shown(self, value: float, digits: int, sign: str = "") -> str:
        """A value in the unit in which the quantity is shown; empty for NaN."""
        _, factor = shown_unit(self.quantity, self.unit)
        return f"{sign}{number(value * factor, digits)}" if np.isfinite(value) else ""

    @property
    def label(self) -> str:
        """What it is the extreme of."""
        return (
            f"{self.figure} of the mean" if np.isnan(self.scatter) else f"{self.figure} of a cycle"
        )


def peaks_of(channel: RigChannelCycles) -> list[Peak]:
    """Largest and smallest value over the cycles."""
    peaks = []
    for name, sign in (("largest", 1.0), ("smallest", -1.0)):
        values, angles = channel.peaks(sign)
        middle = float(np.angle(np.mean(np.exp(1j * angles))) % (2 * np.pi))
        away = (angles - middle + np.pi) % (2 * np.pi) - np.pi
        spread = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
        interval = student(len(values)) * spread / np.sqrt(len(values)) if spread else 0.0
        peaks.append(
            Peak(
                channel.cycles.quantity,
                channel.cycles.unit,
                name,
                float(np.mean(values)),
                interval,
                spread,
                middle,
                float(np.sqrt(np.mean(away**2))),
            )
        )
    return peaks


def peak_rows(result: RigResult) -> list[Peak]:
    """Peak of the mean, and peaks of the cycles, of every channel."""
    rows = []
    for channel in result.channels:
        one = channel.cycles
        top = int(np.argmax(one.mean))
        spread = float(channel.spread[top])
        rows.append(
            Peak(
                one.quantity,
                one.unit,
                "largest",
                float(one.mean[top]),
                spread if np.isfinite(spread) else np.nan,
                np.nan,
                float(one.cam_angle[top]),
                np.nan,
            )
        )
        rows += peaks_of(channel)
    return rows


def _shown_angle(peak: Peak, degrees: float, pattern: str) -> str:
    """An angle, unless it is of an extreme in the dwell, which can be anywhere in it."""
    flat = np.degrees(peak.scatter_of_angle) >= FLAT
    return "" if flat or np.isnan(degrees) else format(degrees, pattern)


#: The table of peaks.
COLUMNS = (
    RowColumn("channel", lambda peak: peak.quantity.replace("_", " "), number=False),
    RowColumn("", lambda peak: peak.label, "figure", "figure", number=False),
    RowColumn("mean", lambda peak: peak.shown(peak.mean, 5), "mean", "mean"),
    RowColumn(
        "95 %",
        lambda peak: peak.shown(peak.interval or np.nan, 2, "±"),
        "interval",
        "interval",
    ),
    RowColumn("scatter", lambda peak: peak.shown(peak.scatter, 2), "scatter", "scatter"),
    RowColumn("unit", lambda peak: shown_unit(peak.quantity, peak.unit)[0], number=False),
    RowColumn(
        "at cam deg",
        lambda peak: _shown_angle(peak, np.degrees(peak.cam_angle), ".1f"),
        "cam_angle",
        "cam_angle",
    ),
    RowColumn(
        "scatter",
        lambda peak: _shown_angle(peak, float(np.degrees(peak.scatter_of_angle)), ".2g"),
        "scatter_of_angle",
        "scatter_of_angle",
    ),
)


def facts_of(result: RigResult) -> tuple[tuple[str, str], ...]:
    """The most important results."""
    speeds = result.grid.cam_speeds[list(result.retained)] * RPM
    bands = sorted({f"{channel.band / 1e3:.4g} kHz" for channel in result.channels})
    return (
        ("cycles", f"{len(result.retained)} of {result.grid.cycles}"),
        ("cam speed", f"{speeds.mean():.5g} rpm ({speeds.min():.5g} to {speeds.max():.5g})"),
        ("band", ", ".join(bands)),
        ("angles per revolution", str(len(result.grid.cam_angle))),
        ("read as", result.form),
        *((("data", "synthetic"),) if result.synthetic else ()),
    )


def sentences_of(result: RigResult) -> tuple[str, ...]:
    """Offset, outliers and all that was found on the way."""
    sentences = []
    if result.synthetic:
        sentences.append("the recording is synthetic: computed, not measured")
    offset, fit = f"{np.degrees(result.offset):.3f}", result.alignment
    if fit is not None:
        sentences.append(
            f"the mark of the rig is at {offset} ± {2 * np.degrees(result.offset_uncertainty):.2g} cam deg of the "
            f"case (95 %), by the lift; the flanks alone give {np.degrees(fit.opening):.3f} and {np.degrees(fit.closing):.3f}; measured "
            f"lift over that of the case {fit.gain:.4f}"
        )
    elif result.offset:
        sentences.append(f"the mark of the rig is at {offset} cam deg, as stated")
    if result.shaft.scatter:
        sentences.append(
            f"the channel of the angle scatters by {np.degrees(result.shaft.scatter):.2g} cam deg about its spline"
        )
    for cycle, why in result.outliers:
        fate = "retained as requested" if cycle in result.retained else "left out"
        time = result.grid.cut_times[cycle]
        sentences.append(f"cycle {cycle + 1} (at {time:.4f} s) {why}; it was {fate}")
    return (*sentences, *result.notes)


def data_of(result: RigResult) -> dict[str, Any]:
    """The same for JSON, SI; ``quantities`` as every command names its numbers."""
    peaks = {id(channel): peaks_of(channel) for channel in result.channels}
    fit = result.alignment
    return {
        "quantities": {
            f"{peak.figure}_{peak.quantity}": {"value": peak.mean, "unit": peak.unit}
            for channel in result.channels
            for peak in peaks[id(channel)]
        },
        "command": "rig",
        "case": "",
        "completed": True,
        "file": result.name,
        "form": result.form,
        "synthetic": result.synthetic,
        "cycles": result.grid.cycles,
        "kept": [cycle + 1 for cycle in result.retained],
        "outliers": [{"cycle": cycle + 1, "why": why} for cycle, why in result.outliers],
        "cam_speed": {
            "value": float(np.mean(result.grid.cam_speeds[list(result.retained)])),
            "unit": "rad/s",
        },
        "angles": len(result.grid.cam_angle),
        "offset": {
            "value": result.offset,
            "standard_uncertainty": result.offset_uncertainty,
            "unit": "rad",
        },
        "alignment": fit
        and {
            "opening": fit.opening,
            "closing": fit.closing,
            "gain": fit.gain,
            "residual": float(np.sqrt(np.mean(fit.residual**2))),
        },
        "angle_scatter": result.shaft.scatter,
        "channels": [
            {
                "quantity": one.cycles.quantity,
                "unit": one.cycles.unit,
                "channel": one.raw.channel,
                "band": one.band,
                "notes": list(one.cycles.notes),
                "figures": [json_row(COLUMNS, peak) for peak in peaks[id(one)]],
                "spread_of_mean": float(np.median(one.spread))
                if np.isfinite(one.spread).all()
                else None,
            }
            for one in result.channels
        ],
        "notes": list(sentences_of(result)),
    }


def rig_page(title: str, result: RigResult) -> Page:
    """The whole page."""
    channels = result.channels
    first, *cycles = (Figure(cycles_chart(one)) for one in channels)
    spectra = tuple(Figure(spectrum_chart(one)) for one in channels)
    sections = [
        Section("figures", "Figures of the cycles", (grid(COLUMNS, peak_rows(result)),)),
        *([Section("cycles", "Cycles over the cam angle", tuple(cycles))] if cycles else ()),
    ]
    if result.alignment is not None:
        figure = Figure(alignment_chart(result))
        sections.append(Section("alignment", "Aligned to the cam by its lift", (figure,)))
    notes = (text(f"{one[:1].upper()}{one[1:]}.", "note") for one in sentences_of(result))
    sections += [
        Section("speed", "Speed of the cam", (Figure(speed_chart(result)),)),
        Section("raw", "As recorded", (Figure(raw_chart(result)),)),
        Section("spectra", "Spectrum before and after the low-pass", spectra),
        Section("notes", "How it was read", tuple(notes), folded=True),
    ]
    lead = (
        "Means over the retained cycles. The dashed line below each figure is the half width within which 95 % of such means are: scatter "
        "of cycles, and of the angle."
    )
    if result.synthetic:
        lead = f"Synthetic recording: computed, not measured. {lead}"
    facts = facts_of(result)
    foot = "Angles are cam degrees."
    said = verdict_of(result)
    return Page(title, "Rig data", lead, facts, tuple(sections), foot, said, (first,))


def _with_unit(label: str, unit: str) -> str:
    return f"{label} ({unit})" if unit else label


def _deviation(values: Array) -> Array:
    """Standard deviation over cycles; zero of a single one."""
    deviation: Array = values.std(axis=0, ddof=1) if len(values) > 1 else np.zeros(values.shape[1])
    return deviation


def cycles_chart(one: RigChannelCycles) -> Chart:
    """Single cycles, their mean with its band, and the scatter over cycles."""
    name = one.cycles.quantity
    unit, factor = shown_unit(name, one.cycles.unit)
    degrees, values = np.degrees(one.cycles.cam_angle), one.cycles.values * factor
    count = max(1, len(degrees) * SMOOTH // 360)
    whole = len(degrees) // count * count
    pieces = degrees[:whole].reshape(-1, count).mean(axis=1)

    def smoothed(scatter: Array) -> tuple[Array, Array]:
        """Root mean squares over pieces: single angles scatter too much to be read."""
        return pieces, np.sqrt(np.mean(scatter[:whole].reshape(-1, count) ** 2, axis=1))

    above: list[Layer] = [
        Line(*thin(degrees, cycle, POINTS), "single cycles", theme.RULE, 0.9, in_legend=not index)
        for index, cycle in enumerate(values[:CYCLES])
    ]
    mean = thin(degrees, values.mean(axis=0), POINTS)
    above.append(Line(*mean, "mean", theme.SERIES[0], 1.7))
    scatter = smoothed(_deviation(values))
    below: list[Layer] = [Line(*scatter, "standard deviation over cycles", theme.SERIES[1], 1.3)]
    if np.isfinite(one.spread).all():
        spread = smoothed(one.spread * factor)
        below.append(Line(*spread, "95 % of the mean within", theme.INK, 1.2, "dash"))
    label = name.replace("_", " ")
    panels = tuple(
        Panel(_ANGLE, _with_unit(axis, unit), tuple(layers), x_range=(0.0, 360.0), x_step=60.0)
        for axis, layers in ((label, above), ("scatter", below))
    )
    more = f"; the first {CYCLES} of {len(values)} cycles are drawn" if len(values) > CYCLES else ""
    caption = f"Band up to {one.band / 1e3:.4g} kHz{more}. Scatter is drawn as its root mean square over {SMOOTH} cam degrees."
    return Chart(f"cycles-{name}", label.capitalize(), caption, panels, 1, 560)


def alignment_chart(result: RigResult) -> Chart:
    """Measured lift over the lift of the case, and the residual."""
    fit = result.alignment
    assert fit is not None
    degrees = np.degrees(fit.cam_angle)
    measured = thin(degrees, 1e3 * fit.measured, POINTS)
    fitted = thin(degrees, 1e3 * (fit.base + fit.gain * fit.model), POINTS)
    residual = thin(degrees, 1e6 * fit.residual, POINTS)
    lifts = (
        Line(*measured, "measured, median of the cycles", theme.SERIES[0], 1.8),
        Line(*fitted, "lift of the case, with gain and base", theme.INK, 1.1, "dash"),
    )
    away = (Line(*residual, "measured minus case", theme.SERIES[1], 1.1, in_legend=False),)
    panels = tuple(
        Panel(_ANGLE, label, layers, x_range=(0.0, 360.0), x_step=60.0)
        for label, layers in (("valve lift (mm)", lifts), ("measured minus case (µm)", away))
    )
    caption = (
        f"Offset of the mark {np.degrees(result.offset):.3f} ± {2 * np.degrees(result.offset_uncertainty):.2g} cam degrees (95 %), gain "
        f"{fit.gain:.4f}, base {1e6 * fit.base:.3g} µm."
    )
    return Chart("alignment", "Lift of the rig and of the case", caption, panels, 1, 520)


def speed_chart(result: RigResult) -> Chart:
    """Speed of the cam over time, by the spline through the recorded angles."""
    cuts = result.grid.cut_times
    times: Array = np.linspace(cuts[0], cuts[-1], POINTS)
    speed = Line(times, result.shaft.cam_speed(times) * RPM, "by the spline", theme.SERIES[0], 1.2)
    middle = (cuts[1:] + cuts[:-1]) / 2
    mean = Line(middle, result.grid.cam_speeds * RPM, "mean of each cycle", theme.INK, 1.2, "dash")
    ends = (float(cuts[0]), float(cuts[-1]))
    panel = Panel("time (s)", "cam speed (rpm)", (speed, mean), x_range=ends)
    caption = f"The angle was recorded {result.shaft.readings:.0f} times per cam revolution."
    return Chart("speed", "Speed over time", caption, (panel,), 1, 340)


def raw_chart(result: RigResult) -> Chart:
    """Every channel as recorded, cut marks as lines, cycles that were left out shaded."""
    cuts = result.grid.cut_times
    every = max(1, len(cuts) // MARKS)
    rules = tuple(Rule("x", float(cut)) for cut in cuts[::every])
    out = [cycle for cycle, _ in result.outliers if cycle not in result.retained][:MARKS]
    bands = tuple(Band(float(cuts[cycle]), float(cuts[cycle + 1]), "left out") for cycle in out)
    panels = []
    for one in result.channels:
        raw, name = one.raw, one.cycles.quantity.replace("_", " ")
        unit, factor = shown_unit(one.cycles.quantity, one.cycles.unit)
        times: Array = raw.start + raw.step * np.arange(len(raw.values), dtype=np.float64)
        points = thin(times, raw.values * factor, POINTS)
        line = Line(*points, name, theme.SERIES[0], 1.0, in_legend=False)
        ends = (float(times[0]), float(times[-1]))
        axis = _with_unit(name, unit)
        panels.append(Panel("time (s)", axis, (line,), bands=bands, rules=rules, x_range=ends))
    caption = "Upright lines: where cycles were cut" + (f" (one in {every})." if every > 1 else ".")
    return Chart("raw", "Channels over time", caption, tuple(panels), 1, 120 + 230 * len(panels))


def spectrum_chart(one: RigChannelCycles) -> Chart:
    """Amplitudes before the low-pass (samples over time) and after it (cycles on the grid of
    angles).
    """
    name, raw = one.cycles.quantity, one.raw
    unit, factor = shown_unit(name, one.cycles.unit)
    before = _amplitudes(raw.values[np.isfinite(raw.values)] * factor, 1 / raw.step)
    rate = len(one.cycles.cam_angle) * one.cycles.cam_speed / (2 * np.pi)
    after = _amplitudes(one.cycles.values.ravel() * factor, rate)
    top = max(float(before[1].max()), 1e-300)
    layers = tuple(
        Line(1e-3 * frequency, np.maximum(amplitude, 1e-7 * top), label, colour, width)
        for (frequency, amplitude), label, colour, width in (
            (before, "as recorded", theme.MUTED, 1.0),
            (after, "over the cam angle", theme.SERIES[0], 1.1),
        )
    )
    panel = Panel(
        "frequency (kHz)",
        _with_unit("amplitude", unit),
        layers,
        bands=(Band(0.0, 1e-3 * one.band, "band"),),
        x_range=(0.0, 0.5e-3 / raw.step),
        y_log=True,
        y_range=(1e-5 * top, 2 * top),
    )
    caption = "Hann window, largest of neighbouring lines. Content beyond the band is cut before the grid of angles, so it cannot fold back."
    title = name.replace("_", " ").capitalize()
    return Chart(f"spectrum-{name}", title, caption, (panel,), 1, 340)


def _amplitudes(values: Array, rate: float) -> tuple[Array, Array]:
    """Frequencies (Hz) and amplitudes, averaged over segments of the record; largest of neighbours
    where there are many.
    """
    segment = min(SEGMENT, len(values))
    frequency, power = signal.welch(
        values[: MAX_SEGMENTS * segment], rate, np.hanning(segment), noverlap=0, scaling="spectrum"
    )
    count = max(1, -(-len(power) // (POINTS // 2)))
    whole = len(power) // count * count
    return (
        frequency[:whole].reshape(-1, count).mean(axis=1),
        np.sqrt(2 * power[:whole].reshape(-1, count).max(axis=1)),
    )


def write_rig(result: RigResult, folder: Path) -> list[Path]:
    """``cycles.nc`` with every channel, ``<quantity>.csv`` with the cycles of each, ``means.csv``
    with means, scatter and bands.
    """
    files = [write_cycles(folder / "cycles.nc", result.cycles)]
    files += [
        write_cycles(folder / f"{one.quantity}.csv", [one])
        for one in result.cycles
        if one.values.size <= MAX_IN_TEXT
    ]
    columns = [("cam angle [deg]", np.degrees(result.grid.cam_angle))]
    for channel in result.channels:
        one = channel.cycles
        columns += [
            (f"{one.quantity} [{one.unit}]", one.mean),
            (f"standard deviation of {one.quantity} [{one.unit}]", _deviation(one.values)),
            (f"95 % of the mean within [{one.unit}]", channel.spread),
        ]
    rows = np.column_stack([column for _, column in columns])
    lines = ["# synthetic: computed, not measured"] if result.synthetic else []
    lines.append(",".join(heading for heading, _ in columns))
    lines += [",".join(f"{value:.9g}" for value in row) for row in rows]
    return [*files, write_text(folder / "means.csv", "\n".join(lines) + "\n")]


def report_rig(result: RigResult, folder: Path) -> StudyFiles:
    """The page of a recording and the files of :func:`write_rig`."""
    return with_page(rig_page(result.name, result), folder, write_rig(result, folder))
