"""Answers of the backend as parts of a page, in the form of the report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from typing import Any

from valvetrain.report.page import Block, Cell, Grid, Section, render_part, text
from valvetrain.report.plotly_chart import in_script
from valvetrain.workbench.answers import AnswerTable, Overlaid


def figure_html(key: str, title: str, caption: str, plotly: Mapping[str, Any]) -> str:
    """A figure with its data, as a report has it."""
    height = int(plotly.get("layout", {}).get("height", 320))
    return (
        f'<figure id="fig-{escape(key)}"><h3>{escape(title)}</h3><div class="plot" data-chart="{escape(key)}" style="height:{height}px" role="group" '
        f'aria-label="{escape(title)}"></div><figcaption>{escape(caption)}</figcaption></figure>'
        f'<script type="application/json" id="data-{escape(key)}">{in_script(json.dumps(plotly, separators=(",", ":")))}</script>'
    )


def grid_of(key: str, title: str, table: AnswerTable | None, otherwise: str = "") -> str:
    """A table as a section; ``otherwise``: the sentence in its place where it has no rows."""
    blocks: tuple[Block, ...] = (grid(table),) if table is not None and table.rows else (text(otherwise, "quiet"),)
    return render_part([Section(key, title, blocks)])


def grid(table: AnswerTable) -> Grid:
    """A table of the report's kind."""
    right = table.right or (False,) * len(table.headers)
    rows = tuple(
        (tuple(Cell(words, "number" if place < len(right) and right[place] else "") for place, words in enumerate(row)), ())
        for row in table.rows
    )
    return Grid(table.headers, rows, caption=table.title)


def test_part(found: Overlaid) -> str:
    """Test data over a run."""
    said = "".join(f"<p>{escape(words)}</p>" for words in found.sentences)
    figure = found.figure
    drawn = "" if figure is None else figure_html("test-" + figure.key, figure.title, figure.caption, figure.plotly)
    table = "" if found.table is None else render_part([Section("test-table", "Events and values", (grid(found.table),))])
    return f'<section id="test"><h2>Test</h2>{said}{drawn}</section>{table}'
