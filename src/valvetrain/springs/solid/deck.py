"""Writes a solid mesh and its load steps as an Abaqus / CalculiX input deck, in mm, N, s, tonne and
MPa.

Keywords after the CalculiX CrunchiX user's manual, version 2.20; everything but the contact
printout is also Abaqus syntax.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.material import Material
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.solid.layout import MeshOptions
from valvetrain.springs.solid.mesh import FaceSet, SolidMesh
from valvetrain.springs.solid.plates import seat_plates

#: SI to the deck's units.
MILLIMETRE, MEGAPASCAL, TONNE_PER_MM3 = 1e3, 1e-6, 1e-12

#: Share of a turn by which the lower partner's faces reach beyond the turn below the upper
#: partner's.
PARTNER_OVERLAP = 0.15


@dataclass(frozen=True)
class SolidContact:
    """Coil self-contact, face to face by penalty: ``stiffness`` is pressure per closing distance
    (Pa/m).

    ``wire_per_pair``: turns of the upper coil in one reported pair; ``seats``: end coils can touch
    the seat planes.
    5e13 Pa/m (5e4 MPa/mm) lets two 4 mm wires in contact approach by about a micrometre per 20 N/mm
    of line load.
    """

    stiffness: float = 5e13
    wire_per_pair: float = 0.5
    seats: bool = True


def comment(words: str) -> str:
    """``words`` as they may stand in a comment of the deck: one line of ASCII, at most 60
    characters.
    """
    return "".join(char if " " <= char <= "~" else "?" for char in words[:60])


def model_text(
    mesh: SolidMesh,
    material: Material,
    options: MeshOptions,
    contact: SolidContact | None = None,
    mass_damping: float = 0.0,
) -> str:
    """Nodes, elements, sets, material (``mass_damping`` in 1/s acts in transients) and contact of
    the deck.
    """
    parts = [
        "*NODE, NSET=ALL",
        _nodes(mesh),
        f"*ELEMENT, TYPE={options.element_type}, ELSET=WIRE",
        _elements(mesh),
    ]
    for name, members in mesh.node_sets.items():
        parts += [f"*NSET, NSET={name.upper()}", _wrapped(members + 1)]
    parts.append(
        f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{material.youngs_modulus * MEGAPASCAL:.10g}, {material.poisson_ratio:.10g}\n"
        f"*DENSITY\n{material.density * TONNE_PER_MM3:.10g}"
    )
    if mass_damping:
        parts.append(f"*DAMPING, ALPHA={mass_damping:.10g}, BETA=0.")
    parts.append("*SOLID SECTION, ELSET=WIRE, MATERIAL=STEEL")
    if contact is not None:
        parts.append(_contact(mesh, contact))
    return "\n".join(parts) + "\n"


def seats_text(mesh: SolidMesh, spring: SpringDefinition, ground: bool) -> str:
    """Rigid blocks of the seat planes and their contact with the free wire next to the fixed ends;
    stands after the contact of coils.

    ``ground``: the mesh has flat ground faces (:func:`seat_plates`).
    """
    lines, node, element = [], len(mesh.coordinates), len(mesh.elements)
    for plate, faces in zip(seat_plates(spring, ground), (mesh.lower, mesh.upper), strict=True):
        reachable = faces.between(plate.first, plate.last)
        numbers = np.arange(node + 1, node + 9)
        lines.append(f"*NODE, NSET={plate.node_set}")
        lines += [
            f"{i}, {x:.9e}, {y:.9e}, {z:.9e}"
            for i, (x, y, z) in zip(numbers, plate.corners * MILLIMETRE, strict=True)
        ]
        lines += [
            f"*ELEMENT, TYPE=C3D8, ELSET=WIRE\n{element + 1}, {_row(numbers)}",
            f"*SURFACE, NAME={plate.name}, TYPE=ELEMENT",
        ]
        lines += [f"{element + 1}, {plate.side}", f"*SURFACE, NAME=ON{plate.name}, TYPE=ELEMENT"]
        lines += [f"{one + 1}, S4" for one in reachable.elements]
        lines += [
            "*CONTACT PAIR, INTERACTION=COILS, TYPE=SURFACE TO SURFACE",
            f"ON{plate.name}, {plate.name}",
        ]
        node, element = node + 8, element + 1
    return "\n".join(lines) + "\n"


def contact_pairs(mesh: SolidMesh, contact: SolidContact) -> list[tuple[float, FaceSet, FaceSet]]:
    """(first coil number of the upper partner, its lower faces, upper faces one turn below), pairs
    without a partner left out.
    """
    first, last = float(mesh.coil.min()) + 1.0, float(mesh.coil.max())
    edges = (
        np.linspace(first, last, max(1, round((last - first) / contact.wire_per_pair)) + 1)
        if last > first
        else np.array([])
    )
    pairs = []
    for start, end in pairwise(edges):
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
        lines += [
            "*CONTACT PAIR, INTERACTION=COILS, TYPE=SURFACE TO SURFACE",
            f"ABOVE{number}, BELOW{number}",
        ]
    return "\n".join(lines)


def _nodes(mesh: SolidMesh) -> str:
    return "\n".join(
        f"{i}, {x:.9e}, {y:.9e}, {z:.9e}"
        for i, (x, y, z) in enumerate(mesh.coordinates * MILLIMETRE, start=1)
    )


def _elements(mesh: SolidMesh) -> str:
    rows = (np.concatenate([[i + 1], nodes + 1]) for i, nodes in enumerate(mesh.elements))
    return "\n".join(_row(row) for row in rows)


def _row(numbers: Iterable[int]) -> str:
    """Comma list broken after 15 numbers: the longest line that both solvers read is 16 entries."""
    items = [str(number) for number in numbers]
    return ",\n".join(", ".join(items[i : i + 15]) for i in range(0, len(items), 15))


def _wrapped(numbers: NDArray[np.int64]) -> str:
    return "\n".join(", ".join(map(str, numbers[i : i + 12])) for i in range(0, len(numbers), 12))
