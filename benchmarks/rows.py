"""One row of the table of speeds, and how it is printed and saved."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

NAN = float("nan")


@dataclass(frozen=True)
class Row:
    """A measurement: ``wall`` and ``cpu`` in s (medians), peak ``memory`` in MB, relative rms
    ``error``, ``ratio`` to this package.
    """

    job: str
    program: str
    setting: str
    wall: float = NAN
    cpu: float = NAN
    memory: float = NAN
    error: float = NAN
    ratio: float = NAN
    note: str = ""


HEAD = ("job", "program", "setting", "wall s", "CPU s", "MB", "error", "ratio", "note")


def cells(row: Row) -> tuple[str, ...]:
    """The row as text, empty where nothing was measured."""

    def number(value: float, form: str) -> str:
        return "" if value != value else format(value, form)

    return (
        row.job,
        row.program,
        row.setting,
        number(row.wall, ".3g"),
        number(row.cpu, ".3g"),
        number(row.memory, ".0f"),
        number(100 * row.error, ".2f") + (" %" if row.error == row.error else ""),
        number(row.ratio, ".3g"),
        row.note,
    )


def markdown(rows: Sequence[Row]) -> str:
    """The table as Markdown."""
    lines = [HEAD, ("---",) * len(HEAD), *map(cells, rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def machine() -> str:
    """Processor, cores and interpreter in one line."""
    name = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next(
            line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        pass
    return f"{name}, {os.cpu_count()} cores, Python {platform.python_version()}"


def save(rows: Sequence[Row], folder: Path) -> None:
    """Write ``speed.json`` and ``speed.md``."""
    folder.mkdir(parents=True, exist_ok=True)
    stamp = {"machine": machine(), "date": time.strftime("%Y-%m-%d")}
    content = [
        {key: (None if value != value else value) for key, value in asdict(row).items()}
        for row in rows
    ]
    (folder / "speed.json").write_text(
        json.dumps({**stamp, "rows": content}, indent=1) + "\n", encoding="utf-8"
    )
    (folder / "speed.md").write_text(
        f"{stamp['machine']}, {stamp['date']}\n\n{markdown(rows)}", encoding="utf-8"
    )


def rusage_of(code: str) -> str:
    """``code`` followed by a line that prints its CPU time (s) and peak memory (MB)."""
    return f"{code}\nimport resource as _r\n_u = _r.getrusage(_r.RUSAGE_SELF)\nprint(_u.ru_utime + _u.ru_stime, _u.ru_maxrss / 1024)"
