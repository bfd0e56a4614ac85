"""Springs whose ends are not held in every way: a retainer free to turn (Love), a slender spring
that buckles.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from valvetrain.cosserat.static import compress
from valvetrain.cosserat.turning import TurningStatics, rotation_of
from valvetrain.runs.statics import static_curve
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.validation.beams import love_wrench
from valvetrain.validation.row import Row, book_case
from valvetrain.validation.springs import STEEL, mesh, spring
from valvetrain.validation.wires import Helix, tube


@book_case()
def retainer_free_to_turn() -> list[Row]:
    """A helix pressed between plates of which one may turn: Love's helix of no torque has its force
    and its rotation.
    """
    wire, diameter, turns, pitch = 1e-3, 24e-3, 10.0, 6e-3
    rod = mesh(spring(wire, diameter, pitch, turns), 48)
    radius, lead, length = (
        diameter / 2,
        np.arctan(pitch / (np.pi * diameter)),
        turns * np.hypot(np.pi * diameter, pitch),
    )
    bending, torsion = (
        STEEL.youngs_modulus * np.pi / 64 * wire**4,
        STEEL.shear_modulus * np.pi / 32 * wire**4,
    )
    free, statics, rows = (
        Helix(radius, lead, tube(bending, torsion, length)),
        TurningStatics(rod),
        [],
    )
    about = "d 1, D 24, pitch 6 mm, 10 turns, 48 elements per coil"
    for travel in (12e-3, 36e-3):
        angle = np.arcsin(np.sin(lead) - travel / length)
        bent = brentq(
            lambda r, a=angle: love_wrench(free, Helix(r, a, free.wire))[1],
            0.8 * radius,
            1.3 * radius,
        )
        force = -love_wrench(free, Helix(bent, angle, free.wire))[0]
        rotation = np.degrees(length * (np.cos(angle) / bent - np.cos(lead) / radius))
        found = compress(statics, [travel])[-1]
        turned = np.degrees(rotation_of(statics, found.state))
        why = "clamped ends, shear of the wire and second order of the mesh"
        for word, expected, computed, unit, limit in (
            ("force", float(force), found.retainer_force, "N", 0.0025 * float(force)),
            ("rotation", float(rotation), float(turned), "deg", 0.015),
        ):
            name = f"retainer free to turn, {word} pressed by {1e3 * travel:g} mm"
            rows.append(
                Row("springs", name, "love1927", about, expected, computed, unit, limit, why)
            )
    return rows


@book_case()
def buckling_limit() -> list[Row]:
    """Compression at which slender clamped springs leave their axis, beside the formula of EN
    13906-1 with nu = 0.5.
    """
    wire, diameter, ratio = 1e-3, 10e-3, STEEL.shear_modulus / STEEL.youngs_modulus
    rows = []
    for slenderness, turns in ((6.5, 20.0), (8.0, 24.0)):
        length = slenderness * diameter
        root = 1 - (1 - ratio) / (0.5 + ratio) * (np.pi / (0.5 * slenderness)) ** 2
        expected = float(0.5 / (1 - ratio) * (1 - np.sqrt(root)))
        rod = FiniteElementRod(spring(wire, diameter, length / turns, turns), 0.0, 12)
        curve, _ = static_curve(rod, 1.3 * expected * length)
        found = curve.buckling.compression / length if curve.buckling is not None else np.nan
        about = f"d 1, D 10, L0 {1e3 * length:g} mm, {turns:g} turns, both ends clamped"
        why = "the formula's column has no coils and loads its axis"
        what = f"buckling, compression over free length at L0 / D = {slenderness:g}"
        rows.append(
            Row("springs", what, "en13906-1", about, expected, found, "-", 0.006 * expected, why)
        )
    return rows
