"""Wire stress: factors, and the stress from the rod's section forces under an axial load."""

from __future__ import annotations

import numpy as np

from validation.row import Row, book_case
from validation.springs import mesh, spring
from validation.wires import ring_section
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.springs.stress import CURVATURE_FACTORS, shear_stress_factor, wire_stress

PRINTED = {"bergstraesser": (1.2941, 1.1724), "wahl": (1.3105, 1.1840), "goehner": (1.2930, 1.1719)}
SOURCES = {"bergstraesser": "en13906-1", "wahl": "wahl1963", "goehner": "goehner1932"}


@book_case()
def stress_factors() -> list[Row]:
    """Factors of Bergstraesser, Wahl and Goehner at index 5 and 8."""
    return [
        Row(
            "stress",
            f"factor of {name} at index {index:g}",
            SOURCES[name],
            f"w = {index:g}",
            value,
            float(shear_stress_factor(name, index)),
            "-",
            5e-5,
            "printed digits",
        )
        for name, values in PRINTED.items()
        for index, value in zip((5.0, 8.0), values, strict=True)
    ]


@book_case()
def stress_from_section_forces() -> list[Row]:
    """Inner-fibre shear stress from the rod's section forces against that of a bar bent to a ring
    under the same load, by no factor.
    """
    rows = []
    for index in (5.0, 8.0):
        wire = 3e-3
        diameter = index * wire
        definition = spring(wire, diameter, 1.3 * wire, 10.0)
        rod = mesh(definition)
        result = compress(RodStatics(rod), [2e-3])[-1]
        _, vector = quat.relative_vector(result.state.frame[:-1], result.state.frame[1:])
        moment = rod.bend_stiffness * (2 * vector - rod.rest_bend)
        chord = np.diff(result.state.position, axis=0) / rod.edge_length[1:-1, None]
        strain = (
            np.einsum("nji,nj->ni", quat.to_matrix(result.state.frame[1:-1]), chord)
            - rod.rest_stretch[1:-1]
        )
        force = rod.stretch_stiffness[1:-1] * strain
        middle = slice(rod.elements // 2 - 24, rod.elements // 2 + 24)
        loads = {
            "torsional_moment": moment[middle, 2],
            "binormal_moment": moment[middle, 1],
            "normal_force": force[middle, 2],
            "shear_force": np.hypot(force[middle, 0], force[middle, 1]),
        }
        for name in CURVATURE_FACTORS:
            found = wire_stress(loads, definition, rod.coil_number[middle], name)[
                "inner_fibre_shear_stress"
            ]
            expected = (
                ring_section(index)[1] * 8 * result.retainer_force * diameter / (np.pi * wire**3)
            )
            rows.append(
                Row(
                    "stress",
                    f"inner fibre by {name}, index {index:g}",
                    "timoshenko1970",
                    "d 3 mm, 10 turns, 2 mm compression, mean of two turns",
                    expected / 1e6,
                    float(found.mean()) / 1e6,
                    "MPa",
                    0.01 * expected / 1e6,
                    "0.7 % by the lead angle and the eccentric load; Wahl's factor is 1.1 to 1.4 % high",
                    "independent computation",
                )
            )
    return rows
