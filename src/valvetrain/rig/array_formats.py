"""Channels from named arrays: which of them is the time of which, what is a rate."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measured.tables import (
    COMMENTS,
    TextTable,
    parting_mark,
    read_content,
    read_text_table,
    text_of,
)
from valvetrain.rig.recording import (
    Array,
    Budget,
    Recording,
    RigChannel,
    RigFormat,
    plain_word,
    says_synthetic,
)

#: A table of more columns is no table of channels.
MAX_COLUMNS = 64
#: Units of times -> seconds; files of arrays may count them since a date, which tells nothing here.
SECONDS = {
    "s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "": 1.0, "ms": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6,
    "microseconds": 1e-6, "ns": 1e-9, "nanoseconds": 1e-9, "min": 60.0, "minutes": 60.0,
}  # fmt: skip
_TIME = re.compile(r"(?:.*[/_. ])?(time|times|t|zeit|timestamps?)", re.I)


def is_time(name: str, unit: str = "") -> bool:
    """Whether a channel holds times by its name; ``t`` in a ``unit`` that is none of time is a
    temperature or whatever else.
    """
    found = _TIME.fullmatch(name.strip())
    return found is not None and (found[1].lower() != "t" or _word(unit) in SECONDS)


def channels_of(
    arrays: Mapping[str, Any], units: Mapping[str, str], budget: Budget
) -> tuple[tuple[RigChannel, ...], dict[str, float]]:
    """Channels of rows and tables, each with the array of times that is as long as it is, and the
    single numbers by name.
    """
    rows: dict[str, Any] = {}
    scalars: dict[str, float] = {}
    for name, values in arrays.items():
        if values.size == 1:
            scalars[name] = float(np.ravel(values)[0])
        elif values.ndim == 1 or (values.ndim == 2 and 1 in values.shape):
            rows[name] = np.ravel(values).astype(float)
        elif values.ndim == 2 and min(values.shape) <= MAX_COLUMNS:
            table = values if values.shape[0] > values.shape[1] else values.T
            rows |= {
                f"{name}_{place + 1}": table[:, place].astype(float)
                for place in range(table.shape[1])
            }
    # times are stored in seconds, or in what their unit says
    times = {
        len(values): values * seconds_of(units.get(name, ""))
        for name, values in reversed(rows.items())
        if is_time(name, units.get(name, ""))
    }
    channels = [
        RigChannel(
            plain_word(name), plain_word(units.get(name, "")), values, times=times.get(len(values))
        )
        for name, values in rows.items()
        if not is_time(name, units.get(name, "")) and budget.wants(plain_word(name))
    ]
    return tuple(channels), {plain_word(name): value for name, value in scalars.items()}


def seconds_of(unit: str) -> float:
    """Seconds in a unit of times. Raises :class:`InputError` for one that is none of them."""
    word = _word(unit)
    if word not in SECONDS:
        raise InputError(
            f"the times have the unit '{word[:20]}', which is none of time; write s, ms or us"
        )
    return SECONDS[word]


def _word(unit: str) -> str:
    return unit.partition(" since ")[0].strip()


_NUMBERS = (
    "double",
    "single",
    "int8",
    "int16",
    "int32",
    "int64",
    "uint8",
    "uint16",
    "uint32",
    "uint64",
)
#: The best compression makes of one byte no more than this many.
_MAX_EXPANDED = 1100
#: Longest text that may be a unit or a description.
_MAX_TEXT = 500


def recognise_mat5(head: bytes, name: str) -> bool:
    """Whether the content begins as MAT files of version 5 to 7 do."""
    return head.startswith(b"MATLAB 5.0 MAT-file") and len(head) >= 128


def read_mat5(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Arrays of numbers; a text ``<name>_unit`` gives a unit, a number ``fs`` or ``sampling_rate``
    the rate.
    """
    from scipy import io

    budget, size = Budget(name, wanted), path.stat().st_size
    listed = io.whosmat(str(path))
    arrays: dict[str, Any] = {}
    texts: dict[str, str] = {}
    notes = []
    for word, shape, kind in listed:
        count = int(np.prod([int(side) for side in shape], dtype=object)) if shape else 0
        if count * 1.0 > size * _MAX_EXPANDED:
            raise InputError(
                f"'{name[:80]}' is damaged: '{plain_word(word)}' claims more numbers than its bytes can hold"
            )
        if kind == "char" and count <= _MAX_TEXT:
            texts[word] = " ".join(map(str, np.ravel(_one(io, path, word))))
        elif kind in _NUMBERS and 0 < count:
            budget.take(count)
            arrays[word] = np.asarray(_one(io, path, word))
        elif kind not in ("char", *_NUMBERS):
            notes.append(
                f"'{plain_word(word)}' is left out: it is no array of numbers ({plain_word(kind)})"
            )
    channels, scalars = channels_of(
        arrays,
        {
            word.removesuffix("_unit"): text
            for word, text in texts.items()
            if word.endswith("_unit")
        },
        budget,
    )
    return Recording("MAT", channels, scalars, says_synthetic(*texts.values()), tuple(notes))


