"""Where a result came from: case, versions, options, papers."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from types import MappingProxyType

#: Packages whose version can change a number.
DEPENDENCIES = ("numpy", "scipy", "numba", "xarray")

Option = float | int | str | bool | None


@dataclass(frozen=True)
class Provenance:
    """What makes a result repeatable.

    ``engine_speed`` in rad/s of the crank (0 where none applies). ``created_at`` is given by the
    caller (ISO 8601, or
    empty), so that equal inputs give equal content. ``citations`` are whole references, papers
    behind this run. ``label`` names the run
    within its study (the model's word where nothing else tells runs apart); ``system``:
    ``prescribed-spring`` or ``train``; ``springs``:
    the springs in the slot, ``("spring",)`` or ``("outer", "inner")``, whose names stand before
    channels of a nested pair.
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

    def __post_init__(self) -> None:
        object.__setattr__(self, "dependencies", MappingProxyType(dict(self.dependencies)))
        object.__setattr__(self, "options", MappingProxyType(dict(self.options)))
        object.__setattr__(self, "citations", tuple(self.citations))
        object.__setattr__(self, "springs", tuple(self.springs))
        object.__setattr__(self, "label", self.label or self.model)

    def __reduce__(self) -> tuple[object, ...]:
        return Provenance, (
            self.case_name,
            self.model,
            self.engine_speed,
            self.case_digest,
            self.package_version,
            self.python_version,
            dict(self.dependencies),
            dict(self.options),
            self.created_at,
            self.citations,
            self.label,
            self.spring_set,
            self.system,
            self.springs,
        )


def collect_provenance(
    case_name: str,
    model: str,
    *,
    engine_speed: float = 0.0,
    case_digest: str = "",
    options: Mapping[str, Option] | None = None,
    created_at: str = "",
    citations: Iterable[str] = (),
    label: str = "",
    spring_set: str = "",
    system: str = "",
    springs: tuple[str, ...] = ("spring",),
) -> Provenance:
    """Provenance with the versions of this package, of Python and of :data:`DEPENDENCIES` filled
    in.
    """
    versions = {name: version for name in DEPENDENCIES if (version := _version(name))}
    return Provenance(
        case_name,
        model,
        engine_speed,
        case_digest,
        _version("valvetrain"),
        platform.python_version(),
        versions,
        options or {},
        created_at,
        tuple(citations),
        label,
        spring_set,
        system,
        springs,
    )


@cache
def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""
