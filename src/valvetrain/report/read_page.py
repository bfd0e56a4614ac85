"""A report page read back: the figures, tables and sentences that
:func:`valvetrain.report.page.render` wrote.

Whoever shows a saved run elsewhere than in its page takes them from here, so that nothing is
computed or written twice.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError

#: Largest page that is read (bytes).
MAX_BYTES = 200_000_000
_SCRIPT = re.compile(
    r'<script(?: type="application/json" id="(data|motion)-([^"]*)")?[^>]*>(.*?)</script>',
    re.DOTALL,
)
#: Elements without content.
_EMPTY = ("meta", "link", "br", "path", "circle", "img", "input", "hr", "rect", "line")
_LEFT_OUT = re.compile(r"<style>.*?</style>|<noscript>.*?</noscript>", re.DOTALL)
_STILL = re.compile(r'data-motion="([^"]*)">(.*?)<noscript>', re.DOTALL)


@dataclass(frozen=True, eq=False)
class PageFigure:
    """A figure: ``key``, ``title``, ``caption``, and ``plotly`` with ``data``, ``layout`` and
    ``narrow`` (the layout of a narrow page).

    ``tab``: label of its tab, empty for none. ``legend``: (name, colour) of the
    lines in its key.
    """

    key: str
    title: str
    caption: str
    plotly: Mapping[str, Any]
    tab: str = ""
    legend: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, eq=False)
class PageMotion:
    """A moving picture: ``data`` is what the page's own script mounts, ``still`` an SVG element
    until it does; ``tab`` as of a figure.
    """

    key: str
    title: str
    caption: str
    data: Mapping[str, Any]
    still: str
    tab: str = ""


@dataclass(frozen=True, slots=True)
class PageTable:
    """A table: ``title``, ``headers`` and ``rows`` of words, ``right``: which columns hold numbers,
    ``tab`` as of a figure.

    A row of one cell is a heading across.
    """

    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    right: tuple[bool, ...] = ()
    tab: str = ""


@dataclass(frozen=True, slots=True)
class PageSentence:
    """A paragraph; ``tone`` is ``alert`` for what went wrong, ``note`` for small print; ``tab`` as
    of a figure.
    """

    text: str
    tone: str = ""
    tab: str = ""


PagePart = PageFigure | PageMotion | PageTable | PageSentence


@dataclass(frozen=True, eq=False)
class PageSection:
    """A section of the page: ``key``, ``title`` and its ``parts`` in order."""

    key: str
    title: str
    parts: tuple[PagePart, ...]


def read_page(path: Path) -> tuple[PageSection, ...]:
    """The sections of a report page.

    Raises :class:`InputError` for a file that cannot be read or is no report page.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(
                f"is larger than {MAX_BYTES / 1e6:.0f} MB, so it is not read", path.name
            )
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"cannot be read ({getattr(error, 'strerror', None) or 'no text'}); repeat the run",
            path.name,
        ) from None
    return sections_of(text, path.name)


def sections_of(text: str, where: str = "page") -> tuple[PageSection, ...]:
    """As :func:`read_page`, of the text of a page."""
    if '<meta name="generator" content="valvetrain">' not in text[:4000]:
        raise InputError("is no report page; repeat the run", where)
    try:
        page_data = {
            (match[1], match[2]): json.loads(match[3])
            for match in _SCRIPT.finditer(text)
            if match[1]
        }
    except (ValueError, RecursionError):
        raise InputError("is damaged; repeat the run", where) from None
    bare = _SCRIPT.sub("", text)
    reader = _Reader(page_data, dict(_STILL.findall(bare)))
    reader.feed(_LEFT_OUT.sub("", bare))
    reader.close()
    return tuple(reader.sections)


