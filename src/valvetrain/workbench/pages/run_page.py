"""The page of one run: results, downloads, test data over it."""

from __future__ import annotations

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.pages.case_page import missing_page
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Results, tag
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.run_list import run_table
from valvetrain.workbench.pages.run_tests import RunTests
from valvetrain.workbench.pages.run_view import run_head


def run_page(desk: Desk, run_id: str) -> None:
    """The page of a kept run."""
    try:
        run = desk.workspace.run(run_id)
    except ValvetrainError as error:
        missing_page("This run is not there", str(error))
        return
    with frame(f"{run.case}, {run.command}"):
        run_head(desk, run, full=True)
        RunTests(desk, run)
        Results(f"/part/{run_id}")


def runs_page(desk: Desk) -> None:
    """All kept runs."""
    with frame("Runs", "/runs", figures=False):
        tag("h1", "Runs")
        runs = desk.workspace.runs()
        if runs:
            run_table(runs)
        else:
            tag("p", "There is no run yet. Choose a case on the start page and run it.", "said")
