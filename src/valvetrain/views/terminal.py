"""The answer of a command in the terminal: one screen."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rich.console import RenderableType, group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from valvetrain.findings.words import speed_text
from valvetrain.views.shown import Shown, ShownStudy
from valvetrain.views.table import TextTable

if TYPE_CHECKING:
    from valvetrain.views.over_speed import Bar

STYLE = {"bad": "bold red", "warn": "yellow", "ok": "green", "": ""}
SIGN = {"bad": "✗", "warn": "!", "ok": "✓", "": ""}
#: Letters of units that capitals would spoil: kN, MPa, mJ, µm.
UNIT_LETTERS = {*"NPJWµ"}
#: Findings behind the rows, and width of the bars of control.
BULLETS, WIDTH = 6, 40


@group()
def screen(answer: Shown, page: str = "", folder: str = "") -> Iterator[RenderableType]:
    """Title, verdict, rows, printed values, further findings, assumptions, what to run next, and the ``page``, or the
    ``folder`` of the files where no page was written.
    """
    yield Text(answer.title, style="bold")
    told = set[str]()
    if answer.verdict is not None:
        fact, rest = answer.headline
        words = (word if {*word} & UNIT_LETTERS else word.upper() for word in fact.split(" "))
        yield Text.assemble((" ".join(words), STYLE[answer.verdict.mark]), rest)
    if isinstance(answer, ShownStudy) and {"searched", "run-up"} & {*answer.facts.kinds}:
        from valvetrain.views.over_speed import bars, reach  # loads plotly

        if found := bars(answer.facts):
            yield Padding(_bars(answer, found, reach(answer.facts)), (0, 2), expand=False)
            told = {one.code for one in found}
    if answer.models is not None:
        yield Padding(_texts(answer.models, -1), (0, 2), expand=False)
    if answer.lines:
        yield Padding(_rows(answer), (0, 2), expand=False)
    if answer.paper is not None:
        yield Padding(_texts(answer.paper), (0, 2), expand=False)
    for one in [one for one in answer.bullets if one.code not in told][:BULLETS]:
        sign = f"{SIGN[one.mark]} " if one.mark == "warn" else ""
        yield Text(f"  {sign}{one}", style=STYLE[one.mark])
    if answer.rests_on:
        yield Text(f"  rests on: {', '.join(answer.rests_on)}", style="dim")
    if answer.next_step:
        command = answer.next_step.startswith("valvetrain ")
        yield _line("next" if command else "to do", answer.next_step, wraps=not command)
    if answer.further_step:
        yield _line("also", answer.further_step)
    if folder and not page:
        yield _line("files", folder)
    if page:
        yield _line("page", page)


def _line(word: str, text: str, wraps: bool = False) -> Text:
    """A text behind a grey word, on one line of any length unless it ``wraps``: a command or a path is copied as it is."""
    manner: dict[str, Any] = {} if wraps else {"no_wrap": True, "overflow": "ignore"}
    return Text.assemble((f"  {word}: ", "dim"), text, **manner)


def _rows(answer: Shown) -> Table:
    """The rows with their marks."""
    several = len(answer.headings) > 1
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(style="dim", no_wrap=True)
    for _ in answer.headings:
        grid.add_column(justify="right" if several else "left")
    grid.add_column(min_width=1)  # rich narrows the others next to an empty column
    if several:
        grid.add_row("", *(Text(one, style="dim") for one in answer.headings), "")
    for row in answer.lines:
        remark = f"{SIGN[row.mark]} {row.remark}".strip()
        grid.add_row(row.label, *row.cells, Text(remark, style=STYLE[row.mark]))
    return grid


def _texts(table: TextTable, last: int | None = None) -> Table:
    """A table with grey headings and names, up to the column ``last``."""
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_row(*(Text(one, style="dim") for one in table.columns[:last]))
    for name, *cells in (row[:last] for row in table.rows):
        grid.add_row(Text(name, style="dim"), *cells)
    return grid


def _bars(answer: ShownStudy, bars: list[Bar], span: tuple[float, float]) -> Table:
    """Bars over engine speed, with the red line where they leave room."""
    low, high = span
    step = (high - low) / WIDTH
    red = (answer.facts.red_line - low) / step
    why = {one.code: one.remark for one in answer.findings}
    grid = Table.grid(padding=(0, 2, 0, 0))
    scale = f"{speed_text(low, '')}{speed_text((low + high) / 2, ''):^{WIDTH - 8}}{speed_text(high, '')}"
    grid.add_column(no_wrap=True)
    grid.add_column(no_wrap=True)
    grid.add_row("", Text(scale, style="dim"))
    for bar in bars:
        cells = [" "] * WIDTH
        if 0 <= red < WIDTH:
            cells[int(red)] = "¦"
        for begin, end in bar.spans:
            first = round((begin - low) / step)
            for place in range(first, max(round((end - low) / step), first + 1)):
                cells[min(place, WIDTH - 1)] = "█"
        said = Text(why.get(bar.code, ""), style="dim")
        grid.add_row(Text(bar.word, style="dim"), Text("".join(cells), style=STYLE[bar.mark]), said)
    return grid
