"""Named stresses of a run: peaks over wire and cycle, amplitude and mean at each point of the wire, quasi-static beside dynamic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.quantities.cycle import Array, reported_cycle
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticStress

SHEAR, EQUIVALENT = "inner_fibre_shear_stress", "inner_fibre_equivalent_stress"


@dataclass(frozen=True, eq=False)
class WireStress:
    """Stress at the inner fibre over one cycle, arrays (wire point,) in Pa: extremes of the shear, and the largest von Mises stress."""

    coil_number: Array
    least_shear: Array
    largest_shear: Array
    largest_equivalent: Array

    @property
    def amplitude(self) -> Array:
        """Half of largest less least shear."""
        return (self.largest_shear - self.least_shear) / 2

    @property
    def mean(self) -> Array:
        """Half of largest plus least shear."""
        return (self.largest_shear + self.least_shear) / 2

    @property
    def worst(self) -> int:
        """The wire point of the largest shear."""
        return int(np.argmax(self.largest_shear))


def wire_stress_of(solution: Solution) -> WireStress | None:
    """Extremes over the reported cycle; None without the stress channels or without a cycle."""
    if not solution.has(SHEAR, EQUIVALENT) or len(solution.time) < 3:
        return None
    cycle = reported_cycle(solution)
    shear, coil = cycle.channel(SHEAR), np.asarray(solution.channels["coil_number"].values)
    return WireStress(coil, shear.min(axis=0), shear.max(axis=0), cycle.channel(EQUIVALENT).max(axis=0))


def stress_quantities(solution: Solution, static: StaticStress | None = None, precompression: float = 0.0) -> dict[str, float]:
    """Peak, amplitude and mean of the stress of one run (Pa), its place, and its ratio to the quasi-static one (docs/quantities.md)."""
    stress = wire_stress_of(solution)
    if stress is None:
        return {}
    cycle, worst, most = reported_cycle(solution), stress.worst, int(np.argmax(stress.amplitude))
    shear = cycle.channel(SHEAR)[:, worst]
    found = {
        "peak_shear_stress": float(stress.largest_shear[worst]),
        "peak_shear_stress_cam_angle": float(cycle.cam_angle[int(np.argmax(shear))]),
        "peak_shear_stress_coil_number": float(stress.coil_number[worst]),
        "peak_equivalent_stress": float(np.max(stress.largest_equivalent)),
        "largest_amplitude_shear_stress": float(stress.amplitude[most]),
        "largest_amplitude_mean_shear_stress": float(stress.mean[most]),
        "largest_amplitude_coil_number": float(stress.coil_number[most]),
    }
    if static is not None and solution.has("valve_lift"):
        slow = static.shear_at(precompression + cycle.channel("valve_lift"))
        found["quasi_static_peak_shear_stress"] = float(np.max(slow))
        found["quasi_static_amplitude_shear_stress"] = float(np.max(np.ptp(slow, axis=0)) / 2)
        found["dynamic_to_static_stress_ratio"] = found["peak_shear_stress"] / found["quasi_static_peak_shear_stress"]
    return found
