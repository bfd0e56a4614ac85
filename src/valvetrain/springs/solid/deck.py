"""Writes a solid mesh and its load steps as an Abaqus / CalculiX input deck, in mm, N, s, tonne and MPa.

Keywords after the CalculiX CrunchiX user's manual, version 2.20; everything but the contact printout is also Abaqus syntax.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.material import Material
from valvetrain.springs.solid.layout import MeshOptions
from valvetrain.springs.solid.mesh import FaceSet, SolidMesh

#: SI to the deck's units.
MILLIMETRE, MEGAPASCAL, TONNE_PER_MM3 = 1e3, 1e-6, 1e-12

#: Share of a turn by which the lower partner's faces reach beyond the turn below the upper partner's.
PARTNER_OVERLAP = 0.15


@dataclass(frozen=True)
class SolidContact:
    """Coil self-contact, face to face by penalty: ``stiffness`` is pressure per closing distance (Pa/m).

    5e13 Pa/m (5e4 MPa/mm) lets two 4 mm wires in contact approach by about a micrometre per 20 N/mm of line load.
    """

    stiffness: float = 5e13
    wire_per_pair: float = 0.5


def model_text(mesh: SolidMesh, material: Material, options: MeshOptions, contact: SolidContact | None = None) -> str:
    """Nodes, elements, sets, material and contact of the deck."""
    parts = ["*NODE, NSET=ALL", _nodes(mesh), f"*ELEMENT, TYPE={options.element_type}, ELSET=WIRE", _elements(mesh)]
    for name, members in mesh.node_sets.items():
        parts += [f"*NSET, NSET={name.upper()}", _wrapped(members + 1)]
    parts.append(
        f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{material.youngs_modulus * MEGAPASCAL:.10g}, {material.poisson_ratio:.10g}\n"
        f"*DENSITY\n{material.density * TONNE_PER_MM3:.10g}\n*SOLID SECTION, ELSET=WIRE, MATERIAL=STEEL"
    )
    if contact is not None:
        parts.append(_contact(mesh, contact))
    return "\n".join(parts) + "\n"


def contact_pairs(mesh: SolidMesh, contact: SolidContact) -> list[tuple[float, FaceSet, FaceSet]]:
    """(first coil number of the upper partner, its lower faces, upper faces one turn below), pairs without a partner left out."""
    first, last = float(mesh.coil.min()) + 1.0, float(mesh.coil.max())
    edges = np.linspace(first, last, max(1, round((last - first) / contact.wire_per_pair)) + 1) if last > first else np.array([])
    pairs = []
    for start, end in zip(edges[:-1], edges[1:], strict=True):
        above = mesh.lower.between(start, end)
        below = mesh.upper.between(start - 1 - PARTNER_OVERLAP, end - 1 + PARTNER_OVERLAP)
        if len(above.elements) and len(below.elements):
            pairs.append((float(start + end) / 2, above, below))
    return pairs


def _contact(mesh: SolidMesh, contact: SolidContact) -> str:
    lines = ["*SURFACE INTERACTION, NAME=COILS", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    lines.append(f"{contact.stiffness * MEGAPASCAL / MILLIMETRE:.10g}")
    for number, (_, above, below) in enumerate(contact_pairs(mesh, contact), start=1):
        for name, faces in ((f"ABOVE{number}", above), (f"BELOW{number}", below)):
            lines.append(f"*SURFACE, NAME={name}, TYPE=ELEMENT")
            lines += [f"{element + 1}, S4" for element in faces.elements]
        lines += ["*CONTACT PAIR, INTERACTION=COILS, TYPE=SURFACE TO SURFACE", f"ABOVE{number}, BELOW{number}"]
    return "\n".join(lines)


def _nodes(mesh: SolidMesh) -> str:
    return "\n".join(f"{i}, {x:.9e}, {y:.9e}, {z:.9e}" for i, (x, y, z) in enumerate(mesh.coordinates * MILLIMETRE, start=1))


def _elements(mesh: SolidMesh) -> str:
    rows = (np.concatenate([[i + 1], nodes + 1]) for i, nodes in enumerate(mesh.elements))
    return "\n".join(_row(row) for row in rows)


def _row(numbers: Iterable[int]) -> str:
    """Comma list broken after 15 numbers: the longest line that both solvers read is 16 entries."""
    items = [str(number) for number in numbers]
    return ",\n".join(", ".join(items[i : i + 15]) for i in range(0, len(items), 15))


def _wrapped(numbers: NDArray[np.int64]) -> str:
    return "\n".join(", ".join(map(str, numbers[i : i + 12])) for i in range(0, len(numbers), 12))
