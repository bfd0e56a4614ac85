"""A run while it goes on: each solution is written as it comes, so that a process that is killed
loses none that was finished.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from valvetrain.report.json import engine_speed_object, quantities_object, status_object
from valvetrain.solution.atomic import append_whole
from valvetrain.solution.gaps import Gaps
from valvetrain.solution.netcdf import save_netcdf
from valvetrain.solution.result import Solution
from valvetrain.studies.run_store import LIST, mark_unfinished


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
        self.gaps = Gaps()

    def add(self, place: int, solution: Solution) -> None:
        """Keep the solution of the run at ``place`` of its study."""
        self.gaps.part("runs could not be kept as they came", None, self._add, place, solution)

    def file_of(self, solution: Solution) -> Path | None:
        """Where a solution was written as it came."""
        found = next((name for kept, name in self._files.values() if kept is solution), None)
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
        (self.folder / LIST).unlink(missing_ok=True)
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
