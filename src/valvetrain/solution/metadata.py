"""Metadata of a result file: everything that is not an array, as one JSON text, and checks of what
a file claims.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event, Status

if TYPE_CHECKING:
    import h5py
    import xarray


Part = TypeVar("Part")
#: Raised when what is stored, or how, changes.
FORMAT_VERSION = 1


def pack(
    kind: str,
    *,
    status: Status,
    provenance: Provenance | None = None,
    events: tuple[Event, ...] = (),
    **more: Any,
) -> str:
    """JSON text with the ``kind`` of a result (solution, static-curve, modal-result), its status,
    events and other entries.
    """
    content = {
        "format": f"valvetrain {kind}", "version": FORMAT_VERSION, "checksum": "blake2b", "status": _fields(status),
        "provenance": None if provenance is None else _fields(provenance), "events": [_fields(event) for event in events], **more,
    }  # fmt: skip
    return json.dumps(content, default=_plain, ensure_ascii=False)


def unpack(text: str, kind: str, where: str, closed: bool) -> dict[str, Any]:
    """The content of :func:`pack` with its objects rebuilt; ``closed``: whether the file ends in a
    checksum that is right.

    Raises :class:`InputError` when it is not a ``kind`` of this package, and when it should have a
    checksum and has none.
    """
    try:
        content: dict[str, Any] = json.loads(text)
        found, version = content["format"], content["version"]
        if not isinstance(found, str) or type(version) is not int:
            raise ValueError("format and version are not text and number")
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(
            f"is not a valvetrain {kind} file; give one that this package wrote", where
        ) from error
    if found != f"valvetrain {kind}":
        raise InputError(
            f"holds a {found[:40]}, not a valvetrain {kind}; open it as what it is", where
        )
    if version > FORMAT_VERSION:
        raise InputError(
            f"was written by a newer valvetrain (file version {version}); update the package", where
        )
    if content.get("checksum") and not closed:
        raise InputError(
            "is damaged, or was rewritten by another program: its closing checksum is missing; write it again",
            where,
        )
    try:
        content["status"] = _made(Status, content["status"])
        content["provenance"] = (
            None if content["provenance"] is None else _made(Provenance, content["provenance"])
        )
        if not isinstance(content["events"], list):
            _refuse("events")
        content["events"] = tuple(_made(Event, event) for event in content["events"])
        for name in ("statistics", "quantities"):
            if not _FITS["Mapping"](content.setdefault(name, {})):
                _refuse(name)
        if not all(map(_FITS["float"], content["quantities"].values())):
            _refuse("quantities")
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"is damaged: its description cannot be read ({error}); write it again", where
        ) from error
    return content


#: Begin of a field's type -> whether a value of JSON fits it.
_FITS: dict[str, Callable[[Any], bool]] = {
    "str": lambda value: isinstance(value, str),
    "bool": lambda value: isinstance(value, bool),
    "float": lambda value: isinstance(value, (int, float)) and not isinstance(value, bool),
    "tuple": lambda value: (
        isinstance(value, list) and all(isinstance(one, (str, list)) for one in value)
    ),
    "Mapping": lambda value: (
        isinstance(value, dict)
        and all(isinstance(one, (str, int, float, type(None))) for one in value.values())
    ),
}


def _refuse(name: str) -> None:
    raise ValueError(f"'{name}' is not what it should be")


def _made(kind: type[Part], content: Any) -> Part:
    """An object from its stored fields; ValueError, TypeError or KeyError where one is unknown,
    missing or of another type.
    """
    if not isinstance(content, dict):
        raise ValueError(f"a {kind.__name__.lower()} is missing")
    for entry in fields(kind):  # type: ignore[arg-type]  # every one is a dataclass
        fits = _FITS[str(entry.type).split("[")[0]]
        if entry.name in content and not fits(content[entry.name]):
            _refuse(entry.name)
    return kind(**content)


def _fields(item: Any) -> dict[str, Any]:
    named = {entry.name: getattr(item, entry.name) for entry in fields(item)}
    return {
        name: dict(value) if isinstance(value, Mapping) else value for name, value in named.items()
    }


def _plain(value: Any) -> Any:
    """NumPy scalars and read-only mappings as what JSON knows."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"a {type(value).__name__} cannot be stored in a result file")


#: Begin of every sentence about a file whose parts do not fit.
DAMAGED = "is damaged:"
#: Most bytes that the best compression stores in one; variables of at most this size are always
#: read.
MAX_EXPANDED, SMALL = 1100, 65_536
#: Upper bound of the variables of a result.
MAX_VARIABLES = 5000
_DIMENSION = b"This is a netCDF dimension but not a netCDF variable"


def refuse_claims(path: Path) -> None:
    """Raise :class:`InputError` for a NetCDF file whose variables claim more than is stored, are in
    another file or linked.

    Only the description in the file is read, so memory of the claimed size is not allocated. Errors of
    the library pass.
    """
    import h5py

    whole = path.stat().st_size
    with h5py.File(path, "r") as file:
        if len(file) > MAX_VARIABLES:
            raise InputError(
                f"claims {len(file)} variables, more than a result has; write it again", str(path)
            )
        for name in file:
            variable = (
                file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
            )
            if not isinstance(variable, h5py.Dataset) or variable.is_virtual or variable.external:
                raise InputError(
                    f"{DAMAGED} '{name}' is no variable of its own; write it again", str(path)
                )
            label = variable.attrs.get("NAME", b"")
            if (label.encode() if isinstance(label, str) else bytes(label)).startswith(_DIMENSION):
                continue  # the length of a dimension, of which nothing is stored or read
            stored = variable.id.get_storage_size()
            claimed = max(
                variable.nbytes, _chunk_bytes(variable) if stored else 0
            )  # one value of a chunk allocates all of it
            if stored > whole or claimed > max(SMALL, stored * MAX_EXPANDED):
                raise InputError(
                    f"{DAMAGED} '{name}' claims {claimed:.3g} bytes and holds {stored}; write it again",
                    str(path),
                )


def _chunk_bytes(variable: h5py.Dataset) -> int:
    """Bytes of one chunk of a chunked variable; 0 of others."""
    return math.prod(variable.chunks) * variable.dtype.itemsize if variable.chunks else 0


def solution_of(dataset: xarray.Dataset, content: dict[str, Any], where: str) -> Solution:
    """The solution of labelled arrays and the unpacked description.

    Raises :class:`InputError` where channels are not numbers or lack unit or label.
    """
    for name, variable in dataset.variables.items():
        text_of = (variable.attrs.get(key, "") for key in ("units", "long_name"))
        if variable.dtype.kind not in "biuf" or not all(isinstance(text, str) for text in text_of):
            raise InputError(
                f"{DAMAGED} channel '{name}' holds no numbers, or its unit is no word; write it again",
                where,
            )
    origin = content["provenance"] or Provenance("", "")
    parts = content["events"], content["status"], content["statistics"], origin
    try:
        return Solution(dataset, *parts, content["quantities"], tuple(content.get("gaps", ())))
    except InputError as error:
        raise InputError(f"{DAMAGED} {error.reason}", where) from error
