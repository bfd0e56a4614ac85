"""Tables of a film: one list of columns each, which terminal, page, CSV and JSON read.

A column more is one entry of :data:`PEAK_COLUMNS` or :data:`LINE_COLUMNS`; what it needs of other rows
is a field more of the row, filled in where rows are made.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from valvetrain.film.cycles import CoilPeak
from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.film.surge import BAND, SurgeLine
from valvetrain.report.text import number, percent
from valvetrain.views.columns import RowColumn


class PeakRow(NamedTuple):
    """Peak of one coil, and that of the model (m) where a run is compared with the film."""

    peak: CoilPeak
    model_peak: float | None = None

    @property
    def model_difference(self) -> str:
        """Model less film as a share of the film's peak; a dash where that is lost in its scatter."""
        mean, spread = self.peak.mean, self.peak.spread
        if self.model_peak is None or not mean > 20 * max(spread, 1e-6):
            return "–"
        return percent(self.model_peak / mean - 1)


class LineRow(NamedTuple):
    """One surge line and its number, from 1."""

    position: int
    line: SurgeLine


def peak_table(motion: CoilMotion, model: FilmedModel | None) -> list[PeakRow]:
    """Rows of the peaks along the spring."""
    if model is None:
        return [PeakRow(one) for one in motion.peaks]
    return [PeakRow(one, float(model.peaks[one.coil - 1])) for one in motion.peaks]


def line_table(motion: CoilMotion) -> list[LineRow]:
    """Rows of the surge lines."""
    lines = () if motion.surge is None else motion.surge.lines
    return [LineRow(index, one) for index, one in enumerate(lines, start=1)]


def digits(width: float) -> int:
    """Decimals of a value that is known within ``width``."""
    return (
        int(np.clip(1 - np.floor(np.log10(width)), 0, 7)) if width > 0 and np.isfinite(width) else 4
    )


def _millimetres(value: float) -> str:
    return "–" if np.isnan(value) else f"{1e3 * value:.3f}"


PEAK_COLUMNS: list[RowColumn] = [
    RowColumn("coil", lambda row: str(row.peak.coil), "peak.coil", "coil", "coil"),
    RowColumn(
        "mean peak (mm)",
        lambda row: _millimetres(row.peak.mean),
        "peak.mean",
        "mean",
        "mean peak displacement [mm]",
        1e3,
    ),
    RowColumn(
        "95 %",
        lambda row: f"±{_millimetres(BAND * row.peak.spread)}",
        "peak.spread",
        "standard_deviation",
        "standard deviation of the mean [mm]",
        1e3,
    ),
    RowColumn(
        "scatter of a turn (mm)",
        lambda row: _millimetres(row.peak.scatter),
        "peak.scatter",
        "scatter",
        "scatter of a turn [mm]",
        1e3,
    ),
    RowColumn(value="peak.cycles", key="turns", csv="turns"),
]
#: Shown beyond these where a run is compared with the film; the files have them in ``model``.
MODEL_COLUMNS: list[RowColumn] = [
    RowColumn("model (mm)", lambda row: _millimetres(row.model_peak)),
    RowColumn("model less film", lambda row: row.model_difference),
]
LINE_COLUMNS: list[RowColumn] = [
    RowColumn("line", lambda row: str(row.position)),
    RowColumn(
        "frequency",
        lambda row: f"{row.line.natural_frequency:.{digits(BAND * row.line.frequency_spread)}f} Hz",
        lambda row: {
            "value": row.line.natural_frequency,
            "standard_deviation": row.line.frequency_spread,
        },
        "frequency",
    ),
    RowColumn("95 %", lambda row: f"±{number(BAND * row.line.frequency_spread, 2)}"),
    RowColumn(
        "damping ratio",
        lambda row: f"{row.line.damping_ratio:.{digits(BAND * row.line.damping_spread)}f}",
        lambda row: {
            "value": row.line.damping_ratio,
            "standard_deviation": row.line.damping_spread,
        },
        "damping_ratio",
    ),
    RowColumn("95 %", lambda row: f"±{number(BAND * row.line.damping_spread, 2)}"),
    RowColumn(
        "decay rate",
        lambda row: f"{row.line.decay_rate:.3g} 1/s",
        "line.decay_rate",
        "decay_rate",
    ),
    RowColumn(
        "log. decrement",
        lambda row: f"{row.line.logarithmic_decrement:.3g}",
        "line.logarithmic_decrement",
        "logarithmic_decrement",
    ),
    RowColumn(
        "amplitude",
        lambda row: f"{1e6 * row.line.amplitude:.3g} µm",
        "line.amplitude",
        "amplitude",
    ),
]


def peak_columns(model: FilmedModel | None) -> list[RowColumn]:
    """Columns of the peaks, those of a compared model included."""
    return PEAK_COLUMNS if model is None else [*PEAK_COLUMNS, *MODEL_COLUMNS]
