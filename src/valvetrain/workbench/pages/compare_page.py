"""Two runs side by side: curves over each other, inputs and results that differ."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from html import escape, unescape
from typing import Any
from urllib.parse import quote

from valvetrain.errors import InputError
from valvetrain.report.plotly_chart import in_script
from valvetrain.views.page import data_of
from valvetrain.workbench import answers
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Results, tag
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.html import figure_html, grid_of
from valvetrain.workbench.pages.runs import first_sentence, models_of, name_of, speeds_of
from valvetrain.workbench.saved_runs import Run

_DATA = re.compile(
    r'<script type="application/json" id="(?:data|motion)-([^"]*)">[^<]*</script>\n?'
)
_FIGURE = re.compile(r'<script type="application/json" id="data-([^"]*)">([^<]*)</script>')
#: Pictures for readers without scripts.
_WITHOUT_SCRIPTS = re.compile(r"<noscript>.*?</noscript>\n?", re.DOTALL)
_VERDICT = re.compile(r'<(p|h1) class="verdict">(.*?)</\1>', re.DOTALL)
#: Parts between the picture of a report and its first section, which the page of a run shows itself.
_ABOUT = re.compile(r'<div class="about">.*?</dl>\n</div>\n?', re.DOTALL)
_TAG = re.compile(r"<[^>]*>")
_CHART = re.compile(r'data-chart="([^"]*)"')
#: Sections that are seen first, whose figures come with them.
FIRST = ("opening", "answers", "force", "verdict")
#: Largest report that is read for its sections (bytes).
MAX_REPORT = 200_000_000


def report_part(run: Run) -> str:
    """Sections of a run's report, with the data of the figures that are seen first, for a page that
    has its style and script.

    Raises :class:`InputError` for a run without a report.
    """
    sections, data = _taken_apart(run)
    first = _seen_first(sections)
    return (
        sections + "\n" + "".join(match[0] for match in _DATA.finditer(data) if match[1] in first)
    )


def verdict_in(run: Run) -> str:
    """The one sentence with which a run's report opens; empty where it has none."""
    try:
        found = _VERDICT.search(_report(run))
    except InputError:
        return ""
    return "" if found is None else unescape(_TAG.sub("", found[2]))


def report_rest(run: Run) -> str:
    """The data of the other figures and moving pictures."""
    sections, data = _taken_apart(run)
    first = _seen_first(sections)
    return "".join(match[0] for match in _DATA.finditer(data) if match[1] not in first)


def _taken_apart(run: Run) -> tuple[str, str]:
    """The sections of a report, and the data between them and its scripts."""
    text = _report(run)
    start, end = text.find('<section id="'), text.rfind("\n<footer>")
    if start < 0 or end < start:
        raise InputError("the report of this run has no sections; run it again", run.run_id)
    scripts = text.find("\n<script>", end)
    shown = text[start:end]
    if (content := data_of(text)) is not None:
        return shown, "".join(_data_element(*one) for one in content.items())
    for left_out in (_WITHOUT_SCRIPTS, _ABOUT, _VERDICT):  # the page shows these itself
        shown = left_out.sub("", shown)
    return shown, text[end : scripts if scripts > 0 else len(text)]


def _data_element(key: str, content: Any) -> str:
    """The data of a figure as the script of the workbench reads them."""
    text = in_script(json.dumps(content, separators=(",", ":")))
    return f'<script type="application/json" id="{escape(key)}">{text}</script>\n'


def _seen_first(sections: str) -> set[str]:
    """Keys of the figures of the sections that are seen first."""
    parts = sections.split('<section id="')[1:]
    shown = [part for part in parts if part.partition('"')[0] in FIRST] or parts[:2]
    return {key for part in shown for key in _CHART.findall(part)}


def report_figures(run: Run) -> dict[str, dict[str, Any]]:
    """Figures of a run's report by their keys, each with data and layouts."""
    text = _report(run)
    if (content := data_of(text)) is not None:
        found = {key.removeprefix("data-"): one for key, one in content.items()}
    else:
        found = {key: json.loads(one) for key, one in _FIGURE.findall(text)}
    return {key: figure for key, figure in found.items() if "data" in figure}


def _report(run: Run) -> str:
    page = run.page
    if page is None or page.stat().st_size > MAX_REPORT:
        raise InputError("this run wrote no report; run it again", run.run_id)
    try:
        return page.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise InputError("the report of this run is damaged; run it again", run.run_id) from None


