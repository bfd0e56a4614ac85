"""A spring by the rod, the modal model and solid finite elements: static curve, modes about the installed state, a ride when asked for."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.cam.build import build_lift_law
from valvetrain.citations import cite
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.quantities.spring_comparison import ModelStatics, SpringComparison, differences
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.solid.calculix import find_solver
from valvetrain.springs.solid.deck import SolidContact
from valvetrain.springs.solid.installed import installed_statics, motion_seconds, statics_seconds
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.layout import MeshOptions
from valvetrain.springs.solid.transient import MOTION_CONTACT, TransientJob, run_transient
from valvetrain.studies.modal_runs import modal_model
from valvetrain.studies.solid_motion import check_motion, rod_motion
from valvetrain.studies.spring_runs import modal_result, static_curve

Array = NDArray[np.float64]
Progress = Callable[[float, str], None]

#: Models of this comparison.
MODELS = ("finite-element", "modal-varied", "solid")
#: Modes of the solid, and how many more of the rod, so that each finds its partner.
MODES, SPARE_MODES = 12, 8
#: Steps of the rod's curve: straight lines between them are exact to 0.01 % of the force where coils close.
ROD_STEPS = 160
#: Seconds that the rod's part takes, for the time left.
ROD_SECONDS = 3.0


@dataclass(frozen=True)
class SolidChoice:
    """Mesh of the solid (elements per coil, ``core`` x ``core`` cells and ``rings`` rings over the section), ``time_limit`` (s) of each
    run of the solver; ``ride`` first and last cam angle (rad) of a transient at ``engine_speed`` (crank rad/s), None for no transient."""

    elements_per_coil: int = 12
    core: int = 1
    rings: int = 1
    time_limit: float = 1800.0
    ride: tuple[float, float] | None = None
    engine_speed: float = 0.0


@dataclass(frozen=True)
class SolidCost:
    """What the solid part will take: unknowns, seconds of statics and modes, increments and seconds of the ride (0 without one)."""

    unknowns: int
    elements: int
    statics: float
    increments: int
    ride: float


def solid_model(case: Case, choice: SolidChoice, **changes: Any) -> SolidSpring:
    """The solid model of a case: held end turns, coils in contact, seat planes where the case has them."""
    contact = SolidContact(seats=case.installation.seats != "clamps")
    mesh = MeshOptions(choice.elements_per_coil, choice.core, choice.rings, ends="held")
    return SolidSpring.from_case(case, options=mesh, contact=contact, time_limit=choice.time_limit, **changes)


def solid_cost(case: Case, choice: SolidChoice) -> SolidCost:
    """What the solid part will take, told before it begins, good to a factor of two.

    Raises :class:`MissingExtraError` without the solver and :class:`InputError` for a mesh or a ride that cannot be.
    """
    find_solver()
    model = solid_model(case, choice)
    unknowns = model.mesh.unknowns
    increments = 0
    if choice.ride is not None:
        increments = int(np.ceil(_job(case, choice).duration / TransientJob.time_step)) + 10
    return SolidCost(unknowns, len(model.mesh.elements), statics_seconds(unknowns), increments, motion_seconds(unknowns, increments))


def run_solid_comparison(
    case: Case, *, models: Sequence[str] = MODELS, choice: SolidChoice = SolidChoice(), workers: int = 2, progress: Progress | None = None,
    created_at: str = "",
) -> SpringComparison:  # fmt: skip
    """Each of ``models`` on one spring case; the solid, where it takes part, is what the others are set against.

    Statics and ride of the solid run at a time for ``workers`` above 1. A failed run is a status in its part. Raises
    :class:`InputError` for an unknown model, a case without a spring or a ride that cannot be, :class:`MissingExtraError` without solver.
    """
    unknown = [name for name in models if name not in MODELS]
    if unknown:
        raise InputError(f"spring model '{unknown[0]}' is not one of {', '.join(MODELS)}; choose from these")
    cost = solid_cost(case, choice) if "solid" in models else SolidCost(0, 0, 0.0, 0, 0.0)
    rod = FiniteElementRod.from_case(case)
    installed, reach = case.installation.precompression, comparison_reach(case)
    meter = _Meter(progress, {"rod": ROD_SECONDS, "statics": cost.statics, "ride": cost.ride})
    members, rides = [], []
    with ThreadPoolExecutor(max(1, min(workers, 2))) as pool:
        try:
            statics = pool.submit(_solid_statics, case, choice, reach, meter) if "solid" in models else None
            ride = pool.submit(_solid_ride, case, choice, meter) if "solid" in models and choice.ride is not None else None
            by_rod = _rod_statics(case, rod, reach)
            meter("rod", 1.0)
            if statics is not None:
                members.append(statics.result())
            if ride is not None:
                rides.append(ride.result())
        except BaseException:
            meter.cancelled.set()  # the solver's own loop sees it and stops the solver
            raise
    if "finite-element" in models:
        members.append(by_rod)
    if "modal-varied" in models:
        members.append(_modal_statics(case, by_rod))
    if rides and "finite-element" in models and len(rides[0].time) > 2:
        rides.append(rod_motion(case, rod, rides[0]))
    return SpringComparison(
        case, installed, reach, tuple(members), differences(members, installed), tuple(rides), _notes(models, rides),
        collect_provenance(case.name, "spring comparison", created_at=created_at, citations=tuple(cite(key) for key in case.cite())),
    )  # fmt: skip


def comparison_reach(case: Case) -> float:
    """Compression (m) up to which curves are compared: a tenth, or a twentieth of the spring's travel, beyond the installed state."""
    spring, installed = case.require_spring(), case.installation.precompression
    travel = spring.free_length - spring.solid_height
    return min(installed + max(0.1 * installed, 0.05 * travel), 0.97 * travel)


