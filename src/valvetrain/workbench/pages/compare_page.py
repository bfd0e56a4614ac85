"""Two runs side by side: curves over each other, inputs and results that differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from valvetrain.errors import InputError
from valvetrain.workbench import answers
from valvetrain.workbench.kept import Run
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Results, tag
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.html import figure_html, grid_of
from valvetrain.workbench.pages.reports import report_figures
from valvetrain.workbench.pages.run_list import models_of, name_of, speeds_of

#: Figures that are laid over each other, those that both runs have.
FIGURES = {
    "force-retainer": "Spring force on the retainer", "force-seat": "Spring force on the cylinder head", "sweep": "Over engine speed",
    "static-1": "Static curve",
}  # fmt: skip


def compare_page(desk: Desk, a: str, b: str) -> None:
    """The page of a comparison; without two runs it asks for them."""
    runs = desk.workspace.runs()
    with frame("Compare", "/compare"):
        tag("h1", "Compare two runs")
        if len(runs) < 2:
            tag("p", "There are fewer than two runs yet. Run a case, change a value, run it again.", "said")
            return
        with tag("form", classes="row end compare", action="/compare", method="get"):
            for name, words, chosen in (("a", "Run A", a or runs[1].run_id), ("b", "Run B", b or runs[0].run_id)):
                _choice(name, words, chosen, runs)
            tag("button", "Compare", "button main", type="submit")
        if a and b:
            Results(f"/part-compare?a={quote(a)}&b={quote(b)}", whole=True)


def _choice(name: str, words: str, chosen: str, runs: Sequence[Run]) -> None:
    with tag("div", classes="labelled"):
        tag("label", words, for_=f"run-{name}")
        with tag("select", id=f"run-{name}", name=name):
            for run in runs:
                selected = "selected" if run.run_id == chosen else None
                tag("option", f"{name_of(run)}: {models_of(run)}, {speeds_of(run)}", value=run.run_id, selected=selected)


def comparison_part(desk: Desk, a: str, b: str) -> str:
    """The comparison as HTML. Raises :class:`InputError` for a run that is not there."""
    one, other = desk.workspace.run(a), desk.workspace.run(b)
    if one.run_id == other.run_id:
        raise InputError("both are the same run; choose another", "run B")
    found = answers.compare(one, other)
    first, second = _figures(one), _figures(other)
    drawn = [
        figure_html(f"both-{key}", title, "Solid: run A. Dashed: run B.", over(first[key], second[key]))
        for key, title in FIGURES.items() if key in first and key in second
    ]  # fmt: skip
    return "".join((
        grid_of("inputs-differ", "Inputs that differ", found.inputs, "The inputs are the same."),
        f'<section id="curves"><h2>Curves</h2>{"".join(drawn)}</section>' if drawn else "",
        grid_of("results-differ", "Results that differ", found.results, "The results are the same."),
    ))  # fmt: skip


def _figures(run: Run) -> dict[str, dict[str, Any]]:
    try:
        return report_figures(run)
    except InputError:
        return {}


def over(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """The figure ``first`` with the lines of ``second`` dashed over it; axes reach as far as both need."""
    lines = [
        {**trace, "name": f"{trace.get('name', '')}, B", "line": {**trace["line"], "dash": "dash"}}
        for trace in second["data"] if trace.get("mode") == "lines" and _axis(trace) in first["layout"]
    ]  # fmt: skip
    made = {**first, "data": [*first["data"], *lines]}
    for layout in ("layout", "narrow"):
        made[layout] = {
            key: {**value, "range": _reach(value.get("range"), second[layout].get(key, {}).get("range"))}
            if key.startswith("yaxis") and isinstance(value, dict) else value
            for key, value in first[layout].items()
        }  # fmt: skip
    return made


def _axis(trace: Mapping[str, Any]) -> str:
    return f"yaxis{str(trace.get('yaxis', 'y'))[1:]}"


def _reach(one: Sequence[float] | None, other: Sequence[float] | None) -> list[float] | None:
    if not one or not other:
        return list(one) if one else None
    return [min(one[0], other[0]), max(one[1], other[1])]
