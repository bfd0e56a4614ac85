"""The page of one run: results, downloads, test data over it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.pages.case_page import missing_page
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Results, Upload, tag
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.run_list import run_table
from valvetrain.workbench.pages.run_view import run_head

if TYPE_CHECKING:
    from nicegui.events import GenericEventArguments


def run_page(desk: Desk, run_id: str) -> None:
    """The page of a kept run."""
    try:
        run = desk.workspace.run(run_id)
    except ValvetrainError as error:
        missing_page("This run is not there", str(error))
        return
    with frame(f"{run.case}, {run.command}"):
        run_head(desk, run, full=True)

        def laid_over(event: GenericEventArguments) -> None:
            over.show(str(event.args["part"]))

        with tag("div", classes="panel"):
            tag("h2", "Test data over this run")
            most = desk.settings.most_upload
            hint = "Measured cycles (.csv, .nc) as 'valvetrain rig' writes them, or a table of values."
            Upload("test-file", "File of a test", hint, f"/upload/test?run={run_id}", "", most, laid_over)
            over = Results(whole=True)
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
