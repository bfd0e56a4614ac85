"""Everything of a result that is not an array, as one JSON text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution.event import Event
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.status import Status

#: Raised when what is stored, or how, changes.
FORMAT_VERSION = 1


def pack(kind: str, *, status: Status, provenance: Provenance | None = None, events: tuple[Event, ...] = (), **more: Any) -> str:
    """JSON text with the result's ``kind`` (solution, static-curve, modal-result) and its words and events."""
    content = {
        "format": f"valvetrain {kind}", "version": FORMAT_VERSION, "status": _fields(status),
        "provenance": None if provenance is None else _fields(provenance), "events": [_fields(event) for event in events], **more,
    }  # fmt: skip
    return json.dumps(content, default=_plain, ensure_ascii=False)


def unpack(text: str, kind: str, where: str) -> dict[str, Any]:
    """The content of :func:`pack` with its objects rebuilt; :class:`InputError` when it is not a ``kind`` of this package."""
    try:
        content: dict[str, Any] = json.loads(text)
        found, version = content["format"], content["version"]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"is not a valvetrain {kind} file; give one that this package wrote", where) from error
    if found != f"valvetrain {kind}":
        raise InputError(f"holds a {found}, not a valvetrain {kind}; open it as what it is", where)
    if version > FORMAT_VERSION:
        raise InputError(f"was written by a newer valvetrain (file version {version}); update the package", where)
    try:
        content["status"] = Status(**content["status"])
        content["provenance"] = _provenance(content["provenance"])
        content["events"] = tuple(Event(**event) for event in content["events"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"is damaged: its description cannot be read ({error}); write it again", where) from error
    return content


def _provenance(content: dict[str, Any] | None) -> Provenance | None:
    if content is None:
        return None
    return Provenance(**{**content, "citations": tuple(content["citations"]), "springs": tuple(content.get("springs", ("spring",)))})


def _fields(item: Any) -> dict[str, Any]:
    named = {entry.name: getattr(item, entry.name) for entry in fields(item)}
    return {name: dict(value) if isinstance(value, Mapping) else value for name, value in named.items()}


def _plain(value: Any) -> Any:
    """NumPy scalars and read-only mappings as what JSON knows."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"a {type(value).__name__} cannot be stored in a result file")
