"""Energy balance of a run: what went in, what is stored, what became heat, and what is missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.solution.result import Solution

Array = NDArray[np.float64]
_CHANNELS = ("kinetic_energy", "elastic_energy", "work_done", "energy_dissipated")


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """Energies (sample) in J from the first sample on; ``imbalance = stored + dissipated - work``.

    ``scale`` (J): span of the work done, which the imbalance is measured against.
    """

    cam_angle: Array
    kinetic: Array
    stored: Array
    dissipated: Array
    work: Array
    imbalance: Array
    scale: float

    @property
    def relative_imbalance(self) -> float:
        """Largest imbalance over the span of the work done; zero when no work was done and none is
        missing.
        """
        largest = float(np.max(np.abs(self.imbalance), initial=0.0))
        return largest / self.scale if self.scale > 0 else largest


def energy_balance(solution: Solution) -> EnergyBalance | None:
    """Balance over the whole run, both cycles; None for a model without energies."""
    if not solution.has(*_CHANNELS):
        return None
    kinetic = solution.channel("kinetic_energy")
    contact = (
        solution.channel("contact_energy")
        if solution.has("contact_energy")
        else np.zeros_like(kinetic)
    )
    stored = kinetic + solution.channel("elastic_energy") + contact
    stored = stored - stored[0]
    work = solution.channel("work_done") - solution.channel("work_done")[0]
    dissipated = solution.channel("energy_dissipated") - solution.channel("energy_dissipated")[0]
    return EnergyBalance(
        solution.cam_angle,
        kinetic,
        stored,
        dissipated,
        work,
        stored + dissipated - work,
        float(np.ptp(work)),
    )


def energy_quantities(solution: Solution) -> dict[str, float]:
    """Largest imbalance over the work done, and the energy turned to heat in the run (J)."""
    balance = energy_balance(solution)
    if balance is None:
        return {}
    return {
        "energy_imbalance_ratio": balance.relative_imbalance,
        "dissipated_energy": float(balance.dissipated[-1]),
    }
