"""Helical springs: rates, natural frequencies, surge, curvature of the bar."""

from __future__ import annotations

import numpy as np

from validation.row import Row, book_case
from validation.wires import ring_section
from valvetrain.cosserat.mesh import RodMesh, mesh_spring
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.parameters.curves import Constant, Curve, Parabola, PiecewiseLinear
from valvetrain.parameters.material import Material
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END

STEEL = Material("spring steel", 206e9, 79.6e9, 7850.0)
CLAMPED_HELIX = (393.5, 396.1, 462.8, 525.7, 864.0, 876.9, 914.3, 1037.0, 1310.5, 1363.8)


def spring(
    wire: float, diameter: Curve | float, pitch: float, coils: float, material: Material = STEEL
) -> SpringDefinition:
    """Spring of constant pitch clamped at both wire tips; lengths in m."""
    law = Constant(diameter) if isinstance(diameter, float) else diameter
    return SpringDefinition(
        Constant(wire),
        law,
        Constant(pitch),
        total_coils=coils,
        material=material,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
    )


def mesh(definition: SpringDefinition, per_coil: int = 24, curvature: bool = False) -> RodMesh:
    """Rod of a spring whose coils do not meet."""
    return mesh_spring(definition, per_coil, curvature_correction=curvature, contact=False)


def rate(rod: RodMesh, travel: float) -> float:
    """Secant rate (N/m) over a small travel (m)."""
    return compress(RodStatics(rod), [travel])[-1].retainer_force / travel


@book_case()
def clamped_helix_frequencies() -> list[Row]:
    """Ten natural frequencies of a clamped helix by the default mesh."""
    lead, radius, turns = np.radians(8.5744), 5e-3, 7.6
    steel = Material("steel", 206e9, 206e9 / 2.6, 7900.0)
    rod = mesh(spring(1e-3, 2 * radius, 2 * np.pi * radius * np.tan(lead), turns, steel))
    found = natural_modes(RodStatics(rod), free_state(rod), 10).natural_frequency
    return [
        Row(
            "springs",
            f"clamped helix, natural frequency {n + 1}",
            "mottershead1980",
            "R 5 mm, d 1 mm, 7.6 turns, lead 8.5744 deg",
            value,
            float(found[n]),
            "Hz",
            0.003 * value,
            "codes in the literature scatter by 0.3 %",
            "recalled",
        )
        for n, value in enumerate(CLAMPED_HELIX)
    ]


@book_case()
def rates_of_shaped_springs() -> list[Row]:
    """1 / k = integral of 64 R^3 / (G d^4) over the turns, for slender wire and small lead angle."""
    wire, turns, pitch = 1e-3, 8.0, 1.5e-3
    laws: dict[str, Curve] = {
        "cylinder": Constant(24e-3),
        "cone": PiecewiseLinear((0.0, turns), (28e-3, 18e-3)),
        "barrel": Parabola(18e-3, 28e-3, turns),
        "hourglass": Parabola(28e-3, 18e-3, turns),
    }
    rows, coil = [], np.linspace(0, turns, 4001)
    for name, law in laws.items():
        cubes = (law.value(coil) / 2) ** 3
        compliance = (
            64
            / (STEEL.shear_modulus * wire**4)
            * float(np.sum((cubes[1:] + cubes[:-1]) / 2) * (coil[1] - coil[0]))
        )
        found = rate(mesh(spring(wire, law, pitch, turns)), 1e-4)
        rows.append(
            Row(
                "springs",
                f"rate of a {name}",
                "wahl1963",
                "d 1 mm, D 18-28 mm, 8 turns, pitch 1.5 mm",
                1 / compliance,
                found,
                "N/m",
                0.0025 / compliance,
                "terms of (d / D)^2 and of the lead angle",
            )
        )
    return rows


@book_case()
def curvature_of_the_bar() -> list[Row]:
    """Rate of a close-coiled spring against that of a bar bent to a ring, solved on its section
    without any factor.
    """
    rows = []
    for index in (4.0, 6.0, 10.0):
        wire, turns = 4e-3, 8.0
        diameter = index * wire
        plain = STEEL.shear_modulus * wire**4 / (8 * diameter**3 * turns)
        # Pitch far below the wire: no such spring exists, but the formula is that of the flat ring.
        rod = mesh(_flat(wire, diameter, turns), curvature=True)
        expected = plain * ring_section(index)[0]
        rows.append(
            Row(
                "springs",
                f"rate with curvature of the bar, index {index:g}",
                "timoshenko1970",
                "d 4 mm, 8 turns, lead angle to zero",
                expected,
                rate(rod, 1e-5),
                "N/m",
                0.18 / index**4 * expected,
                "Goehner's correction leaves out 0.14 (d / D)^4",
                "independent computation",
            )
        )
    return rows


def _flat(wire: float, diameter: float, turns: float) -> SpringDefinition:
    definition = spring(wire, diameter, 1.02 * wire, turns)
    object.__setattr__(definition, "pitch", Constant(1e-3 * wire))
    return definition


@book_case()
def trial_spring() -> list[Row]:
    """Rate and first frequency of a typical valve spring without curvature correction, against bar
    theory.
    """
    definition = spring(3.8e-3, 22e-3, 7e-3, 5.0)
    rod, plain = mesh(definition), STEEL.shear_modulus * 3.8e-3**4 / (8 * 22e-3**3 * 5)
    return [
        Row(
            "springs",
            "typical spring, rate over G d^4 / (8 D^3 n)",
            "wahl1963",
            "d 3.8, D 22, pitch 7 mm, 5 turns clamped",
            0.990041,
            rate(rod, 1e-4) / plain,
            "-",
            5e-4,
            "second order: 1.6e-4 at 24 per coil; shooting on the rod's equations to 1e-10",
            "independent computation",
        ),
        Row(
            "springs",
            "typical spring, secant rate to 7 mm over G d^4 / (8 D^3 n)",
            "wahl1963",
            "d 3.8, D 22, pitch 7 mm, 5 turns clamped",
            0.984626,
            rate(rod, 7e-3) / plain,
            "-",
            5e-4,
            "as above",
            "independent computation",
        ),
    ]


@book_case()
def surge_frequency() -> list[Row]:
    """First axial frequency of a slender spring of many coils: d / (2 pi n D^2) sqrt(G / (2 rho))."""
    wire, diameter, turns = 1e-3, 12e-3, 30.0
    rod = mesh(spring(wire, diameter, 1.6e-3, turns), 12)
    modes = natural_modes(RodStatics(rod), free_state(rod), 40)
    expected = (
        wire
        / (2 * np.pi * turns * diameter**2)
        * np.sqrt(STEEL.shear_modulus / (2 * STEEL.density))
    )
    found = float(modes.natural_frequency[modes.axial_modes(1)[0]])
    return [
        Row(
            "springs",
            "surge frequency, both ends fixed",
            "en13906-1",
            "d 1, D 12, pitch 1.6 mm, 30 turns",
            expected,
            found,
            "Hz",
            0.005 * expected,
            "terms of (d / D)^2 and of the ends over 30 turns",
        )
    ]
