"""A run in progress: each solution is written as it comes, so that a process that is killed
loses none that was finished.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from valvetrain.report.json import engine_speed_object, quantities_object, status_object
from valvetrain.runs.saved_runs import LIST as saved_runs_LIST
from valvetrain.runs.saved_runs import mark_unfinished
from valvetrain.solution.atomic import append_whole, write_text
from valvetrain.solution.netcdf import save_netcdf
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.solution.result import Solution


class UnfinishedRun:
    """Keeps solutions as they come, in a folder that ``make_folder`` makes for the first of them.

    ``unfinished-runs.jsonl`` holds a line per solution: label, model, engine speed, status,
    quantities and, where it keeps channels, its
    ``file`` (NetCDF); the first holds the ``command_line`` too, words of the command that began it.
    Nothing here ends a study: what
    cannot be written is among the ``gaps``.
    """

    def __init__(self, make_folder: Callable[[], Path], command_line: Sequence[str] = ()) -> None:
        self._make_folder = make_folder
        self._command_line = tuple(command_line)
        self._handle: int | None = None
        self._files: dict[int, tuple[Solution, str]] = {}
        self.folder: Path | None = None
        self.gaps = PartialFailures()

    def add(self, place: int, solution: Solution) -> None:
        """Keep the solution of the run at ``place`` of its study."""
        self.gaps.part("runs could not be saved as they came", None, self._add, place, solution)

    def file_of(self, solution: Solution) -> Path | None:
        """Where a solution was written as it came."""
        found = next((name for saved, name in self._files.values() if saved is solution), None)
        path = self.folder / found if found is not None and self.folder is not None else None
        return path if path is not None and path.is_file() else None

    def moved_to(self, folder: Path) -> None:
        """Say that the folder has its final name."""
        self.folder = folder

    def close(self) -> None:
        """The run is written whole: remove what stood for it meanwhile."""
        if self._handle is None or self.folder is None:
            return
        for _, name in self._files.values():
            (self.folder / name).unlink(missing_ok=True)
        (self.folder / saved_runs_LIST).unlink(missing_ok=True)
        os.close(self._handle)
        self._handle = None

    def _add(self, place: int, solution: Solution) -> None:
        begins = self.folder is None
        if self.folder is None:
            folder = self._make_folder()
            self._handle, self.folder = mark_unfinished(folder), folder
        assert self._handle is not None
        row: dict[str, Any] = {
            "label": solution.label, "model": solution.model, "engine_speed": engine_speed_object(solution.engine_speed),
            "status": status_object(solution.status), "quantities": quantities_object(solution.quantities),
        }  # fmt: skip
        if begins:
            row["command_line"] = list(self._command_line)
        if solution.arrays.variables and len(solution.time):
            name = row["file"] = f"run-{place + 1:04d}.nc"
            save_netcdf(solution, self.folder / name)
            self._files[place] = solution, name
        append_whole(self._handle, (json.dumps(row) + "\n").encode())


#: The list of what was written, with the digest of every file, saved in the folder itself.
LIST = ".valvetrain-files.json"


def remove_earlier(folder: Path, kind: str, written: Iterable[Path]) -> tuple[Path, ...]:
    """Remove files listed by the last run of this ``kind`` that this run did not write, then list
    what it wrote; the files removed.

    A file goes only if it is on the list and still holds, byte by byte, what was written: a file of
    the user's, or one changed since,
    stays. A folder without a list loses nothing.
    """
    base = folder.resolve()
    now = {path.resolve().relative_to(base).as_posix(): path for path in written}
    lists = _read(folder / LIST)
    removed = []
    for name, digest in lists.get(kind, {}).items():
        if (
            name not in now
            and not any(name in other for key, other in lists.items() if key != kind)
            and _is_ours(base, name, digest)
        ):
            (base / name).unlink()
            removed.append(folder / name)
    lists[kind] = {name: _digest(path) for name, path in now.items()}
    write_text(folder / LIST, json.dumps(lists, indent=1) + "\n")
    return tuple(removed)


def _is_ours(base: Path, name: str, digest: str) -> bool:
    path = base / name
    return (
        path.resolve() == path
        and path.is_relative_to(base)
        and path.is_file()
        and _digest(path) == digest
    )


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _read(path: Path) -> dict[str, dict[str, str]]:
    """The lists by kind; a file that is no such list counts as none."""
    try:
        lists = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(lists, dict):
        return {}
    return {
        kind: {str(name): str(digest) for name, digest in files.items()}
        for kind, files in lists.items()
        if isinstance(files, dict)
    }
