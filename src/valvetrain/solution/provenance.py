"""Provenance of a result: case, versions, options and references."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from typing import Any, Literal

from valvetrain.errors import FrozenMapping
from valvetrain.solution.status import Fact

#: Packages whose version can change a number.
DEPENDENCIES = ("numpy", "scipy", "numba", "xarray")

Option = float | int | str | bool | None


@dataclass(frozen=True)
class Provenance:
    """Everything that a result depends on.

    ``engine_speed`` in rad/s of the crank (0 where none applies). ``created_at`` is an argument
    (ISO 8601, or empty), so that equal inputs give equal content. ``citations``: whole references.
    ``label`` of the run within its study (the name of the model where it is unique); ``system``:
    ``prescribed-spring`` or ``train``; ``springs``: ``("spring",)`` or ``("outer", "inner")``, the
    prefixes of the channels of a nested pair; ``facts``: what its model leaves out or needs.
    """

    case_name: str
    model: str
    engine_speed: float = 0.0
    case_digest: str = ""
    package_version: str = ""
    python_version: str = ""
    dependencies: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, Option] = field(default_factory=dict)
    created_at: str = ""
    citations: tuple[str, ...] = ()
    label: str = ""
    spring_set: str = ""
    system: str = ""
    springs: tuple[str, ...] = ("spring",)
    facts: tuple[Fact, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "dependencies", FrozenMapping(self.dependencies))
        object.__setattr__(self, "options", FrozenMapping(self.options))
        object.__setattr__(self, "citations", tuple(self.citations))
        object.__setattr__(self, "springs", tuple(self.springs))
        facts = tuple(Fact(code, dict(values)) for code, values in self.facts)
        object.__setattr__(self, "facts", facts)
        object.__setattr__(self, "label", self.label or self.model)


def collect_provenance(case_name: str, model: str, **fields: Any) -> Provenance:
    """Provenance with the versions of this package, of Python and of :data:`DEPENDENCIES` filled
    in; ``fields``: further ones of :class:`Provenance`.
    """
    return Provenance(
        case_name,
        model,
        package_version=_version("valvetrain"),
        python_version=platform.python_version(),
        dependencies={name: version for name in DEPENDENCIES if (version := _version(name))},
        **fields,
    )


@cache
def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""


Role = Literal["calibration", "check", "prediction"]


@dataclass(frozen=True, slots=True)
class PublishedValue:
    """One published number to compare with.

    ``quantity``: name from docs/quantities.md. ``value``: SI. ``unit``: the shown unit. ``model``:
    what produced it in the source (such as ``solid finite elements``). ``origin``: the place in the
    source. ``role``: ``calibration`` for a value that unknown numbers of the case were identified
    or chosen by, ``check`` for one that was known then and not used, ``prediction`` for one that
    must not be used; ``used_for``: a text on its use; ``doubt``: why the number cannot be right,
    where its source contradicts it; ``reading``: how the source read it (samples, band, one curve of
    a figure). ``engine_speed`` in rad/s of the crank, None for statics and modes. ``tolerance``:
    allowed absolute difference (SI), None where none is stated. ``relation``: how firmly the source
    states it.
    """

    quantity: str
    value: float
    unit: str
    origin: str = ""
    role: Role = "prediction"
    engine_speed: float | None = None
    model: str = ""
    source: str = ""
    tolerance: float | None = None
    relation: Literal["equal", "about", "at-most", "at-least"] = "equal"
    used_for: str = ""
    doubt: str = ""
    reading: str = ""


@dataclass(frozen=True)
class CaseRecord:
    """Description of a case in a result.

    ``study``: name of the published study that the case re-runs (empty for a case of one's own).
    ``changed``: key paths that were set from outside the file; a changed case is not compared with
    published numbers. ``text``: the resolved case file (TOML), from which the case is read again.
    ``citations``: whole references. ``points``: coil numbers of the study's points on the wire,
    where the case gives them. ``red_line`` (rad/s of the crank): the highest speed in use. ``top_speed``: that,
    else the highest engine speed that the case names, else 0. ``digest``: short fingerprint of what the case says.
    ``assumed``: what is called assumed in the file, such as "valve mass". ``limits``: name and number (SI) of
    each limit that the case sets on what a spin rig measures.
    """

    name: str
    title: str = ""
    description: str = ""
    study: str = ""
    remarks: tuple[str, ...] = ()
    published: tuple[PublishedValue, ...] = ()
    citations: tuple[str, ...] = ()
    zero_of_angle: str = ""
    changed: tuple[str, ...] = ()
    text: str = ""
    points: tuple[tuple[str, float], ...] = ()
    digest: str = ""
    red_line: float | None = None
    top_speed: float = 0.0
    assumed: tuple[str, ...] = ()
    limits: tuple[tuple[str, float], ...] = ()
