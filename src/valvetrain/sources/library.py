"""Reads a published study from its file: TOML with the tables of :class:`SourceStudy`, values with units."""

from __future__ import annotations

import tomllib
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from valvetrain.errors import InputError
from valvetrain.parameters.schema_types import first_problem
from valvetrain.sources.contract import SourceStudy
from valvetrain.sources.rows import NAMES, path_of


def read_source(path: Path) -> SourceStudy:
    """The study of a file; its name without ending is the key.

    Raises :class:`InputError` for a key that no table has, and for a value without its unit.

    >>> read_source(path_of("gu2021")).windows["event"]
    'Stage II'
    """
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    tables = {key: value for key, value in tree.items() if key not in NAMES}
    try:
        return TypeAdapter(SourceStudy).validate_python({"key": path.stem, **tables})
    except ValidationError as error:
        place, reason = first_problem(error)
        raise InputError(reason, f"{path.name}: {'.'.join(map(str, place))}") from error


GU2021, MULTIBODY4B17, VASILYEV2016 = (
    read_source(path_of(key)) for key in ("gu2021", "multibody4b17", "vasilyev2016")
)
