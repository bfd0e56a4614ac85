"""Tables of reduced rods by their inputs: some in memory, some next to the compiled
kernels, each file whole or none.
"""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import astuple, fields, is_dataclass
from pathlib import Path

import numpy as np

from valvetrain.compiled import program_digest
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.errors import InputError
from valvetrain.solution.atomic import atomic_path
from valvetrain.springs import reduced_rod_kernel
from valvetrain.springs.reduced_rod_tables import ReducedTables

#: Tables that stay in memory and on disk (some 4 MB each); the oldest go.
IN_MEMORY, ON_DISK = 8, 24
_MADE: OrderedDict[str, ReducedTables] = OrderedDict()


def tables_of(
    mesh: RodMesh, numbers: tuple[object, ...], make: Callable[[], ReducedTables]
) -> ReducedTables:
    """Tables of a rod of ``mesh`` and the ``numbers`` that they also depend on, computed where they
    are not cached.
    """
    key = _key(mesh, numbers)
    if key not in _MADE:
        folder = _folder()
        found = None if folder is None else _read(folder / f"{key}.npz")
        if found is None:
            found = make()
            if folder is not None:
                _write(folder, key, found)
        _MADE[key] = found
        while len(_MADE) > IN_MEMORY:
            _MADE.popitem(last=False)
    _MADE.move_to_end(key)
    return _MADE[key]


def _key(mesh: RodMesh, numbers: tuple[object, ...]) -> str:
    digest = hashlib.blake2b(digest_size=16)
    program = program_digest(
        "cosserat/*.py", "springs/reduced_rod_*.py", "springs/finite_element_channels.py"
    )
    digest.update(repr((numbers, program)).encode())
    for one in fields(mesh):
        value = getattr(mesh, one.name)
        whole = is_dataclass(value) and not isinstance(value, type)
        parts = astuple(value) if whole else (value,)
        for part in parts:
            array = part if isinstance(part, np.ndarray) else np.array(repr(part))
            digest.update(f"{one.name} {array.shape} {array.dtype} ".encode() + array.tobytes())
    return digest.hexdigest()


def _folder() -> Path | None:
    """Folder of the tables: with the compiled kernels; None where those are not stored."""
    kernels = getattr(reduced_rod_kernel.advance_reduced, "_cache", None)
    place = getattr(kernels, "cache_path", None)
    return None if place is None else Path(place) / "reduced-rods"


def _read(path: Path) -> ReducedTables | None:
    """Tables in a file; None where it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            values = {one.name: stored[one.name] for one in fields(ReducedTables)}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return ReducedTables(
        **{name: value if value.ndim else value.item() for name, value in values.items()}
    )


def _write(folder: Path, key: str, tables: ReducedTables) -> None:
    """Store tables, if the disk takes them, and remove the oldest beyond the number that stays."""
    with suppress(OSError, InputError):
        with atomic_path(folder / f"{key}.npz") as path, open(path, "wb") as file:
            np.savez(file, **{one.name: getattr(tables, one.name) for one in fields(tables)})
        by_age = sorted(folder.glob("*.npz"), key=os.path.getmtime)
        for old in by_age[:-ON_DISK]:
            old.unlink(missing_ok=True)
