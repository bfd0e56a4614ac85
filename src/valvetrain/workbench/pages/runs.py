"""Lists of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime

from valvetrain.units.text import clipped
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import link, tag
from valvetrain.workbench.saved_runs import Run

#: Command -> word.
KINDS = {
    "run": "run",
    "compare": "models compared",
    "sweep": "sweep",
    "branches": "branches of motion",
    "compare-springs": "springs compared",
    "study": "study",
    "static": "static curve",
    "modes": "modes",
    "run-up": "run-up",
    "refine": "error bars",
}
_MAX_SPEEDS = 4


def when(run: Run) -> str:
    """Time of a run, to the minute, UTC."""
    try:
        return f"{datetime.fromisoformat(run.created_at):%Y-%m-%d %H:%M}"
    except ValueError:
        return run.created_at[:16] or clipped(run.folder.name)


def models_of(run: Run) -> str:
    """Spring models in words."""
    return ", ".join(run.models) or "the case's own"


def speeds_of(run: Run) -> str:
    """Engine speeds in words."""
    speeds = run.engine_speeds
    if len(speeds) > _MAX_SPEEDS:
        return f"{len(speeds)} from {speeds[0]:.10g} to {speeds[-1]:.10g} rpm"
    return f"{', '.join(f'{speed:.10g}' for speed in speeds)} rpm" if speeds else "the case's own"


def sets_of(run: Run) -> str:
    """Spring sets that were chosen, in words; empty where none were."""
    choices = run.answer.get("choices")
    named = choices.get("spring_sets") if isinstance(choices, Mapping) else None
    return ", ".join(clipped(str(one)) for one in named) if isinstance(named, list) else ""


def name_of(run: Run) -> str:
    """A run in one line."""
    return f"{run.case}, {KINDS.get(run.command, run.command)} of {when(run)}"


def run_table(runs: Sequence[Run], alone: bool = False) -> None:
    """A table of runs, newest first; ``alone``: all are of one case, whose name is then left out."""
    heads = (
        "run",
        *(() if alone else ("case",)),
        "kind",
        "spring models",
        "engine speeds",
        "result",
    )
    with (
        tag("div", classes="scroll", tabindex="0", role="region", aria_label="runs"),
        tag("table", classes="plain runs"),
    ):
        with tag("thead"), tag("tr"):
            for label in heads:
                tag("th", label, scope="col")
        with tag("tbody"):
            for run in runs:
                with tag("tr"):
                    with tag("th", scope="row"):
                        link(when(run), f"/run/{run.run_id}", aria_label=f"Open {name_of(run)}")
                    cells = (KINDS.get(run.command, run.command), models_of(run), speeds_of(run))
                    for label in cells if alone else (run.case, *cells):
                        tag("td", label)
                    result = run.verdict or ("complete" if run.completed else "in part")
                    tag("td", result, "" if run.completed else "bad")


#: Kind of file -> words.
DOWNLOADS = (
    ("report", "Report (HTML)"),
    ("csv", "Tables (CSV)"),
    ("data", "All data"),
    ("case", "Case file"),
)


def run_head(desk: Desk, run: Run, full: bool) -> None:
    """Title, what it was made from, downloads; ``full``: on the run's own page, with a link to its case."""
    kind = KINDS.get(run.command, run.command)
    with tag("div", classes="split"):
        tag(
            "h1" if full else "h2",
            f"{run.title or run.case}: {kind}" if full else f"Results: {kind} of {when(run)}",
        )
        if not full:
            link("Open on its own page", f"/run/{run.run_id}", "quiet")
    made = (f"case {run.case}", f"{when(run)} UTC") if full else ()
    tag("p", "; ".join(filter(None, (*made, models_of(run), sets_of(run), speeds_of(run)))), "said")
    for sentence in run.failures:
        tag("p", sentence, "alert")
    with tag("div", classes="row"):
        for file, label in DOWNLOADS:
            link(label, f"/download/{run.run_id}/{file}", "button small", download="")
        link("Compare with …", f"/compare?a={run.run_id}", "button small")
        if full and run.case in {card.name for card in desk.workspace.cases()}:
            link("Change the case", f"/case/{run.case}", "button small")
