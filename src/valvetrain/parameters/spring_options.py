"""What can be chosen of each spring model: one typed table per word, ``[spring.options.<word>]`` in a case file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.schema_types import Length, PositiveTime, StrictModel, quantity

Share = Annotated[float, quantity("ratio", low=0.0, high=1.0)]


class SpringOptions(StrictModel):
    """Base of the tables. ``wire_only`` and ``card_only``: keys that have no effect on a spring known the other way."""

    wire_only: ClassVar[tuple[str, ...]] = ()
    card_only: ClassVar[tuple[str, ...]] = ()


class MasslessOptions(SpringOptions):
    """Options of the massless spring."""

    effective_mass_fraction: Share = Field(1 / 3, description="share of the spring's mass that rides on the retainer")


class MultiMassOptions(SpringOptions):
    """Options of the chain of masses."""

    wire_only: ClassVar[tuple[str, ...]] = ("masses_per_coil",)
    card_only: ClassVar[tuple[str, ...]] = ("elements",)
    masses_per_coil: int = Field(12, ge=1, le=2000, description="masses along one turn of the wire")
    elements: int = Field(5, ge=1, le=2000, description="elements of the chain made from a card")


class ModalUniformOptions(SpringOptions):
    """Options of the modal model of a uniform spring."""

    modes: int = Field(5, ge=1, le=500, description="natural modes taken along")


class NoOptions(SpringOptions):
    """A model without a choice."""


class FiniteElementOptions(SpringOptions):
    """Options of the geometrically exact rod."""

    card_only: ClassVar[tuple[str, ...]] = ("card_lift",)
    elements_per_coil: int = Field(24, ge=4, le=1000, description="elements along one turn of the wire")
    curvature_correction: bool = Field(True, description="stiffness of the section corrected for the curvature of the bar")
    time_step: PositiveTime | None = Field(None, description="time step; without it the stability limit decides")
    card_lift: Length = Field(0.012, description="lift up to which the coils of a wire made from a card stay apart")


class SolidOptions(SpringOptions):
    """Options of solid finite elements."""

    elements_per_coil: int = Field(12, ge=4, le=1000, description="slices along one turn of the wire")
    core: int = Field(1, ge=1, le=40, description="cells across the square core of the section")
    rings: int = Field(1, ge=1, le=40, description="rings of cells around the core")
    time_limit: PositiveTime = Field(1800.0, description="longest time one solution may take")


OPTIONS: dict[str, type[SpringOptions]] = {
    "massless": MasslessOptions,
    "multi-mass": MultiMassOptions,
    "modal-uniform": ModalUniformOptions,
    "modal-varied": NoOptions,
    "wave-rod": NoOptions,
    "wave-rod-clash": NoOptions,
    "finite-element": FiniteElementOptions,
    "solid": SolidOptions,
}


def options_table(word: str) -> type[StrictModel]:
    """The table of the spring model ``word``. Raises :class:`InputError` for an unknown word, with the nearest."""
    if word in OPTIONS:
        return OPTIONS[word]
    if word in registry.words("springs"):
        table: type[StrictModel] = registry.find("springs", word).options
        return table
    known = (*OPTIONS, *registry.words("springs"))
    raise InputError(f"spring model '{word[:40]}' is unknown; {nearest(word, known)}")


def options_problem(options: Mapping[str, Mapping[str, Any]], by_card: bool) -> tuple[str, str, str] | None:
    """Model word, key and reason of the first option that is unknown or has no effect on such a spring; None when all fit."""
    for word, values in options.items():
        table = options_table(word)
        useless: tuple[str, ...] = getattr(table, "wire_only" if by_card else "card_only", ())
        for key in values:
            if key not in table.model_fields:
                return word, key, f"option '{key[:40]}' of spring model '{word}' is unknown; {nearest(key, tuple(table.model_fields))}"
            if key in useless:
                known_by, other = ("card", "wire") if by_card else ("wire", "card")
                return word, key, f"{key} has no effect on a spring known by its {known_by} (it is for a {other}); remove it"
    return None
