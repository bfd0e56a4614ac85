"""What a case says as bytes: equal for equal parameters, whatever text and units said so."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from inspect import getsource
from typing import Any

import numpy as np

#: Fields of a case that change none of its numbers.
_TEXTS = (
    "name", "title", "description", "notes", "sources", "remarks", "published", "text", "changed",
)  # fmt: skip
#: Fields of its parts that change none where the case does not give them.
_NO_NUMBER = (
    "permitted_seating_velocity", "face_diameter", "red_line", "force_bandwidth", "replica", "stated_solid_height", "top_dead_centre",
)  # fmt: skip


def content(item: Any, exact: bool = True) -> bytes:
    """Frozen parameters as bytes, numbers to the last bit, or to 12 digits where not ``exact``."""
    return b"\0".join(_parts(item, exact))


def content_digest(case: Any) -> str:
    """16 hexadecimal digits of all that can change a number of a case, to 12 digits of its values;
    names of the case and of its parts take no part.
    """
    values = tuple(getattr(case, one.name) for one in fields(case) if one.name not in _TEXTS)
    return hashlib.sha256(content(values, exact=False)).hexdigest()[:16]


def _parts(item: Any, exact: bool) -> Iterator[bytes]:
    if isinstance(item, (bool, str, bytes, Enum, type(None))):
        yield repr(item).encode()
    elif isinstance(item, (float, int, np.number)):
        # a whole number and the same float are one value
        yield (float(item).hex() if exact else f"{float(item) + 0.0:.12g}").encode()
    elif isinstance(item, np.ndarray):
        yield str(item.shape).encode()
        for number in item.ravel().tolist():
            yield from _parts(number, exact)
    elif is_dataclass(item) and not isinstance(item, type):
        yield type(item).__name__.encode()
        for one in fields(item):
            unsaid = one.name in _NO_NUMBER and getattr(item, one.name) == one.default
            if one.compare and (exact or not (unsaid or one.name == "name")):
                yield one.name.encode()
                yield from _parts(getattr(item, one.name), exact)
    elif isinstance(item, Mapping):
        for key in sorted(item, key=str):
            yield str(key).encode()
            yield from _parts(item[key], exact)
        yield b"}"
    elif isinstance(item, (tuple, list)):
        for one in item:
            yield from _parts(one, exact)
        yield b"]"
    elif callable(item):
        yield function_text(item).encode()
    else:
        yield repr(item).encode()


def function_text(function: Any) -> str:
    """A function's name and source text, its code where there is no source."""
    name = (
        f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', repr(function))}"
    )
    try:
        return name + getsource(function)
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        return name + ("" if code is None else f"{code.co_code.hex()}{code.co_consts!r}")
