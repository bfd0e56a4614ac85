"""Cuts the sections of ground end turns flat at the seat plane by moving section nodes, never by
cutting elements.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.solid.section import SectionMesh

Array = NDArray[np.float64]

#: Least thickness of the wire left by grinding, as a share of its diameter.
LEAST_THICKNESS = 0.1


def ground_section(
    spring: SpringDefinition, coil: float, upright: float, section: SectionMesh
) -> Array:
    """Nodes (n, 2) of ``section`` at ``coil`` with everything beyond the seat planes moved inside.

    ``upright`` is the z component of the section's upward axis (cosine of the helix angle).
    """
    radius, height = float(spring.wire_diameter.value(coil)) / 2, float(spring.axial_position(coil))
    low = (spring.lower_seat_height - height) / (radius * upright)
    high = (spring.upper_seat_height - height) / (radius * upright)
    if coil <= spring.lower_end.ground_coils and low > -1:
        return _cut_below(section, section.nodes, _checked(low, coil, spring))
    if coil >= spring.total_coils - spring.upper_end.ground_coils and high < 1:
        return _cut_below(section, section.nodes * (1, -1), _checked(-high, coil, spring)) * (1, -1)
    return section.nodes


def _checked(level: float, coil: float, spring: SpringDefinition) -> float:
    if level > 1 - 2 * LEAST_THICKNESS:
        raise InputError(
            f"at coil {coil:.2f} of spring '{spring.name}' grinding leaves less than {LEAST_THICKNESS:.0%} of the wire; "
            "grind fewer turns or use fixed ends"
        )
    return level


def _cut_below(section: SectionMesh, nodes: Array, level: float) -> Array:
    """Disc nodes mapped onto the part of the disc above y = level, ray by ray from the middle of
    that part.
    """
    rim = float(np.max(np.hypot(*nodes.T)))
    level, middle = level / rim, (1 + level / rim) / 2
    angle, share = np.arctan2(nodes[:, 1], nodes[:, 0]), np.hypot(nodes[:, 0], nodes[:, 1]) / rim
    across, up = np.cos(angle), np.sin(angle)
    to_circle = -middle * up + np.sqrt(np.maximum((middle * up) ** 2 + 1 - middle**2, 0.0))
    with np.errstate(divide="ignore"):
        to_plane = np.where(up < 0, (level - middle) / np.minimum(up, -1e-300), np.inf)
    reach = share * np.minimum(to_circle, to_plane)
    mapped = rim * np.stack([reach * across, middle + reach * up], axis=-1)
    return _straightened(section, mapped, to_circle <= to_plane)


def _straightened(section: SectionMesh, mapped: Array, round_side: NDArray[np.bool_]) -> Array:
    """Edge middles put between their corners, except on edges of the uncut circle: a middle beside
    a kink folds an element.
    """
    rim = np.zeros(len(mapped), dtype=bool)
    rim[section.quads[section.rim_quads][:, [1, 2, 5]]] = True
    straight = mapped.copy()
    for edge in range(4):
        first, last, middle = (
            section.quads[:, edge],
            section.quads[:, (edge + 1) % 4],
            section.quads[:, 4 + edge],
        )
        keep = rim[middle] & round_side[first] & round_side[last] & round_side[middle]
        straight[middle] = np.where(
            keep[:, None], mapped[middle], (mapped[first] + mapped[last]) / 2
        )
    return straight
