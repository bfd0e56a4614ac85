"""Reads the printed results (.dat) of CalculiX: total forces, node tables, contact totals and
natural frequencies.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_HEADING = re.compile(
    r"^\s*(?P<what>[a-zA-Z][a-zA-Z ]*?) \(.*?\) for set (?P<set>\S+) and time\s+(?P<time>\S+)"
)
_CONTACT = re.compile(
    r"^\s*statistics for slave set (?P<set>\S+?),? master set \S+ and time\s+(?P<time>\S+)"
)
_MODE = re.compile(r"E I G E N V A L U E\s+N U M B E R\s+(\d+)")
_PARTICIPATION = re.compile(r"P A R T I C I P A T I O N")
_STEP = re.compile(r"E I G E N V A L U E\s+O U T P U T")
#: More blocks than one mode or increment prints.
_MOST_SETS = 64


@dataclass(frozen=True)
class Table:
    """One printed block: quantity, node set (upper case), solver time, mode number (0 outside a
    modal step), rows.
    """

    quantity: str
    node_set: str
    time: float
    mode: int
    modal_step: int
    rows: Array


@dataclass(frozen=True)
class Printed:
    """All blocks of a .dat file in order; natural frequencies (Hz) and participation factors (mode,
    6) of each modal step.
    """

    tables: tuple[Table, ...]
    natural_frequencies: tuple[Array, ...]
    participation: tuple[Array, ...] = ()

    def history(self, quantity: str, node_set: str) -> tuple[Array, list[Array]]:
        """Times and rows of every non-modal block of that quantity and set."""
        found = [
            table
            for table in self.tables
            if (table.quantity, table.node_set, table.mode) == (quantity, node_set, 0)
        ]
        return np.array([table.time for table in found]), [table.rows for table in found]

    def modal(self, quantity: str, node_set: str, step: int = -1) -> list[Array]:
        """Rows of every mode of the modal step (-1 the last), in order."""
        wanted = len(self.natural_frequencies) + step + 1 if step < 0 else step + 1
        return [
            t.rows
            for t in self.tables
            if (t.quantity, t.node_set, t.modal_step) == (quantity, node_set, wanted) and t.mode > 0
        ]


def read_printed(text: str) -> Printed:
    """The blocks of a .dat file; an unfinished last block (a stopped run) is dropped."""
    tables: list[Table] = []
    frequencies: list[Array] = []
    participation: list[Array] = []
    lines = text.splitlines()
    position, mode = 0, 0
    while position < len(lines):
        line = lines[position]
        position += 1
        if _STEP.search(line):
            values, position = _mode_rows(lines, position, 5)
            frequencies.append(values[:, 3])
            mode = 0
        elif _PARTICIPATION.search(line):
            values, position = _mode_rows(lines, position, 7)
            participation.append(values[:, 1:])
        elif found := _MODE.search(line):
            mode = int(found[1])
        elif found := _HEADING.match(line) or _CONTACT.match(line):
            quantity = found.groupdict().get("what", "contact")
            rows, position = _rows(lines, position)
            key = (quantity.strip(), found["set"].rstrip(","))
            # A static step has no heading of its own: a block that a mode has printed already
            # belongs to the next step.
            if mode and any(
                (t.quantity, t.node_set, t.mode, t.modal_step) == (*key, mode, len(frequencies))
                for t in tables[-_MOST_SETS:]
            ):
                mode = 0
            if len(rows):
                tables.append(
                    Table(*key, float(found["time"]), mode, len(frequencies) if mode else 0, rows)
                )
    return Printed(tuple(tables), tuple(frequencies), tuple(participation))


def _mode_rows(lines: list[str], position: int, width: int) -> tuple[Array, int]:
    """Rows of ``width`` numbers that begin with a mode number, up to the first line that is none."""
    values: list[list[float]] = []
    while position < len(lines):
        items = lines[position].split()
        if len(items) == width and items[0].isdigit():
            values.append([float(item) for item in items])
        elif values:
            break
        position += 1
    return np.array(values).reshape(len(values), width), position


def _rows(lines: list[str], position: int) -> tuple[Array, int]:
    """Numbers up to the next line that holds words; blank lines and contact subtitles between are
    skipped.
    """
    rows: list[list[float]] = []
    while position < len(lines):
        numbers = _numbers(lines[position])
        if numbers is None:
            if not re.match(r"^\s*(total surface|center of gravity|area,|moment)", lines[position]):
                break
        elif numbers:
            rows.append(numbers)
        position += 1
    width = min((len(row) for row in rows), default=0)
    return np.array([row[:width] for row in rows]).reshape(len(rows), width), position


def _numbers(line: str) -> list[float] | None:
    """Numbers of a line, empty for a blank one, None when it holds words."""
    try:
        return [float(item) for item in line.split()]
    except ValueError:
        return None
