"""The page of one run: results, downloads, test data over it."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import quote

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.pages.case_page import missing_page
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Results, Upload, button, tag
from valvetrain.workbench.pages.file_lists import FileList
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.runs import run_head, run_table
from valvetrain.workbench.saved_runs import Run, remove_test, saved_tests
from valvetrain.workbench.side_files import StoredFile

if TYPE_CHECKING:
    from nicegui.events import GenericEventArguments


class RunTests:
    """The panel of one visit: the tests that are saved with a run, one of which is shown."""

    def __init__(self, desk: Desk, run: Run) -> None:
        self.run, self.shown = run, ""
        with tag("div", classes="panel"):
            tag("h2", "Test data over this run")
            hint = "Measured cycles (.csv, .nc) as 'valvetrain rig' writes them, or a table of values. It stays with the run."
            address = f"/upload/test?run={quote(run.run_id)}"
            Upload(
                {"done": self.arrived}, field="test-file", label="File of a test", hint=hint, url=address, most=desk.settings.most_upload,
            )  # fmt: skip
            self.list = FileList(
                lambda: saved_tests(run),
                self.head,
                lambda name: remove_test(run, name),
                self.removed,
            )
            self.over = Results()
        self.show()

    def arrived(self, event: GenericEventArguments) -> None:
        """A test was sent: it is shown."""
        self.show(str(event.args["test"]))

    async def removed(self) -> None:
        """A test was taken away: that which was shown is shown again where it is still there."""
        self.show(self.shown)

    def show(self, name: str = "") -> None:
        """Show the test of that name, the newest where there is none, and the list of all."""
        tests = {one.name: one for one in saved_tests(self.run)}
        self.shown = name if name in tests else next(iter(tests), "")
        self.list.show()
        place = f"/part-test/{quote(self.run.run_id)}/{quote(self.shown)}"
        self.over.tell(source=f"{place}?at={tests[self.shown].changed}" if tests else "")

    def head(self, test: StoredFile) -> None:
        """The name of a test, and a button that shows it."""
        tag("span", test.name)
        pressed = "true" if test.name == self.shown else "false"
        button(
            "Show",
            lambda: self.show(test.name),
            "button small",
            aria_label=f"Show {test.name}",
            aria_pressed=pressed,
        )


def run_page(desk: Desk, run_id: str) -> None:
    """The page of a saved run."""
    try:
        run = desk.workspace.run(run_id)
    except ValvetrainError as error:
        missing_page("This run is not there", str(error))
        return
    with frame(f"{run.case}, {run.command}"):
        run_head(desk, run, full=True)
        Results(source=f"/part/{run_id}")
        RunTests(desk, run)


def runs_page(desk: Desk) -> None:
    """All saved runs."""
    with frame("Runs", "/runs", figures=False):
        tag("h1", "Runs")
        runs = desk.workspace.runs()
        if runs:
            run_table(runs)
        else:
            tag("p", "There is no run yet. Choose a case on the start page and run it.", "said")
