"""Exact periodic solution of the modal model with varied stiffness: harmonic by harmonic over one
cam revolution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array
from valvetrain.integrate.contract import OfOneSpring, RunOptions, Until
from valvetrain.solution.channels import FINE, spring_channels
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import COMPLETED
from valvetrain.springs.modal_varied import ModalVaried
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring

SAMPLES, TURN = 720, 2 * np.pi
EXTRA: dict[str, tuple[tuple[str, ...], str, str]] = {
    "seat_force_as_printed": ((), "N", "seat force with the modal signs of equation 5 as printed"),
    "modal_coordinate": (("mode",), "m", "coordinate of each axial mode"),
}


@dataclass(frozen=True)
class Harmonic(OfOneSpring):
    """No step and no transient: every harmonic of the lift gives the same harmonic of each mode."""

    model = ModalVaried
    word: str = "harmonic"
    order: int = 0

    def run(
        self,
        system: System,
        cam_speed: float,
        until: Until,
        options: RunOptions,
        provenance: Provenance,
    ) -> Solution:
        """See :class:`valvetrain.integrate.contract.Integrator`."""
        assert isinstance(system, PrescribedSpring)
        model = system.springs[0]
        assert isinstance(model, ModalVaried)
        solved, samples = model.solve(system.valve_lift.lift, cam_speed), options.samples or SAMPLES
        angle = TURN * np.arange(samples + 1) / samples
        around = np.append(solved.cam_angle, TURN)
        finer = -(-len(solved.cam_angle) // samples)
        fine = angle[:, None] + TURN / samples / finer * np.arange(finer)

        def at(values: Array, angle: Array = angle) -> Array:
            return np.asarray(np.interp(angle % TURN, around, np.append(values, values[0])))

        values = {
            "valve_lift": system.valve_lift.lift(angle), "retainer_velocity": cam_speed * system.valve_lift.lift(angle, 1),
            "retainer_acceleration": cam_speed**2 * system.valve_lift.lift(angle, 2),
            "seat_force": at(solved.seat_force), "seat_force_as_printed": at(solved.seat_force_as_printed),
            "retainer_force": at(solved.retainer_force), "seat_force_fine": at(solved.seat_force, fine),
            "retainer_force_fine": at(solved.retainer_force, fine), "modal_coordinate": np.stack([at(g) for g in solved.modal_coordinates], axis=1),
        }  # fmt: skip
        channels = spring_channels(angle / cam_speed, angle, values, extra=EXTRA | FINE)
        statistics: dict[str, float | int | str | bool] = {
            "modes_count": len(model.natural_frequencies), "damping_ratio": model.damping_ratio, "integrator": self.word,
        }  # fmt: skip
        return Solution(channels, (), COMPLETED, statistics, provenance)


SPEC = Harmonic()
