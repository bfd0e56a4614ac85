"""A small spring study with made-up numbers and the published values of the beehive case."""

from __future__ import annotations

import numpy as np

from synthetic_spring import ENGINE_SPEED, bump
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.clash import clash_events
from valvetrain.quantities.compare import compare
from valvetrain.quantities.evaluate import study_quantities
from valvetrain.quantities.study import SpringStudy
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.status import Status

SPEED = ENGINE_SPEED
COILS = np.arange(0.0, 7.25, 0.5)
PAIRS = np.arange(1.0, 7.25, 0.5)


def rod_run(engine_speed: float = SPEED, samples: int = 720, status: Status | None = None) -> Solution:
    """Two turns of a spring with a clash at 250 degrees, four substeps a sample in its force."""
    angle = np.arange(2 * samples) * 2 * np.pi / samples
    degrees = np.degrees(angle) % 360
    lift = 9e-3 * bump(degrees, 180, 106)
    fine = np.degrees(angle[:, None] + np.arange(4) * np.pi / 2 / samples) % 360
    spike = 300 + 500 * bump(fine, 180, 106) + 400 * bump(fine, 250, 3)
    share = COILS / 7
    moved = -lift[:, None] * share + 1e-4 * np.sin(np.pi * share) * np.sin(np.radians(13 * degrees))[:, None]
    work = np.cumsum(np.gradient(lift)) * 300
    values = {
        "valve_lift": lift, "seat_force": spike[:, 0], "axial_displacement": moved, "axial_velocity": 10 * moved,
        "axial_acceleration": 1e3 * moved, "axial_position": 6e-3 * COILS + moved,
        "coil_gap": 1e-3 - 1.1e-3 * bump(degrees, 250, 3)[:, None] * (PAIRS < 2.6),
        "coil_contact_force": 200 * bump(degrees, 250, 3)[:, None] * (PAIRS < 2.6), "kinetic_energy": 0 * lift,
        "elastic_energy": work, "work_done": 1.001 * work, "energy_dissipated": 0 * lift, "seat_force_fine": spike,
    }  # fmt: skip
    extra = {"seat_force_fine": (("subsample",), "N", "seat force between the samples")}
    channels = spring_channels(angle / (engine_speed / 2), angle, values, coil_number=COILS, upper_coil=PAIRS, extra=extra)
    made = Solution(channels, (), status or Status(), {"steps": 10}, Provenance("gu2021-beehive", "finite-element", engine_speed))
    return Solution(channels, clash_events(made), made.status, made.statistics, made.provenance)


def modal_run(engine_speed: float = SPEED, samples: int = 720) -> Solution:
    """The same without coils."""
    angle = np.arange(samples) * 2 * np.pi / samples
    values = {"valve_lift": 9e-3 * bump(np.degrees(angle), 180, 106), "seat_force": 300 + 500 * bump(np.degrees(angle), 180, 106)}
    channels = spring_channels(angle / (engine_speed / 2), angle, values)
    return Solution(channels, provenance=Provenance("gu2021-beehive", "modal-varied", engine_speed))


def study(solutions: tuple[Solution, ...] | None = None) -> SpringStudy:
    """Static curve, three axial modes among five, and the runs above."""
    case = load_case("gu2021-beehive")
    steps = np.linspace(0, 15e-3, 40)
    gap = (12e-3 - steps)[:, None] * np.ones(len(PAIRS))
    curve = StaticCurve(steps, 41e3 * steps, np.full(40, 41e3), gap, 0 * gap, PAIRS, np.ones((40, len(COILS))), COILS)
    shape = np.zeros((5, len(COILS), 3))
    for number, mode in enumerate((1, 2, 4), start=1):
        shape[mode, :, 2] = -np.sin(np.pi * number * COILS / 7)
    shape[1] /= np.abs(shape[1]).max()
    modes = ModalResult(7e-3, np.array([400, 630, 1120, 1300, 1639.0]), shape, COILS, np.array([0.01, 1, -0.7, 0.1, 0.5]), (1, 2, 4))
    runs = (rod_run(), modal_run()) if solutions is None else solutions
    found = study_quantities(curve, modes, runs, precompression=7e-3)
    return SpringStudy(case, curve, modes, runs, found, compare(case.published, found), ("A note <for> readers.",))
