"""Reads a published study from its file: TOML with the tables of :class:`SourceStudy`, values with units."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError
from valvetrain.sources.claims import Claim, Term
from valvetrain.sources.contract import Origin, SourceStudy
from valvetrain.sources.reader import Sampling
from valvetrain.sources.readings import Reading
from valvetrain.sources.rows import path_of
from valvetrain.units import parse_quantity

#: Keys whose values are written with a unit -> dimension.
UNITS = {
    "below": "frequency", "above": "frequency", "smooth": "frequency", "reach": "angle", "spacing": "angle",
    "engine_speed": "angular speed",
}  # fmt: skip


def read_source(path: Path) -> SourceStudy:
    """The study of a file; its name without ending is the key.

    Raises :class:`InputError` for a key that no table has, and for a value without its unit.
    """
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    for key in ("quantities", "systems"):
        tree.pop(key, None)
    tables: dict[str, Any] = {"readings": Reading, "claims": Claim, "origins": Origin}
    try:
        for key in tables.keys() & tree.keys():
            table, given = tables[key], tree[key]
            if isinstance(given, list):
                tree[key] = tuple(table(**_si(one)) for one in given)
            else:
                tree[key] = {name: table(**_si(one)) for name, one in given.items()}
        if "sampling" in tree:
            tree["sampling"] = Sampling(**_si(tree["sampling"]))
        return SourceStudy(path.stem, **_si(tree))
    except TypeError as error:
        raise InputError(f"has a table that is not complete ({error})", path.name) from error


def _si(table: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a table: SI for those with units, tuples for lists, sides of a claim as terms."""
    found = dict(table)
    for key, value in table.items():
        if key in UNITS:
            found[key] = parse_quantity(value, UNITS[key])
        elif isinstance(value, list):
            found[key] = tuple(value)
        elif key in ("left", "right"):
            found[key] = Term(**value)
    return found


GU2021, MULTIBODY4B17, VASILYEV2016 = (
    read_source(path_of(key)) for key in ("gu2021", "multibody4b17", "vasilyev2016")
)
