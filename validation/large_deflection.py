"""Springs under large compression: a retainer free to turn (Love), buckling of a slender spring, a
conical spring whose wide turns close first (Wahl).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from validation.beams import love_wrench
from validation.row import Row, book_case
from validation.springs import STEEL, mesh, spring
from validation.wires import Helix, tube
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.turning import TurningStatics, rotation_of
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import EndCoil
from valvetrain.runs.statics import static_curve
from valvetrain.springs.finite_element import FiniteElementRod


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
    """Compression at which slender clamped springs leave their axis, against the formula of EN
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


WIRE, WIDE, NARROW, TURNS, CLEARANCE = 1e-3, 24e-3, 20e-3, 8.0, 1.2e-3
#: Turn numbers over which the flat bed passes into the full pitch, either side of its end.
PASSAGE = 0.05


def cone() -> SpringDefinition:
    """Eight turns of constant pitch on one flat turn, on which the first of them closes."""
    end = TURNS + 1
    return SpringDefinition(
        Constant(WIRE),
        PiecewiseLinear((0.0, 1.0, end), (WIDE, WIDE, NARROW)),
        PiecewiseLinear(
            (0.0, 1 - PASSAGE, 1 + PASSAGE, end), (WIRE, WIRE, WIRE + CLEARANCE, WIRE + CLEARANCE)
        ),
        total_coils=end,
        material=STEEL,
        lower_end=EndCoil("closed-ground", 1.0, 1.0),
        upper_end=EndCoil("closed-ground", 0.0, 0.0),
    )


def closing_force(travel: float) -> float:
    """Force (N) at a travel (m) by Wahl: a turn gives way by 64 F R^3 / (G d^4) until its clearance
    is gone, the widest first.

    Adjacent turns that differ by s in radius touch at a height of sqrt(d^2 - s^2).
    """
    rigidity, large, small = STEEL.shear_modulus * WIRE**4, WIDE / 2, NARROW / 2
    room = WIRE + CLEARANCE - float(np.sqrt(WIRE**2 - ((large - small) / TURNS) ** 2))

    def reached(force: float) -> float:
        open_from = min(large, float(np.cbrt(room * rigidity / (64 * force))))
        closed = room * TURNS * (large - open_from) / (large - small)
        return closed + 16 * force * TURNS * (open_from**4 - small**4) / (
            rigidity * (large - small)
        )

    return float(
        brentq(lambda force: reached(force) - travel, 1e-3, room * rigidity / (64 * small**3))
    )


@book_case()
def conical_closing() -> list[Row]:
    """Force and progressive rate of a cone whose turns close one after the other, by the rod with
    coil contact.
    """
    travels = (5e-3, 8e-3, 8.5e-3)
    forces = [
        point.retainer_force
        for point in compress(
            RodStatics(mesh_spring(cone(), 12, curvature_correction=False)), list(travels)
        )
    ]
    expected = [closing_force(travel) for travel in travels]
    about = "d 1, D 24 to 20 mm, 8 turns of 1.2 mm clearance on a flat one"
    rows = []
    for travel, closed, found, share in zip(
        travels, expected, forces, (0.002, 0.018, 0.018), strict=True
    ):
        why = (
            "terms of (d / D)^2"
            if share < 0.01
            else "turns close point by point, the force is then off the axis"
        )
        what = f"conical spring, force at {1e3 * travel:g} mm"
        rows.append(
            Row("springs", what, "wahl1963", about, closed, found, "N", share * closed, why)
        )
    span = travels[2] - travels[1]
    rate, found = ((values[2] - values[1]) / span for values in (expected, forces))
    what = "conical spring, rate while it closes, 8 to 8.5 mm"
    rows.append(
        Row(
            "springs",
            what,
            "wahl1963",
            about,
            rate,
            found,
            "N/m",
            0.05 * rate,
            "as above; the rate before is 116 N/m",
        )
    )
    return rows
