"""Named stresses of a run: by EN 13906-1 from the loads at rest, and along the wire where the model gives
section loads.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import PERMITTED_SHEAR, tensile_strength
from valvetrain.quantities.cycle import Cycle, Frame
from valvetrain.quantities.forces import largest_lift
from valvetrain.quantities.statics import solid_quantities
from valvetrain.solution.channels import Variable
from valvetrain.solution.result import Solution
from valvetrain.springs.chain_statics import reduction_chain, static_curve
from valvetrain.springs.stress import (
    LOADS,
    STRESS_CHANNELS,
    nominal_stress_per_force,
    wire_stress,
)

SHEAR, EQUIVALENT = "inner_fibre_shear_stress", "inner_fibre_equivalent_stress"
#: What EN 13906-1 holds against the permitted shear.
UNCORRECTED = "open_uncorrected_shear_stress"


def stress_quantities(cycle: Cycle, frame: Frame) -> dict[str, float]:
    """All stresses (Pa) that the run and its springs support; of a nested pair the largest, and
    each with its spring's name in front.
    """
    names = cycle.solution.springs
    found: dict[str, float] = {}
    for name, spring in zip(names, frame.springs, strict=False):
        mine = _nominal(cycle, spring) | _of_wire(cycle, name, spring, frame)
        found |= (
            {f"{name}_{word}": value for word, value in mine.items()} if len(names) > 1 else mine
        )
    if len(names) > 1:
        peaks = {
            name: found[key]
            for name in names
            if (key := f"{name}_open_nominal_shear_stress") in found
        }
        if peaks:
            worst = max(peaks, key=lambda name: peaks[name])
            found |= {
                f"{word}_nominal_shear_stress": found[f"{worst}_{word}_nominal_shear_stress"]
                for word in ("open", "closed")
            }
            found |= {
                name: found[f"{worst}_{name}"]
                for name in (UNCORRECTED, "wire_tensile_strength", "permitted_shear_stress")
                if f"{worst}_{name}" in found
            }
    return found


def _nominal(cycle: Cycle, spring: InstalledSpring) -> dict[str, float]:
    """Shear by EN 13906-1 at the worst place of the wire under the spring's load at rest, with the valve
    closed and at the largest lift of the cycle.

    The standard is about loads at rest. Of the force at the seat in motion it would make a stress that no
    wire bears: a spike goes from coil to coil, and a wave loads one turn more than the next. What the
    wire bears in motion is the stress of a model that has sections.
    """
    lift = largest_lift(cycle)
    if spring.wire is None or lift is None:
        return {}
    at = np.array([spring.precompression, spring.precompression + lift])
    closed, opened = static_curve(reduction_chain(spring.wire), at)[0].tolist()
    factor = nominal_stress_per_force(spring.wire)
    opened = min(opened, solid_quantities(spring.wire)["solid_force"])
    found = {
        "open_nominal_shear_stress": factor * opened,
        "closed_nominal_shear_stress": factor * closed,
        UNCORRECTED: nominal_stress_per_force(spring.wire, corrected=False) * opened,
    }
    coils = np.linspace(0.0, spring.wire.total_coils, 201)
    thickest = float(np.max(spring.wire.wire_diameter.value(coils)))
    strength = tensile_strength(spring.wire.material, thickest)
    if strength is not None:
        found |= {
            "wire_tensile_strength": strength, "permitted_shear_stress": PERMITTED_SHEAR * strength,
        }  # fmt: skip
    return found


def most_force_of_wire(spring: InstalledSpring) -> float:
    """Largest force (N) that the wire of a spring carries, that at solid; infinite where no wire is
    known or its coils do not meet.
    """
    if spring.wire is None or spring.contact.stiffness <= 0:
        return np.inf
    return solid_quantities(spring.wire)["solid_force"]


def with_wire_stress(solution: Solution, frame: Frame) -> Solution:
    """The run with the stresses (Pa) at the inner fibre as channels, of every spring whose section
    loads were saved.
    """
    added: dict[str, Variable] = {}
    for spring, place in zip(solution.springs, frame.springs, strict=False):
        names, loads = (
            [solution.channel_of(spring, name) for name in known]
            for known in ((SHEAR, EQUIVALENT), LOADS)
        )
        if place.wire is None or solution.has(names[0]) or not solution.has(*loads):
            continue
        values = wire_stress(
            {load: solution.channel(name) for load, name in zip(LOADS, loads, strict=True)},
            place.wire,
            _coils(solution, loads[0]),
        )
        dims = solution.arrays[loads[0]].dims
        added |= {
            name: Variable(
                dims, values[known], {"units": "Pa", "long_name": STRESS_CHANNELS[known]}
            )
            for name, known in zip(names, (SHEAR, EQUIVALENT), strict=True)
        }
    return replace(solution, channels=solution.arrays.assign(added)) if added else solution


def _coils(solution: Solution, name: str) -> Array:
    """Coil numbers along the wire of one channel."""
    coils = solution.arrays.along(name)
    assert coils is not None
    return coils


def _of_wire(cycle: Cycle, name: str, spring: InstalledSpring, frame: Frame) -> dict[str, float]:
    """Peak, least, amplitude and mean along the wire, their places, and the ratio to the
    quasi-static peak (docs/quantities.md).
    """
    solution = cycle.solution
    names = [solution.channel_of(name, one) for one in (SHEAR, EQUIVALENT)]
    if not solution.has(*names):
        return {}
    coil, (shear, equivalent) = _coils(solution, names[0]), map(cycle.channel, names)
    least, largest = shear.min(axis=0), shear.max(axis=0)
    amplitude, mean = (largest - least) / 2, (largest + least) / 2
    worst, most = int(np.argmax(largest)), int(np.argmax(amplitude))
    found = {
        "peak_shear_stress": float(largest[worst]),
        "peak_shear_stress_cam_angle": float(cycle.cam_angle[int(np.argmax(shear[:, worst]))]),
        "peak_shear_stress_coil_number": float(coil[worst]),
        "minimum_shear_stress": float(least[worst]),
        "peak_equivalent_stress": float(np.max(equivalent)),
        "largest_amplitude_shear_stress": float(amplitude[most]),
        "largest_amplitude_mean_shear_stress": float(mean[most]),
        "largest_amplitude_coil_number": float(coil[most]),
    }
    static = next(
        (one.stress for one in frame.rest if one.spring == spring.name and one.stress is not None),
        None,
    )
    if static is not None and solution.has("valve_lift"):
        slow = static.shear_at(spring.precompression + cycle.channel("valve_lift"))
        found["quasi_static_peak_shear_stress"] = float(np.max(slow))
        found["quasi_static_amplitude_shear_stress"] = float(np.max(np.ptp(slow, axis=0)) / 2)
        found["dynamic_to_static_stress_ratio"] = (
            found["peak_shear_stress"] / found["quasi_static_peak_shear_stress"]
        )
    return found
