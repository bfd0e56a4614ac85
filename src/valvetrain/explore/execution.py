"""How the points of a study, a search or an identification are computed, and who watches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from valvetrain.runs.cost import FEWER, Cost, Limits, cost_text, refuse_cost
from valvetrain.runs.request_fields import option, read_path
from valvetrain.runs.requests import Clustered, Limited, Parallel


def silent(done: float, text: str) -> None:
    """A report of progress that goes nowhere."""


@dataclass(frozen=True)
class Watch:
    """Who watches: ``report`` is called with the share done and a text, ``announce`` with the estimated cost as a text and its
    seconds before the start. ``raises``: how the limit of a request is raised.
    """

    report: Callable[[float, str], None] = silent
    announce: Callable[[str, float], None] = lambda text, seconds: None
    raises: str = "limit="

    def admit(self, cost: Cost, limit: Limits, work: str, fewer: str = FEWER) -> None:
        """Announce the ``work`` with its cost. Raises :class:`InputError` where that is beyond the limit."""
        refuse_cost(cost, limit, self.raises, fewer)
        self.announce(f"{work}, {cost_text(cost)}", cost.seconds)


@dataclass(frozen=True, kw_only=True)
class Execution(Clustered, Parallel, Limited):
    """How points are computed: by which workers or cluster, where they are stored, and what they may cost."""

    output: Path | None = option(
        read_path,
        "Folder of points and results; points that it holds are not computed again (default: runs/COMMAND/FILE).",
        "--output",
        "FOLDER",
    )