def _one(io: Any, path: Path, word: str) -> Any:
    return io.loadmat(
        str(path),
        variable_names=[word],
        struct_as_record=True,
        verify_compressed_data_integrity=True,
    )[word]


MAT5_SPEC = RigFormat("MAT", recognise_mat5, read_mat5)


def recognise_netcdf3(head: bytes, name: str) -> bool:
    """Whether the content begins as classic NetCDF does."""
    return head[:4] in (b"CDF\x01", b"CDF\x02")


def read_netcdf3(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Every variable of numbers; units from the attribute ``units``."""
    from scipy.io import netcdf_file

    budget = Budget(name, wanted)
    arrays, units = {}, {}
    with warnings.catch_warnings(action="ignore"), netcdf_file(str(path), "r", mmap=True) as file:
        words = [plain_word(value) for value in file._attributes.values()]
        for word, held in file.variables.items():
            if held.data.dtype.kind in "fiu":
                budget.take(int(held.data.size))
                arrays[str(word)] = np.array(held.data, dtype=float)
                units[str(word)] = plain_word(getattr(held, "units", ""))
            del held
    channels, scalars = channels_of(arrays, units, budget)
    return Recording("NetCDF", channels, scalars, says_synthetic(*words))


NETCDF3_SPEC = RigFormat("NetCDF", recognise_netcdf3, read_netcdf3)


_MARK = b"\x89HDF\r\n\x1a\n"
#: Groups within groups, members of all groups, and how much the best compression makes of one byte.
_DEEPEST, _MAX_MEMBERS, _MOST_EXPANDED_hdf5 = 6, 5000, 1100
_SMALL = 65_536
#: Attributes by which files give a rate (1/s) or a step (s).
_RATES, _STEPS = (
    ("sampling_rate", "sample_rate", "fs", "rate"),
    ("dt", "wf_increment", "sampling_interval"),
)


def recognise_hdf5(head: bytes, name: str) -> bool:
    """Whether an HDF5 file begins here, or behind the 512 bytes that MAT 7.3 puts before it."""
    return head.startswith(_MARK) or head[512:520] == _MARK


def read_hdf5(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Every array of numbers in the file; units from the attribute ``units`` or ``unit``."""
    import h5py

    found = _Found(Budget(name, wanted), path.stat().st_size, name)
    with h5py.File(path, "r", locking=False) as file:
        words = [
            plain_word(value)
            for value in _attributes(file).values()
            if isinstance(value, (str, bytes))
        ]
        found.walk(h5py, file, "", 0)
    channels, scalars = channels_of(found.arrays, found.units, found.budget)
    channels = tuple(_timed(channel, found.steps.get(channel.name, 0.0)) for channel in channels)
    return Recording(
        "HDF5", channels, scalars, says_synthetic(*words, *found.words), tuple(found.notes)
    )


def _timed(channel: RigChannel, step: float) -> RigChannel:
    return (
        channel
        if channel.times is not None
        else RigChannel(channel.name, channel.unit, channel.values, step=step)
    )


class _Found:
    """What a walk through the groups has found."""

    def __init__(self, budget: Budget, size: int, name: str) -> None:
        self.budget, self.size, self.name = budget, size, name
        self.arrays: dict[str, Any] = {}
        self.units: dict[str, str] = {}
        self.steps: dict[str, float] = {}
        self.notes: list[str] = []
        self.words: list[str] = []
        self.members = 0

    def walk(self, h5py: Any, group: Any, path: str, depth: int) -> None:
        """Take the arrays of a group and of those within; only what is linked hard, so nothing
        outside the file.
        """
        for word in group:
            self.members += 1
            if self.members > _MAX_MEMBERS:
                raise InputError(
                    f"'{self.name[:80]}' holds more than {_MAX_MEMBERS} groups and arrays; store the wanted ones alone"
                )
            name = f"{path}{plain_word(word)}"
            if not isinstance(group.get(word, getlink=True), h5py.HardLink):
                self.notes.append(
                    f"'{name}' is left out: it is a link, and no other file is opened"
                )
                continue
            held = group[word]
            if isinstance(held, h5py.Group) and depth < _DEEPEST and word != "#refs#":
                self.walk(h5py, held, f"{name}/", depth + 1)
            elif isinstance(held, h5py.Dataset):
                self.take(held, name)

    def take(self, held: Any, name: str) -> None:
        """Take an array of numbers, or the text of a unit."""
        if held.is_virtual or held.external:
            self.notes.append(
                f"'{name}' is left out: it lies in another file, and no other file is opened"
            )
            return
        told, count = _attributes(held), int(np.prod(held.shape or (0,), dtype=object))
        text = plain_word(told.get("MATLAB_class", "")) == "char"
        if (
            held.dtype.kind not in "fiu"
            or told.get("MATLAB_object_decode") is not None
            or not count
        ):
            if held.dtype.kind not in "fiuSU":
                self.notes.append(f"'{name}' is left out: it is no array of numbers")
            return
        stored = int(held.id.get_storage_size())
        if stored > self.size or held.nbytes > max(_SMALL, stored * _MOST_EXPANDED_hdf5):
            raise InputError(
                f"'{self.name[:80]}' is damaged: '{name}' claims {held.nbytes:.3g} bytes and holds {stored}"
            )
        if text:
            if name.endswith("_unit") and count <= 40:
                self.units[name.removesuffix("_unit")] = "".join(
                    chr(int(code)) for code in np.ravel(held[()])
                )
            elif count <= 500:
                self.words.append("".join(chr(int(code)) for code in np.ravel(held[()])))
            return
        self.budget.take(count)
        self.arrays[name] = np.asarray(held[()])
        self.units.setdefault(
            name, plain_word(told.get("units", told.get("unit", told.get("Unit", ""))))
        )
        rate, step = (
            next((_number(told[key]) for key in keys if key in told), 0.0)
            for keys in (_RATES, _STEPS)
        )
        self.steps[name] = step if step > 0 else 1 / rate if rate > 0 else 0.0


def _attributes(held: Any) -> dict[str, Any]:
    """Attributes that can be read; those of kinds the library does not know are left out."""
    found = {}
    for key in list(held.attrs)[:100]:
        try:
            if held.attrs.get_id(key).get_storage_size() < _SMALL:
                found[key] = held.attrs[key]
        except (OSError, TypeError, ValueError, RuntimeError, KeyError):
            continue
    return found


def _number(value: Any) -> float:
    try:
        number = float(np.ravel(value)[0])
    except (TypeError, ValueError, IndexError):
        return 0.0
    return number if np.isfinite(number) else 0.0


HDF5_SPEC = RigFormat("HDF5", recognise_hdf5, read_hdf5)


#: Larger texts are no recordings; of longer ones the first lines tell the form.
MAX_BYTES, HEAD_LINES = 500_000_000, 400
_RATE = re.compile(
    r"\s*(sampling rate|sample rate|fs|rate)\s*[:=]\s*([\d.]+(?:[eE][+-]?\d+)?)\s*(k?)(?:Hz|1/s|S/s)",
    re.I,
)


def recognise_text(head: bytes, name: str) -> bool:
    """Whether it is text at all."""
    return b"\0" not in head or head[:2] in (b"\xff\xfe", b"\xfe\xff")


def read_text(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """The columns of the text: times where a heading says so, channels else."""
    text = text_of(read_content(path, MAX_BYTES, "recording"), name)
    table = _table(text, name)
    budget = Budget(name, wanted)
    budget.take(table.rows.size)
    names = tuple(
        plain_word(word) or f"column {place}" for place, word in enumerate(table.names, start=1)
    )
    times = next(
        (
            _in_seconds(table, place)
            for place, word in enumerate(names)
            if is_time(word, table.units[place])
        ),
        None,
    )
    channels = tuple(
        RigChannel(
            word,
            plain_word(table.units[place]),
            np.ascontiguousarray(table.rows[:, place]),
            times=times,
        )
        for place, word in enumerate(names)
        if not is_time(word, table.units[place]) and budget.wants(word)
    )
    rates = [
        float(found[2]) * (1e3 if found[3] else 1.0)
        for line in table.headings
        if (found := _RATE.match(line))
    ]
    return Recording(
        "text",
        channels,
        {"sampling_rate": rates[0]} if rates else {},
        says_synthetic(*table.headings),
    )


def _in_seconds(table: TextTable, place: int) -> Array:
    scaled: Array = table.rows[:, place] * seconds_of(table.units[place])
    return scaled


def _table(text: str, name: str) -> TextTable:
    """The whole table; its form is found in the first lines and the rest is read by that form."""
    first = "".join(line for _, line in zip(range(HEAD_LINES), io.StringIO(text), strict=False))
    if len(first) == len(text):
        return read_text_table(text, name, MAX_COLUMNS)
    try:
        head = read_text_table(first, name, MAX_COLUMNS)
        rows = first.splitlines()[head.first_line - 1 :]
        mark = parting_mark(
            [
                line.strip()
                for line in rows
                if line.strip() and not line.strip().startswith(COMMENTS)
            ]
        )
        body = _bulk(text, mark, head.first_line - 1)
    except (InputError, ValueError):
        body = None
    if (
        body is None
        or body.ndim != 2
        or body.shape[1] != head.rows.shape[1]
        or not np.isfinite(body).all()
    ):
        return read_text_table(
            text, name, MAX_COLUMNS
        )  # line by line, which names the line at fault
    return TextTable(body, head.headings, head.names, head.units, head.first_line)


def _bulk(text: str, mark: str, skipped: int) -> Array | None:
    plain = {";": ";", "\\|": "|", "\t": "\t", "\\\t": "\t", r"\s+": None, ",": ",", r",\s+": ","}
    if mark not in plain:
        return None
    parts = plain[mark]
    if parts not in (",",) and mark != r",\s+":
        text = text.replace(",", ".")
    body: Array = np.loadtxt(
        io.StringIO(text), delimiter=parts, comments=list(COMMENTS), skiprows=skipped, ndmin=2
    )
    return body


TEXT_SPEC = RigFormat("text", recognise_text, read_text, apart=False)
