"""Model against test for readers: page with figures and tables, CSV and JSON."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest, ValueRow
from valvetrain.compare_test.summary import (
    SYNTHETIC,
    band_sentence,
    counting_sentence,
    events_sentence,
    outside_sentence,
    text_of_test,
    unit_of_test,
    verdict_sentences,
)
from valvetrain.compare_test.tables import (
    adequacy_columns,
    agreement_columns,
    event_columns,
    is_spike,
    stage_columns,
    value_columns,
    value_label,
    with_adequacy,
    with_agreement,
)
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Marks, Panel, Rule, thin
from valvetrain.report.columns import RowColumn, csv_row, grid, json_row
from valvetrain.report.page import Block, Figure, Page, Section, text
from valvetrain.report.run_charts import ANGLE_LABEL, LineStyle, line_styles
from valvetrain.report.study import StudyFiles, with_page
from valvetrain.report.text import quantity_label, speed_text
from valvetrain.report.verdict import verdict_of
from valvetrain.solution.atomic import write_text

Array = NDArray[np.float64]
#: What the columns of nearness mean.
NEAR = (
    "Bias is the mean of model less test, rms its root mean square; rest is what is left of it when bias and shift are taken away; later "
    "says by how many cam degrees the model follows the test, from their cross-correlation. In the tables of events seen is "
    "what this test would show of the model on average, for scatter raises what is largest; the difference is seen less test, scatter one "
    "standard deviation of a cycle, s.e. the standard error of the mean of the cycles."
)
#: Most runs whose difference is drawn; tables hold them all.
MAX_DRAWN = 4


def compare_test_page(found: ModelAgainstTest) -> Page:
    """The whole page of a comparison.

    Parameters
    ----------
    found : result of :func:`compare_with_test`

    Raises
    ------
    InputError : no run completed

    Examples
    --------
    >>> import numpy as np
    >>> import valvetrain as vt
    >>> angle = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    >>> cycles = vt.measured.MeasuredCycles("spring_force", "N", angle, np.full((1, 90), 430.0), cam_speed=209.44)
    >>> found = vt.compare_test.compare_with_test("job-t", cycles, spring_models="massless")
    >>> [section.title for section in vt.compare_test.compare_test_page(found).sections][0]
    'What the test refutes'
    """
    test, known = found.test, line_styles(found.study)
    if isinstance(test, MeasuredCycles):
        picture = Figure(overlay_chart(found, test, *unit_of_test(found), known))
    else:
        picture = Figure(values_chart(found, known))
    blocks: list[Block] = [text(SYNTHETIC, "alert")] if found.test.synthetic else []
    blocks += [text(one, "note") for one in verdict_sentences(found)]
    sections = [Section("verdict", "What the test refutes", tuple(blocks))]
    sections += (
        _of_cycles(found, test, known)
        if isinstance(test, MeasuredCycles)
        else _of_values(found, known)
    )
    tests = [one.adequacy for one in found.runs if one.adequacy is not None]
    if tests:
        explained = text(counting_sentence(tests[0]), "note")
        sections.append(
            Section(
                "f-test",
                "Fisher's test of adequacy",
                (
                    grid(adequacy_columns(*unit_of_test(found)), with_adequacy(found.runs)),
                    explained,
                ),
            )
        )
    said = [text(f"{one[:1].upper()}{one[1:]}.", "note") for one in dict.fromkeys(found.notes)]
    said += [text(f"Not completed: {one}", "alert") for one in found.failures]
    if said:
        sections.append(
            Section("notes", "Found and assumed", tuple(said), folded=not found.failures)
        )
    lead = (
        "Differences are model less test. The test refutes a model where it misses the mean of the repeats by more than their "
        "scatter allows."
    )
    facts = (("test", text_of_test(found)), ("case", found.study.record.name))
    return Page(
        found.study.record.title or found.study.record.name,
        "Model against test",
        lead,
        facts,
        tuple(sections),
        "Angles are cam degrees.",
        verdict=verdict_of(found),
        picture=(picture,),
    )


def _of_cycles(
    found: ModelAgainstTest, test: MeasuredCycles, known: dict[str, LineStyle]
) -> list[Section]:
    unit, factor = unit_of_test(found)
    drawn = found.runs[:MAX_DRAWN]
    sections = [
        Section("difference", "Difference with its band",
                (Figure(difference_chart(found, drawn, unit, factor, known)), *(text(band_sentence(one, test), "note") for one in drawn))),
        Section("agreement", "How near", (grid(agreement_columns(unit, factor), with_agreement(found.runs)), text(NEAR, "note"))),
    ]  # fmt: skip
    student = float(stdtrit(len(test.values) - 1, 0.975)) if len(test.values) > 1 else float("nan")
    for one in drawn:
        name = known[one.label].label
        spikes = [row for row in one.events if is_spike(row)]
        others = [row for row in one.events if not is_spike(row)]
        blocks: list[Block] = [
            text(events_sentence(one), "note"),
            grid(event_columns(unit, factor), others),
        ]
        blocks += [grid(event_columns(unit, factor, "spike"), spikes)] if spikes else []
        blocks += [grid(stage_columns(unit, factor, student), one.stages)] if one.stages else []
        sections.append(
            Section(
                f"events-{one.label.replace(' ', '-').replace(',', '')}",
                f"Events and stretches, {name}",
                tuple(blocks),
            )
        )
    return sections


def overlay_chart(
    found: ModelAgainstTest,
    test: MeasuredCycles,
    unit: str,
    factor: float,
    known: dict[str, LineStyle],
) -> Chart:
    """Mean and range of the cycles, and every model."""
    degrees, values = np.degrees(test.cam_angle), test.values * factor
    made = "synthetic test" if test.synthetic else "test"
    layers: list[Layer] = []
    if len(values) > 1:
        layers += [
            Line(
                *thin(degrees, values.min(axis=0)),
                f"minimum and maximum of the {len(values)} cycles",
                theme.MUTED,
                0.8,
                "dot",
            ),
            Line(*thin(degrees, values.max(axis=0)), "", theme.MUTED, 0.8, "dot", in_legend=False),
        ]
    layers.append(Line(*thin(degrees, values.mean(axis=0)), f"mean of the {made}", theme.INK, 1.8))
    for one in found.runs:
        if one.curve is not None:
            look = known[one.label]
            layers.append(
                Line(*thin(degrees, one.curve * factor), look.label, look.colour, 1.4, look.dash)
            )
    panel = Panel(
        ANGLE_LABEL,
        _axis(found, unit),
        tuple(layers),
        "",
        _stretches(found),
        x_range=(0.0, 360.0),
        x_step=30,
    )
    return Chart(
        "overlay",
        quantity_label(test.quantity),
        f"Model and {made} over one cam revolution.",
        (panel,),
        1,
        420,
    )


def difference_chart(
    found: ModelAgainstTest,
    runs: tuple[RunAgainstTest, ...],
    unit: str,
    factor: float,
    known: dict[str, LineStyle],
) -> Chart:
    """Model less test with its band; red where the band leaves zero out."""
    test = found.test
    assert isinstance(test, MeasuredCycles)
    degrees, mean = np.degrees(test.cam_angle), test.values.mean(axis=0)
    panels: list[Panel] = []
    shown_off = False
    for place, one in enumerate(runs):
        assert one.curve is not None
        off, look = (one.curve - mean) * factor, known[one.label]
        layers: list[Layer] = []
        if one.band is not None:
            half = one.band.half_width * factor
            layers += [
                Line(
                    *thin(degrees, off - half),
                    "95 % band, at all angles at once",
                    theme.MUTED,
                    0.9,
                    "solid",
                    place == 0,
                ),
                Line(*thin(degrees, off + half), "", theme.MUTED, 0.9, "solid", in_legend=False),
            ]
        layers.append(
            Line(*thin(degrees, off), f"{look.label} less test", look.colour, 1.5, look.dash)
        )
        layers.append(
            Line(np.array([0.0, 360.0]), np.zeros(2), "", theme.RULE, 1.0, in_legend=False)
        )
        if one.band is not None and one.band.outside.any():
            x, y = _stretches_of(degrees, one.band.outside)
            layers.append(Line(x, y, "zero left out", theme.ALERT, 3.5, "solid", not shown_off))
            shown_off = True
        panels.append(
            Panel(
                ANGLE_LABEL,
                f"model less test ({unit})" if unit else "model less test",
                tuple(layers),
                look.label,
                _stretches(found),
                x_range=(0.0, 360.0),
                x_step=30,
            )
        )
    caption = "Where its band leaves zero out the model is off; of a true model one turn in twenty shows any such place."
    return Chart("difference", "Model less test", caption, tuple(panels), 1, 300 * len(panels) + 60)


def _stretches_of(degrees: Array, mask: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Level strokes at zero over the angles of ``mask``, half a step beyond either end."""
    half = 0.5 * float(np.median(np.diff(degrees)))
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    begins, ends = (
        degrees[np.flatnonzero(edges == 1)] - half,
        degrees[np.flatnonzero(edges == -1) - 1] + half,
    )
    gap = np.full(len(begins), np.nan)
    return np.stack([begins, ends, gap], axis=1).ravel(), np.stack(
        [0 * begins, 0 * ends, gap], axis=1
    ).ravel()


