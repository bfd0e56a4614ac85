"""HDF5 in all its clothes: NetCDF-4, MAT 7.3, plain HDF5; what lies in other files or is no number is left alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.recording import Budget, Recording, RigChannel
from valvetrain.measurements.rig_formats.arrays import channels_of
from valvetrain.measurements.rig_formats.contract import RigFormat, plain_word, says_synthetic

_MARK = b"\x89HDF\r\n\x1a\n"
#: Groups within groups, members of all groups, and how much the best compression makes of one byte.
_DEEPEST, _MOST_MEMBERS, _MOST_EXPANDED = 6, 5000, 1100
_SMALL = 65_536
#: Attributes by which files give a rate (1/s) or a step (s).
_RATES, _STEPS = ("sampling_rate", "sample_rate", "fs", "rate"), ("dt", "wf_increment", "sampling_interval")


def recognise(head: bytes, name: str) -> bool:
    """Whether an HDF5 file begins here, or behind the 512 bytes that MAT 7.3 puts before it."""
    return head.startswith(_MARK) or head[512:520] == _MARK


def read(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Every array of numbers in the file; units from the attribute ``units`` or ``unit``."""
    import h5py

    found = _Found(Budget(name, wanted), path.stat().st_size, name)
    with h5py.File(path, "r", locking=False) as file:
        words = [plain_word(value) for value in _attributes(file).values() if isinstance(value, (str, bytes))]
        found.walk(h5py, file, "", 0)
    channels, scalars = channels_of(found.arrays, found.units, found.budget)
    channels = tuple(_timed(channel, found.steps.get(channel.name, 0.0)) for channel in channels)
    return Recording("HDF5", channels, scalars, says_synthetic(*words, *found.words), tuple(found.notes))


def _timed(channel: RigChannel, step: float) -> RigChannel:
    return channel if channel.times is not None else RigChannel(channel.name, channel.unit, channel.values, step=step)


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
        """Take the arrays of a group and of those within; only what is linked hard, so nothing outside the file."""
        for word in group:
            self.members += 1
            if self.members > _MOST_MEMBERS:
                raise InputError(f"'{self.name[:80]}' holds more than {_MOST_MEMBERS} groups and arrays; store the wanted ones alone")
            name = f"{path}{plain_word(word)}"
            if not isinstance(group.get(word, getlink=True), h5py.HardLink):
                self.notes.append(f"'{name}' is left out: it is a link, and no other file is opened")
                continue
            held = group[word]
            if isinstance(held, h5py.Group) and depth < _DEEPEST and word != "#refs#":
                self.walk(h5py, held, f"{name}/", depth + 1)
            elif isinstance(held, h5py.Dataset):
                self.take(held, name)

    def take(self, held: Any, name: str) -> None:
        """Take an array of numbers, or the text of a unit."""
        if held.is_virtual or held.external:
            self.notes.append(f"'{name}' is left out: it lies in another file, and no other file is opened")
            return
        told, count = _attributes(held), int(np.prod(held.shape or (0,), dtype=object))
        text = plain_word(told.get("MATLAB_class", "")) == "char"
        if held.dtype.kind not in "fiu" or told.get("MATLAB_object_decode") is not None or not count:
            if held.dtype.kind not in "fiuSU":
                self.notes.append(f"'{name}' is left out: it is no array of numbers")
            return
        stored = int(held.id.get_storage_size())
        if stored > self.size or held.nbytes > max(_SMALL, stored * _MOST_EXPANDED):
            raise InputError(f"'{self.name[:80]}' is damaged: '{name}' claims {held.nbytes:.3g} bytes and holds {stored}")
        if text:
            if name.endswith("_unit") and count <= 40:
                self.units[name.removesuffix("_unit")] = "".join(chr(int(code)) for code in np.ravel(held[()]))
            elif count <= 500:
                self.words.append("".join(chr(int(code)) for code in np.ravel(held[()])))
            return
        self.budget.take(count)
        self.arrays[name] = np.asarray(held[()])
        self.units.setdefault(name, plain_word(told.get("units", told.get("unit", told.get("Unit", "")))))
        rate, step = (next((_number(told[key]) for key in keys if key in told), 0.0) for keys in (_RATES, _STEPS))
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


SPEC = RigFormat("HDF5", recognise, read)
