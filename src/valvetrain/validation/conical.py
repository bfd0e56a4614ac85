"""A conical spring whose wide turns close first: Wahl's progressive curve."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.spring import EndCoil, SpringDefinition
from valvetrain.validation.row import Row, book_case
from valvetrain.validation.springs import STEEL

WIRE, WIDE, NARROW, TURNS, CLEARANCE = 1e-3, 24e-3, 20e-3, 8.0, 1.2e-3
#: Turn numbers over which the flat bed passes into the full pitch, either side of its end.
PASSAGE = 0.05


def cone() -> SpringDefinition:
    """Eight turns of constant pitch on one flat turn, which is the bed that the first of them
    closes on.
    """
    end = TURNS + 1
    return SpringDefinition(
        Constant(WIRE),
        PiecewiseLinear((0.0, 1.0, end), (WIDE, WIDE, NARROW)),
        PiecewiseLinear(
            (0.0, 1 - PASSAGE, 1 + PASSAGE, end), (WIRE, WIRE, WIRE + CLEARANCE, WIRE + CLEARANCE)
        ),
        end,
        STEEL,
        EndCoil("closed-ground", 1.0, 1.0),
        EndCoil("closed-ground", 0.0, 0.0),
    )


def closing_force(travel: float) -> float:
    """Force (N) at a travel (m) by Wahl: a turn gives way by 64 F R^3 / (G d^4) until its clearance
    is gone, the widest first.

    Turns that lie beside each other by s on the radius touch at a height of sqrt(d^2 - s^2).
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
            else "turns close point by point, the force then stands off the axis"
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
