"""Computes the solid-element reference numbers that the rod is checked against; run by hand, needs
``ccx``.

    python -m benchmarks.solid_reference run CASE LEVEL     one CalculiX run, result kept as JSON in
    build/solid-reference
    python -m benchmarks.solid_reference stress LEVEL       inner and outer fibre stress of a
    three-turn spring on STRESS_LEVELS
    python -m benchmarks.solid_reference beehive LEVEL      static curve with coils closing, then
    modes, on BEEHIVE_LEVELS
    python -m benchmarks.solid_reference ends TREATMENT     closed and ground spring with its end
    turns bonded or ground
    python -m benchmarks.solid_reference ride               transient of the beehive at 8000 rpm on
    the coarse mesh
    python -m benchmarks.solid_reference write              data file from all kept results

CASE is one of the names in SPRINGS, LEVEL one of LEVELS. One core; minutes at the finest level.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from validation.calculix import deck as steps
from validation.calculix.deck import SolidContact
from validation.calculix.jobs import SolidSpring
from validation.calculix.results import (
    fibre_stress,
    last_field,
    read_fields,
    read_printed,
    wire_torque,
)
from validation.calculix.transient import TransientJob, run_transient

from valvetrain.cam import build_lift_law
from valvetrain.continuum.mesh import MeshOptions
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END, EndCoil
from valvetrain.solution.atomic import write_text
from valvetrain.solution.netcdf import save_netcdf

STORE = Path("build/solid-reference")
#: level -> (elements per coil, core cells per side, rings); h falls as 1 : 1/2 : 1/3.
LEVELS = {"1": (12, 1, 1), "2": (24, 2, 2), "3": (36, 3, 3)}
#: Even cores put a node row on the inner fibre; stress needs a finer section than force and
#: frequency.
STRESS_LEVELS = {"1": (16, 2, 2), "2": (24, 4, 4), "3": (30, 6, 6)}
BEEHIVE_LEVELS = {"1": (12, 1, 1), "2": (24, 2, 1), "3": (32, 2, 2)}
SMALL, LARGE, MODES = 0.07e-3, 7e-3, 14


def uniform(mean_diameter: float, coils: float = 5.0) -> SpringDefinition:
    """Open spring of constant pitch 7 mm, wire 3.8 mm, both wire ends clamped."""
    return SpringDefinition(
        wire_diameter=Constant(3.8e-3),
        mean_diameter=Constant(mean_diameter),
        pitch=Constant(7e-3),
        total_coils=coils,
        material=OTEVA_90_SC,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
        name=f"uniform D {mean_diameter * 1e3:g} mm, {coils:g} turns",
    )


#: A beehive of the library's kind, fixed here so that a new identification of the library case does
#: not move the reference.
BEEHIVE: dict[str, Any] = {
    "wire_diameter": 3.867e-3, "total_coils": 7.0, "held_lower": 0.78, "held_upper": 0.83,
    "mean_diameter_coils": [0.0, 4.0, 7.0], "mean_diameter": [22.47e-3, 22.47e-3, 17.31e-3],
    "pitch_coils": [0.0, 0.875, 1.125, 2.0, 3.0, 6.0, 7.0],
    "pitch_clearance": [0.0, 0.0, 1.017e-3, 2.032e-3, 5.488e-3, 5.488e-3, 1.351e-3],
}  # fmt: skip


def beehive() -> SpringDefinition:
    """The spring of :data:`BEEHIVE`."""
    data = BEEHIVE
    return SpringDefinition(
        wire_diameter=Constant(data["wire_diameter"]),
        total_coils=data["total_coils"],
        material=OTEVA_90_SC,
        name="beehive",
        mean_diameter=PiecewiseLinear(
            tuple(data["mean_diameter_coils"]), tuple(data["mean_diameter"])
        ),
        pitch=PiecewiseLinear(
            tuple(data["pitch_coils"]),
            tuple(data["wire_diameter"] + gap for gap in data["pitch_clearance"]),
        ),
        lower_end=EndCoil("closed-ground", data["held_lower"], data["held_lower"]),
        upper_end=EndCoil("closed-ground", data["held_upper"], data["held_upper"]),
    )


SPRINGS = {
    "uniform-22": uniform(22e-3), "index-6": uniform(6 * 3.8e-3), "index-8": uniform(8 * 3.8e-3),
    "index-6-ten-turns": uniform(6 * 3.8e-3, 10.0),
}  # fmt: skip


def run(case: str, level: str) -> dict[str, Any]:
    """One run: modes unloaded, small and large compression, modes there, inner and outer fibre
    stress.
    """
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
    free, loaded = (
        model.modes_from(printed, at, output.status, step) for at, step in ((0.0, 0), (LARGE, 1))
    )
    fields = read_fields(output.fields)
    stress = [item for item in fields if item.name == "STRESS"]
    motion = [item for item in fields if item.name == "DISP"]
    # Modal fields follow the static ones; the static step's last increment is the last at its own
    # time.
    at_load = max(i for i, item in enumerate(stress) if abs(item.time - 2.0) < 1e-6)
    inner, outer = (
        fibre_stress(model.mesh, _same_time(motion, 2.0), stress[at_load], x) for x in (-1.0, 1.0)
    )
    middle = SPRINGS[case].total_coils / 2
    return {
        "case": case,
        "level": level,
        "elements": len(model.mesh.elements),
        "unknowns": model.mesh.unknowns,
        "wall_time": time.perf_counter() - started,
        "force_small": -float(forces[0][0, 2]),
        "force_large": -float(forces[-1][0, 2]),
        "frequencies_free": free.natural_frequency.tolist(),
        "transmission_free": free.axial_transmission.tolist(),
        "frequencies_loaded": loaded.natural_frequency.tolist(),
        "transmission_loaded": loaded.axial_transmission.tolist(),
        "axial_free": free.axial_modes,
        "axial_loaded": loaded.axial_modes,
        "inner_shear": inner.mean_shear(middle - 1, middle + 1),
        "outer_shear": outer.mean_shear(middle - 1, middle + 1),
        "inner_shear_range": [float(np.min(_inside(inner))), float(np.max(_inside(inner)))],
    }


def run_stress(level: str) -> dict[str, Any]:
    """Fibre stress of three turns at D/d = 6 under 0.1 mm, mean over the middle turn, as a factor
    on 16 T / (pi d^3).

    T is the torsional moment that the retainer's reactions leave in the wire at each place.
    """
    per_coil, core, rings = STRESS_LEVELS[level]
    spring = uniform(6 * 3.8e-3, 3.0)
    model = SolidSpring(spring, MeshOptions(per_coil, core, rings), time_limit=900.0)
    step = steps.static_step(
        1e-4,
        steps.Printout(fields=True, nodal_reactions=True),
        first=1.0,
        largest=1.0,
        smallest=1.0,
    )
    output = model.run(model.deck(step), read_fields=True)
    if not output.status.completed:
        raise SystemExit(output.status.sentence())
    fields, printed = read_fields(output.fields), read_printed(output.printed)
    force = -float(printed.history("total force", "RETAINER")[1][-1][0, 2])
    reactions = printed.history("forces", "RETAINER")[1][-1]
    displacement, stress = last_field(fields, "DISP"), last_field(fields, "STRESS")
    assert displacement and stress
    inner, outer = (
        _factor(spring, model, fibre_stress(model.mesh, displacement, stress, x), reactions)
        for x in (-1.0, 1.0)
    )
    torque = wire_torque(spring, model.mesh, np.linspace(1, 2, 101), reactions)
    return {
        "case": "stress-index-6",
        "level": level,
        "elements": len(model.mesh.elements),
        "unknowns": model.mesh.unknowns,
        "wall_time": output.wall_time,
        "force": force,
        "torque_share": float(np.abs(torque).mean() / (force * 11.4e-3)),
        "inner_factor": inner,
        "outer_factor": outer,
    }


def _factor(spring, model, stress, reactions) -> float:
    coil = np.linspace(1.0, 2.0, 401)
    nominal = 16 * wire_torque(spring, model.mesh, coil, reactions) / (np.pi * 3.8e-3**3)
    return float(np.mean(np.abs(np.interp(coil, stress.coil, stress.shear) / nominal)))


def run_beehive(level: str) -> dict[str, Any]:
    """The library's beehive with its end turns bonded, self-contact and seat planes, compressed to
    7 mm; modes there.
    """
    per_coil, core, rings = BEEHIVE_LEVELS[level]
    model = SolidSpring(
        beehive(),
        MeshOptions(per_coil, core, rings, ends="bonded"),
        SolidContact(),
        time_limit=900.0,
    )
    printout = steps.Printout(axis=True, pairs=len(model.pairs))
    deck = model.deck(
        steps.static_step(LARGE, printout, first=0.05, largest=0.05),
        steps.frequency_step(MODES, steps.Printout(axis=True), preloaded=True),
    )
    output = model.run(deck)
    printed = read_printed(output.printed)
    curve, modes = (
        model.curve_from(printed, LARGE, output.status),
        model.modes_from(printed, LARGE, output.status),
    )
    return {
        "case": "beehive",
        "level": level,
        "elements": len(model.mesh.elements),
        "unknowns": model.mesh.unknowns,
        "wall_time": output.wall_time,
        "status": output.status.sentence(),
        "compression": curve.compression.tolist(),
        "force": curve.force.tolist(),
        "stiffness": curve.stiffness.tolist(),
        "upper_coil": curve.upper_coil.tolist(),
        "coil_gap": curve.coil_gap.tolist(),
        "coil_contact_force": curve.coil_contact_force.tolist(),
        "frequencies": modes.natural_frequency.tolist(),
        "transmission": modes.axial_transmission.tolist(),
        "axial": modes.axial_modes,
    }


def run_ends(treatment: Literal["bonded", "ground"]) -> dict[str, Any]:
    """Six-turn closed and ground spring, bonded turns or truly ground and bonded end faces, with
    seat planes and self-contact.
    """
    spring = SpringDefinition(3.8e-3, 22e-3, 7e-3, total_coils=6.0, material=OTEVA_90_SC)
    model = SolidSpring(
        spring, MeshOptions(24, 2, 1, ends=treatment), SolidContact(), time_limit=600.0
    )
    curve = model.static_curve(5e-3, points=8)
    return {
        "case": "ends",
        "level": treatment,
        "elements": len(model.mesh.elements),
        "unknowns": model.mesh.unknowns,
        "status": curve.status.sentence(),
        "compression": curve.compression.tolist(),
        "force": curve.force.tolist(),
    }


def run_ride() -> dict[str, Any]:
    """Beehive on its lift law at 8000 rpm from the start of lift past the first clash; mass damping
    only, 40 us increments.
    """
    case = load_case("gu2021-beehive-blind")
    # Softer contact than in statics: coils that meet at speed otherwise exhaust the solver's
    # cutbacks.
    contact = SolidContact(stiffness=1e13)
    model = SolidSpring(beehive(), MeshOptions(12, 1, 1, ends="bonded"), contact, time_limit=480.0)
    speed = 8000 * 2 * np.pi / 60
    job = TransientJob(
        build_lift_law(case.lift_law),
        speed,
        7e-3,
        np.radians(85),
        np.radians(265),
        4e-5,
        case.springs[0].damping.mass_damping,
    )
    solution = run_transient(model, job, case.name)
    solution_file = STORE / "ride.nc"
    save_netcdf(solution, solution_file)
    return {
        "case": "ride",
        "level": "8000rpm",
        "status": solution.status.sentence(),
        **dict(solution.statistics),
    }


def _same_time(fields, wanted):
    return [item for item in fields if abs(item.time - wanted) < 1e-6][-1]


def _inside(stress):
    return stress.shear[(stress.coil > 1.5) & (stress.coil < stress.coil[-1] - 1.5)]


def richardson(
    values: Sequence[float], sizes: Sequence[float] = (1.0, 1 / 2, 1 / 3)
) -> tuple[float, float, float]:
    """Limit, its uncertainty and the observed order from three mesh sizes; the finest value where
    they do not behave.
    """
    coarse, middle, fine = values
    low, high = 0.5, 8.0

    def ratio(order: float) -> float:
        h = [size**order for size in sizes]
        return (h[0] - h[1]) / (h[1] - h[2])

    wanted = (coarse - middle) / (middle - fine) if middle != fine else np.inf
    if not ratio(low) < wanted < ratio(high):
        return fine, abs(fine - middle), float("nan")
    for _ in range(60):
        order = (low + high) / 2
        low, high = (order, high) if ratio(order) < wanted else (low, order)
    step = (fine - middle) * sizes[2] ** order / (sizes[1] ** order - sizes[2] ** order)
    return fine + step, abs(step), order


def summary(case: str) -> dict[str, Any]:
    """Extrapolated numbers of one uniform spring."""
    found = [
        json.loads((STORE / f"{case}-{level}.json").read_text())
        for level in LEVELS
        if (STORE / f"{case}-{level}.json").exists()
    ]

    def limit(pick) -> tuple[float, float, float]:
        values = [pick(item) for item in found]
        return (
            richardson(values)
            if len(values) == 3
            else (values[-1], abs(values[-1] - values[-2]), float("nan"))
        )

    count = min(12, len(found[-1]["frequencies_free"]))
    out = {
        "found": found,
        "force_small": limit(lambda item: item["force_small"]),
        "force_large": limit(lambda item: item["force_large"]),
    }
    for state in ("free", "loaded"):
        out[state] = [
            limit(lambda item, i=i, state=state: item[f"frequencies_{state}"][i])
            for i in range(count)
        ]
        out[f"axial_{state}"] = [
            index + 1 for index in found[-1][f"axial_{state}"] if index < count
        ]
    return out


def _numbers(values: Sequence[float], digits: int = 7) -> str:
    return "[" + ", ".join(f"{value:.{digits}g}" for value in values) + "]"


def toml_text() -> str:
    """The data file for the tests."""
    lines = [
        "# Solid finite elements (CalculiX 2.20, C3D20R) as a reference for the rod. Written by benchmarks/solid_reference.py; SI units.",
        "# Uniform springs: wire 3.8 mm, pitch 7 mm, end sections clamped, E 206 GPa, G 79.6 GPa, 7850 kg/m3. Values are Richardson",
        "# limits of three meshes with their uncertainty; axial modes are counted from 1.",
        "",
    ]
    for name, spring in SPRINGS.items():
        if not (STORE / f"{name}-2.json").exists():
            continue
        data = summary(name)
        small, large = data["force_small"], data["force_large"]
        lines += [
            "[[uniform]]",
            f'name = "{name}"',
            "wire_diameter = 3.8e-3",
            f"mean_diameter = {float(spring.mean_diameter.value(0)):.6g}",
            "pitch = 7e-3",
            f"coils = {spring.total_coils:g}",
            f"compressions = [{SMALL:g}, {LARGE:g}]",
            f"forces = {_numbers([small[0], large[0]])}",
            f"force_uncertainties = {_numbers([small[1], large[1]], 2)}",
            f"frequencies_free = {_numbers([v[0] for v in data['free']])}",
            f"frequencies_loaded = {_numbers([v[0] for v in data['loaded']])}",
            f"axial_modes_free = {data['axial_free']}",
            f"axial_modes_loaded = {data['axial_loaded']}",
            "",
        ]
    stress = [
        json.loads((STORE / f"stress-index-6-{level}.json").read_text()) for level in STRESS_LEVELS
    ]
    lines += [
        "[stress]",
        "# Shear at the fibre over 16 T / (pi d^3), T the torsional moment of the wire, mean over a turn.",
        "index = 6.0",
    ]
    for key in ("inner_factor", "outer_factor"):
        value, uncertainty, _ = richardson([item[key] for item in stress], (1 / 2, 1 / 4, 1 / 6))
        lines += [f"{key} = {value:.5g}", f"{key}_uncertainty = {uncertainty:.2g}"]
    lines += ["", "[beehive]"] + [f"{key} = {value!r}" for key, value in BEEHIVE.items()]
    bee = [json.loads(path.read_text()) for path in sorted(STORE.glob("beehive-?.json"))][-1]
    contact = np.sum(bee["coil_contact_force"], axis=1)
    lines += [
        f"unknowns = {bee['unknowns']}",
        f"compressions = {_numbers(bee['compression'])}",
        f"forces = {_numbers(bee['force'])}",
        f"contact_forces = {_numbers(contact, 5)}",
        f"frequencies = {_numbers(bee['frequencies'])}",
        f"transmissions = {_numbers(bee['transmission'], 3)}",
        f"axial_modes = {[index + 1 for index in bee['axial']]}",
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    action, *rest = sys.argv[1:]
    actions: dict[str, Callable[..., dict[str, Any]]] = {
        "run": run,
        "stress": run_stress,
        "beehive": run_beehive,
        "ends": run_ends,
        "ride": run_ride,
    }
    if action in actions:
        result = actions[action](*rest)
        STORE.mkdir(parents=True, exist_ok=True)
        (STORE / f"{result['case']}-{result['level']}.json").write_text(
            json.dumps(result, indent=1)
        )
        print(json.dumps(result, indent=1))
    elif action == "write":
        write_text("tests/published/solid_reference.toml", toml_text())
