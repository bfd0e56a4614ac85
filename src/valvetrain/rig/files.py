"""A recording as files: JSON, and the cycles as NetCDF and CSV."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.measured.cycles import write_cycles
from valvetrain.rig.result import Peak, RigChannelCycles, RigResult, mean_peak, peaks_of
from valvetrain.solution.atomic import write_text
from valvetrain.views.columns import RowColumn, csv_text, json_row

#: Scatter (cam deg) of the angle of an extreme above which the angle is that of no peak.
FLAT = 15.0


def quantity_of(peak: Peak) -> str:
    """The quantity in whose unit an extreme is shown."""
    return peak.quantity


def angle_of(peak: Peak) -> float:
    """Cam angle (rad) of an extreme; NaN in the dwell, where it can be anywhere."""
    return np.nan if np.degrees(peak.scatter_of_angle) >= FLAT else peak.cam_angle


#: The table of extremes.
COLUMNS = (
    RowColumn("channel", lambda peak: peak.quantity.replace("_", " ")),
    RowColumn("of the cycles", value="figure", key="figure"),
    *(RowColumn(heading, value=key, key=key, quantity=quantity_of) for heading, key in (
        ("mean", "mean"), ("± (95 %)", "interval"), ("scatter", "scatter"))),
    RowColumn("at", value=angle_of, quantity="cam_angle"),
    *(RowColumn(value=key, key=key) for key in ("cam_angle", "scatter_of_angle"))
)  # fmt: skip


def data_of(result: RigResult) -> dict[str, Any]:
    """The answer for JSON, SI; ``quantities`` as every command names its numbers."""
    peaks = [peaks_of(channel) for channel in result.channels]
    fit, retained = result.alignment, list(result.retained)
    units = {channel.cycles.quantity: channel.cycles.unit for channel in result.channels}
    return {
        "quantities": {
            f"{peak.figure}_{peak.quantity}": {"value": peak.mean, "unit": units[peak.quantity]} for some in peaks for peak in some
        },
        "command": "rig", "case": "", "completed": True, "file": result.name, "form": result.form, "synthetic": result.synthetic,
        "cycles": result.grid.cycles, "kept": [cycle + 1 for cycle in retained],
        "outliers": [{"cycle": cycle + 1, "why": why} for cycle, why in result.outliers],
        "cam_speed": {"value": float(np.mean(result.grid.cam_speeds[retained])), "unit": "rad/s"},
        "angles": len(result.grid.cam_angle),
        "offset": {"value": result.offset, "standard_uncertainty": result.offset_uncertainty, "unit": "rad"},
        "alignment": fit and {
            "opening": fit.opening, "closing": fit.closing, "gain": fit.gain, "residual": float(np.sqrt(np.mean(fit.residual**2)))
        },
        "angle_scatter": result.shaft.scatter,
        "channels": [_channel(*one) for one in zip(result.channels, peaks, strict=True)],
        "notes": list(result.notes)
    }  # fmt: skip


def _channel(channel: RigChannelCycles, peaks: list[Peak]) -> dict[str, Any]:
    whole = bool(np.isfinite(channel.spread).all())
    return {
        "quantity": channel.cycles.quantity, "unit": channel.cycles.unit, "channel": channel.raw.channel, "band": channel.band,
        "clipped": channel.clipped, "drift": channel.drift, "notes": list(channel.cycles.notes),
        "figures": [json_row(COLUMNS, peak) for peak in peaks], "spread_of_mean": float(np.median(channel.spread)) if whole else None
    }  # fmt: skip


def rows_of(result: RigResult) -> list[Peak]:
    """Largest value of the mean, and extremes of the cycles, of every channel."""
    return [
        peak for channel in result.channels for peak in (mean_peak(channel), *peaks_of(channel))
    ]


def write_rig(result: RigResult, folder: Path) -> list[Path]:
    """``<quantity>.csv`` with the cycles of each channel, ``means.csv`` with means, scatter and bands."""
    files = [write_cycles(folder / f"{one.quantity}.csv", one) for one in result.cycles]
    columns = [("cam angle [deg]", np.degrees(result.grid.cam_angle))]
    for channel in result.channels:
        one = channel.cycles
        columns += [
            (f"{one.quantity} [{one.unit}]", one.mean),
            (f"standard deviation of {one.quantity} [{one.unit}]", deviation(channel)),
            (f"95 % of the mean within [{one.unit}]", channel.spread),
        ]
    names, values = zip(*columns, strict=True)
    head = "# synthetic: computed, not measured\n" * result.synthetic
    text = csv_text(names, np.column_stack(values).tolist())
    return [*files, write_text(folder / "means.csv", head + text)]


def deviation(channel: RigChannelCycles) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Standard deviation over the cycles, shape (angles,); zero of a single one."""
    values = channel.cycles.values
    return np.std(values, axis=0, ddof=1) if len(values) > 1 else np.zeros(values.shape[1])
