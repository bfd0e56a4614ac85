"""The panel of files of a case: list, upload, removal."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from urllib.parse import quote

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Upload, button, link, tag
from valvetrain.workbench.pages.html import sentence_of, size_text
from valvetrain.workbench.side_files import StoredFile
from valvetrain.workbench.workspace import CaseId


class CaseFiles:
    """The panel of one visit.

    Parameters
    ----------
    desk : workspace and bounds
    case : whose files
    on_change : called when a file came or went
    """

    def __init__(self, desk: Desk, case: CaseId, on_change: Callable[[], Awaitable[None]]) -> None:
        self.desk, self.case, self.on_change = desk, case, on_change
        self.shown: tuple[StoredFile, ...] = ()
        files = desk.workspace.side_files(case)
        with tag("details", classes="group", id="case-files", open="" if files else None):
            with tag("summary"):
                tag("span", "Files of this case")
                self.count = tag("span", classes="count")
            with tag("div", classes="inside"):
                self.list = tag("ul", classes="files")
                self.refusal = tag("div")
                hint = "A table of lifts, for instance: name it in the lift law, as in 'lift.csv'."
                address = f"/upload/file?case={quote(case)}"
                Upload(
                    {"done": self.changed}, field="side-file", label="Add a file", hint=hint, url=address, most=desk.settings.most_upload,
                )  # fmt: skip
        self.fill(files)

    def show(self) -> None:
        """The present files; nothing is sent where they are the same."""
        files = self.desk.workspace.side_files(self.case)
        if files != self.shown:
            self.fill(files)

    def fill(self, files: tuple[StoredFile, ...], refusal: str = "") -> None:
        """List files, and why one was not removed."""
        self.shown = files
        for place in (self.count, self.list, self.refusal):
            place.clear()
        with self.count:
            tag("span", str(len(files)))
        with self.list:
            for one in files:
                self.row(one)
            if not files:
                tag("li", "None yet.", "said")
        with self.refusal:
            if refusal:
                tag("p", refusal, "refusal", role="alert")

    def row(self, file: StoredFile) -> None:
        """One file: what it is called, how large it is, and what may be done with it."""
        with tag("li"):
            link(file.name, f"/case-file/{quote(self.case)}/{quote(file.name)}", download="")
            tag(
                "span",
                f"{size_text(file.size)}{', named by the case' if file.is_named else ''}",
                "hint",
            )
            button(
                "Remove",
                lambda: self.remove(file.name),
                "button small",
                aria_label=f"Remove {file.name}",
            )

    async def changed(self) -> None:
        """A file came or went."""
        self.fill(self.desk.workspace.side_files(self.case))
        await self.on_change()

    async def remove(self, name: str) -> None:
        """Take a file away, or say why it stays."""
        try:
            await asyncio.to_thread(self.desk.workspace.detach, self.case, name)
        except ValvetrainError as error:
            self.fill(self.desk.workspace.side_files(self.case), sentence_of(error, name))
            return
        await self.changed()