class _Reader(HTMLParser):
    """Parser of the elements of the page's template."""

    def __init__(self, page_data: Mapping[tuple[str, str], Any], stills: Mapping[str, str]) -> None:
        super().__init__(convert_charrefs=True)
        self.page_data, self.stills, self.sections = page_data, stills, list[PageSection]()
        self._key, self._title, self._parts = "", "", list[PagePart]()
        self._text: list[str] | None = None
        self._open: list[tuple[str, dict[str, str]]] = []
        self._tabs: list[list[str]] = []
        self._tab = ""
        self._figure: dict[str, Any] = {}
        self._table: dict[str, Any] = {}
        self._card = self._caption = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Open an element."""
        given = {name: value or "" for name, value in attrs}
        if tag not in _EMPTY:
            self._open.append((tag, given))
        kind = given.get("class", "").split()
        if tag == "button" and any(name == "figcaption" for name, _ in self._open):
            self._caption, self._text = (
                "".join(self._text or ()),
                None,
            )  # its words are none of the caption's
            return
        if tag == "section":
            self._key, self._title, self._parts, self._tab = given.get("id", ""), "", [], ""
        elif tag == "figure":
            self._figure = {"key": "", "title": "", "caption": "", "legend": []}
        elif tag == "div" and "plot" in kind:
            self._figure["key"] = given.get("data-chart", "")
        elif tag == "div" and "moving" in kind:
            self._figure["motion"] = given.get("data-motion", "")
        elif tag in ("path", "circle") and self._figure and given.get("stroke"):
            self._figure["colour"] = given["stroke"]
        elif tag == "div" and "tabs" in kind:
            self._tabs.append([])
        elif tag == "div" and "tabpanel" in kind:
            place = int(given.get("data-panel", "0") or 0)
            names = self._tabs[-1] if self._tabs else []
            self._tab = names[place] if place < len(names) else ""
        elif tag == "div" and "card" in kind:
            self._card = ""
        elif tag == "table":
            self._table = {"title": self._card, "headers": [], "rows": [], "right": []}
        elif tag == "tr" and self._table:
            self._table["row"], self._table["numbers"] = [], []
        if tag in (
            "h2",
            "h3",
            "figcaption",
            "caption",
            "th",
            "td",
            "p",
            "button",
            "summary",
            "pre",
        ):
            self._text = []

    def handle_data(self, data: str) -> None:
        """Collect the text of the open element."""
        if self._text is not None:
            self._text.append(data)

    def handle_endtag(self, tag: str) -> None:
        """Close an element."""
        if tag in _EMPTY or not any(tag == name for name, _ in self._open):
            return
        given: dict[str, str] = {}
        while self._open:
            last, given = self._open.pop()
            if last == tag:
                break
        label = "".join(self._text or ())
        label = label if tag == "pre" else " ".join(label.split())
        inside = {name for name, _ in self._open}
        if tag in (
            "h2",
            "h3",
            "figcaption",
            "caption",
            "th",
            "td",
            "p",
            "button",
            "summary",
            "pre",
        ):
            self._text = None
        if tag == "h2":
            self._title = label
        elif tag == "h3":
            if "figure" in inside:
                self._figure["title"] = label
            else:
                self._card = label
        elif tag == "figcaption":
            self._figure["caption"] = label or " ".join(self._caption.split())
            self._caption = ""
        elif tag == "caption":
            self._table["title"] = label
        elif tag in ("th", "td") and self._table:
            self._cell(label, given, "thead" in inside)
        elif tag == "tr" and self._table:
            self._row("thead" in inside)
        elif tag == "table":
            self._end_table()
        elif tag == "figure":
            self._end_figure()
        elif tag in ("p", "pre") and "section" in inside and label:
            self._parts.append(PageSentence(label, given.get("class", ""), self._tab))
        elif tag == "button" and given.get("role") == "tab" and self._tabs:
            self._tabs[-1].append(label)
        elif tag == "button" and "data-name" in given and self._figure:
            self._figure["legend"].append((given["data-name"], self._figure.get("colour", "")))
        elif tag == "div" and "tabpanel" in given.get("class", "").split():
            self._tab = ""
        elif tag == "div" and "tabs" in given.get("class", "").split() and self._tabs:
            self._tabs.pop()
        elif tag == "section":
            self.sections.append(PageSection(self._key, self._title, tuple(self._parts)))

    def _cell(self, label: str, given: Mapping[str, str], head: bool) -> None:
        number = "number" in given.get("class", "").split()
        if head:
            self._table["headers"].append(label)
            self._table["right"].append(number)
        else:
            self._table["row"].append(label)

    def _row(self, head: bool) -> None:
        if not head and self._table.get("row"):
            self._table["rows"].append(tuple(self._table["row"]))

    def _end_table(self) -> None:
        page_data = self._table
        self._parts.append(
            PageTable(
                page_data["title"],
                tuple(page_data["headers"]),
                tuple(page_data["rows"]),
                tuple(page_data["right"]),
                self._tab,
            )
        )
        self._table = {}

    def _end_figure(self) -> None:
        page_data, self._figure = self._figure, {}
        if "motion" in page_data:
            data, still = (
                self.page_data.get(("motion", page_data["motion"]), {}),
                self.stills.get(page_data["motion"], ""),
            )
            self._parts.append(
                PageMotion(
                    page_data["motion"],
                    page_data["title"],
                    page_data["caption"],
                    data,
                    still,
                    self._tab,
                )
            )
            return
        drawn = self.page_data.get(("data", page_data["key"]))
        if isinstance(drawn, dict) and "data" in drawn:
            self._parts.append(
                PageFigure(
                    page_data["key"],
                    page_data["title"],
                    page_data["caption"],
                    drawn,
                    self._tab,
                    tuple(page_data["legend"]),
                )
            )
        elif isinstance(drawn, dict) and "gap" in drawn:
            self._parts.append(PageSentence(str(drawn["gap"]), "alert", self._tab))
