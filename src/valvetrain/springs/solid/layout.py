"""How finely a spring is meshed and how its ends are fixed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition

Array = NDArray[np.float64]
EndTreatment = Literal["sections", "bonded", "ground"]
ELEMENT_TYPES = {"C3D20R": 20, "C3D20": 20, "C3D8I": 8, "C3D8": 8, "C3D8R": 8}

#: Turns over which the refinement towards a clamp fades.
END_REFINEMENT_LENGTH = 0.08


@dataclass(frozen=True)
class MeshOptions:
    """Mesh of the wire.

    ``elements_per_coil`` along the wire; ``core`` x ``core`` cells and ``rings`` rings over the
    section;
    ``element_type`` of CalculiX; ``end_refinement`` shortens elements at the clamps by this factor.
    ``ends``: ``sections`` meshes only the free wire and clamps its two end sections; ``bonded``
    meshes the whole wire and
    bonds every node of the inactive turns to its seat; ``ground`` cuts the end turns flat at the
    seat planes and bonds the
    cut faces over the inactive turns (the wire above a bonded face stays elastic).
    """

    elements_per_coil: int = 24
    core: int = 2
    rings: int = 1
    element_type: str = "C3D20R"
    end_refinement: float = 1.0
    ends: EndTreatment = "sections"

    def __post_init__(self) -> None:
        if self.element_type not in ELEMENT_TYPES:
            raise InputError(
                f"solid element '{self.element_type}' is not supported; use one of {', '.join(ELEMENT_TYPES)}"
            )
        if self.elements_per_coil < 4:
            raise InputError(
                f"{self.elements_per_coil} elements per coil cannot follow a helix; give at least 4"
            )
        if self.end_refinement < 1:
            raise InputError(
                f"end_refinement {self.end_refinement} would coarsen the ends; give 1 or more"
            )
        if self.ends not in ("sections", "bonded", "ground"):
            raise InputError(
                f"end treatment '{self.ends}' is unknown; use sections, bonded or ground"
            )

    @property
    def quadratic(self) -> bool:
        """True for twenty-node elements, whose edges follow the wire."""
        return ELEMENT_TYPES[self.element_type] == 20


def layer_coils(spring: SpringDefinition, options: MeshOptions) -> Array:
    """Coil numbers of the element boundaries along the wire, increasing; always holds both ends of
    the free wire.
    """
    first, last = spring.free_coils
    free = _graded(first, last, options)
    if options.ends == "sections":
        return free
    below = _even(0.0, first, options.elements_per_coil)
    above = _even(last, spring.total_coils, options.elements_per_coil)
    return np.concatenate([below[:-1], free, above[1:]])


def _even(first: float, last: float, per_coil: int) -> Array:
    if last - first < 1e-9:
        return np.array([first])
    return np.linspace(first, last, max(1, round((last - first) * per_coil)) + 1)


def _graded(first: float, last: float, options: MeshOptions) -> Array:
    """Boundaries from first to last with a density that rises towards both ends."""
    fine = np.linspace(first, last, 20001)
    rise = options.end_refinement - 1
    density = options.elements_per_coil * (
        1
        + rise
        * (
            np.exp(-(fine - first) / END_REFINEMENT_LENGTH)
            + np.exp(-(last - fine) / END_REFINEMENT_LENGTH)
        )
    )
    count = np.concatenate(([0.0], np.cumsum(np.diff(fine) * (density[1:] + density[:-1]) / 2)))
    number = max(2, round(float(count[-1])))
    layers = np.interp(np.linspace(0, count[-1], number + 1), count, fine)
    layers[0], layers[-1] = first, last
    return layers
