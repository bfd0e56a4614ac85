"""Stiffness-proportional damping of CalculiX under a prescribed retainer: a short spring pulled
evenly.

    python benchmarks/solid_damping.py      seconds

Retainer at even velocity v, quasi-static: with damping b K v of all velocities the wire keeps its
linear shape (the middle at half the way)
and the seat force is k (u + b v); with the retainer's velocity left out, the wire lags by b and
both are lower by the share b v / u.
"""

from __future__ import annotations

import numpy as np

from valvetrain.parameters.constructors import cylindrical
from valvetrain.parameters.spring import OPEN_END
from valvetrain.springs.solid import axis_motion
from valvetrain.springs.solid import deck as steps
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.mesh import MeshOptions
from valvetrain.springs.solid.results import read_printed

START, VELOCITY, DURATION, INCREMENT = 0.5e-3, 0.05, 20e-3, 1e-3


def pulled(stiffness_damping: float) -> tuple[float, float, float]:
    """Share of the way that the middle of the wire has gone, seat and retainer force over the way
    (N/mm), at the end.
    """
    spring = cylindrical(
        3.8e-3, 22e-3, 7e-3, 3.0, closed_coils=0.0, lower_end=OPEN_END, upper_end=OPEN_END
    )
    model, printout = (
        SolidSpring(spring, MeshOptions(6, 1, 1)),
        steps.Printout(axis=True, energy=True),
    )
    time = np.array([0.0, DURATION])
    table = steps.amplitude_text("LIFT", time, -(START + VELOCITY * time) * 1e3)
    static = steps.static_step(START, printout, first=0.5, largest=0.5, period=DURATION)
    deck = model.deck(
        static,
        steps.dynamic_step(DURATION, INCREMENT, printout, amplitude="LIFT"),
        before=table,
        mass_damping=1e-9,
    )
    printed = read_printed(
        model.run(deck.replace("BETA=0.", f"BETA={stiffness_damping:g}")).printed
    )
    way = 1e3 * (START + VELOCITY * DURATION)
    coil, index, _ = axis_motion.axis_points(model.mesh)
    middle = axis_motion.averaged(
        printed.history("displacements", "AXIS")[1][-1], model.mesh, index, len(coil)
    )[len(coil) // 2, 2]
    seat, retainer = (
        abs(printed.history("total force", name)[1][-1][0, 2]) / way
        for name in ("SEAT", "RETAINER")
    )
    return -middle / way, seat, retainer


if __name__ == "__main__":
    free = pulled(0.0)
    for damping in (1e-3, 2e-3):
        shares = [100 * (one / other - 1) for one, other in zip(pulled(damping), free, strict=True)]
        due = 100 * damping * VELOCITY / (START + VELOCITY * DURATION)
        print(
            f"b = {damping:g} s: b v / u {due:.1f} %; middle {shares[0]:+.1f} %, seat {shares[1]:+.1f} %, retainer {shares[2]:+.0f} %"
        )
