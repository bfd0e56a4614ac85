"""Files of a run: rows as CSV, unique file names, solutions written while the run is in progress, and removal of
outdated files.
"""

from __future__ import annotations

import json
import math
import os
import re
import unicodedata
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.toml_text import toml_text
from valvetrain.parameters.winding import EndCoil
from valvetrain.runs.run_folders import LIST as RUNS_LIST
from valvetrain.runs.run_folders import mark_unfinished
from valvetrain.solution.atomic import append_whole, digest, write_text
from valvetrain.solution.netcdf import save_netcdf
from valvetrain.solution.result import Solution
from valvetrain.solution.status import PartialFailures
from valvetrain.views.json import engine_speed_object, quantities_object, status_object

#: Bytes of a name's stem, so that endings and the name of a temporary file next to it fit into the
#: 255 that file systems take.
MAX_LENGTH = 120
#: Signs with which a spreadsheet takes a cell for a formula, and words that are numbers all the same.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-](inf|nan)")


def csv_of(heads: Iterable[str], rows: Iterable[Iterable[Any]], digits: int = 0) -> str:
    """Rows of plain values under their heads as CSV text: floats to the last digit, or with as many ``digits`` and nothing
    for NaN; nothing for None; words that a spreadsheet would compute are led by an apostrophe.
    """

    def cell(value: Any) -> str:
        if isinstance(value, float):
            if not digits:
                return repr(value)
            return "" if math.isnan(value) else f"{value:.{digits}g}"
        text = "" if value is None else str(value)
        if isinstance(value, str) and text.startswith(_FORMULA) and not _NUMBER.fullmatch(text):
            text = f"'{text}"
        return '"' + text.replace('"', '""') + '"' if any(one in text for one in ',"\n\r') else text

    return "".join(",".join(map(cell, row)) + "\n" for row in (heads, *rows))


@dataclass
class FreeNames:
    """Unique file names, also for labels that differ only in signs, case or accents.

    >>> names = FreeNames()
    >>> names.free("x 1"), names.free("x/1"), names.free("X-1")
    ('x-1', 'x-1-2', 'X-1-3')
    """

    taken: set[str] = field(default_factory=set)

    def free(self, label: str) -> str:
        """A name of letters, digits, points and dashes that is not in use yet."""
        composed = unicodedata.normalize("NFC", label)
        plain = (
            "-".join(
                "".join(
                    char if char.isalnum() or char in ".+" else " " for char in composed
                ).split()
            ).strip(".-")
            or "run"
        )
        tries = (
            (plain, "") if number == 1 else (plain, f"-{number}")
            for number in range(1, len(self.taken) + 2)
        )
        name = next(
            one for label, ending in tries if _key(one := _short(label, ending)) not in self.taken
        )
        self.taken.add(_key(name))
        return name


