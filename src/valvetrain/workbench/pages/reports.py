"""The report of a kept run, taken apart: its sections with the data of their figures, to stand in another page."""

from __future__ import annotations

import json
import re
from typing import Any

from valvetrain.errors import InputError
from valvetrain.workbench.kept import Run

_DATA = re.compile(r'<script type="application/json" id="(?:data|motion)-([^"]*)">[^<]*</script>\n?')
_FIGURE = re.compile(r'<script type="application/json" id="data-([^"]*)">([^<]*)</script>')
#: Pictures for readers without scripts.
_WITHOUT_SCRIPTS = re.compile(r"<noscript>.*?</noscript>\n?", re.DOTALL)
_CHART = re.compile(r'data-chart="([^"]*)"')
#: Sections that are seen first, whose figures come with them.
FIRST = ("answers", "force", "verdict")
#: Largest report that is read for its sections (bytes).
MOST_REPORT = 200_000_000


def report_part(run: Run) -> str:
    """Sections of a run's report, with the data of the figures that are seen first, for a page that has its style and script.

    Raises :class:`InputError` for a run without a report.
    """
    sections, data = _taken_apart(run)
    first = _seen_first(sections)
    return sections + "\n" + "".join(match[0] for match in _DATA.finditer(data) if match[1] in first)


def report_rest(run: Run) -> str:
    """The data of the other figures and moving pictures."""
    sections, data = _taken_apart(run)
    first = _seen_first(sections)
    return "".join(match[0] for match in _DATA.finditer(data) if match[1] not in first)


def _taken_apart(run: Run) -> tuple[str, str]:
    """The sections of a report, and the data that stand between them and its scripts."""
    text = _report(run)
    start, end = text.find('<section id="'), text.rfind("\n<footer>")
    if start < 0 or end < start:
        raise InputError("the report of this run has no sections; run it again", run.run_id)
    scripts = text.find("\n<script>", end)
    return _WITHOUT_SCRIPTS.sub("", text[start:end]), text[end : scripts if scripts > 0 else len(text)]


def _seen_first(sections: str) -> set[str]:
    """Keys of the figures of the sections that are seen first."""
    parts = sections.split('<section id="')[1:]
    shown = [part for part in parts if part.partition('"')[0] in FIRST] or parts[:2]
    return {key for part in shown for key in _CHART.findall(part)}


def report_figures(run: Run) -> dict[str, dict[str, Any]]:
    """Figures of a run's report by their keys, each with data and layouts."""
    found = {key: json.loads(content) for key, content in _FIGURE.findall(_report(run))}
    return {key: figure for key, figure in found.items() if "data" in figure}


def _report(run: Run) -> str:
    page = run.page
    if page is None or page.stat().st_size > MOST_REPORT:
        raise InputError("this run wrote no report; run it again", run.run_id)
    return page.read_text(encoding="utf-8")
