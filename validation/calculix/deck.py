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

from valvetrain.continuum.mesh import FaceSet, MeshOptions, SolidMesh
from valvetrain.parameters.material import Material
from valvetrain.parameters.spring import SpringDefinition

Array = NDArray[np.float64]

#: Free turns next to a fixed end that can reach the seat plane.
SEAT_REACH = 0.9


@dataclass(frozen=True)
class SeatPlate:
    """A rigid block: ``name`` of its surface, node set it moves with, corners (8, 3) in m, the side
    that faces the wire.

    ``first`` and ``last``: coil numbers of the free wire that can touch it.
    """

    name: str
    node_set: str
    corners: Array
    side: str
    first: float
    last: float


def seat_plates(spring: SpringDefinition, ground: bool) -> tuple[SeatPlate, SeatPlate]:
    """Blocks under and over ``spring`` whose inner faces are the seat planes, widened to hold the
    spring.

    ``ground``: the mesh has flat ground faces. A round wire would start inside the plane over the
    ground turns, so it
    meets the plane only beyond them.
    """
    first, last = spring.free_coils
    if not ground:
        first = max(first, spring.lower_end.ground_coils)
        last = min(last, spring.total_coils - spring.upper_end.ground_coils)
    half = 0.75 * float(np.max(spring.outer_diameter(np.linspace(0, spring.total_coils, 257))))
    thick = float(spring.wire_diameter.value(0.0))
    low, high = spring.lower_seat_height, spring.upper_seat_height
    return (
        SeatPlate(
            "SEATPLANE",
            "SEAT",
            _block(half, low - thick, low),
            "S2",
            first,
            min(first + SEAT_REACH, last),
        ),
        SeatPlate(
            "RETAINERPLANE",
            "RETAINER",
            _block(half, high, high + thick),
            "S1",
            max(last - SEAT_REACH, first),
            last,
        ),
    )


def _block(half: float, bottom: float, top: float) -> Array:
    square = [(-half, -half), (half, -half), (half, half), (-half, half)]
    return np.array([(x, y, z) for z in (bottom, top) for x, y in square])


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


def comment(sentence: str) -> str:
    """``sentence`` made safe for a comment of the deck: one line of ASCII, at most 60
    characters.
    """
    return "".join(char if " " <= char <= "~" else "?" for char in sentence[:60])


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
    comes after the contact of coils.

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


@dataclass(frozen=True)
class Printout:
    """What every increment prints: end forces always; ``axis`` motion of the wire axis; ``pairs``
    number of contact pairs.

    ``energy``: totals of elastic and kinetic energy (a transient needs them from the first step
    on); ``fields``: displacement
    and stress at the nodes; ``nodal_reactions``: the reaction of every retainer node.
    """

    axis: bool = False
    pairs: int = 0
    fields: bool = False
    energy: bool = False
    nodal_reactions: bool = False

    def text(self) -> str:
        """The output requests of one step."""
        lines = [f"*NODE PRINT, NSET={name}, TOTALS=ONLY\nRF" for name in ("SEAT", "RETAINER")]
        if self.axis:
            lines.append("*NODE PRINT, NSET=AXIS\nU")
        lines += [
            f"*CONTACT PRINT, SLAVE=ABOVE{i}, MASTER=BELOW{i}\nCF" for i in range(1, self.pairs + 1)
        ]
        if self.energy:
            lines.append("*EL PRINT, ELSET=WIRE, TOTALS=ONLY\nELSE, ELKE")
        if self.nodal_reactions:
            lines.append("*NODE PRINT, NSET=RETAINER\nRF")
        if self.fields:
            lines.append("*NODE FILE\nU\n*EL FILE\nS")
        return "\n".join(lines)


def static_step(
    compression: float,
    printout: Printout,
    *,
    first: float,
    largest: float,
    smallest: float = 1e-5,
    period: float = 1.0,
    limit: int = 500,
) -> str:
    """Compression (m) reached in one step; ``first``, ``largest``, ``smallest`` increment as shares
    of the step.

    First equal to largest equal to smallest gives fixed increments. ``period`` is the step's
    length in solver time (s).
    """
    one, most, least = (f"{share * period:.10g}" for share in (first, largest, smallest))
    fixed = first == largest == smallest
    times = (
        f"*STATIC, DIRECT\n{one}, {period:.10g}"
        if fixed
        else f"*STATIC\n{one}, {period:.10g}, {least}, {most}"
    )
    return (
        f"*STEP, NLGEOM, INC={limit}\n{times}\n*BOUNDARY\nSEAT, 1, 3\nRETAINER, 1, 2\n"
        f"RETAINER, 3, 3, {-compression * MILLIMETRE:.10g}\n{printout.text()}\n*END STEP\n"
    )


def frequency_step(modes: int, printout: Printout, *, preloaded: bool) -> str:
    """Lowest ``modes`` natural frequencies, about the state the last static step left when
    ``preloaded``.
    """
    perturbation = ", PERTURBATION" if preloaded else ""
    clamps = "" if preloaded else "*BOUNDARY\nSEAT, 1, 3\nRETAINER, 1, 3\n"
    return f"*STEP{perturbation}\n*FREQUENCY\n{modes}\n{clamps}{printout.text()}\n*END STEP\n"


def amplitude_text(name: str, time: Array, value: Array) -> str:
    """Table of values over step time, to be placed before the first step."""
    rows = "\n".join(f"{t:.9e}, {v:.9e}" for t, v in zip(time, value, strict=True))
    return f"*AMPLITUDE, NAME={name}\n{rows}\n"


def dynamic_step(
    duration: float, time_step: float, printout: Printout, *, amplitude: str, alpha: float = -0.05
) -> str:
    """Implicit transient (Hilber-Hughes-Taylor, ``alpha``) with the retainer's displacement (mm) in
    table ``amplitude``.
    """
    times = f"{time_step:.9e}, {duration:.9e}, {time_step / 1e3:.9e}, {time_step:.9e}"
    return (
        f"*STEP, NLGEOM, INC=100000\n*DYNAMIC, ALPHA={alpha:.4g}\n{times}\n"
        f"*BOUNDARY\nSEAT, 1, 3\nRETAINER, 1, 2\n*BOUNDARY, AMPLITUDE={amplitude}\nRETAINER, 3, 3, 1.\n{printout.text()}\n*END STEP\n"
    )
