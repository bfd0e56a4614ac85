"""Differences between two frozen parameter sets, and the name that was meant."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any


def nearest(name: str, valid: list[str] | tuple[str, ...]) -> str:
    """A clause that names the valid name(s) nearest to ``name``, or lists them all when none is
    near.
    """
    close = difflib.get_close_matches(name[:60], valid, n=3, cutoff=0.6)
    if close:
        return "did you mean " + " or ".join(close) + "?"
    return (
        "valid names are " + ", ".join(sorted(valid)) if valid else "there are no valid names here"
    )


def differences(first: Any, second: Any, path: str = "") -> dict[str, tuple[Any, Any]]:
    """Key path -> (value in ``first``, value in ``second``) of everything that differs."""
    one, other = _parts(first), _parts(second)
    if one is None or other is None or type(first) is not type(second):
        return {} if _same(first, second) else {path: (first, second)}
    found: dict[str, tuple[Any, Any]] = {}
    for name in dict.fromkeys([*one, *other]):
        place = f"{path}.{name}" if path else str(name)
        found |= differences(one.get(name), other.get(name), place)
    return found


def _parts(item: Any) -> Mapping[Any, Any] | None:
    """What is compared one by one: fields of a dataclass, items of a mapping, dataclasses of a tuple."""
    if is_dataclass(item):
        return {one.name: getattr(item, one.name) for one in fields(item) if one.compare}
    if isinstance(item, tuple) and any(is_dataclass(one) for one in item):
        return dict(enumerate(item))
    return item if isinstance(item, Mapping) else None


def _same(first: Any, second: Any) -> bool:
    try:
        return bool(first == second)
    except ValueError:  # arrays
        return False
