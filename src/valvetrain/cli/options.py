"""Options that several commands share, and how their text is read."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated

import typer

from valvetrain.errors import InputError

CaseArgument = Annotated[
    str, typer.Argument(metavar="CASE", help="Name of a library case (see 'valvetrain cases') or path of a case file.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY.PATH=VALUE", show_default=False,
        help="Change a value of the case, written as in its file: 'spring.wire_diameter=4.1 mm'. Nothing after '=' removes it. Repeatable.",
    ),
]  # fmt: skip
ElementsOption = Annotated[int | None, typer.Option("--elements-per-coil", metavar="N", help="Rod elements per coil.", show_default=False)]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output and nothing else there.")]
SpeedOption = Annotated[
    str | None,
    typer.Option(
        "--engine-speed", metavar="SPEEDS", show_default=False,
        help="Crank speeds instead of the case's own: '4200, 5600 rpm' or '1000:9000:500 rpm'.",
    ),
]  # fmt: skip
OutputOption = Annotated[Path | None, typer.Option("--output", metavar="FOLDER", help="Folder of the results (default: runs/<case>).")]
WorkersOption = Annotated[
    int | None, typer.Option("--workers", metavar="N", help="Runs at a time (default: the cores there are, at most 4).")
]

#: More speeds than this in one command are a slip of the pen.
MOST_SPEEDS = 10_000
_RANGE = re.compile(r"\s*([^:\s]+)\s*:\s*([^:\s]+)\s*:\s*([^:\s]+)(\s+[^:]*)?\Z")


def read_engine_speeds(text: str | None, where: str = "--engine-speed") -> tuple[float, ...] | None:
    """Crank speeds (rad/s) from ``'4200, 5600 rpm'`` or a range with both ends, ``'1000:9000:500 rpm'``; None for None.

    Raises :class:`InputError` for a missing or wrong unit, speeds that are not positive and ranges that lead nowhere.
    """
    if text is None:
        return None
    from valvetrain.units import parse_quantities, parse_quantity

    if match := _RANGE.match(text):
        unit = match[4] or ""
        first, last, step = (parse_quantity(f"{part}{unit}", "angular speed", where) for part in match.groups()[:3])
        if not (first > 0 and last >= first and step > 0):
            raise InputError(f"range '{text}' leads nowhere; write first:last:step, rising, as in '1000:9000:500 rpm'", where)
        if (last - first) / step > MOST_SPEEDS:
            raise InputError(f"range '{text}' holds more than {MOST_SPEEDS} speeds; take a larger step", where)
        return tuple(first + step * index for index in range(int((last - first) / step * (1 + 1e-12) + 1e-9) + 1))
    speeds = parse_quantities(text, "angular speed", where)
    if any(speed <= 0 for speed in speeds):
        raise InputError(f"an engine speed in '{text}' is not positive; write such as '4200, 5600 rpm'", where)
    return tuple(dict.fromkeys(speeds))


def read_length(text: str | None, where: str) -> float | None:
    """A length (m) from text such as ``'12 mm'``, zero or more; None for None."""
    if text is None:
        return None
    from valvetrain.units import parse_quantity

    value = parse_quantity(text, "length", where)
    if value < 0:
        raise InputError(f"'{text}' is negative; a compression is zero or more", where)
    return value


def read_count(value: int, low: int, high: int, where: str) -> int:
    """A whole number within bounds, or :class:`InputError`."""
    if not low <= value <= high:
        raise InputError(f"{value} lies outside {low} to {high}; choose a number between", where)
    return value


def read_workers(value: int | None) -> int:
    """Number of runs at a time: as asked, else the cores this process may use, at most 4."""
    if value is not None:
        return read_count(value, 1, 256, "--workers")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(4, cores)


def read_output(folder: Path | None, case_name: str) -> Path:
    """Folder of the results, checked before the work rather than after it. Raises :class:`InputError` for one that cannot be written."""
    chosen = folder or Path("runs") / (re.sub(r"[^\w.-]+", "-", case_name)[:80].strip(".-") or "case")
    try:
        there = next(path for path in (chosen.absolute(), *chosen.absolute().parents) if path.exists())
    except (OSError, ValueError) as error:
        raise InputError(f"'{chosen}' is no usable folder name ({error}); choose another", "--output") from None
    if not there.is_dir():
        raise InputError(f"'{there}' is a file, not a folder; choose another", "--output")
    if not os.access(there, os.W_OK):
        raise InputError(f"folder '{there}' may not be written to; choose another", "--output")
    return chosen


def make_folder(folder: Path) -> Path:
    """Make the folder of the results before the work, not after it. Raises :class:`InputError` when that cannot be done."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"folder '{folder}' cannot be made ({error.strerror}); choose another", "--output") from None
    return folder
