"""Contract: every quantity written in a case file of the library or in a template arrives in the
case, under its own key and in SI units as pint converts it.
"""

from __future__ import annotations

import dataclasses
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pint
import pytest

from valvetrain.parameters.loading import LIBRARY, parse_case
from valvetrain.parameters.templates import KINDS, TEMPLATES

FILES = {
    **{path.stem: path for path in sorted(LIBRARY.glob("*.toml"))},
    **{f"template-{kind}": TEMPLATES / f"{kind}.toml" for kind in KINDS},
}
#: Keys that the case stores in another form: as a compression, a mean diameter, the maximum lift or
#: angles of opening and closing, an engine speed.
CONVERTED = {
    "installed_height", "open_height", "lobe_lift", "outer_diameter", "wall_thickness", "duration", "advertised_duration", "lobe_centre",
    "cam_speeds",
}  # fmt: skip
UNITS = pint.UnitRegistry()


def written(found: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], float]]:
    """Path and SI value of every text ``"number unit"`` of a parsed TOML file."""
    if isinstance(found, dict) and "value" in found:
        yield from written(found["value"], path)
    elif isinstance(found, dict):
        for key, value in found.items():
            yield from written(value, (*path, key))
    elif isinstance(found, list):
        for value in found:
            yield from written(value, path)
    elif isinstance(found, str) and (match := re.fullmatch(r"([-+\d.e]+) ([a-zA-Z][^,:]*)", found)):
        try:
            quantity = UNITS.Quantity(float(match[1]), match[2])
        except (ValueError, pint.UndefinedUnitError):
            return  # a text that only begins with a number
        yield path, float(quantity.to_base_units().magnitude)


def numbers(found: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], float]]:
    """Path and value of every number of a case."""
    if dataclasses.is_dataclass(found) and not isinstance(found, type):
        for field in dataclasses.fields(found):
            yield from numbers(getattr(found, field.name), (*path, field.name))
    elif isinstance(found, Mapping):
        for key, value in found.items():
            yield from numbers(value, (*path, str(key)))
    elif isinstance(found, (tuple, list, np.ndarray)):
        for value in found:
            yield from numbers(value, path)
    elif isinstance(found, (float, int)) and not isinstance(found, bool):
        yield path, float(found)


@pytest.mark.parametrize("name", FILES)
def test_every_quantity_of_a_case_file_arrives_in_si_units(name):
    text = FILES[name].read_text(encoding="utf-8")
    case = list(numbers(parse_case(text, name)))
    expected = list(written(tomllib.loads(text)))
    assert len(expected) >= 5
    for path, value in expected:
        if path[-1] not in CONVERTED:
            equal = [other for other, one in case if math.isclose(one, value, rel_tol=1e-12)]
            key = "published" if path[0] == "published" else path[-1]
            assert any(key in other for other in equal), (path, value, equal)
