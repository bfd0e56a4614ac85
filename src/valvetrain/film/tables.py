"""Tables of a film: one list of columns each, which page, CSV and JSON read.

A column more is one entry of :data:`PEAK_COLUMNS` or :data:`LINE_COLUMNS`; what it needs of other rows
is a field more of the row, filled in where rows are made.
"""

from __future__ import annotations

from typing import NamedTuple

from valvetrain.film.cycles import CoilPeak
from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.film.surge import BAND, SurgeLine
from valvetrain.findings.words import digits_text
from valvetrain.measured.json import json_estimate
from valvetrain.parameters.summary import percent
from valvetrain.views.columns import RowColumn

#: Quantity in whose unit displacements are read.
LENGTH = "maximum_lift"


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
        return [PeakRow(peak) for peak in motion.peaks]
    return [PeakRow(peak, float(model.peaks[peak.coil - 1])) for peak in motion.peaks]


def line_table(motion: CoilMotion) -> list[LineRow]:
    """Rows of the surge lines."""
    lines = () if motion.surge is None else motion.surge.lines
    return [LineRow(index, peak) for index, peak in enumerate(lines, start=1)]


PEAK_COLUMNS: list[RowColumn] = [
    RowColumn("coil", lambda row: str(row.peak.coil), "peak.coil", "coil", "coil"),
    RowColumn("mean peak", None, "peak.mean", "mean", "mean peak displacement [mm]", 1e3, quantity=LENGTH),
    RowColumn("95 %, ±", None, lambda row: BAND * row.peak.spread, quantity=LENGTH),
    RowColumn("", None, "peak.spread", "standard_deviation", "standard deviation of the mean [mm]", 1e3),
    RowColumn("scatter of a turn", None, "peak.scatter", "scatter", "scatter of a turn [mm]", 1e3, quantity=LENGTH),
    RowColumn(value="peak.cycles", key="turns", csv="turns")
]  # fmt: skip
#: Shown beyond these where a run is compared with the film; the files have them in ``model``.
MODEL_COLUMNS: list[RowColumn] = [
    RowColumn("model", None, "model_peak", quantity=LENGTH),
    RowColumn("model less film", lambda row: row.model_difference),
]
LINE_COLUMNS: list[RowColumn] = [
    RowColumn("line", lambda row: str(row.position)),
    RowColumn(
        "frequency", lambda row: f"{digits_text(row.line.natural_frequency, row.line.frequency_spread, 7)} Hz",
        lambda row: json_estimate((row.line.natural_frequency, row.line.frequency_spread)), "frequency"
    ),
    RowColumn("95 %, ±", lambda row: f"{digits_text(BAND * row.line.frequency_spread, 0, 2)} Hz"),
    RowColumn(
        "damping ratio", lambda row: digits_text(row.line.damping_ratio, row.line.damping_spread, 7),
        lambda row: json_estimate((row.line.damping_ratio, row.line.damping_spread)), "damping_ratio"
    ),
    RowColumn("95 %, ±", lambda row: digits_text(BAND * row.line.damping_spread, 0, 2)),
    RowColumn("decay rate", lambda row: f"{digits_text(row.line.decay_rate)} 1/s", "line.decay_rate", "decay_rate"),
    RowColumn("amplitude", None, "line.amplitude", "amplitude", quantity=LENGTH)
]  # fmt: skip


def peak_columns(model: FilmedModel | None) -> list[RowColumn]:
    """Columns of the peaks, those of a compared model included."""
    return PEAK_COLUMNS if model is None else [*PEAK_COLUMNS, *MODEL_COLUMNS]
