"""Folders of runs that go on or were killed: what they hold, and the command that began them."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from valvetrain.runs.saved_answer import ANSWER, MAX_BYTES
from valvetrain.runs.saved_runs import LIST, ROOT, UNFINISHED, homes, whole_lines
from valvetrain.solution.atomic import is_living

#: How the folder of a run begins: date and time (UTC).
_BEGUN = re.compile(r"(\d{8}-\d{6})-")


@dataclass(frozen=True)
class UnfinishedFolder:
    """``case``, ``created_at`` (UTC, ISO 8601), whether the run ``goes_on`` (else it was killed),
    how many of its runs are ``finished``,
    the ``files`` it holds, and the words of the command that began it (none where it was killed
    before its first run was finished)."""

    folder: Path
    case: str
    created_at: str
    goes_on: bool
    finished: int
    files: int
    command_line: tuple[str, ...] = ()

    @property
    def command(self) -> str:
        """The command that began it, as a shell takes it."""
        return shlex.join(self.command_line)


def unfinished_runs(case: str = "", root: Path = ROOT) -> tuple[UnfinishedFolder, ...]:
    """Every folder under ``root`` that a run began and did not finish, newest first, of one
    ``case`` where given.
    """
    found = []
    for home in homes(case, root):
        with suppress(OSError):
            for folder in home.iterdir():
                if not folder.is_symlink() and folder.is_dir() and (one := _unfinished(folder)):
                    found.append(one)
    return tuple(sorted(found, key=lambda one: (one.created_at, one.folder.name), reverse=True))


def _unfinished(folder: Path) -> UnfinishedFolder | None:
    begun, rows = _BEGUN.match(folder.name), folder / LIST
    if (
        begun is None
        or (folder / ANSWER).exists()
        or not (rows.is_file() or UNFINISHED in folder.name)
    ):
        return None
    try:
        created_at = datetime.strptime(begun[1], "%Y%m%d-%H%M%S").replace(tzinfo=UTC).isoformat()
    except ValueError:
        return None
    lines = whole_lines(rows) if rows.is_file() and rows.stat().st_size <= MAX_BYTES else []
    first = _row(lines[0]) if lines else {}
    words = first.get("command_line", ())
    told = tuple(map(str, words)) if isinstance(words, list) else ()
    files = sum(path.is_file() and path.name != LIST for path in folder.iterdir())
    goes_on = rows.is_file() and is_living(rows)
    return UnfinishedFolder(
        folder, folder.parent.name, created_at, goes_on, len(lines), files, told
    )


def _row(line: bytes) -> Mapping[str, Any]:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