def _key(name: str) -> str:
    """The form in which file systems may treat two names as equal."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())


def _short(label: str, ending: str) -> str:
    """The name with its ending, shortened in the middle to :data:`MAX_LENGTH` bytes."""
    content = label.encode()
    room = MAX_LENGTH - len(ending)
    if len(content) > room:
        half = room // 2
        label = (
            content[:half].decode(errors="ignore")
            + "~"
            + content[half + 1 - room :].decode(errors="ignore")
        )
    return label + ending


def spring_text(name: str, spring: InstalledSpring, source: str) -> str:
    """A case file with the spring alone, known by its wire or by its card."""
    wire, card = spring.wire, spring.card
    if wire is None:
        assert card is not None
        loads: dict[str, Any] = {
            "name": card.name,
            "rate": f"{card.rate!r} N/m",
            "preload": f"{card.preload!r} N",
        }
        for key in ("installed_height", "solid_height"):
            if (height := getattr(card, key)) is not None:
                loads[key] = f"{height!r} m"
        return toml_text({"name": name, "title": f"{card.name}, {source}", "spring": loads})
    material = wire.material
    block: dict[str, Any] = {
        "name": wire.name, "wire_diameter": _curve(wire.wire_diameter), "mean_diameter": _curve(wire.mean_diameter),
        "total_coils": wire.total_coils, "pitch": _curve(wire.pitch), "lower_end": _end(wire.lower_end), "upper_end": _end(wire.upper_end),
        "material": {
            "name": material.name, "youngs_modulus": f"{material.youngs_modulus / 1e9!r} GPa",
            "shear_modulus": f"{material.shear_modulus / 1e9!r} GPa", "density": f"{material.density!r} kg/m^3",
        },
        "precompression": f"{spring.precompression!r} m", "seats": spring.seats,
    }  # fmt: skip
    if wire.hand != "right":
        block["hand"] = wire.hand
    if wire.stated_solid_height is not None:
        block["solid_height"] = f"{wire.stated_solid_height!r} m"
    return toml_text({"name": name, "title": f"{wire.name}, {source}", "spring": block})


def _end(end: EndCoil) -> dict[str, Any]:
    return {
        "kind": end.kind,
        "inactive_coils": end.inactive_coils,
        "ground_coils": end.ground_coils,
    }


def _curve(curve: Curve) -> str | dict[str, Any]:
    if isinstance(curve, Constant):
        return f"{curve.level!r} m"
    assert isinstance(curve, PiecewiseLinear)
    coils, values = np.asarray(curve.coils, dtype=float), np.asarray(curve.values, dtype=float)
    return {"coils": coils.tolist(), "values": [f"{value!r} m" for value in values.tolist()]}


class UnfinishedRun:
    """Saves each solution when it is computed, in a folder that ``make_folder`` creates for the
    first of them.

    ``unfinished-runs.jsonl`` holds a line per solution: label, model, engine speed, status,
    quantities and, where channels are saved, its ``file`` (NetCDF); the first holds the
    ``command_line`` too, the command that began it. Nothing here ends a study: what cannot
    be written is among the ``gaps``.
    """

    def __init__(self, make_folder: Callable[[], Path], command_line: Sequence[str] = ()) -> None:
        self._make_folder = make_folder
        self._command_line = tuple(command_line)
        self._handle: int | None = None
        self._files: dict[int, tuple[Solution, str]] = {}
        self.folder: Path | None = None
        self.gaps = PartialFailures()

    def add(self, place: int, solution: Solution) -> None:
        """Save the solution of the run at ``place`` of its study."""
        self.gaps.part("runs could not be saved as they came", None, self._add, place, solution)

    def file_of(self, solution: Solution) -> Path | None:
        """The file that a solution was saved to."""
        for saved, name in self._files.values():
            if saved is solution and self.folder and (self.folder / name).is_file():
                return self.folder / name
        return None

    def begin(self, folder: Path) -> None:
        """Write into ``folder``, the final one, which is marked unless this run has marked one."""
        if self._handle is None:
            self._handle = mark_unfinished(folder)
        self.folder = folder

    def finish(self) -> None:
        """Remove the marks of an unfinished run after everything is written."""
        if self._handle is None or self.folder is None:
            return
        for _, name in self._files.values():
            (self.folder / name).unlink(missing_ok=True)
        (self.folder / RUNS_LIST).unlink(missing_ok=True)
        self.release()

    def release(self) -> None:
        """Give up the lock; a folder that is not finished keeps its mark."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None

    def _add(self, place: int, solution: Solution) -> None:
        begins = self.folder is None
        folder = self.folder or self._make_folder()
        if begins:
            self.begin(folder)
        assert self._handle is not None
        row: dict[str, Any] = {
            "label": solution.label, "model": solution.model, "engine_speed": engine_speed_object(solution.engine_speed),
            "status": status_object(solution.status), "quantities": quantities_object(solution.quantities),
        }  # fmt: skip
        if begins:
            row["command_line"] = list(self._command_line)
        if solution.arrays.variables and len(solution.time):
            name = row["file"] = f"run-{place + 1:04d}.nc"
            save_netcdf(solution, folder / name)
            self._files[place] = solution, name
        append_whole(self._handle, (json.dumps(row) + "\n").encode())


#: The list of what was written, with the digest of every file, saved in the folder itself.
LIST = ".valvetrain-files.json"


def remove_earlier(folder: Path, kind: str, written: Iterable[Path]) -> tuple[Path, ...]:
    """Remove files listed by the last run of this ``kind`` that this run did not write, then list
    what it wrote; the files removed.

    A file goes only if it is on the list and still holds, byte by byte, what was written: a file of
    the user's, or one changed since, stays. A folder without a list loses nothing.
    """
    base = folder.resolve()
    now = {path.resolve().relative_to(base).as_posix(): path for path in written}
    lists = _read(folder / LIST)
    removed = []
    for name, checksum in lists.get(kind, {}).items():
        if (
            name not in now
            and not any(name in other for key, other in lists.items() if key != kind)
            and _is_ours(base, name, checksum)
        ):
            (base / name).unlink()
            removed.append(folder / name)
    lists[kind] = {name: digest(path.read_bytes()) for name, path in now.items()}
    write_text(folder / LIST, json.dumps(lists, indent=1) + "\n")
    return tuple(removed)


def _is_ours(base: Path, name: str, checksum: str) -> bool:
    path = base / name
    return (
        path.resolve() == path
        and path.is_relative_to(base)
        and path.is_file()
        and digest(path.read_bytes()) == checksum
    )


def _read(path: Path) -> dict[str, dict[str, str]]:
    """The lists by kind; empty for a file that is not such a list."""
    try:
        lists = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(lists, dict):
        return {}
    return {
        kind: {str(name): str(checksum) for name, checksum in files.items()}
        for kind, files in lists.items()
        if isinstance(files, dict)
    }
