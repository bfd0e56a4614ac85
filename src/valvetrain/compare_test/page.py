"""The page of a model against a test: verdict and overlay, difference with its band, events in
units of scatter, the F-test.
"""

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

from valvetrain.compare_test.adequacy import AdequacyTest
from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest, ValueRow
from valvetrain.compare_test.summary import (
    EVENT_HEADS,
    STAGE_HEADS,
    SYNTHETIC,
    VALUE_HEADS,
    Row,
    adequacy_heads,
    adequacy_rows,
    agreement_heads,
    agreement_rows,
    band_sentence,
    counting_sentence,
    event_rows,
    events_sentence,
    outside_sentence,
    stage_rows,
    text_of_test,
    unit_of_test,
    value_rows,
    verdict_sentences,
)
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Marks, Panel, Rule, thin
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, text
from valvetrain.report.run_charts import ANGLE_LABEL, LineStyle, line_styles
from valvetrain.report.text import quantity_label, speed_text
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
    """The whole page. Raises :class:`InputError` where no run completed."""
    cycles = isinstance(found.test, MeasuredCycles)
    blocks: list[Block] = [text(SYNTHETIC, "alert")] if found.test.synthetic else []
    blocks += [text(one, "note") for one in verdict_sentences(found)]
    sections = [Section("verdict", "Verdict", tuple(blocks))]
    if cycles:
        sections += _of_cycles(found)
    else:
        sections += _of_values(found)
    tests = [one.adequacy for one in found.runs if one.adequacy is not None]
    if tests:
        explained = text(counting_sentence(tests[0]), "note")
        sections.append(
            Section(
                "f-test",
                "Fisher's test of adequacy",
                (_grid(adequacy_heads(found), adequacy_rows(found)), explained),
            )
        )
    said = [text(f"{one[:1].upper()}{one[1:]}.", "note") for one in dict.fromkeys(found.notes)]
    said += [text(f"Not completed: {one}", "alert") for one in found.failures]
    if said:
        sections.append(Section("notes", "Found and assumed", tuple(said)))
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
    )


def _grid(heads: Row, rows: list[Row]) -> Grid:
    """A table: the first column words, numbers right, verdicts as they are."""
    toned = {
        "outside": "bad",
        "refuted": "bad",
        "inside": "good",
        "not refuted": "good",
        "not in the model": "bad",
    }

    def cell(place: int, word: str) -> Cell:
        tone = toned.get(word, "")
        return Cell(word, tone or ("number" if place and _is_number(word) else ""))

    return Grid(
        heads,
        tuple((tuple(cell(place, word) for place, word in enumerate(row)), ()) for row in rows),
    )


def _is_number(word: str) -> bool:
    return word[:1].isdigit() or word[:1] in "−±–∞"


def _of_cycles(found: ModelAgainstTest) -> list[Section]:
    test = found.test
    assert isinstance(test, MeasuredCycles)
    unit, factor = unit_of_test(found)
    known = line_styles(found.study)
    drawn = found.runs[:MAX_DRAWN]
    sections = [
        Section("overlay", "Model and test", (Figure(overlay_chart(found, test, unit, factor, known)),)),
        Section("difference", "Difference with its band",
                (Figure(difference_chart(found, drawn, unit, factor, known)), *(text(band_sentence(one, test), "note") for one in drawn))),
        Section("agreement", "How near", (_grid(agreement_heads(found), agreement_rows(found)), text(NEAR, "note"))),
    ]  # fmt: skip
    student = float(stdtrit(len(test.values) - 1, 0.975)) if len(test.values) > 1 else float("nan")
    for one in drawn:
        name = known[one.label].label
        blocks: list[Block] = [
            text(events_sentence(one), "note"),
            _grid(EVENT_HEADS, event_rows(one, unit, factor, spikes=False)),
        ]
        spikes = event_rows(one, unit, factor, spikes=True)
        blocks += [_grid(("spike", *EVENT_HEADS[1:]), spikes)] if spikes else []
        if one.stages:
            heads = tuple(
                f"{head} ({unit})" if head in ("bias", "rms", "± (95 %)") else head
                for head in STAGE_HEADS
            )
            blocks.append(_grid(heads, stage_rows(one, factor, student)))
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
        f"Model and {made} over one turn of the cam.",
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
    words = quantity_label(found.quantity).lower()
    return f"{words} ({unit})" if unit else words


def _stretches(found: ModelAgainstTest) -> tuple[Band, ...]:
    event = found.study.lift_event
    return (
        ()
        if event is None
        else (Band(float(np.degrees(event.start)), float(np.degrees(event.end)), "lift event"),)
    )


