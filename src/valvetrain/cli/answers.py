"""The answer of a study in the terminal: the most important results first, then published values
where there are any, then the folder of all results.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

from valvetrain.cli.outcome import PLAIN_WIDTH, plain_table
from valvetrain.cli.published import NARROW, ErrorBars, Ranges, fitting
from valvetrain.parameters.summary import number, unit_text
from valvetrain.report.headlines import (
    HeadlineColumn,
    HeadlineRow,
    headline_columns,
    headline_rows,
    largest_clash_rows,
)
from valvetrain.report.key_figures import key_figures
from valvetrain.report.run_charts import set_and_model
from valvetrain.report.run_summary import (
    CRITICAL_LEGEND,
    control_legend,
    critical_rows,
    searched,
    unsettled_text,
)
from valvetrain.report.text import rpm, rpm_text
from valvetrain.solution.critical import KINDS
from valvetrain.solution.definition import label_of, names_for
from valvetrain.units.reader import reader_text, reader_unit
from valvetrain.views.answer import Answer
from valvetrain.views.results import moved, tables_in_full
from valvetrain.views.terminal import screen

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from valvetrain.solution.comparison import Comparison
    from valvetrain.solution.study import Study

#: Runs shown side by side in 100 columns; further runs follow below, up to this many.
MAX_COLUMNS, MAX_TABLE_ROWS = 4, 24
#: Letters of a label before it takes a second line, where its table would be too wide.
LABEL = 34
#: Runs up to which what does not fit side by side is in a second table.
TWICE = 12


def show_study(
    console: Console, study: Study, folder: Path, page: Path | None, published: bool = False
) -> None:
    """Print the answer of a study; with ``published`` every comparison, finding and note in full."""
    if moved(study):
        console.print(screen(Answer(study), str(page or ""), str(folder)))
        for one in tables_in_full(study).values() if published else ():
            console.print(plain_table(one.columns, one.rows, f"\n{one.title}"))
        return
    console.print(study.record.title or study.record.name)
    try:
        for table in _tables(study):
            console.print()
            console.print(table)
        if searched(study):
            some = any(not row.main for row in critical_rows(study, study.labels))
            legend = (control_legend(study), CRITICAL_LEGEND if some else "")
            if any(legend):
                console.print(f"\n{' '.join(filter(None, legend))}")
        else:
            rows = [row for row in headline_rows(study) if row.name not in names_for("page")]
            if told := ErrorBars.of(study).legend(rows, headline_columns(study)):
                console.print(f"\n{told}")
        _show_published(console, study, published)
    finally:  # the folder is printed even where a table fails
        console.print(f"results  {folder}", soft_wrap=True)
        if page is not None:
            console.print(f"report   {page}", soft_wrap=True)
    sets = {run.spring_set for run in study.solutions}
    of_models = len(study.labels) > 1 and len(sets) == 1 and not study.over_speed
    if not of_models and (figures := key_figures(study)):  # next to the verdict
        between = "\n" if len(study.labels) > 1 else "; "
        console.print(between.join(f"{name} {value}" for name, value in figures))


def _tables(study: Study) -> Iterator[Table]:
    columns, rows, bars = headline_columns(study), headline_rows(study), ErrorBars.of(study)
    if (
        len(study.rest) > 1 or not study.solutions or (study.rest and not rows)
    ):  # a stretch of motion alone answers nothing
        yield from _rest_tables(study)
    if study.over_speed:
        for first in range(0, len(columns), MAX_COLUMNS):
            yield _over_speeds(study, columns[first : first + MAX_COLUMNS], rows, first)
    elif len(columns) <= MAX_COLUMNS:
        if rows:
            yield _side_by_side(study, columns, rows, bars)
    else:
        same = [
            (row.label, row.unit, _range(row.values))
            for row in rows
            if row.name in names_for("case")
        ]
        if same:
            yield plain_table(("", "", ""), same)
        brief = [row for row in rows if row.name in names_for("brief")]
        close = ErrorBars(bars.rows, "")  # without spaces, where the table fits then
        if _fitting(columns, brief, bars) < _fitting(columns, brief, close):
            bars = close
        fits = _fitting(columns, brief, bars)
        yield _by_run(columns, brief[:fits], "run", bars)
        if fits < len(brief) and len(columns) <= TWICE:
            yield _by_run(
                columns, brief[fits:][: _fitting(columns, brief[fits:], bars)], "run", bars
            )
        ranged = [row for row in brief if any(bars.ranges(row, columns))]
        if ranged:
            ranges = Ranges(bars.rows)
            yield _by_run(columns, ranged[: _fitting(columns, ranged, ranges)], "range", ranges)


def _side_by_side(
    study: Study, columns: Sequence[HeadlineColumn], rows: Sequence[HeadlineRow], bars: ErrorBars
) -> Table:
    """A row per question, a column per run; ranges below their values, and the largest clash of each
    run below the number of clashes.
    """
    speeds = (
        "" if column.engine_speed is None else f"\n{rpm(column.engine_speed):g} rpm"
        for column in columns
    )
    headers = [
        "",
        "",
        *(column.label + label for column, label in zip(columns, speeds, strict=True)),
    ]
    shown = [row for row in rows if row.name not in names_for("page")]

    def width(chosen: ErrorBars, label: int = LABEL) -> int:
        lines = [
            headers,
            *(
                [row.label[:label], unit_text(row.unit), *chosen.cells(row, columns)]
                for row in shown
            ),
            *(["", "", *chosen.ranges(row, columns)] for row in shown),
        ]
        return (
            sum(
                max(len(part) for line in lines for part in line[k].split("\n")) + 2
                for k in range(len(headers))
            )
            - 2
        )

    close = fitting(bars, width)
    table = plain_table(headers, (), right=range(2, len(headers)))
    table.columns[1].no_wrap = True
    if width(close, PLAIN_WIDTH) > NARROW:
        table.columns[0].max_width = LABEL
    for row in rows:
        if row.name not in names_for("page"):
            table.add_row(row.label, unit_text(row.unit), *close.cells(row, columns))
            if any(ranges := bars.ranges(row, columns)):
                table.add_row("  range", "", *ranges)
        if row.name == "clash_count":
            for label, unit, cells in largest_clash_rows(study, columns):
                table.add_row(f"  {label}", unit, *cells)
    return table


def _over_speeds(
    study: Study, columns: Sequence[HeadlineColumn], rows: Sequence[HeadlineRow], first: int
) -> Table:
    """A row per question, a column per label with its worst value and the engine speed (rpm) where
    of that value; ``first``: its column.
    """
    heads = [set_and_model(study, column.label) for column in columns]
    table = plain_table(("", "", *heads), (), right=range(2, 2 + len(columns)))
    table.columns[0].no_wrap = table.columns[1].no_wrap = True
    known = {row.name: row for row in rows}
    control = critical_rows(study, [column.label for column in columns]) if searched(study) else []
    for name in names_for("sweep"):
        row = known.get(name)
        if name in KINDS.values() and control:
            for line in control:
                if line.name == name:
                    table.add_row(
                        line.label if line.main else f"  {line.label}", "rpm", *line.cells
                    )
        for one in () if row is None or (name in KINDS.values() and control) else (row, row.beyond):
            if one is None:
                continue
            pairs = zip(
                one.values[first : first + len(columns)],
                one.engine_speeds[first : first + len(columns)],
                strict=True,
            )
            still = name in names_for("case")
            cells = [
                "–"
                if value is None
                else _at_speed(value, None if still else speed) + one.mark(first + place)
                for place, (value, speed) in enumerate(pairs)
            ]
            label = one.label if one is row else f"  {one.label}"
            table.add_row(label, unit_text(one.unit), *cells)
    speeds = [study.runs(column.label) for column in columns]
    table.add_row("Engine speeds run", "", *(str(len(runs)) for runs in speeds))
    unsettled = [unsettled_text(runs) for runs in speeds]
    if any(unsettled):
        table.add_row("  that did not settle", "", *(cell or "0" for cell in unsettled))
    return table


def _fitting(
    columns: Sequence[HeadlineColumn], rows: Sequence[HeadlineRow], bars: ErrorBars
) -> int:
    """How many of the ``rows`` fit as columns next to the names of the runs without breaking a
    word.
    """
    room = PLAIN_WIDTH - max(len(column.label) for column in columns) - 2 - 7
    for count, row in enumerate(rows):
        room -= _width(columns, row, bars) + 2
        if room < 0:
            return max(count, 1)
    return len(rows)


def _header(row: HeadlineRow) -> str:
    return (
        f"{row.label} ({unit_text(row.unit)})".replace("N s)", "N\u00a0s)")
        if row.unit
        else row.label
    )


def _width(columns: Sequence[HeadlineColumn], row: HeadlineRow, bars: ErrorBars) -> int:
    """Columns that the longest word or number of a row takes."""
    return max(map(len, (*_header(row).split(" "), *_cells(columns, row, bars))))


def _cells(columns: Sequence[HeadlineColumn], row: HeadlineRow, bars: ErrorBars) -> list[str]:
    """Values of a row with their error bars, or with the engine speed of the worst value of a
    sweep.
    """
    if any(speed is not None for speed in row.engine_speeds):
        cells = map(_at_speed, row.values, row.engine_speeds)
        return [cell + row.mark(place) for place, cell in enumerate(cells)]
    return bars.cells(row, columns)


def _by_run(
    columns: Sequence[HeadlineColumn], rows: Sequence[HeadlineRow], noun: str, bars: ErrorBars
) -> Table:
    """A row per run, a column per question."""
    timed = any(column.engine_speed is not None for column in columns)
    headers = [
        noun,
        *(["rpm"] if timed else []),
        *(
            "\n".join(wrap(_header(row), _width(columns, row, bars), break_long_words=False))
            for row in rows
        ),
    ]
    table = plain_table(headers, (), right=range(1, len(headers)))
    for place in range(1 + timed):
        table.columns[place].no_wrap = True
    cells = [_cells(columns, row, bars) for row in rows]
    for place, column in enumerate(columns[:MAX_TABLE_ROWS]):
        speed = (
            []
            if not timed
            else [f"{rpm(column.engine_speed):g}" if column.engine_speed is not None else ""]
        )
        table.add_row(column.label, *speed, *(one[place] for one in cells))
    if len(columns) > MAX_TABLE_ROWS:
        table.add_row(f"and {len(columns) - MAX_TABLE_ROWS} more")
    return table


def _rest_tables(study: Study) -> Iterator[Table]:
    """Springs at rest by each model: force and rate as installed, first axial modes; with the
    difference from the first model.
    """
    reference, several = (
        study.rest[0] if study.rest else None,
        len({one.spring for one in study.rest}),
    )
    rows = []
    for one in study.rest:
        force = rate = None
        if (
            one.curve is not None
            and one.curve.compression[0] <= one.precompression <= one.curve.compression[-1]
        ):
            force, rate = (
                one.curve.force_at(one.precompression),
                one.curve.stiffness_at(one.precompression) * 1e-3,
            )
        modes = (
            [float(value) for value in one.modes.axial_frequencies[:3]]
            if one.modes is not None
            else []
        )
        cells = [force, rate, *modes, *[None] * (3 - len(modes))]
        if one is reference:
            first = cells
        compared = (
            []
            if one is reference or one.spring != study.rest[0].spring
            else [_percent(*pair) for pair in zip(cells, first, strict=True)]
        )
        label = [
            _cell(value) + (f" ({share})" if share else "")
            for value, share in zip(cells, compared or [""] * 5, strict=True)
        ]
        rows.append((one.model if several == 1 else f"{one.spring}, {one.model}", *label))
    if rows:
        table = plain_table(
            (
                "at rest",
                f"preload ({reader_unit('N')})",
                f"rate ({reader_unit('N/mm')})",
                "mode 1 (Hz)",
                "mode 2 (Hz)",
                "mode 3 (Hz)",
            ),
            rows,
            right=range(1, 6),
        )
        table.columns[0].no_wrap = True
        yield table


def _percent(value: float | None, reference: float | None) -> str:
    from valvetrain.report.text import percent

    return "" if value is None or not reference else percent(value / reference - 1)


def _show_published(console: Console, study: Study, whole: bool) -> None:
    """A line on published values, and one on findings and notes; or all of them."""
    from valvetrain.cli.published import show_comparisons
    from valvetrain.report.fact_texts import study_notes
    from valvetrain.report.published_verdict import calibration_sentence, not_compared_sentence

    lines = (
        published_summary(study.comparisons) if study.comparisons else "",
        calibration_sentence(study.record),
        not_compared_sentence(study) if whole else "",
    )
    if any(lines):
        console.print("\n" + "\n".join(filter(None, lines)))
    notes = study_notes(study)
    more = [
        f"{len(found)} {noun}{'s' if len(found) > 1 else ''}"
        for found, noun in ((study.findings, "finding"), (notes, "note"))
        if found
    ]
    if not study.comparisons and not study.findings:
        for number, note in enumerate(notes):
            console.print(("" if number else "\n") + f"note: {reader_text(note)}")
        return
    if not whole:
        if study.comparisons or more:
            console.print(
                f"{' and '.join(more) + ' in the report; ' if more else ''}--published prints all of it",
                soft_wrap=True,
            )
        return
    if study.comparisons:
        show_comparisons(console, study.comparisons)
    for item in study.findings:
        console.print(
            f"\n{item.place}: {item.statement}\n  computed: {item.computed}\n  verdict:  {item.verdict}",
            soft_wrap=True,
        )
    for note in notes:
        console.print(f"\n{note}", soft_wrap=True)


def published_summary(rows: Sequence[Comparison]) -> str:
    """One sentence: how many published values, which are in doubt, and how many stated tolerances are
    met; the verdict gives how far they differ.
    """
    from valvetrain.report.text import percent

    judged = [row for row in rows if row.verdict.startswith(("within", "misses"))]
    met = sum(row.verdict.startswith("within") for row in judged)
    text = f"{len(rows)} published value{'s' if len(rows) > 1 else ''}"
    for row in rows:
        if row.doubt and row.relative_difference is not None:
            text += f"; {label_of(row.quantity)} {percent(row.relative_difference)}, but the number is in doubt: {row.doubt}"
    return text + (f"; {met} of {len(judged)} stated tolerances met" if judged else "")


def _at_speed(value: float | None, engine_speed: float | None) -> str:
    return _cell(value) + ("" if engine_speed is None else f" at {rpm_text(engine_speed)}")


def _range(values: Sequence[float | None]) -> str:
    """One value, or the minimum and maximum of several."""
    return " to ".join(
        dict.fromkeys(
            map(
                _cell,
                (min(known), max(known))
                if (known := [v for v in values if v is not None])
                else (None,),
            )
        )
    )


def _cell(value: float | None) -> str:
    return number(value, 4)
