"""Runs of the classical modal model with varied stiffness, frequencies and k(x) taken from the finite-element rod."""

from __future__ import annotations

import numpy as np

from valvetrain.cam.build import build_lift_law
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.status import COMPLETED
from valvetrain.springs.modal_varied import ModalVaried

EXTRA = {
    "seat_force_wave_equation": ((), "N", "seat force with the modal signs of the wave equation"),
    "modal_coordinate": (("mode",), "m", "coordinate of each axial mode"),
}


def modal_model(case: Case, curve: StaticCurve, modes: ModalResult) -> ModalVaried:
    """The modal model of a case. Raises :class:`InputError` when no axial mode was found or the case is undamped and unsure."""
    frequencies = tuple(float(value) for value in modes.axial_frequencies)
    if not frequencies:
        raise InputError(f"the spring of case '{case.name}' shows no axial mode; compute more modes or run the finite-element model alone")
    ratio = case.damping.ratio if case.damping.ratio is not None else case.damping.ratio_at(frequencies[0])
    keep = curve.compression > 0
    return ModalVaried(
        frequencies, ratio, tuple(curve.compression[keep].tolist()), tuple(curve.force[keep].tolist()), case.installation.precompression
    )


def run_modal(case: Case, curve: StaticCurve, modes: ModalResult, engine_speed: float, provenance: Provenance) -> Solution:
    """Periodic response over one cam turn at ``engine_speed`` (rad/s of the crank), sampled at the case's output step.

    ``seat_force`` follows the printed equation 5; ``seat_force_wave_equation`` the signs that the wave equation demands.
    """
    model, law, cam_speed = modal_model(case, curve, modes), build_lift_law(case.lift_law), engine_speed / 2
    solved = model.solve(law.lift, cam_speed)
    samples = round(2 * np.pi / case.rod.output_step)
    cam_angle = 2 * np.pi * np.arange(samples + 1) / samples
    around = np.append(solved.cam_angle, 2 * np.pi)

    def at(values: np.ndarray) -> np.ndarray:
        return np.interp(cam_angle, around, np.append(values, values[0]))

    values = {
        "valve_lift": law.lift(cam_angle), "retainer_velocity": cam_speed * law.lift(cam_angle, 1),
        "seat_force": at(solved.seat_force_as_printed), "seat_force_wave_equation": at(solved.seat_force),
        "retainer_force": at(solved.retainer_force), "modal_coordinate": np.stack([at(g) for g in solved.modal_coordinates], axis=1),
    }  # fmt: skip
    channels = spring_channels(cam_angle / cam_speed, cam_angle, values, extra=EXTRA)
    statistics = {"modes": len(model.natural_frequencies), "damping_ratio": model.damping_ratio}
    return Solution(channels, (), COMPLETED, statistics, provenance)
