"""Lists of files that visitors put somewhere: tables next to a case, tests over a run."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from urllib.parse import quote

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Upload, button, link, tag
from valvetrain.workbench.pages.html import sentence_of, size_text
from valvetrain.workbench.side_files import StoredFile
from valvetrain.workbench.workspace import CaseId


class FileList:
    """The present ``files``, each with what ``head`` shows of it, its size and a button that takes it away.

    ``remove`` takes one away by its name; ``changed`` is called once one has gone, and shows the list again.
    """

    def __init__(
        self,
        files: Callable[[], Sequence[StoredFile]],
        head: Callable[[StoredFile], object],
        remove: Callable[[str], None],
        changed: Callable[[], Awaitable[None]],
    ) -> None:
        self.files, self.head, self.take, self.changed = files, head, remove, changed
        self.list, self.refusal = tag("ul", classes="files"), tag("div")
        self.listed: Sequence[StoredFile] = ()
        self.show()

    def show(self, refusal: str = "") -> None:
        """The present files, and why one was not removed."""
        self.listed = self.files()
        self.list.clear()
        self.refusal.clear()
        with self.list:
            for file in self.listed:
                with tag("li"):
                    self.head(file)
                    named = ", named by the case" if file.is_named else ""
                    tag("span", f"{size_text(file.size)}{named}", "hint")
                    button(
                        "Remove",
                        lambda name=file.name: self.remove(name),
                        "button small",
                        aria_label=f"Remove {file.name}",
                    )
            if not self.listed:
                tag("li", "None yet.", "said")
        with self.refusal:
            if refusal:
                tag("p", refusal, "refusal", role="alert")

    async def remove(self, name: str) -> None:
        """Take a file away, or say why it stays."""
        try:
            await asyncio.to_thread(self.take, name)
        except ValvetrainError as error:
            self.show(sentence_of(error, name))
            return
        await self.changed()


def case_files(desk: Desk, case: CaseId, changed: Callable[[], Awaitable[None]]) -> FileList:
    """The panel of the files of a case; ``changed`` is called when one came or went."""
    workspace = desk.workspace
    opened = "" if workspace.side_files(case) else None
    with tag("details", classes="group", id="case-files", open=opened):
        with tag("summary"):
            tag("span", "Files of this case")
        with tag("div", classes="inside"):
            made = FileList(
                lambda: workspace.side_files(case),
                lambda file: link(
                    file.name, f"/case-file/{quote(case)}/{quote(file.name)}", download=""
                ),
                lambda name: workspace.detach(case, name),
                changed,
            )
            hint = "A table of lifts, for instance: name it in the lift law, as in 'lift.csv'."
            address = f"/upload/file?case={quote(case)}"
            Upload(
                {"done": changed}, field="side-file", label="Add a file", hint=hint, url=address, most=desk.settings.most_upload,
            )  # fmt: skip
    return made
