"""What the pages share: workspace, jobs, settings, and the chains of the cases that are open."""

from __future__ import annotations

import asyncio
import threading
from dataclasses import dataclass, field

from valvetrain.workbench.jobs import Jobs
from valvetrain.workbench.live import LiveChain, LiveResult
from valvetrain.workbench.pages.forms import ENGINE_SPEED
from valvetrain.workbench.settings import ServeSettings
from valvetrain.workbench.workspace import CaseId, Workspace

#: Cases whose chains are kept running.
MOST_CHAINS = 3


@dataclass
class OpenChain:
    """A chain, the text of the case it holds, and the curve of that case."""

    chain: LiveChain
    text: str
    base: LiveResult


@dataclass
class Desk:
    """What the pages share."""

    workspace: Workspace
    jobs: Jobs
    settings: ServeSettings
    chains: dict[CaseId, OpenChain] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def chain(self, case: CaseId) -> OpenChain:
        """The chain of a case as it stands, begun where there is none; blocks for seconds then, so a page calls it in a thread."""
        with self._lock:
            text = self.workspace.text(case)
            found = self.chains.pop(case, None)
            if found is not None and found.text != text:
                found.chain.close()
                found = None
            if found is None:
                chain = LiveChain(text, folder=self.workspace.case_folder(case))
                found = OpenChain(chain, text, chain.curve())
            self.chains[case] = found
            while len(self.chains) > MOST_CHAINS:
                self.chains.pop(next(iter(self.chains))).chain.close()
            return found

    async def moved(self, case: CaseId, key: str, value: str) -> tuple[LiveResult, LiveResult]:
        """The curve of a case, and that by the chain with ``value`` at ``key``."""
        opened = await asyncio.to_thread(self.chain, case)
        return opened.base, await asyncio.to_thread(opened.chain.curve, *moved_to(key, value))

    async def by_rod(self, case: CaseId, key: str, value: str) -> tuple[LiveResult, LiveResult]:
        """The curve of a case by the chain, and that by the rod with ``value`` at ``key``."""
        opened = await asyncio.to_thread(self.chain, case)
        return opened.base, await asyncio.to_thread(opened.chain.rod, *moved_to(key, value))

    def close(self) -> None:
        """End all chains."""
        with self._lock:
            for one in self.chains.values():
                one.chain.close()
            self.chains.clear()


def moved_to(key: str, value: str) -> tuple[dict[str, str], str]:
    """Changes of the case, and the engine speed, that a place of the slider stands for."""
    return ({}, value) if key == ENGINE_SPEED else ({key: value}, "")
