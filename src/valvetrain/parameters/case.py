"""A case: everything that defines one study, frozen, in SI, with the source and status of its values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.changes import changed, differences
from valvetrain.parameters.damping import DampingParameters
from valvetrain.parameters.lift_law import FrozenMapping, LiftLawParameters
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.solution.record import PublishedValue

__all__ = [
    "Case", "CaseSummary", "DampingParameters", "Installation", "LiftLawParameters",
    "Note", "Operation", "PublishedValue", "RodOptions", "SpringCard",
]  # fmt: skip

ValueStatus = Literal["measured", "published", "assumed", "identified"]
STATUSES: tuple[str, ...] = get_args(ValueStatus)


@dataclass(frozen=True, slots=True)
class Note:
    """Where a value comes from: ``status`` and ``source`` (key of the references, then the place)."""

    status: ValueStatus | None = None
    source: str = ""


@dataclass(frozen=True, slots=True)
class Installation:
    """How the spring stands in the engine.

    ``precompression`` (m): shortening from the free length at zero lift. ``installed_height`` (m): the same as a height,
    None when the case gives the precompression. ``seats``: ``planes`` where the end coils may touch flat seats beyond their held
    turns, ``clamps`` where nothing but the held ends is touched.
    """

    precompression: float = 0.0
    installed_height: float | None = None
    seats: Literal["planes", "clamps"] = "planes"


@dataclass(frozen=True, slots=True)
class Operation:
    """What is run: ``engine_speeds`` (rad/s of the crank, twice the cam's) and ``cycles`` (cam revolutions, the last is reported)."""

    engine_speeds: tuple[float, ...] = ()
    cycles: int = 2

    @property
    def cam_speeds(self) -> tuple[float, ...]:
        """Cam speeds (rad/s), half the engine speeds."""
        return tuple(speed / 2 for speed in self.engine_speeds)


@dataclass(frozen=True, slots=True)
class RodOptions:
    """Numerical constants of the finite-element rod.

    ``elements_per_coil``; ``contact_stiffness`` line stiffness of coil on coil (N/m per m of wire = Pa; 0: coils pass
    through); ``contact_damping_time`` (s), Kelvin-Voigt; ``output_step`` (cam rad);
    ``curvature_correction`` of the section stiffness for the bar's curvature;
    ``time_step`` (s), None to let the stability limit decide.
    """

    elements_per_coil: int = 24
    contact_stiffness: float = 2e10
    contact_damping_time: float = 1e-6
    output_step: float = math.radians(0.5)
    curvature_correction: bool = True
    time_step: float | None = None


@dataclass(frozen=True, slots=True)
class CaseSummary:
    """One line of the case library."""

    name: str
    title: str
    holds: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()


@dataclass(frozen=True)
class Case:
    """Everything that defines a study; SI throughout. See docs/architecture.md for the fields."""

    name: str
    title: str = ""
    description: str = ""
    spring: SpringDefinition | None = None
    spring_card: SpringCard | None = None
    lift_law: LiftLawParameters | None = None
    installation: Installation = Installation()
    damping: DampingParameters = field(default_factory=DampingParameters)
    operation: Operation = Operation()
    rod: RodOptions = RodOptions()
    train: Any = None
    published: tuple[PublishedValue, ...] = ()
    notes: Mapping[str, Note] = field(default_factory=FrozenMapping)
    sources: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", FrozenMapping(self.notes))

    def replace(self, changes: Mapping[str, Any] | None = None, /, **fields: Any) -> Case:
        """A copy with fields changed; ``changes`` takes dotted paths: ``case.replace({"rod.elements_per_coil": 12}, name="coarse")``.

        Raises :class:`InputError` for a path that does not exist, with the nearest one that does.
        """
        result = changed(self, {**(changes or {}), **fields})
        assert isinstance(result, Case)
        return result

    def diff(self, other: Case) -> dict[str, tuple[Any, Any]]:
        """Key path -> (value here, value in ``other``) of everything that differs."""
        return differences(self, other)

    def cite(self) -> tuple[str, ...]:
        """Keys of the references (valvetrain/references.bib) this case draws on, in order of first use."""
        texts = [*self.sources, *(note.source for note in self.notes.values()), *(value.source for value in self.published)]
        keys = [text.split(",")[0].strip() for text in texts]
        return tuple(dict.fromkeys(key for key in keys if key and " " not in key))

    def require_spring(self) -> SpringDefinition:
        """The spring definition. Raises :class:`InputError` when the case has none."""
        if self.spring is None:
            if self.train is not None:
                raise InputError(f"case '{self.name}' is a valvetrain; give a case whose [spring] table holds one of its wires")
            raise InputError(f"case '{self.name}' defines no spring; add a [spring] table to it")
        return self.spring
