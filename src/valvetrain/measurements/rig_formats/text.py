"""Recordings as text: columns of any form, long ones read in one go."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.content import read_content, text_of
from valvetrain.measurements.recording import Array, Budget, Recording, RigChannel
from valvetrain.measurements.rig_formats.arrays import MOST_COLUMNS, is_time, seconds_of
from valvetrain.measurements.rig_formats.contract import RigFormat, plain_word, says_synthetic
from valvetrain.measurements.text_table import COMMENTS, TextTable, parting_mark, read_text_table

#: Larger texts are no recordings; of longer ones the first lines tell the form.
MOST_BYTES, HEAD_LINES = 500_000_000, 400
_RATE = re.compile(r"\s*(sampling rate|sample rate|fs|rate)\s*[:=]\s*([\d.]+(?:[eE][+-]?\d+)?)\s*(k?)(?:Hz|1/s|S/s)", re.I)


def recognise(head: bytes, name: str) -> bool:
    """Whether it is text at all."""
    return b"\0" not in head or head[:2] in (b"\xff\xfe", b"\xfe\xff")


def read(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """The columns of the text: times where a heading says so, channels else."""
    text = text_of(read_content(path, MOST_BYTES, "recording"), name)
    table = _table(text, name)
    budget = Budget(name, wanted)
    budget.take(table.rows.size)
    names = tuple(plain_word(word) or f"column {place}" for place, word in enumerate(table.names, start=1))
    times = next((_in_seconds(table, place) for place, word in enumerate(names) if is_time(word, table.units[place])), None)
    channels = tuple(
        RigChannel(word, plain_word(table.units[place]), np.ascontiguousarray(table.rows[:, place]), times=times)
        for place, word in enumerate(names)
        if not is_time(word, table.units[place]) and budget.wants(word)
    )
    rates = [float(found[2]) * (1e3 if found[3] else 1.0) for line in table.headings if (found := _RATE.match(line))]
    return Recording("text", channels, {"sampling_rate": rates[0]} if rates else {}, says_synthetic(*table.headings))


def _in_seconds(table: TextTable, place: int) -> Array:
    scaled: Array = table.rows[:, place] * seconds_of(table.units[place])
    return scaled


def _table(text: str, name: str) -> TextTable:
    """The whole table; its form is found in the first lines and the rest is read by that form."""
    first = "".join(line for _, line in zip(range(HEAD_LINES), io.StringIO(text), strict=False))
    if len(first) == len(text):
        return read_text_table(text, name, MOST_COLUMNS)
    try:
        head = read_text_table(first, name, MOST_COLUMNS)
        rows = first.splitlines()[head.first_line - 1 :]
        mark = parting_mark([line.strip() for line in rows if line.strip() and not line.strip().startswith(COMMENTS)])
        body = _bulk(text, mark, head.first_line - 1)
    except (InputError, ValueError):
        body = None
    if body is None or body.ndim != 2 or body.shape[1] != head.rows.shape[1] or not np.isfinite(body).all():
        return read_text_table(text, name, MOST_COLUMNS)  # line by line, which names the line at fault
    return TextTable(body, head.headings, head.names, head.units, head.first_line)


def _bulk(text: str, mark: str, skipped: int) -> Array | None:
    plain = {";": ";", "\\|": "|", "\t": "\t", "\\\t": "\t", r"\s+": None, ",": ",", r",\s+": ","}
    if mark not in plain:
        return None
    parts = plain[mark]
    if parts not in (",",) and mark != r",\s+":
        text = text.replace(",", ".")
    body: Array = np.loadtxt(io.StringIO(text), delimiter=parts, comments=list(COMMENTS), skiprows=skipped, ndmin=2)
    return body


SPEC = RigFormat("text", recognise, read, apart=False)
