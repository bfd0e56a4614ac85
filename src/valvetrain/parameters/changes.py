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
    if is_dataclass(first) and type(first) is type(second):
        names = [field.name for field in fields(first) if field.compare]
        parts = [
            differences(getattr(first, name), getattr(second, name), f"{path}.{name}".lstrip("."))
            for name in names
        ]
        return {key: value for part in parts for key, value in part.items()}
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        names = list(dict.fromkeys([*first, *second]))
        parts = [differences(first.get(name), second.get(name), f"{path}.{name}") for name in names]
        return {key: value for part in parts for key, value in part.items()}
    if (
        isinstance(first, tuple)
        and isinstance(second, tuple)
        and len(first) == len(second)
        and any(is_dataclass(item) for item in first)
    ):
        parts = [
            differences(one, other, f"{path}.{place}")
            for place, (one, other) in enumerate(zip(first, second, strict=True))
        ]
        return {key: value for part in parts for key, value in part.items()}
    return {} if _same(first, second) else {path: (first, second)}


def _same(first: Any, second: Any) -> bool:
    try:
        return bool(first == second)
    except ValueError:  # arrays
        return False