#: Figures that are laid over each other, those that both runs have.
FIGURES = {
    "force-retainer": "Spring force on the retainer", "force-seat": "Spring force on the cylinder head", "sweep": "Forces over engine speed",
    "static-1": "Static curve", "force": "Spring force on the retainer", "control": "Force on the cam", "rest": "Static curve",
}  # fmt: skip


def compare_page(desk: Desk, a: str, b: str) -> None:
    """The page of a comparison; without two runs it requests them."""
    # A study has no inputs, and what is damaged no command.
    runs = [run for run in desk.workspace.runs() if run.command not in ("study", "")]
    with frame("Compare", "/compare"):
        tag("h1", "Compare two runs")
        if len(runs) < 2:
            tag(
                "p",
                "There are fewer than two runs yet. Run a case, change a value, run it again.",
                "said",
            )
            return
        with tag("form", classes="row end compare", action="/compare", method="get"):
            first, second = two_runs(runs, a, b)
            for name, chosen in (("a", first), ("b", second)):
                _choice(name, chosen, runs)
            tag("button", "Compare", "button main", type="submit")
        if a and b:
            Results(f"/part-compare?a={quote(a)}&b={quote(b)}", whole=True)


def two_runs(runs: Sequence[Run], a: str, b: str) -> tuple[str, str]:
    """Two different runs to compare, those requested where they are; the other one is the newest
    of the same case, where there is one.
    """
    given = a or b
    case = next((run.case for run in runs if run.run_id == given), "")
    others = [run for run in runs if run.run_id != given]
    other = next((run for run in others if run.case == case), others[0]).run_id
    if a and b and a != b:
        return a, b
    if given:
        return (given, other) if a else (other, given)
    newest = runs[0].run_id
    same = next((run for run in runs[1:] if run.case == runs[0].case), runs[1])
    return same.run_id, newest


def _choice(name: str, chosen: str, runs: Sequence[Run]) -> None:
    with tag("div", classes="labelled"):
        tag("label", f"Run {name.upper()}", for_=f"run-{name}")
        with tag("select", id=f"run-{name}", name=name):
            for run in runs:
                selected = "selected" if run.run_id == chosen else None
                tag(
                    "option",
                    f"{name_of(run)}: {models_of(run)}, {speeds_of(run)}",
                    value=run.run_id,
                    selected=selected,
                )


def comparison_part(desk: Desk, a: str, b: str) -> str:
    """The comparison as HTML. Raises :class:`InputError` for a run that is not there."""
    one, other = desk.workspace.run(a), desk.workspace.run(b)
    if one.run_id == other.run_id:
        raise InputError("both are the same run; choose another", "run B")
    found = answers.compare(one, other)
    first, second = _figures(one), _figures(other)
    drawn = [
        figure_html(
            f"both-{key}", title, "Solid: run A. Dashed: run B.", over(first[key], second[key])
        )
        for key, title in FIGURES.items()
        if key in first and key in second
    ]
    said = "".join(
        f'<p class="verdict"><span>Run {label}: </span>{escape(sentence)}</p>'
        for label, run in (("A", one), ("B", other))
        for sentence in (first_sentence(run.verdict), *run.failures[: answers.MAX_ROWS])
        if sentence
    )
    return "".join(
        (
            f'<section id="verdicts">{said}{"".join(drawn)}</section>' if said or drawn else "",
            grid_of(
                "inputs-differ", "Inputs that differ", found.inputs, "The inputs are the same."
            ),
            grid_of(
                "results-differ", "Results that differ", found.results, "The results are the same."
            ),
        )
    )


def _figures(run: Run) -> dict[str, dict[str, Any]]:
    try:
        return report_figures(run)
    except InputError:
        return {}


def over(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """The figure ``first`` with the lines of ``second`` dashed over it; axes reach as far as both
    need.
    """
    lines = [
        {**trace, "name": f"{trace.get('name', '')}, B", "line": {**trace["line"], "dash": "dash"}}
        for trace in second["data"]
        if trace.get("mode") == "lines" and _axis(trace) in first["layout"]
    ]
    made = {**first, "data": [*first["data"], *lines]}
    for layout in ("layout", "narrow"):
        made[layout] = {
            key: {
                **value,
                "range": _reach(value.get("range"), second[layout].get(key, {}).get("range")),
            }
            if key.startswith("yaxis") and isinstance(value, dict)
            else value
            for key, value in first[layout].items()
        }
    return made


def _axis(trace: Mapping[str, Any]) -> str:
    return f"yaxis{str(trace.get('yaxis', 'y'))[1:]}"


def _reach(one: Sequence[float] | None, other: Sequence[float] | None) -> list[float] | None:
    if not one or not other:
        return list(one) if one else None
    return [min(one[0], other[0]), max(one[1], other[1])]
