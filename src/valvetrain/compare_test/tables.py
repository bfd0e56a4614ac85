"""Tables of a model against a test: the columns that terminal, page, CSV and JSON share."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from valvetrain.compare_test.adequacy import chance_text
from valvetrain.compare_test.comparison import RunAgainstTest, ValueRow
from valvetrain.compare_test.events import EventRow
from valvetrain.report.columns import RowColumn
from valvetrain.report.text import number, quantity_label, speed_text, unit_text
from valvetrain.units import unit_factor

Columns = tuple[RowColumn, ...]
_VERDICTS = {"refuted": "bad", "not refuted": "good"}
_INSIDE = {"outside": "bad", "inside": "good", "not in the model": "bad"}


def _in_unit(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def agreement_columns(unit: str = "", factor: float = 1.0, cam_speed: float = math.nan) -> Columns:
    """Nearness of a run to measured cycles; rows: runs with an agreement."""

    def bias(run: Any) -> str:
        near = run.agreement
        return number(near.bias * factor if abs(near.bias) > 1e-9 * near.rms else 0.0, 3)

    def interval(run: Any) -> str:
        half = run.agreement.shift_reach
        return f"±{number(math.degrees(half), 2)}" if math.isfinite(half) else ""

    return (
        RowColumn("model", lambda run: run.label, number=False),
        RowColumn(_in_unit("bias", unit), bias, "agreement.bias", "bias"),
        RowColumn(
            _in_unit("rms", unit),
            lambda run: number(run.agreement.rms * factor, 3),
            "agreement.rms",
            "rms",
        ),
        RowColumn(
            _in_unit("rest", unit),
            lambda run: number(run.agreement.rest * factor, 3),
            "agreement.rest",
            "rest",
        ),
        RowColumn(
            "correlation",
            lambda run: f"{run.agreement.correlation:.5f}",
            "agreement.correlation",
            "correlation",
        ),
        RowColumn(
            "later (deg)",
            lambda run: number(math.degrees(run.agreement.shift), 3),
            "agreement.shift",
            "shift",
        ),
        RowColumn("95 %", interval, "agreement.shift_reach", "shift_reach"),
        RowColumn(value="agreement.scatter", key="scatter"),
        RowColumn(value=lambda run: run.agreement.shift / cam_speed, key="shift_time"),
    )


def adequacy_columns(unit: str = "", factor: float = 1.0) -> Columns:
    """Fisher's test; rows: runs with an adequacy test. Variances carry the square of the unit."""
    squared = f"({unit})²" if "/" in unit else f"{unit}²" if unit else ""

    def variance(name: str) -> Callable[[Any], str]:
        def text(run: Any) -> str:
            test = run.adequacy
            return number(getattr(test, name) * (factor**2 if test.repeats else 1.0), 3)

        return text

    def degrees(run: Any) -> str:
        both = run.adequacy.degrees
        return ", ".join("∞" if math.isinf(one) else number(one, 3) for one in both)

    return (
        RowColumn("model", lambda run: run.label, number=False),
        RowColumn(
            _in_unit("adequacy", squared),
            variance("adequacy"),
            "adequacy.adequacy",
            "adequacy_variance",
        ),
        RowColumn(
            _in_unit("reproducibility", squared),
            variance("reproducibility"),
            "adequacy.reproducibility",
            "reproducibility_variance",
        ),
        RowColumn("F", lambda run: number(run.adequacy.ratio, 3), "adequacy.ratio", "ratio"),
        RowColumn(
            "degrees of freedom",
            degrees,
            lambda run: list(run.adequacy.degrees),
            "degrees_of_freedom",
        ),
        RowColumn(
            "critical F",
            lambda run: number(run.adequacy.critical, 3),
            "adequacy.critical",
            "critical",
        ),
        RowColumn(
            "p", lambda run: chance_text(run.adequacy.p_value), "adequacy.p_value", "p_value"
        ),
        RowColumn(
            "verdict",
            lambda run: "not refuted" if run.adequacy.adequate else "refuted",
            "adequacy.adequate",
            "adequate",
            number=False,
            tones=_VERDICTS,
        ),
        *(
            RowColumn(value=f"adequacy.{name}", key=key)
            for name, key in (
                ("places", "places"),
                ("independent", "independent_places"),
                ("repeats", "repeats"),
                ("fitted", "fitted"),
                ("level", "level"),
                ("counted_p_value", "p_value_if_every_place_counted"),
                ("refutable", "refutable_rms"),
            )
        ),
        RowColumn(value=lambda run: list(run.adequacy.shared), key="shared_mean_squares"),
    )


def _event_label(row: EventRow) -> str:
    angle = row.dimension == "angle" and "interval" not in row.name
    return f"{row.name[:1].upper()}{row.name[1:]}{', angle' if angle else ''}"


