"""Golden: every block of the input decks of small solid springs, in sums; ``python
tests/golden/test_solid_decks.py`` writes them anew.

That a mesh is the wire it is made of, and that the solver's answers are right, is shown elsewhere
(``tests/unit/test_solid_mesh.py``,
``tests/published``); here no node, face, set or step may move unsaid.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from known_sums import deck_sums, read, same, sums, write
from valvetrain.parameters.constructors import beehive, conical, cylindrical
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import OPEN_END, SpringDefinition
from valvetrain.springs.solid.axis_motion import axis_points, coil_gaps, estimated_rate
from valvetrain.springs.solid.deck import Printout, SolidContact, frequency_step, static_step
from valvetrain.springs.solid.installed import motion_seconds, statics_seconds
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.mesh import MeshOptions
from valvetrain.springs.solid.transient import TransientJob, transient_deck

KEPT = Path(__file__).parent / "solid_decks.json"
ALL = Printout(axis=True, pairs=2, fields=True, energy=True, nodal_reactions=True)
STRAIGHT = SpringDefinition(
    wire_diameter=Constant(3.8e-3),
    mean_diameter=Constant(22e-3),
    pitch=Constant(7e-3),
    total_coils=2.0,
    material=OTEVA_90_SC,
    lower_end=OPEN_END,
    upper_end=OPEN_END,
)
CONE = conical(3.6e-3, 26e-3, 20e-3, 6.5e-3, 3.5)
HIVE = beehive(3.2e-3, 22e-3, 16e-3, 2.0, 6e-3, 4.0)
GROUND = replace(cylindrical(3.8e-3, 22e-3, 7e-3, 4.0), hand="left")
MODELS = {
    "clamped": SolidSpring(STRAIGHT, MeshOptions(5, 2, 1)),
    "linear bricks": SolidSpring(
        STRAIGHT, MeshOptions(6, 1, 2, "C3D8I", 3.0), SolidContact(wire_per_pair=0.3)
    ),
    "bonded cone": SolidSpring(CONE, MeshOptions(5, 1, 1, ends="bonded"), SolidContact(2e13, 0.4)),
    "bonded hive": SolidSpring(
        HIVE, MeshOptions(4, 1, 1, "C3D20", ends="bonded"), SolidContact(seats=False)
    ),
    "ground": SolidSpring(GROUND, MeshOptions(12, 4, 1, ends="ground"), SolidContact()),
}


class Wave:
    """A lift law for the table of a transient."""

    def lift(self, cam_angle, derivative=0):
        return 2e-3 * (1 - np.cos(np.asarray(cam_angle)))


@cache
def decks() -> dict[str, dict]:
    """Every model with its steps, and what is read off its mesh."""
    found = {}
    for name, model in MODELS.items():
        load = static_step(3e-3, ALL, first=0.1, largest=0.2, smallest=1e-4, period=2.0, limit=50)
        fixed = static_step(1e-3, Printout(), first=0.25, largest=0.25, smallest=0.25)
        modes = frequency_step(7, Printout(axis=True), preloaded=name != "clamped")
        coil, index, free = axis_points(model.mesh)
        shifted = np.stack([free, free * np.array([1.0, 1.0, 0.9])])
        found[name] = deck_sums(
            model.deck(load, fixed, modes, mass_damping=12.0 if name == "ground" else 0.0)
        ) | {
            "axis": sums(coil) + sums(free)[2:],
            "index": sums(index),
            "pairs": sums(model.pairs),
            "rate": estimated_rate(model.spring),
            "gaps": sums(coil_gaps(model.spring, coil, shifted, model.pairs, model.contact)),
            "quality": float(model.mesh.jacobian_quality()),
            "lower faces": sums(model.mesh.lower.elements),
            "upper coils": sums(model.mesh.upper.coil),
            "fibre": sums(model.mesh.fibre(-1.0, 0.0)),
        }
    job = TransientJob(Wave(), 300.0, 2e-3, 0.5, 2.0, time_step=2e-3, mass_damping=9.0, alpha=-0.1)
    found["transient"] = deck_sums(transient_deck(MODELS["bonded cone"], job)) | {
        "duration": job.duration
    }
    found["usual options"] = deck_sums(
        SolidSpring(STRAIGHT).deck(static_step(1e-3, Printout(), first=0.1, largest=0.1))
    )
    found["cost"] = {
        str(n): [n, 0, statics_seconds(n), motion_seconds(n, 100), motion_seconds(n, 100)]
        for n in (1000, 40000, 300000)
    }
    return found


@pytest.mark.parametrize("name", [*MODELS, "transient", "usual options", "cost"])
def test_a_deck_is_what_it_was(name):
    assert not same(decks()[name], read(KEPT)[name], 1e-7)


if __name__ == "__main__":
    write(KEPT, decks())