def _axis(found: ModelAgainstTest, unit: str) -> str:
    label = quantity_label(found.quantity).lower()
    return f"{label} ({unit})" if unit else label


def _stretches(found: ModelAgainstTest) -> tuple[Band, ...]:
    event = found.study.lift_event
    return (
        ()
        if event is None
        else (Band(float(np.degrees(event.start)), float(np.degrees(event.end)), "lift event"),)
    )


def _of_values(found: ModelAgainstTest, known: dict[str, LineStyle]) -> list[Section]:
    sections = []
    for one in found.runs:
        key = one.label.replace(" ", "-").replace(",", "")
        sections.append(
            Section(
                f"values-{key}",
                f"Values, {known[one.label].label}",
                (text(outside_sentence(one), "note"), grid(value_columns(), one.values)),
            )
        )
    return sections


def values_chart(found: ModelAgainstTest, known: dict[str, LineStyle]) -> Chart:
    """Difference of every value in units of its scatter, one mark a run."""
    rows = found.runs[0].values
    several = len({row.engine_speed for row in rows}) > 1
    names = [_short(row, several) for row in rows]
    height = len(rows) - 1.0 - np.arange(len(rows))
    layers: list[Layer] = []
    for one in found.runs:
        off = np.array([row.in_scatters for row in one.values])
        there, look = np.isfinite(off), known[one.label]
        hints = tuple(
            f"{name}: {value:+.3g}"
            for name, value in zip(names, off, strict=True)
            if np.isfinite(value)
        )
        layers.append(
            Marks(off[there], height[there], look.label, look.colour, filled=True, hints=hints)
        )
    reach = 1.1 * max(
        [
            4.0,
            *(
                abs(row.in_scatters)
                for one in found.runs
                for row in one.values
                if np.isfinite(row.in_scatters)
            ),
        ]
    )
    panel = Panel(
        "model less test (scatters)",
        "",
        tuple(layers),
        x_range=(-reach, reach),
        y_range=(-0.7, len(rows) + 0.5),
        y_tick_labels=tuple(zip(height.tolist(), names, strict=True)),
        rules=(Rule("x", -2.0), Rule("x", 0.0, "test"), Rule("x", 2.0)),
    )
    caption = "From the top in the order of the table below; the name of each shows on it. Thin lines: the test and two scatters either way."
    return Chart("values", "Model less test", caption, (panel,), 1, max(300, 26 * len(rows) + 120))


