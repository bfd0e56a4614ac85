"""Parts of a report page, and the page itself: one HTML file that loads nothing from anywhere."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from typing import Any

from valvetrain.report import theme
from valvetrain.report.chart import Chart


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph; ``html`` is trusted, use :func:`text` for words from outside."""

    html: str
    tone: str = ""

    kind = "text"


@dataclass(frozen=True, eq=False)
class Figure:
    """A chart with its caption."""

    chart: Chart

    kind = "figure"


@dataclass(frozen=True, slots=True)
class Cell:
    """One table cell: escaped ``words``; ``tone`` styles it (number, good, bad, quiet, tag...), ``sort`` is a title shown on hover."""

    words: str
    tone: str = ""
    hint: str = ""


@dataclass(frozen=True, eq=False)
class Grid:
    """A table; a row is its cells and a word that filters may select by; a row of one cell is a heading across."""

    headers: tuple[str, ...]
    rows: tuple[tuple[tuple[Cell, ...], str], ...]
    filters: tuple[str, ...] = ()
    caption: str = ""

    kind = "grid"


@dataclass(frozen=True, slots=True)
class Card:
    """A headline number with what it is compared to."""

    title: str
    lines: tuple[tuple[str, str, str], ...]

    kind = "card"


@dataclass(frozen=True, eq=False)
class Cards:
    """Cards side by side."""

    cards: tuple[Card, ...]

    kind = "cards"


@dataclass(frozen=True, eq=False)
class Tabs:
    """Blocks of which one set is seen at a time, such as one per engine speed."""

    items: tuple[tuple[str, tuple[Any, ...]], ...]
    key: str = "tabs"

    kind = "tabs"


Block = Text | Figure | Grid | Cards | Tabs


@dataclass(frozen=True, eq=False)
class Section:
    """A part of the page with an entry in the contents."""

    key: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, eq=False)
class Page:
    """A whole report: ``kicker`` above the title, ``lead`` below it, ``facts`` as (name, value) pairs, a footer."""

    title: str
    kicker: str
    lead: str
    facts: tuple[tuple[str, str], ...]
    sections: tuple[Section, ...]
    footer: str = ""


def text(words: str, tone: str = "") -> Text:
    """A paragraph of plain words, escaped."""
    return Text(escape(words), tone)


def charts(page: Page) -> list[Chart]:
    """Every chart on a page, in order, those behind tabs included."""
    return [chart for section in page.sections for chart in _charts(section.blocks)]


def _charts(blocks: Sequence[Any]) -> list[Chart]:
    found: list[Chart] = []
    for block in blocks:
        if isinstance(block, Figure):
            found.append(block.chart)
        elif isinstance(block, Tabs):
            for _, inner in block.items:
                found += _charts(inner)
    return found


def render(page: Page) -> str:
    """The page as one self-contained HTML document, Plotly and data included."""
    import jinja2

    from valvetrain.report.plotly_chart import to_json

    loader = jinja2.FunctionLoader(_template)
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    drawn = {chart.key: to_json(chart) for chart in charts(page)}
    style = _static("page.css").replace("FONT_STACK", theme.FONT)
    library = plotly_script() if drawn else ""
    return environment.get_template("page.html.j2").render(page=page, drawn=drawn, style=style, script=_static("page.js"), plotly=library)


def plotly_script() -> str:
    """The text of plotly.js, safe inside a script element (none for a page without charts is the caller's choice)."""
    source = resources.files("plotly").joinpath("package_data", "plotly.min.js").read_text(encoding="utf-8")
    # Escaped to ASCII, Python keeps the text and its copies in one byte per character instead of two.
    return re.sub(r"[^\x00-\x7f]", lambda found: f"\\u{ord(found[0]):04x}", source.replace("</script", "<\\/script"))


def _template(name: str) -> str:
    return resources.files("valvetrain.report").joinpath("templates", name).read_text(encoding="utf-8")


def _static(name: str) -> str:
    return resources.files("valvetrain.report").joinpath("static", name).read_text(encoding="utf-8")