def _job(case: Case, choice: SolidChoice) -> TransientJob:
    assert choice.ride is not None
    check_motion(case, choice.ride, choice.engine_speed)
    law = build_lift_law(case.lift_law)
    return TransientJob(law, choice.engine_speed, case.installation.precompression, *choice.ride, mass_damping=case.damping.mass_damping)


def _rod_statics(case: Case, rod: FiniteElementRod, reach: float) -> ModelStatics:
    begun = time.perf_counter()
    curve = static_curve(rod, reach, ROD_STEPS)
    modes = modal_result(rod, MODES + SPARE_MODES)
    facts: dict[str, float | int | str] = {"elements per coil": case.rod.elements_per_coil, "elements": rod.mesh.elements}
    return ModelStatics("finite-element", curve, modes, facts, time.perf_counter() - begun)


def _modal_statics(case: Case, rod: ModelStatics) -> ModelStatics:
    """What the modal model holds of statics and modes: k(x) on the rod's curve, and the rod's axial frequencies."""
    model, modes, curve = modal_model(case, rod.curve, rod.modes), rod.modes, rod.curve
    x, axial = curve.compression, list(modes.axial_modes)
    force = np.concatenate(([0.0], model.secant_stiffness(x[1:]) * x[1:]))
    none = np.zeros((len(x), 0))
    own = StaticCurve(x, force, np.gradient(force, x), none, none, np.zeros(0), none, np.zeros(0), curve.status)
    kept = ModalResult(
        modes.compression, modes.natural_frequency[axial], modes.shape[axial], modes.coil_number, modes.axial_transmission[axial],
        tuple(range(len(axial))), modes.status,
    )  # fmt: skip
    return ModelStatics("modal-varied", own, kept, {"modes": len(axial), "damping ratio": model.damping_ratio})


def _solid_statics(case: Case, choice: SolidChoice, reach: float, meter: _Meter) -> ModelStatics:
    installed = case.installation.precompression
    model = solid_model(case, choice, watch=lambda reached: meter("statics", 0.5 * reached if installed > 0 else reached))
    found = installed_statics(model, installed, reach, MODES)
    meter("statics", 1.0)
    return ModelStatics("solid", found.curve, found.modes, _solid_facts(model), found.wall_time)


def _solid_facts(model: SolidSpring) -> dict[str, float | int | str]:
    options = model.options
    return {
        "element": options.element_type, "elements per coil": options.elements_per_coil, "cells over the section": options.core**2
        + 4 * options.core * options.rings, "elements": len(model.mesh.elements), "unknowns": model.mesh.unknowns,
    }  # fmt: skip


def _solid_ride(case: Case, choice: SolidChoice, meter: _Meter) -> Solution:
    job = _job(case, choice)
    model = solid_model(case, choice, watch=lambda reached: meter("ride", reached / job.duration - 1))
    model = replace(model, contact=MOTION_CONTACT if model.contact is None else replace(MOTION_CONTACT, seats=model.contact.seats))
    solution = run_transient(model, job, case.name)
    meter("ride", 1.0)
    return solution


def _notes(models: Sequence[str], rides: Sequence[Solution]) -> tuple[str, ...]:
    notes = []
    if "modal-varied" in models:
        notes.append(
            "The modal model takes its stiffness k(x) and its frequencies from the finite-element rod, so that both show the same numbers "
            "at rest; they differ in motion."
        )
    if rides:
        notes.append(
            "The ride starts at rest, with mass-proportional damping only; the rod rides with the same damping, and its forces are means "
            "over the increments of the solid."
        )
    return tuple(notes)


class _Meter:
    """Joins the progress of parts that run at a time, each weighted by the seconds it is expected to take."""

    def __init__(self, progress: Progress | None, seconds: dict[str, float]) -> None:
        self.progress, self.seconds, self.cancelled = progress, seconds, threading.Event()
        self.done = dict.fromkeys(seconds, 0.0)
        self.lock = threading.Lock()

    def __call__(self, part: str, share: float) -> None:
        if self.cancelled.is_set():
            raise InterruptedError("stopped")
        with self.lock:
            self.done[part] = max(self.done[part], min(1.0, share))
            total = sum(self.done[name] * seconds for name, seconds in self.seconds.items()) / sum(self.seconds.values())
        if self.progress is not None:
            self.progress(min(1.0, total), {"rod": "rod", "statics": "solid, statics and modes", "ride": "solid, ride"}[part])