def _short(row: ValueRow, with_speed: bool) -> str:
    label = value_label(row)
    return f"{label}, {speed_text(row.engine_speed)}" if with_speed else label


def compare_test_json(found: ModelAgainstTest) -> dict[str, Any]:
    """The answer as plain values, SI, angles in rad."""
    test = found.test
    return {
        "case": found.study.record.name,
        "quantity": found.quantity,
        "synthetic": test.synthetic,
        "source": test.source,
        "repeats": len(test.values) if isinstance(test, MeasuredCycles) else test.repeats,
        "verdict": verdict_sentences(found) if found.runs else [],
        "notes": list(found.notes),
        "runs": [_run(one, found.study.engine_speeds[0] / 2) for one in found.runs],
        "closer": [
            {
                "first": one.first,
                "second": one.second,
                "first_mean_square": one.first_square,
                "second_mean_square": one.second_square,
                "student": one.student,
                "p_value": one.p_value,
                "sentence": one.sentence,
            }
            for one in found.closer
        ],
    }


def _run(one: RunAgainstTest, cam_speed: float) -> dict[str, Any]:
    data: dict[str, Any] = {
        "label": one.label,
        "model": one.model,
        "sentence": one.sentence,
        "f_test": None if one.adequacy is None else json_row(adequacy_columns(), one),
    }
    if one.agreement is not None:
        data["agreement"] = json_row(agreement_columns(cam_speed=cam_speed), one)
    if one.band is not None:
        data["band"] = {
            "factor": one.band.factor,
            "level": one.band.level,
            "share_outside": float(one.band.outside.mean()),
        }
    for key, columns, rows in (
        ("events", event_columns(), one.events),
        ("stages", stage_columns(), one.stages),
        ("values", value_columns(), one.values),
    ):
        if rows:
            data[key] = [json_row(columns, row) for row in rows]
    return data