def _of_values(found: ModelAgainstTest) -> list[Section]:
    known = line_styles(found.study)
    sections = [Section("values", "Off by, in scatters", (Figure(values_chart(found, known)),))]
    for one in found.runs:
        grid = _grid(VALUE_HEADS, value_rows(one))
        key = one.label.replace(" ", "-").replace(",", "")
        sections.append(
            Section(
                f"values-{key}",
                f"Values, {known[one.label].label}",
                (text(outside_sentence(one), "note"), grid),
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
    words = quantity_label(row.quantity) + (", angle" if row.kind == "angle" else "")
    return f"{words}, {speed_text(row.engine_speed)}" if with_speed else words


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
    near = one.agreement
    data: dict[str, Any] = {
        "label": one.label,
        "model": one.model,
        "sentence": one.sentence,
        "f_test": _test(one.adequacy),
    }
    if near is not None:
        data["agreement"] = {
            name: getattr(near, name)
            for name in ("bias", "rms", "correlation", "shift", "shift_reach", "rest", "scatter")
        } | {"shift_time": near.shift / cam_speed}
    if one.band is not None:
        data["band"] = {
            "factor": one.band.factor,
            "level": one.band.level,
            "share_outside": float(one.band.outside.mean()),
        }
    if one.events:
        data["events"] = [
            {
                "event": row.name,
                "what": row.dimension,
                "model": row.model,
                "seen": row.seen,
                "test": row.test,
                "difference": row.difference,
                "scatter": row.scatter,
                "in_standard_errors": row.in_errors,
                "outside": row.outside,
            }
            for row in one.events
        ]
    if one.stages:
        data["stages"] = [
            {
                "name": row.name,
                "first": row.first,
                "last": row.last,
                "bias": row.bias,
                "bias_standard_error": row.bias_error,
                "rms": row.rms,
                "share_outside": row.share_outside,
            }
            for row in one.stages
        ]
    if one.values:
        data["values"] = [
            {
                "quantity": row.quantity,
                "what": row.kind,
                "engine_speed": row.engine_speed,
                "unit": row.unit,
                "model": row.model,
                "test": row.test,
                "scatter": row.scatter,
                "difference": row.difference,
                "in_scatters": row.in_scatters,
            }
            for row in one.values
        ]
    return data


def _test(test: AdequacyTest | None) -> dict[str, Any] | None:
    if test is None:
        return None
    return {
        "adequacy_variance": test.adequacy,
        "reproducibility_variance": test.reproducibility,
        "ratio": test.ratio,
        "degrees_of_freedom": list(test.degrees),
        "critical": test.critical,
        "p_value": test.p_value,
        "adequate": test.adequate,
        "places": test.places,
        "independent_places": test.independent,
        "repeats": test.repeats,
        "fitted": test.fitted,
        "level": test.level,
        "p_value_if_every_place_counted": test.counted_p_value,
        "refutable_rms": test.refutable,
        "shared_mean_squares": list(test.shared),
    }


def write_compare_test(found: ModelAgainstTest, folder: Path) -> list[Path]:
    """``curves.csv`` and ``events.csv`` of measured cycles, or ``values.csv`` of a table; SI but
    for angles in cam degrees.
    """
    test = found.test
    heads: tuple[str, ...]
    if not isinstance(test, MeasuredCycles):
        rows: list[tuple[Any, ...]] = [
            (
                one.label,
                row.quantity,
                row.kind,
                row.engine_speed * 30 / math.pi,
                row.model,
                row.test,
                row.scatter,
                row.difference,
                row.in_scatters,
            )
            for one in found.runs
            for row in one.values
        ]
        heads = (
            "run",
            "quantity",
            "what",
            "engine speed [rpm]",
            "model [SI]",
            "test [SI]",
            "scatter [SI]",
            "difference [SI]",
            "in scatters",
        )
        return [_write(folder / "values.csv", heads, rows)]
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
    made = [
        _write(
            folder / "curves.csv",
            tuple(columns),
            zip(*(column.tolist() for column in columns.values()), strict=True),
        )
    ]
    heads = (
        "run",
        "event",
        "what",
        "model",
        "seen",
        "test",
        "difference",
        "scatter of one cycle",
        "in standard errors",
        "outside",
    )
    told = [
        (
            one.label,
            row.name,
            row.dimension,
            row.model,
            row.seen,
            row.test,
            row.difference,
            row.scatter,
            row.in_errors,
            row.outside,
        )
        for one in found.runs
        for row in one.events
    ]
    return [*made, _write(folder / "events.csv", heads, told)]


def _write(path: Path, heads: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Path:
    memory = io.StringIO()
    writer = csv.writer(memory, lineterminator="\n")
    writer.writerow(heads)
    for row in rows:
        writer.writerow(
            [
                ""
                if isinstance(cell, float) and math.isnan(cell)
                else f"{cell:.9g}"
                if isinstance(cell, float)
                else cell
                for cell in row
            ]
        )
    return write_text(path, memory.getvalue())


def _cell(cell: Any) -> Any:
    if not isinstance(cell, float):
        return cell
    return "" if math.isnan(cell) else f"{cell:.9g}"
