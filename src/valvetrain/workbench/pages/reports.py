"""The report of a kept run, taken apart: its sections with the data of their figures, to stand in another page."""

from __future__ import annotations

import json
import re
from typing import Any

from valvetrain.errors import InputError
from valvetrain.workbench.kept import Run

_DATA = re.compile(r'<script type="application/json" id="(?:data|motion)-[^<]*</script>\n?')
_FIGURE = re.compile(r'<script type="application/json" id="data-([^"]*)">([^<]*)</script>')
#: Largest report that is read for its sections (bytes).
MOST_REPORT = 200_000_000


def report_part(run: Run) -> str:
    """Sections and data of the figures of a run's report, to stand in a page that has its style and script.

    Raises :class:`InputError` for a run without a report.
    """
    text = _report(run)
    start, end = text.find('<section id="'), text.rfind("\n<footer>")
    if start < 0 or end < start:
        raise InputError("the report of this run has no sections; run it again", run.run_id)
    return text[start:end] + "\n" + "".join(_DATA.findall(text, end))


def report_figures(run: Run) -> dict[str, dict[str, Any]]:
    """Figures of a run's report by their keys, each with data and layouts."""
    found = {key: json.loads(content) for key, content in _FIGURE.findall(_report(run))}
    return {key: figure for key, figure in found.items() if "data" in figure}


def _report(run: Run) -> str:
    page = run.page
    if page is None or page.stat().st_size > MOST_REPORT:
        raise InputError("this run wrote no report; run it again", run.run_id)
    return page.read_text(encoding="utf-8")
