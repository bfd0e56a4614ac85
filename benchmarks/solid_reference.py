"""Computes the solid-element reference numbers that the rod is checked against; run by hand, needs ``ccx``.

    python benchmarks/solid_reference.py run CASE LEVEL     one CalculiX run, result kept as JSON in build/solid-reference
    python benchmarks/solid_reference.py stress LEVEL       inner and outer fibre stress of a three-turn spring on STRESS_LEVELS
    python benchmarks/solid_reference.py write              data file and page from all kept results

CASE is one of the names in SPRINGS, LEVEL one of LEVELS. One core; minutes at the finest level.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np

from valvetrain.parameters.curves import Constant
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import OPEN_END, SpringDefinition
from valvetrain.springs.solid import steps
from valvetrain.springs.solid.fibre import fibre_stress, wire_torque
from valvetrain.springs.solid.fields import last_field, read_fields
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.layout import MeshOptions
from valvetrain.springs.solid.printed import read_printed

STORE = Path("build/solid-reference")
#: level -> (elements per coil, core cells per side, rings); h falls as 1 : 1/2 : 1/3.
LEVELS = {"1": (12, 1, 1), "2": (24, 2, 2), "3": (36, 3, 3)}
#: Even cores put a node row on the inner fibre; stress needs a finer section than force and frequency.
STRESS_LEVELS = {"1": (16, 2, 2), "2": (24, 4, 4), "3": (30, 6, 6)}
SMALL, LARGE, MODES = 0.07e-3, 7e-3, 14


def uniform(mean_diameter: float, coils: float = 5.0) -> SpringDefinition:
    """Open spring of constant pitch 7 mm, wire 3.8 mm, both wire ends clamped."""
    return SpringDefinition(
        wire_diameter=Constant(3.8e-3), mean_diameter=Constant(mean_diameter), pitch=Constant(7e-3), total_coils=coils,
        material=OTEVA_90_SC, lower_end=OPEN_END, upper_end=OPEN_END, name=f"uniform D {mean_diameter * 1e3:g} mm, {coils:g} turns",
    )  # fmt: skip


SPRINGS = {
    "uniform-22": uniform(22e-3), "index-6": uniform(6 * 3.8e-3), "index-8": uniform(8 * 3.8e-3), "index-6-ten-turns": uniform(6 * 3.8e-3, 10.0),
}  # fmt: skip


def run(case: str, level: str) -> dict:
    """One run: modes unloaded, small and large compression, modes there, inner and outer fibre stress."""
    per_coil, core, rings = LEVELS[level]
    model = SolidSpring(SPRINGS[case], MeshOptions(per_coil, core, rings), time_limit=900.0)
    plain, full = steps.Printout(axis=True), steps.Printout(axis=True, fields=True)
    count = MODES if SPRINGS[case].total_coils < 8 else 2
    deck = model.deck(
        steps.frequency_step(count, plain, preloaded=False),
        steps.static_step(SMALL, plain, first=1.0, largest=1.0, smallest=1.0),
        steps.static_step(LARGE, full, first=1.0, largest=1.0),
        steps.frequency_step(count, plain, preloaded=True),
    )
    started = time.perf_counter()
    output = model.run(deck, read_fields=True)
    if not output.status.completed:
        raise SystemExit(output.status.sentence())
    printed = read_printed(output.printed)
    _, forces = printed.history("total force", "RETAINER")
    free, loaded = (model.modes_from(printed, at, output.status, step) for at, step in ((0.0, 0), (LARGE, 1)))
    fields = read_fields(output.fields)
    stress = [item for item in fields if item.name == "STRESS"]
    motion = [item for item in fields if item.name == "DISP"]
    # Modal fields follow the static ones; the static step's last increment is the last at its own time.
    at_load = max(i for i, item in enumerate(stress) if abs(item.time - 2.0) < 1e-6)
    inner, outer = (fibre_stress(model.mesh, _same_time(motion, 2.0), stress[at_load], x) for x in (-1.0, 1.0))
    middle = SPRINGS[case].total_coils / 2
    return {
        "case": case, "level": level, "elements": len(model.mesh.elements), "nodes": len(model.mesh.coordinates), "unknowns": model.mesh.unknowns,
        "wall_time": time.perf_counter() - started, "force_small": -float(forces[0][0, 2]), "force_large": -float(forces[-1][0, 2]),
        "frequencies_free": free.natural_frequency.tolist(), "transmission_free": free.axial_transmission.tolist(),
        "frequencies_loaded": loaded.natural_frequency.tolist(), "transmission_loaded": loaded.axial_transmission.tolist(),
        "axial_free": free.axial_modes, "axial_loaded": loaded.axial_modes,
        "inner_shear": inner.mean_shear(middle - 1, middle + 1), "outer_shear": outer.mean_shear(middle - 1, middle + 1),
        "inner_shear_range": [float(np.min(_inside(inner))), float(np.max(_inside(inner)))],
    }  # fmt: skip


def run_stress(level: str) -> dict:
    """Fibre stress of three turns at D/d = 6 under 0.1 mm, mean over the middle turn, as a factor on 16 T / (pi d^3).

    T is the torsional moment that the retainer's reactions leave in the wire at each place.
    """
    per_coil, core, rings = STRESS_LEVELS[level]
    spring = uniform(6 * 3.8e-3, 3.0)
    model = SolidSpring(spring, MeshOptions(per_coil, core, rings), time_limit=900.0)
    step = steps.static_step(1e-4, steps.Printout(fields=True, nodal_reactions=True), first=1.0, largest=1.0, smallest=1.0)
    output = model.run(model.deck(step), read_fields=True)
    if not output.status.completed:
        raise SystemExit(output.status.sentence())
    fields, printed = read_fields(output.fields), read_printed(output.printed)
    force = -float(printed.history("total force", "RETAINER")[1][-1][0, 2])
    reactions = printed.history("forces", "RETAINER")[1][-1]
    displacement, stress = last_field(fields, "DISP"), last_field(fields, "STRESS")
    inner, outer = (_factor(spring, model, fibre_stress(model.mesh, displacement, stress, x), reactions) for x in (-1.0, 1.0))
    torque = wire_torque(spring, model.mesh, np.linspace(1, 2, 101), reactions)
    return {
        "case": "stress-index-6", "level": level, "elements": len(model.mesh.elements), "unknowns": model.mesh.unknowns,
        "wall_time": output.wall_time, "force": force, "torque_share": float(np.abs(torque).mean() / (force * 11.4e-3)),
        "inner_factor": inner, "outer_factor": outer,
    }  # fmt: skip


def _factor(spring, model, stress, reactions) -> float:
    coil = np.linspace(1.0, 2.0, 401)
    nominal = 16 * wire_torque(spring, model.mesh, coil, reactions) / (np.pi * 3.8e-3**3)
    return float(np.mean(np.abs(np.interp(coil, stress.coil, stress.shear) / nominal)))


def _same_time(fields, wanted):
    return [item for item in fields if abs(item.time - wanted) < 1e-6][-1]


def _inside(stress):
    return stress.shear[(stress.coil > 1.5) & (stress.coil < stress.coil[-1] - 1.5)]


if __name__ == "__main__":
    action, *rest = sys.argv[1:]
    if action in ("run", "stress"):
        result = run(*rest) if action == "run" else run_stress(*rest)
        STORE.mkdir(parents=True, exist_ok=True)
        (STORE / f"{result['case']}-{result['level']}.json").write_text(json.dumps(result, indent=1))
        print(json.dumps(result, indent=1))
