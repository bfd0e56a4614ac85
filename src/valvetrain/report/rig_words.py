"""Numbers of a recording as people read them: rows of tables for terminal, page and JSON alike."""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.measurements.rig_result import RigChannelCycles, RigResult, student
from valvetrain.report.words import number, unit_words
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
    return (unit_words(usual[1]), 1 / unit_factor(usual[1])) if usual and usual[1] else ("" if unit == "1" else unit_words(unit), 1.0)


def figures_of(channel: RigChannelCycles) -> list[dict[str, Any]]:
    """Largest and smallest value over the cycles, SI: mean, half width of its 95 % interval, standard deviation over cycles, and angle."""
    found = []
    for word, sign in (("largest", 1.0), ("smallest", -1.0)):
        values, angles = channel.peaks(sign)
        middle = float(np.angle(np.mean(np.exp(1j * angles))) % (2 * np.pi))
        away = (angles - middle + np.pi) % (2 * np.pi) - np.pi
        spread = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
        found.append(
            {
                "figure": word, "mean": float(np.mean(values)),
                "interval": student(len(values)) * spread / np.sqrt(len(values)) if spread else 0.0, "scatter": spread, "cam_angle": middle,
                "scatter_of_angle": float(np.sqrt(np.mean(away**2))),
            }
        )  # fmt: skip
    return found


def channel_rows(result: RigResult) -> list[tuple[str, ...]]:
    """One row per channel and figure, as :data:`HEAD` says."""
    rows: list[tuple[str, ...]] = []
    for channel in result.channels:
        unit, factor = shown_unit(channel.cycles.quantity, channel.cycles.unit)
        mean = channel.cycles.mean
        place = int(np.argmax(mean))
        within = f"±{number(channel.spread[place] * factor, 2)}" if np.isfinite(channel.spread[place]) else ""
        words = channel.cycles.quantity.replace("_", " ")
        angle = f"{np.degrees(channel.cycles.cam_angle[place]):.1f}"
        rows.append((words, "largest of the mean", number(mean[place] * factor, 5), within, "", unit, angle, ""))
        for one in figures_of(channel):
            interval = f"±{number(one['interval'] * factor, 2)}" if one["interval"] else ""
            found = f"{one['figure']} of a cycle", number(one["mean"] * factor, 5), interval, number(one["scatter"] * factor, 2), unit
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
        ("kept up to", ", ".join(bands)), ("angles a turn", str(len(result.grid.cam_angle))), ("read as", result.form),
        *((("data", "synthetic"),) if result.synthetic else ()),
    )  # fmt: skip


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
        found.append(f"the mark of the rig lies at {np.degrees(result.offset):.3f} cam deg, as stated")
    if result.shaft.scatter:
        found.append(f"the channel of the angle scatters by {np.degrees(result.shaft.scatter):.2g} cam deg about its spline")
    for place, why in result.outliers:
        what = "kept as asked" if place in result.kept else "left out"
        found.append(f"cycle {place + 1} (at {result.grid.cut_times[place]:.4f} s) {why}; it was {what}")
    return (*found, *result.notes)


def data_of(result: RigResult) -> dict[str, Any]:
    """The same for JSON, SI; ``quantities`` as every command names its numbers."""
    named = {
        f"{one['figure']}_{channel.cycles.quantity}": {"value": one["mean"], "unit": channel.cycles.unit}
        for channel in result.channels for one in figures_of(channel)
    }  # fmt: skip
    return {
        "quantities": named,
        "command": "rig", "case": "", "completed": True, "file": result.name, "form": result.form, "synthetic": result.synthetic,
        "cycles": result.grid.cycles, "kept": [place + 1 for place in result.kept],
        "outliers": [{"cycle": place + 1, "why": why} for place, why in result.outliers],
        "cam_speed": {"value": float(np.mean(result.grid.cam_speeds[list(result.kept)])), "unit": "rad/s"},
        "angles": len(result.grid.cam_angle),
        "offset": {"value": result.offset, "standard_uncertainty": result.offset_uncertainty, "unit": "rad"},
        "alignment": None if result.alignment is None else {
            "opening": result.alignment.opening, "closing": result.alignment.closing, "gain": result.alignment.gain,
            "residual": float(np.sqrt(np.mean(result.alignment.residual**2))),
        },
        "angle_scatter": result.shaft.scatter,
        "channels": [
            {
                "quantity": one.cycles.quantity, "unit": one.cycles.unit, "channel": one.raw.channel, "band": one.band,
                "notes": list(one.cycles.notes), "figures": figures_of(one),
                "spread_of_mean": None if not np.isfinite(one.spread).all() else float(np.median(one.spread)),
            }
            for one in result.channels
        ],
        "notes": list(sentences_of(result)),
    }  # fmt: skip
