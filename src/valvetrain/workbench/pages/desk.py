"""What the pages share: workspace, jobs, settings, and the chains of the cases that are open."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from dataclasses import dataclass, field

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.jobs import Jobs
from valvetrain.workbench.live import LiveChain
from valvetrain.workbench.live_result import LiveResult
from valvetrain.workbench.pages.forms import ENGINE_SPEED
from valvetrain.workbench.pages.html import sentence_of
from valvetrain.workbench.settings import ServeSettings
from valvetrain.workbench.side_files import StoredFile, stored_files
from valvetrain.workbench.workspace import CaseId, Workspace

#: Number of cases whose chains stay running.
MAX_CHAINS = 3
#: Times that the curve of a case is requested where other questions come between.
MAX_TRIES = 3
#: A question to a chain: a method of it that takes changes and an engine speed.
Question = Callable[[LiveChain, dict[str, str], str], LiveResult]


@dataclass
class OpenChain:
    """A chain, the text of the case as it is now, the files next to it, what was changed since the
    chain was built, and the curve of the case.
    """

    chain: LiveChain
    text: str
    files: tuple[StoredFile, ...]
    changes: dict[str, str] = field(default_factory=dict)
    base: LiveResult | None = None


@dataclass
class Desk:
    """What the pages share."""

    workspace: Workspace
    jobs: Jobs
    settings: ServeSettings
    chains: dict[CaseId, OpenChain] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def put(self, case: CaseId, key: str, value: str) -> None:
        """Set a value of a case; a chain that holds the case receives the change, and need not be
        begun again.

        Raises :class:`InputError`, and changes nothing, for a value that is refused.
        """
        with self.workspace.turn:
            before = self.workspace.text(case)
            self.workspace.set_value(case, key, value)
            text = self.workspace.text(case)
        found = self.chains.get(case)
        if found is not None and found.text == before and value:
            found.changes = {**found.changes, key: value}
            found.text, found.base = text, None

    def chain(self, case: CaseId) -> tuple[OpenChain, LiveResult]:
        """The chain of the present case, begun where there is none, and its curve; blocks for
        seconds then.
        """
        with self._lock:
            text, files = self.workspace.text(case), stored_files(self.workspace.case_folder(case))
            found = self.chains.pop(case, None)
            if found is not None and (found.text, found.files) != (text, files):
                found.chain.close()
                found = None
            if found is None:
                while len(self.chains) >= MAX_CHAINS:
                    self.chains.pop(next(iter(self.chains))).chain.close()
                found = OpenChain(LiveChain(text, self.workspace.case_folder(case)), text, files)
            self.chains[case] = found
            for _ in range(MAX_TRIES):
                if (
                    found.base is None or found.base.skipped
                ):  # another tab requested it at the same moment
                    found.base = found.chain.curve(found.changes)
            return found, found.base or LiveResult()

    async def ask(
        self, case: CaseId, key: str, value: str, question: Question = LiveChain.curve
    ) -> tuple[LiveResult, LiveResult]:
        """The curve of a case, and what its chain answers to ``question`` with ``value`` at ``key``; a
        refusal is the sentence of both.
        """
        try:
            opened, base = await asyncio.to_thread(self.chain, case)
            by_speed = key == ENGINE_SPEED
            changes = dict(opened.changes) | ({} if by_speed else {key: value})
            speed = value if by_speed else ""
            return base, await asyncio.to_thread(question, opened.chain, changes, speed)
        except ValvetrainError as error:
            refused = LiveResult(sentence=sentence_of(error))
            return refused, refused

    def close(self) -> None:
        """End all chains."""
        with self._lock:
            for one in self.chains.values():
                one.chain.close()
            self.chains.clear()
