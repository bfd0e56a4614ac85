"""The page of a recording: figures first, then what was recorded, how it was cut and laid on the
cam.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.measured.cycles import write_cycles
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Panel, Rule, thin
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, text
from valvetrain.report.text import number, unit_text
from valvetrain.rig.result import RigChannelCycles, RigResult, student
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import BY_LAST_WORD
from valvetrain.units import unit_factor

#: Headings of the table of channels.
HEAD = ("channel", "", "mean", "95 %", "scatter", "unit", "at cam deg", "scatter")
#: Columns of numbers among them.
NUMBERS = (2, 3, 4, 6, 7)
#: Scatter (cam deg) of the angle of an extreme from which on it has no place.
FLAT = 15.0
RPM = 30 / np.pi


def shown_unit(quantity: str, unit: str) -> tuple[str, float]:
    """Unit in which a quantity is shown, and the factor from SI."""
    if quantity == "strain":
        return "µm/m", 1e6
    usual = BY_LAST_WORD.get(quantity.rsplit("_", 1)[-1])
    return (
        (unit_text(usual[1]), 1 / unit_factor(usual[1]))
        if usual and usual[1]
        else ("" if unit == "1" else unit_text(unit), 1.0)
    )


def figures_of(channel: RigChannelCycles) -> list[dict[str, Any]]:
    """Largest and smallest value over the cycles, SI: mean, half width of its 95 % interval,
    standard deviation over cycles, and angle.
    """
    found = []
    for word, sign in (("largest", 1.0), ("smallest", -1.0)):
        values, angles = channel.peaks(sign)
        middle = float(np.angle(np.mean(np.exp(1j * angles))) % (2 * np.pi))
        away = (angles - middle + np.pi) % (2 * np.pi) - np.pi
        spread = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
        found.append(
            {
                "figure": word,
                "mean": float(np.mean(values)),
                "interval": student(len(values)) * spread / np.sqrt(len(values)) if spread else 0.0,
                "scatter": spread,
                "cam_angle": middle,
                "scatter_of_angle": float(np.sqrt(np.mean(away**2))),
            }
        )
    return found


def channel_rows(result: RigResult) -> list[tuple[str, ...]]:
    """One row per channel and figure, as :data:`HEAD` says."""
    rows: list[tuple[str, ...]] = []
    for channel in result.channels:
        unit, factor = shown_unit(channel.cycles.quantity, channel.cycles.unit)
        mean = channel.cycles.mean
        place = int(np.argmax(mean))
        within = (
            f"±{number(channel.spread[place] * factor, 2)}"
            if np.isfinite(channel.spread[place])
            else ""
        )
        words = channel.cycles.quantity.replace("_", " ")
        angle = f"{np.degrees(channel.cycles.cam_angle[place]):.1f}"
        rows.append(
            (
                words,
                "largest of the mean",
                number(mean[place] * factor, 5),
                within,
                "",
                unit,
                angle,
                "",
            )
        )
        for one in figures_of(channel):
            interval = f"±{number(one['interval'] * factor, 2)}" if one["interval"] else ""
            found = (
                f"{one['figure']} of a cycle",
                number(one["mean"] * factor, 5),
                interval,
                number(one["scatter"] * factor, 2),
                unit,
            )
            away = float(np.degrees(one["scatter_of_angle"]))
            # an extreme of the dwell lies anywhere in it
            at = (f"{np.degrees(one['cam_angle']):.1f}", f"{away:.2g}") if away < FLAT else ("", "")
            rows.append((words, *found, *at))
    return rows


def facts_of(result: RigResult) -> tuple[tuple[str, str], ...]:
    """What a reader wants to know first."""
    speeds = result.grid.cam_speeds[list(result.kept)] * RPM
    bands = sorted({f"{channel.band / 1e3:.4g} kHz" for channel in result.channels})
    return (
        ("cycles", f"{len(result.kept)} of {result.grid.cycles}"),
        ("cam speed", f"{speeds.mean():.5g} rpm ({speeds.min():.5g} to {speeds.max():.5g})"),
        ("kept up to", ", ".join(bands)),
        ("angles a turn", str(len(result.grid.cam_angle))),
        ("read as", result.form),
        *((("data", "synthetic"),) if result.synthetic else ()),
    )


def sentences_of(result: RigResult) -> tuple[str, ...]:
    """Offset, outliers and all that was found on the way."""
    found = []
    if result.synthetic:
        found.append("the recording is synthetic: computed, not measured")
    if result.alignment is not None:
        one = result.alignment
        found.append(
            f"the mark of the rig lies at {np.degrees(result.offset):.3f} ± {2 * np.degrees(result.offset_uncertainty):.2g} cam deg of the "
            f"case (95 %), by the lift; the flanks alone give {np.degrees(one.opening):.3f} and {np.degrees(one.closing):.3f}; measured "
            f"lift over that of the case {one.gain:.4f}"
        )
    elif result.offset:
        found.append(
            f"the mark of the rig lies at {np.degrees(result.offset):.3f} cam deg, as stated"
        )
    if result.shaft.scatter:
        found.append(
            f"the channel of the angle scatters by {np.degrees(result.shaft.scatter):.2g} cam deg about its spline"
        )
    for place, why in result.outliers:
        what = "kept as asked" if place in result.kept else "left out"
        found.append(
            f"cycle {place + 1} (at {result.grid.cut_times[place]:.4f} s) {why}; it was {what}"
        )
    return (*found, *result.notes)


def data_of(result: RigResult) -> dict[str, Any]:
    """The same for JSON, SI; ``quantities`` as every command names its numbers."""
    named = {
        f"{one['figure']}_{channel.cycles.quantity}": {
            "value": one["mean"],
            "unit": channel.cycles.unit,
        }
        for channel in result.channels
        for one in figures_of(channel)
    }
    return {
        "quantities": named,
        "command": "rig",
        "case": "",
        "completed": True,
        "file": result.name,
        "form": result.form,
        "synthetic": result.synthetic,
        "cycles": result.grid.cycles,
        "kept": [place + 1 for place in result.kept],
        "outliers": [{"cycle": place + 1, "why": why} for place, why in result.outliers],
        "cam_speed": {
            "value": float(np.mean(result.grid.cam_speeds[list(result.kept)])),
            "unit": "rad/s",
        },
        "angles": len(result.grid.cam_angle),
        "offset": {
            "value": result.offset,
            "standard_uncertainty": result.offset_uncertainty,
            "unit": "rad",
        },
        "alignment": None
        if result.alignment is None
        else {
            "opening": result.alignment.opening,
            "closing": result.alignment.closing,
            "gain": result.alignment.gain,
            "residual": float(np.sqrt(np.mean(result.alignment.residual**2))),
        },
        "angle_scatter": result.shaft.scatter,
        "channels": [
            {
                "quantity": one.cycles.quantity,
                "unit": one.cycles.unit,
                "channel": one.raw.channel,
                "band": one.band,
                "notes": list(one.cycles.notes),
                "figures": figures_of(one),
                "spread_of_mean": None
                if not np.isfinite(one.spread).all()
                else float(np.median(one.spread)),
            }
            for one in result.channels
        ],
        "notes": list(sentences_of(result)),
    }


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
        (
            tuple(
                Cell(word, "number" if place in NUMBERS else "") for place, word in enumerate(row)
            ),
            (),
        )
        for row in channel_rows(result)
    )
    sections = [
        Section("figures", "Figures of the cycles", (Grid(HEAD, rows),)),
        Section(
            "cycles",
            "Cycles over the cam angle",
            tuple(Figure(cycles_chart(one)) for one in result.channels),
        ),
    ]
    if result.alignment is not None:
        sections.append(
            Section("alignment", "Laid on the cam by its lift", (Figure(alignment_chart(result)),))
        )
    sections += [
        Section("speed", "Speed of the cam", (Figure(speed_chart(result)),)),
        Section("raw", "As recorded", (Figure(raw_chart(result)),)),
        Section(
            "spectra",
            "Spectrum before and after the low-pass",
            tuple(Figure(spectrum_chart(one, result)) for one in result.channels),
        ),
        Section("notes", "How it was read", _sentences(result)),
    ]
    lead = "Means over the kept cycles. The dashed line below each figure holds 95 % of such means: scatter of cycles, and of the angle."
    if result.synthetic:
        lead = f"Synthetic recording: computed, not measured. {lead}"
    return Page(
        title, "Rig data", lead, facts_of(result), tuple(sections), "Angles are cam degrees."
    )


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
    layers: list[Layer] = [
        *single,
        Line(*thin(degrees, mean, POINTS), "mean", theme.SERIES[0], 1.7),
    ]
    below: list[Layer] = [
        Line(*_smooth(degrees, scatter), "standard deviation over cycles", theme.SERIES[1], 1.3)
    ]
    if np.isfinite(one.spread).all():
        below.append(
            Line(
                *_smooth(degrees, one.spread * factor),
                "95 % of the mean within",
                theme.INK,
                1.2,
                "dash",
            )
        )
    name = one.cycles.quantity
    panels = (
        Panel(
            "cam angle (cam degrees)",
            _label(name, unit),
            tuple(layers),
            x_range=(0.0, 360.0),
            x_step=60.0,
        ),
        Panel(
            "cam angle (cam degrees)",
            f"scatter ({unit})" if unit else "scatter",
            tuple(below),
            x_range=(0.0, 360.0),
            x_step=60.0,
        ),
    )
    more = f"; the first {CYCLES} of {len(values)} cycles are drawn" if len(values) > CYCLES else ""
    caption = f"Kept up to {one.band / 1e3:.4g} kHz{more}. Scatter is drawn as its root mean square over {SMOOTH} cam degrees."
    return Chart(f"cycles-{name}", name.replace("_", " ").capitalize(), caption, panels, 1, 560)


def _smooth(degrees: Array, values: Array) -> tuple[Array, Array]:
    """Root mean squares over pieces of :data:`SMOOTH` degrees: single angles scatter too much to be
    read.
    """
    count = max(1, len(degrees) * SMOOTH // 360)
    whole = len(degrees) // count * count
    return degrees[:whole].reshape(-1, count).mean(axis=1), np.sqrt(
        np.mean(values[:whole].reshape(-1, count) ** 2, axis=1)
    )


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
    panel = Panel(
        "time (s)", "cam speed (rpm)", (speed, mean), x_range=(float(cuts[0]), float(cuts[-1]))
    )
    return Chart(
        "speed",
        "Speed over time",
        f"The angle was recorded {result.shaft.told:.0f} times a cam turn.",
        (panel,),
        1,
        340,
    )


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
        times: Array = one.raw.start + one.raw.step * np.arange(
            len(one.raw.values), dtype=np.float64
        )
        line = Line(
            *thin(times, one.raw.values * factor, POINTS),
            one.cycles.quantity.replace("_", " "),
            theme.SERIES[0],
            1.0,
            in_legend=False,
        )
        panels.append(
            Panel(
                "time (s)",
                _label(one.cycles.quantity, unit),
                (line,),
                bands=bands,
                rules=rules,
                x_range=(float(times[0]), float(times[-1])),
            )
        )
    caption = "Upright lines: where cycles were cut" + (f" (one in {every})." if every > 1 else ".")
    return Chart("raw", "Channels over time", caption, tuple(panels), 1, 120 + 230 * len(panels))


def spectrum_chart(one: RigChannelCycles, result: RigResult) -> Chart:
    """Amplitudes before the low-pass (samples over time) and after it (cycles on the grid of
    angles).
    """
    unit, factor = shown_unit(one.cycles.quantity, one.cycles.unit)
    before = _amplitudes(one.raw.values[np.isfinite(one.raw.values)] * factor, 1 / one.raw.step)
    rate = len(one.cycles.cam_angle) * one.cycles.cam_speed / (2 * np.pi)
    after = _amplitudes(one.cycles.values.ravel() * factor, rate)
    top = max(float(before[1].max()), 1e-300)
    panel = Panel(
        "frequency (kHz)",
        f"amplitude ({unit})" if unit else "amplitude",
        (
            Line(
                1e-3 * before[0], np.maximum(before[1], 1e-7 * top), "as recorded", theme.MUTED, 1.0
            ),
            Line(
                1e-3 * after[0],
                np.maximum(after[1], 1e-7 * top),
                "over the cam angle",
                theme.SERIES[0],
                1.1,
            ),
        ),
        bands=(Band(0.0, 1e-3 * one.band, "kept"),),
        x_range=(0.0, 0.5e-3 / one.raw.step),
        y_log=True,
        y_range=(1e-5 * top, 2 * top),
    )
    caption = "Hann window, largest of neighbouring lines. What lies beyond the band is cut before the grid of angles, so it cannot fold back."
    return Chart(
        f"spectrum-{one.cycles.quantity}",
        one.cycles.quantity.replace("_", " ").capitalize(),
        caption,
        (panel,),
        1,
        340,
    )


def _amplitudes(values: Array, rate: float) -> tuple[Array, Array]:
    """Frequencies (Hz) and amplitudes, averaged over pieces of the record; largest of neighbours
    where there are many.
    """
    piece = min(PIECE, len(values))
    window = np.hanning(piece)
    parts = [values[first : first + piece] for first in range(0, len(values) - piece + 1, piece)][
        :64
    ]
    power = np.mean(
        [np.abs(np.fft.rfft((part - part.mean()) * window)) ** 2 for part in parts], axis=0
    )
    amplitude = 2 * np.sqrt(power) / window.sum()
    count = max(1, -(-len(amplitude) // (POINTS // 2)))
    whole = len(amplitude) // count * count
    frequency = np.fft.rfftfreq(piece, 1 / rate)[:whole].reshape(-1, count).mean(axis=1)
    return frequency, amplitude[:whole].reshape(-1, count).max(axis=1)


#: Values of a channel beyond which its cycles are not written as text besides.
MAX_IN_TEXT = 2_000_000


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
    heads, columns = ["cam angle [deg]"], [np.degrees(result.grid.cam_angle)]
    for channel in result.channels:
        one = channel.cycles
        scatter = (
            one.values.std(axis=0, ddof=1) if len(one.values) > 1 else np.zeros(one.values.shape[1])
        )
        heads += [
            f"{one.quantity} [{one.unit}]",
            f"standard deviation of {one.quantity} [{one.unit}]",
            f"95 % of the mean within [{one.unit}]",
        ]
        columns += [one.mean, scatter, channel.spread]
    lines = ["# synthetic: computed, not measured"] if result.synthetic else []
    lines += [
        ",".join(heads),
        *(",".join(f"{value:.9g}" for value in row) for row in np.column_stack(columns)),
    ]
    files.append(write_text(folder / "means.csv", "\n".join(lines) + "\n"))
    return files
