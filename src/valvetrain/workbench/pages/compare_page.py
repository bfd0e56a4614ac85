"""Two runs side by side: curves over each other, inputs and results that differ."""

from __future__ import annotations

from collections.abc import Sequence
from urllib.parse import quote

from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Results, tag
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.runs import models_of, name_of, speeds_of
from valvetrain.workbench.saved_runs import Run


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
            Results(source=f"/part-compare?a={quote(a)}&b={quote(b)}")


def two_runs(runs: Sequence[Run], a: str, b: str) -> tuple[str, str]:
    """Two different runs to compare, those requested where they are; the other one is the newest
    of the same case, where there is one.
    """
    if a and b and a != b:
        return a, b
    first = a or b or runs[0].run_id
    case = next((run.case for run in runs if run.run_id == first), "")
    others = [run for run in runs if run.run_id != first]
    other = min(others, key=lambda run: run.case != case).run_id
    return (first, other) if a else (other, first)


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
