"""Reads recordings from files of named arrays: MAT, HDF5 (MAT 7.3, NetCDF-4) and text of columns.

Which array holds the times of which is found by name and length.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measured.tables import read_content, read_text_table, text_of
from valvetrain.rig.reader import (
    Budget,
    Recording,
    RigChannel,
    RigFormat,
    one_line,
    says_synthetic,
)
from valvetrain.units import dimension_of, unit_factor

#: A table of more columns is no table of channels.
MAX_COLUMNS = 64
#: Bytes that the best compression makes of one byte, at most.
_MAX_EXPANSION = 1100
_TIME = re.compile(r"(?:.*[/_. ])?(time|times|t|zeit|timestamps?)", re.I)


def is_time(name: str, unit: str = "") -> bool:
    """Whether a channel holds times by its name; ``t`` in a ``unit`` that is none of time is a
    temperature or anything else.
    """
    match = _TIME.fullmatch(name.strip())
    return match is not None and (match[1].lower() != "t" or _seconds(unit) > 0)


def _seconds(unit: str) -> float:
    """Seconds in a unit of times, which files may count since a date; 0 in one that is none of them."""
    bare = unit.partition(" since ")[0].strip()
    with contextlib.suppress(InputError):
        return unit_factor(bare) if not bare or dimension_of(bare) == "time" else 0.0
    return 0.0


def seconds_of(unit: str) -> float:
    """Seconds in a unit of times. Raises :class:`InputError` for one that is none of them."""
    if not (seconds := _seconds(unit)):
        raise InputError(
            f"the times have the unit '{unit.strip()[:20]}', which is none of time; write s, ms or us"
        )
    return seconds


def channels_of(
    arrays: Mapping[str, Any], units: Mapping[str, str]
) -> tuple[tuple[RigChannel, ...], dict[str, float]]:
    """Channels of one- and two-dimensional arrays, each with the times of the same length, and the
    single numbers by name.
    """
    columns: dict[str, Any] = {}
    scalars: dict[str, float] = {}
    for name, values in arrays.items():
        if values.size == 1:
            scalars[one_line(name)] = float(np.ravel(values)[0])
        elif values.ndim == 1 or (values.ndim == 2 and 1 in values.shape):
            columns[name] = np.ravel(values).astype(float)
        elif values.ndim == 2 and min(values.shape) <= MAX_COLUMNS:
            table = values if values.shape[0] > values.shape[1] else values.T
            columns |= {
                f"{name}_{index}": column.astype(float)
                for index, column in enumerate(table.T, start=1)
            }
    times = {
        len(values): values * seconds_of(units.get(name, ""))
        for name, values in reversed(columns.items())
        if is_time(name, units.get(name, ""))
    }
    channels = [
        RigChannel(
            one_line(name), one_line(units.get(name, "")), values, times=times.get(len(values))
        )
        for name, values in columns.items()
        if not is_time(name, units.get(name, ""))
    ]
    return tuple(channels), scalars


# MAT files of version 5 to 7

#: Characters of a text that may be a unit or a description, at most.
_MAX_TEXT = 500


def recognise_mat5(head: bytes, file_name: str) -> bool:
    """Whether the content begins as MAT files of version 5 to 7 do."""
    return head.startswith(b"MATLAB 5.0 MAT-file") and len(head) >= 128


def read_mat5(path: Path, file_name: str) -> Recording:
    """Arrays of numbers; a text ``<name>_unit`` gives a unit, a number ``fs`` or ``sampling_rate``
    the rate.
    """
    from scipy import io

    budget, notes = Budget(file_name), []
    arrays: dict[str, Any] = {}
    texts: dict[str, str] = {}
    # the process in which the file was tried is bounded in memory, whatever the file claims
    for name, values in io.loadmat(str(path), verify_compressed_data_integrity=True).items():
        kind = getattr(values, "dtype", np.dtype("O")).kind
        if kind == "U" and values.size:
            texts[name] = str(values.ravel()[0])[:_MAX_TEXT]
        elif kind in "fiu" and values.size:
            budget.take(values.size)
            arrays[name] = values
        elif kind not in "Ufiu" and not name.startswith("__"):
            notes.append(f"'{one_line(name)}' is left out: it is no array of numbers")
    units = {
        name.removesuffix("_unit"): text for name, text in texts.items() if name.endswith("_unit")
    }
    channels, scalars = channels_of(arrays, units)
    return Recording("MAT", channels, scalars, says_synthetic(*texts.values()), tuple(notes))


MAT5_SPEC = RigFormat("MAT", recognise_mat5, read_mat5)


# HDF5, MAT 7.3 and NetCDF-4

#: How an HDF5 file begins.
_HDF5_MARK = b"\x89HDF\r\n\x1a\n"
#: Groups within groups, and members of all groups, at most.
_MAX_DEPTH, _MAX_MEMBERS = 6, 5000
#: Bytes up to which an attribute is read, and an array may claim whatever it stores.
_SMALL = 65_536
#: Attributes by which files give a rate (1/s) or a step (s).
_RATES, _STEPS = (
    ("sampling_rate", "sample_rate", "fs", "rate"),
    ("dt", "wf_increment", "sampling_interval"),
)


def recognise_hdf5(head: bytes, file_name: str) -> bool:
    """Whether an HDF5 file begins here, or behind the 512 bytes that MAT 7.3 puts before it."""
    return head.startswith(_HDF5_MARK) or head[512:520] == _HDF5_MARK


def read_hdf5(path: Path, file_name: str) -> Recording:
    """Every array of numbers in the file; units from the attribute ``units`` or ``unit``."""
    import h5py

    walk = _Hdf5Walk(Budget(file_name), path.stat().st_size)
    with h5py.File(path, "r", locking=False) as file:
        descriptions = [
            one_line(value)
            for value in _attributes(file).values()
            if isinstance(value, (str, bytes))
        ]
        walk.enter(h5py, file, "", 0)
    channels, scalars = channels_of(walk.arrays, walk.units)
    channels = tuple(
        channel
        if channel.times is not None
        else replace(channel, step=walk.steps.get(channel.name, 0.0))
        for channel in channels
    )
    synthetic = says_synthetic(*descriptions, *walk.texts)
    return Recording("HDF5", channels, scalars, synthetic, tuple(walk.notes))


class _Hdf5Walk:
    """Arrays, units, steps, texts and notes collected on a walk through the groups of a file."""

    def __init__(self, budget: Budget, size: int) -> None:
        self.budget, self.size, self.members = budget, size, 0
        self.arrays: dict[str, Any] = {}
        self.units: dict[str, str] = {}
        self.steps: dict[str, float] = {}
        self.notes: list[str] = []
        self.texts: list[str] = []

    def enter(self, h5py: Any, group: Any, path: str, depth: int) -> None:
        """Take the arrays of a group and of those within; only hard links, so nothing outside the
        file.
        """
        for key in group:
            self.members += 1
            if self.members > _MAX_MEMBERS:
                raise InputError(
                    f"'{self.budget.file_name[:80]}' holds more than {_MAX_MEMBERS} groups and arrays; store the needed ones alone"
                )
            name = f"{path}{one_line(key)}"
            if not isinstance(group.get(key, getlink=True), h5py.HardLink):
                self.notes.append(
                    f"'{name}' is left out: it is a link, and no other file is opened"
                )
                continue
            member = group[key]
            if isinstance(member, h5py.Group) and depth < _MAX_DEPTH and key != "#refs#":
                self.enter(h5py, member, f"{name}/", depth + 1)
            elif isinstance(member, h5py.Dataset):
                self.take(member, name)

    def take(self, dataset: Any, name: str) -> None:
        """Take an array of numbers, or the text of a unit."""
        if dataset.is_virtual or dataset.external:
            self.notes.append(
                f"'{name}' is left out: it is in another file, and no other file is opened"
            )
            return
        attributes = _attributes(dataset)
        count = int(np.prod(dataset.shape or (0,), dtype=object))
        numeric = dataset.dtype.kind in "fiu"
        if not numeric or attributes.get("MATLAB_object_decode") is not None or not count:
            if dataset.dtype.kind not in "fiuSU":
                self.notes.append(f"'{name}' is left out: it is no array of numbers")
            return
        stored = int(dataset.id.get_storage_size())
        if stored > self.size or dataset.nbytes > max(_SMALL, stored * _MAX_EXPANSION):
            raise InputError(
                f"'{self.budget.file_name[:80]}' is damaged: '{name}' claims {dataset.nbytes:.3g} bytes and holds {stored}"
            )
        if one_line(attributes.get("MATLAB_class", "")) == "char":
            if count <= _MAX_TEXT:
                text = "".join(chr(int(code)) for code in np.ravel(dataset[()]))
                if name.endswith("_unit") and count <= 40:
                    self.units[name.removesuffix("_unit")] = text
                else:
                    self.texts.append(text)
            return
        self.budget.take(count)
        self.arrays[name] = np.asarray(dataset[()])
        unit = next((attributes[key] for key in ("units", "unit", "Unit") if key in attributes), "")
        self.units.setdefault(name, one_line(unit))
        rate, step = (_first_number(attributes, keys) for keys in (_RATES, _STEPS))
        self.steps[name] = step if step > 0 else 1 / rate if rate > 0 else 0.0


def _attributes(member: Any) -> dict[str, Any]:
    """Attributes that can be read; those of kinds the library does not know are left out."""
    attributes = {}
    for key in list(member.attrs)[:100]:
        try:
            if member.attrs.get_id(key).get_storage_size() < _SMALL:
                attributes[key] = member.attrs[key]
        except (OSError, TypeError, ValueError, RuntimeError, KeyError):
            continue
    return attributes


def _first_number(attributes: Mapping[str, Any], keys: Iterable[str]) -> float:
    """The number of the first of the keys that is there; 0 where it is no finite one."""
    value = next((attributes[key] for key in keys if key in attributes), 0.0)
    try:
        number = float(np.ravel(value)[0])
    except (TypeError, ValueError, IndexError):
        return 0.0
    return number if np.isfinite(number) else 0.0


HDF5_SPEC = RigFormat("HDF5", recognise_hdf5, read_hdf5)


# text of columns

#: Larger texts are no recordings.
MAX_BYTES = 500_000_000
_RATE = re.compile(
    r"\s*(sampling rate|sample rate|fs|rate)\s*[:=]\s*([\d.]+(?:[eE][+-]?\d+)?)\s*(k?)(?:Hz|1/s|S/s)",
    re.I,
)


def recognise_text(head: bytes, file_name: str) -> bool:
    """Whether it is text at all."""
    return b"\0" not in head or head[:2] in (b"\xff\xfe", b"\xfe\xff")


def read_text(path: Path, file_name: str) -> Recording:
    """The columns of the text: times where a heading says so, channels else."""
    text, budget = text_of(read_content(path, MAX_BYTES, "recording"), file_name), Budget(file_name)
    budget.take(text.count("\n"))  # a sample a line at least, before any is read
    table = read_text_table(text, file_name, MAX_COLUMNS, Budget.SAMPLES)
    budget.take(table.rows.size)
    words = [one_line(name) for name in table.names]
    names = [
        word if word and words.count(word) == 1 else f"{word or 'column'} {place}"
        for place, word in enumerate(words, start=1)
    ]
    columns = dict(zip(names, np.ascontiguousarray(table.rows.T), strict=True))
    units = dict(zip(names, table.units, strict=True))
    rates = [
        float(match[2]) * (1e3 if match[3] else 1.0)
        for line in table.headings
        if (match := _RATE.match(line))
    ]
    channels, _ = channels_of(columns, units)
    scalars = {"sampling_rate": rates[0]} if rates else {}
    return Recording("text", channels, scalars, says_synthetic(*table.headings))


TEXT_SPEC = RigFormat("text", recognise_text, read_text, isolated=False)
