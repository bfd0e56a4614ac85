"""MAT files of version 5 to 7 (and 4): plain arrays of numbers alone; objects, structures and functions are left alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.recording import Budget, Recording
from valvetrain.measurements.rig_formats.arrays import channels_of
from valvetrain.measurements.rig_formats.contract import RigFormat, plain_word, says_synthetic

_NUMBERS = ("double", "single", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64")
#: The best compression makes of one byte no more than this many.
_MOST_EXPANDED = 1100
#: Longest text that may be a unit or a description.
_LONGEST_TEXT = 500


def recognise(head: bytes, name: str) -> bool:
    """Whether the content begins as MAT files of version 5 to 7 do."""
    return head.startswith(b"MATLAB 5.0 MAT-file") and len(head) >= 128


def read(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Arrays of numbers; a text ``<name>_unit`` gives a unit, a number ``fs`` or ``sampling_rate`` the rate."""
    from scipy import io

    budget, size = Budget(name, wanted), path.stat().st_size
    listed = io.whosmat(str(path))
    arrays: dict[str, Any] = {}
    texts: dict[str, str] = {}
    notes = []
    for word, shape, kind in listed:
        count = int(np.prod([int(side) for side in shape], dtype=object)) if shape else 0
        if count * 1.0 > size * _MOST_EXPANDED:
            raise InputError(f"'{name[:80]}' is damaged: '{plain_word(word)}' claims more numbers than its bytes can hold")
        if kind == "char" and count <= _LONGEST_TEXT:
            texts[word] = " ".join(map(str, np.ravel(_one(io, path, word))))
        elif kind in _NUMBERS and 0 < count:
            budget.take(count)
            arrays[word] = np.asarray(_one(io, path, word))
        elif kind not in ("char", *_NUMBERS):
            notes.append(f"'{plain_word(word)}' is left out: it is no array of numbers ({plain_word(kind)})")
    channels, scalars = channels_of(
        arrays, {word.removesuffix("_unit"): text for word, text in texts.items() if word.endswith("_unit")}, budget
    )
    return Recording("MAT", channels, scalars, says_synthetic(*texts.values()), tuple(notes))


def _one(io: Any, path: Path, word: str) -> Any:
    return io.loadmat(str(path), variable_names=[word], struct_as_record=True, verify_compressed_data_integrity=True)[word]


SPEC = RigFormat("MAT", recognise, read)