def _inside(row: EventRow) -> str:
    if math.isnan(row.model):
        return "not in the model"
    return "" if row.outside is None else "outside" if row.outside else "inside"


def event_columns(unit: str = "", factor: float = 1.0, title: str = "event") -> Columns:
    """Events of a run, with their difference in units of scatter; rows: :class:`EventRow`."""

    def scaled(name: str, digits: int = 4) -> Callable[[Any], str]:
        return lambda row: number(
            getattr(row, name) * (math.degrees(1.0) if row.dimension == "angle" else factor), digits
        )

    return (
        RowColumn(title, _event_label, "name", "event", "event", number=False),
        RowColumn(value="dimension", key="what", csv="what"),
        *(RowColumn(name, scaled(name), name, name, name) for name in ("model", "seen", "test")),
        RowColumn("difference", scaled("difference", 3), "difference", "difference", "difference"),
        RowColumn("", lambda row: "cam deg" if row.dimension == "angle" else unit, number=False),
        RowColumn("scatter", scaled("scatter", 2), "scatter", "scatter", "scatter of one cycle"),
        RowColumn(
            "in s.e.",
            lambda row: number(row.in_errors, 2),
            "in_errors",
            "in_standard_errors",
            "in standard errors",
        ),
        RowColumn("95 %", _inside, "outside", "outside", "outside", number=False, tones=_INSIDE),
    )


def stage_columns(unit: str = "", factor: float = 1.0, student: float = math.nan) -> Columns:
    """Errors by stage of the revolution; ``student``: half width of a 95 % interval in standard
    errors.
    """

    def outside(row: Any) -> str:
        share = row.share_outside
        return "–" if math.isnan(share) else f"{100 * share:.0f} % of angles"

    return (
        RowColumn(
            "stage", lambda row: row.name[:1].upper() + row.name[1:], "name", "name", number=False
        ),
        RowColumn("from (cam deg)", lambda row: number(math.degrees(row.first)), "first", "first"),
        RowColumn("to (cam deg)", lambda row: number(math.degrees(row.last)), "last", "last"),
        RowColumn(_in_unit("bias", unit), lambda row: number(row.bias * factor, 3), "bias", "bias"),
        RowColumn(
            _in_unit("± (95 %)", unit),
            lambda row: number(student * row.bias_error * factor, 2),
            "bias_error",
            "bias_standard_error",
        ),
        RowColumn(_in_unit("rms", unit), lambda row: number(row.rms * factor, 3), "rms", "rms"),
        RowColumn("zero outside the band", outside, "share_outside", "share_outside"),
    )


def value_label(row: ValueRow) -> str:
    """A measured quantity as a reader sees it."""
    return quantity_label(row.quantity) + (", angle" if row.kind == "angle" else "")


def value_columns(title: str = "quantity") -> Columns:
    """Measured values next to the model's, with the difference in units of their scatter; rows:
    :class:`ValueRow`.
    """

    def scaled(name: str, digits: int = 4) -> Callable[[Any], str]:
        return lambda row: number(getattr(row, name) * (1 / unit_factor(row.unit)), digits)

    return (
        RowColumn(title, value_label, "quantity", "quantity", "quantity", number=False),
        RowColumn(value="kind", key="what", csv="what"),
        RowColumn(
            "crank speed", lambda row: speed_text(row.engine_speed), "engine_speed", "engine_speed"
        ),
        RowColumn(value=lambda row: row.engine_speed * 30 / math.pi, csv="engine speed [rpm]"),
        RowColumn("model", scaled("model"), "model", "model", "model [SI]"),
        RowColumn("test", scaled("test"), "test", "test", "test [SI]"),
        RowColumn("", lambda row: unit_text(row.unit), "unit", "unit", number=False),
        RowColumn("scatter", scaled("scatter", 2), "scatter", "scatter", "scatter [SI]"),
        RowColumn(
            "difference", scaled("difference", 3), "difference", "difference", "difference [SI]"
        ),
        RowColumn(
            "in scatters",
            lambda row: number(row.in_scatters, 2),
            "in_scatters",
            "in_scatters",
            "in scatters",
        ),
    )


def is_spike(row: EventRow) -> bool:
    """Whether an event is a spike or the distance of spikes."""
    return row.name.startswith(("spike", "interval"))


def with_agreement(runs: tuple[RunAgainstTest, ...]) -> list[RunAgainstTest]:
    """Runs that have rows in the table of nearness."""
    return [run for run in runs if run.agreement is not None]


def with_adequacy(runs: tuple[RunAgainstTest, ...]) -> list[RunAgainstTest]:
    """Runs that have rows in the table of Fisher's test."""
    return [run for run in runs if run.adequacy is not None]
