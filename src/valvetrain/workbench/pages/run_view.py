"""A run on the page: what it was, what may be taken of it, and its results."""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.workbench.kept import Run
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import link, tag
from valvetrain.workbench.pages.run_list import KINDS, models_of, sets_of, speeds_of, when

#: Kind of file -> words.
DOWNLOADS = (("report", "Report (HTML)"), ("csv", "Tables (CSV)"), ("data", "All data"), ("case", "Case file"))


def run_head(desk: Desk, run: Run, full: bool) -> None:
    """Title, what it was made from, downloads; ``full``: on the run's own page, with a link to its case."""
    kind = KINDS.get(run.command, run.command)
    with tag("div", classes="split"):
        tag("h1" if full else "h2", f"{run.title or run.case}: {kind}" if full else f"Results: {kind} of {when(run)}")
        if not full:
            link("Open on its own page", f"/run/{run.run_id}", "quiet")
    if full:
        facts = [("case", run.case), ("made", f"{when(run)} UTC"), ("spring models", models_of(run)), ("engine speeds", speeds_of(run))]
        facts += [("spring sets", sets)] if (sets := sets_of(run)) else []
        with tag("dl", classes="facts"):
            for name, value in facts:
                with tag("div"):
                    tag("dt", name)
                    tag("dd", value)
    else:
        if run.models or run.engine_speeds:
            tag("p", "; ".join(filter(None, (models_of(run), sets_of(run), speeds_of(run)))), "said")
    for sentence in run.failures:
        tag("p", sentence, "alert")
    with tag("div", classes="row"):
        for file, words in DOWNLOADS:
            link(words, f"/download/{run.run_id}/{file}", "button small", download="")
        link("Compare with …", f"/compare?a={run.run_id}", "button small")
        if full and run.case in {card.name for card in desk.workspace.cases()}:
            link("Change the case", f"/case/{run.case}", "button small")


def earlier(runs: Sequence[Run], shown: str) -> list[Run]:
    """Runs but the one that is shown."""
    return [run for run in runs if run.run_id != shown]