def write_compare_test(found: ModelAgainstTest, folder: Path) -> list[Path]:
    """``curves.csv`` and ``events.csv`` of measured cycles, or ``values.csv`` of a table; SI but
    for angles in cam degrees.
    """
    test = found.test
    if not isinstance(test, MeasuredCycles):
        rows = [(one.label, row) for one in found.runs for row in one.values]
        return [_write_rows(folder / "values.csv", value_columns(), rows)]
    columns: dict[str, np.ndarray[Any, Any]] = {
        "cam angle [deg]": np.degrees(test.cam_angle),
        f"test [{test.unit}]": test.values.mean(axis=0),
    }
    for one in found.runs:
        if one.curve is not None:
            columns[f"{one.label} [{test.unit}]"] = one.curve
        if one.band is not None:
            columns[f"{one.label} less test [{test.unit}]"] = one.band.difference
            columns[f"half width of its band [{test.unit}] ({one.label})"] = one.band.half_width
    curves = zip(*(column.tolist() for column in columns.values()), strict=True)
    events = [(one.label, row) for one in found.runs for row in one.events]
    return [
        _write(folder / "curves.csv", tuple(columns), curves),
        _write_rows(folder / "events.csv", event_columns(), events),
    ]


def _write_rows(
    path: Path, columns: tuple[RowColumn, ...], rows: Iterable[tuple[str, Any]]
) -> Path:
    """A table of all runs, the label of the run in its first column."""
    headings = ("run", *(column.csv for column in columns if column.csv))
    return _write(path, headings, ((label, *csv_row(columns, row)) for label, row in rows))


def _write(path: Path, headings: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Path:
    def cell(value: Any) -> Any:
        if not isinstance(value, float):
            return value
        return "" if math.isnan(value) else f"{value:.9g}"

    memory = io.StringIO()
    writer = csv.writer(memory, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows([cell(value) for value in row] for row in rows)
    return write_text(path, memory.getvalue())


def report_compare_test(found: ModelAgainstTest, folder: Path) -> StudyFiles:
    """The page of a comparison and the files of :func:`write_compare_test`."""
    return with_page(compare_test_page(found), folder, write_compare_test(found, folder))
