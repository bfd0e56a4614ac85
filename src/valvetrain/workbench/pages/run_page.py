"""The page of one run: results, downloads, test data over it."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import quote

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.pages.case_page import missing_page
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Results, Upload, button, tag
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.html import sentence_of, size_text
from valvetrain.workbench.pages.runs import run_head, run_table
from valvetrain.workbench.saved_runs import Run, remove_test, saved_tests

if TYPE_CHECKING:
    from nicegui.events import GenericEventArguments


class RunTests:
    """The panel of one visit: the tests that are saved with a run, one of which is shown.

    Parameters
    ----------
    desk : workspace and bounds
    run : the run
    """

    def __init__(self, desk: Desk, run: Run) -> None:
        self.desk, self.run, self.shown = desk, run, ""
        with tag("div", classes="panel"):
            tag("h2", "Test data over this run")
            hint = "Measured cycles (.csv, .nc) as 'valvetrain rig' writes them, or a table of values. It stays with the run."
            address = f"/upload/test?run={quote(run.run_id)}"
            Upload(
                {"done": self.arrived}, field="test-file", label="File of a test", hint=hint, url=address, most=desk.settings.most_upload,
            )  # fmt: skip
            self.list = tag("ul", classes="files")
            self.refusal = tag("div")
            self.over = Results()
        self.show()

    def arrived(self, event: GenericEventArguments) -> None:
        """A test was sent: it is shown."""
        self.show(str(event.args["test"]))

    def show(self, name: str = "", refusal: str = "") -> None:
        """Show the test of that name, the newest where there is none, and the list of all."""
        tests = saved_tests(self.run)
        chosen = next((one for one in tests if one.name == name), None) or next(iter(tests), None)
        self.shown = chosen.name if chosen is not None else ""
        self.list.clear()
        with self.list:
            for one in tests:
                self.row(one.name, one.size, len(tests) > 1)
        self.refusal.clear()
        with self.refusal:
            if refusal:
                tag("p", refusal, "refusal", role="alert")
        place = (
            ""
            if chosen is None
            else f"/part-test/{quote(self.run.run_id)}/{quote(chosen.name)}?at={chosen.changed}"
        )
        self.over.tell(source=place)

    def row(self, name: str, size: int, several: bool) -> None:
        """One test; ``several``: there are others to show in its place."""
        with tag("li"):
            tag("span", name)
            tag("span", size_text(size), "hint")
            with tag("span", classes="row"):
                if several:
                    pressed = "true" if name == self.shown else "false"
                    button(
                        "Show",
                        lambda: self.show(name),
                        "button small",
                        aria_label=f"Show {name}",
                        aria_pressed=pressed,
                    )
                button(
                    "Remove", lambda: self.remove(name), "button small", aria_label=f"Remove {name}"
                )

    def remove(self, name: str) -> None:
        """Take a test away from the run."""
        refusal = ""
        try:
            remove_test(self.run, name)
        except ValvetrainError as error:
            refusal = sentence_of(error, "test")
        self.show("" if name == self.shown else self.shown, refusal)


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
