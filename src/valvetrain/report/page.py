"""Blocks of a report page, and the page: one HTML file that loads nothing from elsewhere."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib import resources
from typing import TYPE_CHECKING, Any

from valvetrain.report import theme
from valvetrain.report.chart import Chart, legend_entries
from valvetrain.report.reader_charts import chart_for_reader
from valvetrain.solution.partial_failures import PartialFailures, reason

if TYPE_CHECKING:
    import jinja2


#: Dashes of a line in the key above a figure.
_DASHES = {"solid": "", "dash": "6 4", "dot": "2 3", "dashdot": "8 3 2 3"}


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph; ``html`` is trusted, use :func:`text` for words from outside. ``gap``: it replaces
    a part that failed.
    """

    html: str
    tone: str = ""
    gap: bool = False

    kind = "text"


@dataclass(frozen=True, eq=False)
class Figure:
    """A chart with its caption."""

    chart: Chart

    kind = "figure"


@dataclass(frozen=True, slots=True)
class Cell:
    """One table cell: escaped ``text``; ``tone`` styles it (number, good, bad, quiet, tag...),
    ``sort`` is a title shown on hover.
    """

    text: str
    tone: str = ""
    hint: str = ""


@dataclass(frozen=True, eq=False)
class Grid:
    """A table; a row is its cells and one value per filter; a row of one cell is a heading across.

    ``filters``: what is chosen by, such as ``role``; its words are those that the rows carry.
    """

    headers: tuple[str, ...]
    rows: tuple[tuple[tuple[Cell, ...], tuple[str, ...]], ...]
    filters: tuple[str, ...] = ()
    caption: str = ""

    kind = "grid"

    @property
    def right(self) -> tuple[bool, ...]:
        """Columns of numbers, whose headings are aligned right, as their numbers are."""
        cells = next((row for row, _ in self.rows if len(row) == len(self.headers)), ())
        return tuple("number" in cell.tone for cell in cells) or (False,) * len(self.headers)

    @property
    def choices(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """Filters that part the rows, each with its words in order of appearance."""
        label = [
            tuple(dict.fromkeys(row[place] for _, row in self.rows if row))
            for place in range(len(self.filters))
        ]
        return tuple((name, found) for name, found in zip(self.filters, label, strict=True))


@dataclass(frozen=True, eq=False)
class Details:
    """Blocks that a click opens."""

    summary: str
    blocks: tuple[Any, ...]

    kind = "details"


@dataclass(frozen=True, slots=True)
class Listing:
    """Text of a file, unchanged."""

    text: str

    kind = "listing"


@dataclass(frozen=True, slots=True)
class Motion:
    """A moving picture: ``data`` is what motion.js mounts, as JSON that is safe in a script;
    ``still`` an SVG element until it does.
    """

    key: str
    title: str
    caption: str
    data: str
    still: str

    kind = "motion"


Block = Motion | Text | Figure | Grid | Details | Listing


@dataclass(frozen=True, eq=False)
class Section:
    """A part of the page with an entry in the contents; ``folded`` ones are together at its end,
    closed, under "How it was computed".
    """

    key: str
    title: str
    blocks: tuple[Block, ...]
    folded: bool = False


@dataclass(frozen=True, eq=False)
class Page:
    """A whole report: ``kicker`` above the title, ``verdict`` (its first sentence bold), ``key_figures`` as
    (name, value) pairs and ``picture`` (one figure, or a moving picture) below it, then ``lead``, ``facts`` as (name, value) pairs, sections
    and a footer.
    """

    title: str
    kicker: str
    lead: str
    facts: tuple[tuple[str, str], ...]
    sections: tuple[Section, ...]
    footer: str = ""
    verdict: str = ""
    picture: tuple[Block, ...] = ()
    key_figures: tuple[tuple[str, str], ...] = ()

    @property
    def verdict_sentences(self) -> tuple[str, str]:
        """The first sentence of the verdict, and the rest."""
        first, *more = sentences(self.verdict) or [""]
        return first, " ".join(more)

    @property
    def parts(self) -> tuple[tuple[Block, ...], ...]:
        """Blocks of the picture, then those of each section."""
        return (self.picture, *(section.blocks for section in self.sections))


def text(label: str, tone: str = "") -> Text:
    """A paragraph of plain text, escaped."""
    return Text(escape(label), tone)


def gap(sentence: str) -> Text:
    """A sentence in place of a part that failed."""
    return Text(escape(sentence), "alert", gap=True)


def prose(paragraphs: Sequence[str], summary: str, tone: str = "note") -> tuple[Block, ...]:
    """Paragraphs; text after the third sentence is folded."""
    blocks = tuple(text(sentence, tone) for sentence in paragraphs)
    return (
        (Details(summary, blocks),)
        if sum(len(sentences(sentence)) for sentence in paragraphs) > 3
        else blocks
    )


def sentences(sentence: str) -> list[str]:
    """Sentences of a text, each with its closing sign."""
    return [part for part in re.split(r"(?<=[.!?])\s+(?=[A-Z])", sentence.strip()) if part]


def charts(page: Page) -> list[Chart]:
    """Every chart on a page, in order, those behind folds included."""
    return [block.chart for part in page.parts for block in _all(part) if isinstance(block, Figure)]


def _all(blocks: Sequence[Any]) -> Iterator[Any]:
    """Every block, those behind folds included."""
    for block in blocks:
        if isinstance(block, Details):
            yield from _all(block.blocks)
        else:
            yield block


def render(page: Page, gaps: PartialFailures | None = None) -> str:
    """The page as one self-contained HTML document, Plotly and data included; figures that cannot
    be drawn are added to ``gaps``.
    """
    first = {block.chart.key for block in _all(page.picture) if isinstance(block, Figure)}
    drawn = {chart.key: _drawn(chart, gaps, chart.key in first) for chart in charts(page)}
    library, moving = plotly_script() if drawn else "", _moving(page)
    return _template("page.html.j2").render(
        page=page,
        drawn=drawn,
        style=page_style(),
        script=page_script(),
        plotly=library,
        moving=moving,
        mover=motion_script() if moving else "",
        header=_css_string(f"{page.title} – {page.kicker}"),
        still={
            key: picture
            for key, picture in ((chart.key, _still(chart)) for chart in charts(page))
            if picture
        },
    )


def _moving(page: Page) -> list[Motion]:
    """Every moving picture of a page, in order."""
    return [block for part in page.parts for block in _all(part) if isinstance(block, Motion)]


def page_style() -> str:
    """The style of every page."""
    return _static("page.css").replace("FONT_STACK", theme.FONT)


def page_script() -> str:
    """The script that draws the figures of a page or of a part of one."""
    return _static("page.js")


@cache
def _environment() -> jinja2.Environment:
    import jinja2

    folder = resources.files("valvetrain.report").joinpath("templates")
    loader = jinja2.FunctionLoader(lambda name: folder.joinpath(name).read_text(encoding="utf-8"))
    found = jinja2.Environment(
        loader=loader,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    found.globals |= {"legend": legend_entries, "dashes": _DASHES}
    return found


def _template(name: str) -> jinja2.Template:
    return _environment().get_template(name)


def _still(chart: Chart) -> str:
    """The figure for a reader without scripts; empty where it cannot be drawn."""
    from valvetrain.report.svg_chart import svg

    try:
        return svg(chart_for_reader(chart))
    except Exception:  # one picture must not cost the page
        return ""


def _css_string(label: str) -> str:
    """A text as a string of a style sheet, escaped."""
    return (
        '"'
        + "".join(
            sign if sign.isalnum() or sign in " .,-–()/" else f"\\{ord(sign):x} "
            for sign in label[:120]
        )
        + '"'
    )


def _drawn(chart: Chart, gaps: PartialFailures | None, opening: bool = False) -> str:
    """The figure as JSON, or the reason why it cannot be drawn; ``opening``: it opens the page."""
    from valvetrain.report.plotly_chart import in_script, to_json

    try:
        return to_json(chart_for_reader(chart), opening)
    except Exception as error:  # one figure must not cost the page
        label = f"The figure could not be drawn: {reason(error)}"
        if gaps is not None:
            gaps.add(f"report page, {chart.key}: {label}")
        return in_script(json.dumps({"gap": label}))


def plotly_script() -> str:
    """The text of plotly.js, safe inside a script element."""
    source = (
        resources.files("plotly")
        .joinpath("package_data", "plotly.min.js")
        .read_text(encoding="utf-8")
    )
    # Escaped to ASCII, Python stores the text and its copies in one byte per character instead of
    # two.
    return re.sub(
        r"[^\x00-\x7f]",
        lambda found: f"\\u{ord(found[0]):04x}",
        source.replace("</script", "<\\/script"),
    )


def _static(name: str) -> str:
    return resources.files("valvetrain.report").joinpath("static", name).read_text(encoding="utf-8")


@cache
def motion_script() -> str:
    """Classic script of scene.js, film.js and motion.js that sets ``valvetrainMotion.mount(element,
    data)``; safe inside a script element.
    """
    parts = "\n".join(_static(name) for name in ("scene.js", "film.js", "motion.js"))
    text = f'(function(){{"use strict";\n{parts}\n}})();'
    return text.replace("</script", "<\\/script")
