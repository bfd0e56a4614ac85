"""Answers of the backend as parts of a page, in the form of the report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from typing import Any

from valvetrain.compare_test import ModelAgainstTest
from valvetrain.errors import InputError, ValvetrainError
from valvetrain.report.page import Block, Cell, Grid, Section, render_part, text
from valvetrain.report.plotly_chart import in_script
from valvetrain.views.page import figure_content
from valvetrain.views.results import answer_of, figures_of
from valvetrain.views.table import TextTable
from valvetrain.workbench.answers import PageTable
from valvetrain.workbench.jobs import JobStatus


def size_text(count: int) -> str:
    """A number of bytes in words.

    >>> size_text(812), size_text(20_480), size_text(3_200_000)
    ('812 bytes', '20 kB', '3.2 MB')
    """
    return (
        f"{count} bytes"
        if count < 1000
        else f"{count / 1e3:.0f} kB"
        if count < 999_500
        else f"{count / 1e6:.1f} MB"
    )


def sentence_of(error: ValvetrainError, key: str = "") -> str:
    """An error as a sentence; at the field of ``key`` the location is not repeated."""
    text = (
        error.reason
        if key and isinstance(error, InputError) and error.where.endswith(key)
        else str(error)
    )
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "?")) else ".")


def figure_html(key: str, title: str, caption: str, plotly: Mapping[str, Any]) -> str:
    """A figure with its data, as a report has it."""
    height = int(plotly.get("layout", {}).get("height", 320))
    return (
        f'<figure id="fig-{escape(key)}"><h3>{escape(title)}</h3><div class="plot" data-chart="{escape(key)}" role="group" '
        f'style="height:{height}px" aria-label="{escape(title)}"></div><figcaption>{escape(caption)}</figcaption></figure>'
        f'<script type="application/json" id="data-{escape(key)}">{in_script(json.dumps(plotly, separators=(",", ":")))}</script>'
    )


def grid_of(key: str, title: str, table: PageTable | None, otherwise: str = "") -> str:
    """A table as a section; ``otherwise``: the sentence in its place where it has no rows."""
    blocks: tuple[Block, ...] = (
        (grid(table),) if table is not None and table.rows else (text(otherwise, "quiet"),)
    )
    return render_part([Section(key, title, blocks)])


def grid(table: PageTable) -> Grid:
    """A table of the report's kind."""
    right = table.right or (False,) * len(table.headers)
    rows = tuple(
        (
            tuple(
                Cell(text_of, "number" if place < len(right) and right[place] else "")
                for place, text_of in enumerate(row)
            ),
            (),
        )
        for row in table.rows
    )
    return Grid(table.headers, rows, caption=table.title)


def test_part(found: ModelAgainstTest) -> str:
    """Test data over a run, as ``valvetrain compare-test`` shows them."""
    answer = answer_of(found)
    assert answer is not None
    said = tuple(text(str(one), "note") for one in (*answer.findings[:1], *answer.bullets))
    parts = [render_part([Section("test", "Test", said)])]
    for name, fig in figures_of(answer).items():
        parts.append(figure_html(f"test-{name}", answer.title, "", figure_content(fig)))
    rows = tuple((one.label, *one.cells, one.remark) for one in answer.lines)
    tables = [TextTable("Rows", ("", *answer.headings, ""), rows), *answer.tables().values()]
    for place, one in enumerate(tables):
        parts.append(grid_of(f"test-{place}", one.title, PageTable("", one.columns, one.rows)))
    return "".join(parts)


_TITLES = {
    "run": "Run",
    "compare": "Comparison of models",
    "sweep": "Sweep",
    "study": "Study",
    "static": "Static curve",
    "modes": "Modes",
}
_TONES = {"finished": "good", "failed": "bad", "cancelled": "warn", "interrupted": "warn"}


def time_left_text(seconds: float | None) -> str:
    """Words on the time left; empty while nothing can be said."""
    if seconds is None:
        return ""
    return (
        f"about {max(seconds, 1):.0f} s left"
        if seconds < 90
        else f"about {seconds / 60:.0f} min left"
    )


def job_shown(job: JobStatus | None) -> dict[str, Any] | None:
    """A job for its panel; None for none."""
    if job is None:
        return None
    going = not job.ended
    parts = (
        (f"{100 * job.share:.0f} %", job.text, time_left_text(job.seconds_left))
        if going and job.state == "running"
        else (job.text,)
    )
    text_of = ", ".join(part for part in parts if part) if going else job.error
    if job.state == "cancelled" and not text_of:
        text_of = (
            "Cancelled. What was finished is saved."
            if job.run_id
            else "Cancelled before anything was finished."
        )
    if job.state == "queued":
        text_of = text_of or "Waits for the job before it."
    return {
        "id": job.job_id,
        "title": _TITLES.get(job.kind, job.kind),
        "state": job.state,
        "tone": _TONES.get(job.state, ""),
        "going": going,
        "percent": round(100 * job.share),
        "words": text_of,
        "again": job.state in ("failed", "cancelled", "interrupted"),
    }
