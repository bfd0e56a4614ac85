"""Parts of the JSON answer of a measurement."""

from __future__ import annotations

from typing import Any


def json_fields(source: Any, names: str) -> dict[str, Any]:
    """The attributes of ``source`` by their ``names``, which blanks part."""
    return {name: getattr(source, name) for name in names.split()}


def json_estimate(pair: tuple[float, float]) -> dict[str, float]:
    """A value and its standard deviation."""
    return {"value": pair[0], "standard_deviation": pair[1]}
