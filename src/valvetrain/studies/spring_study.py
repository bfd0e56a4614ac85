"""The main job: a spring case by every model and engine speed, beside what was published."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from valvetrain.cam.build import build_lift_law
from valvetrain.citations import cite
from valvetrain.cosserat.static import Equilibrium
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.quantities.compare import compare, same_speed
from valvetrain.quantities.design import check_room
from valvetrain.quantities.evaluate import study_quantities
from valvetrain.quantities.stages import Stages, stages_of
from valvetrain.quantities.statics import natural_quantities
from valvetrain.quantities.stress import StaticStress, stress_quantities
from valvetrain.quantities.study import SpringStudy
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.provenance import Option, Provenance, collect_provenance
from valvetrain.solution.quantity import Quantity, named
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.stress import LOADS, with_stress
from valvetrain.studies.modal_runs import run_modal
from valvetrain.studies.spread import load_spread, spread_sentences
from valvetrain.studies.spring_runs import modal_result, run_finite_element, static_curve, static_stress
from valvetrain.studies.uncertainty_file import load_uncertainty, meshes_of, uncertainty_sentences

#: Spring models that the study of a spring alone knows.
MODELS = ("finite-element", "modal-varied")

Progress = Callable[[float, str], None]


def run_spring_study(
    case: Case, *, engine_speeds: Sequence[float] | None = None, models: Sequence[str] = MODELS, workers: int = 2,
    progress: Progress | None = None, created_at: str = "",
) -> SpringStudy:  # fmt: skip
    """Static curve, modes and the transient at each engine speed (rad/s of the crank) by each of ``models``.

    Runs go over ``workers`` threads (the compiled march holds no interpreter lock); results do not depend on their number.
    Raises :class:`InputError` for an unknown model or a case without a spring; a failed run is a status in its solution.
    """
    _check_models(models)
    rod_speeds = case.operation.engine_speeds if engine_speeds is None else tuple(engine_speeds)
    if any(not speed > 0 for speed in rod_speeds):
        raise InputError("every engine speed must be positive; give it as '4200 rpm'")
    if rod_speeds:
        check_room(case)
    model = FiniteElementRod.from_case(case)
    tell = _Steps(progress, 2 + len(rod_speeds) * len(models))
    model.installed  # noqa: B018  the equilibrium all runs start from; solved once before the threads share it
    model.stable_time_step()
    with ThreadPoolExecutor(max(1, workers)) as pool:
        marches = {}
        if "finite-element" in models:
            marches = {
                s: pool.submit(run_finite_element, case, model, s, _provenance(case, "finite-element", s, created_at)) for s in rod_speeds
            }
        path: list[Equilibrium] = []
        curve_job = pool.submit(static_curve, model, static_reach(case, model), visit=path.append)
        curve = _wait(curve_job, tell, "static curve")
        modes = modal_result(model)
        tell("modes")
        solutions = [_wait(job, tell, f"finite-element rod at {s * 30 / np.pi:.0f} rpm") for s, job in marches.items()]
    if "modal-varied" in models:
        for speed in rod_speeds:
            solutions.append(run_modal(case, curve, modes, speed, _provenance(case, "modal-varied", speed, created_at)))
            tell(f"modal model at {speed * 30 / np.pi:.0f} rpm")
    return assemble_study(case, curve, modes, solutions, created_at, static_stress(model, path))


def assemble_study(
    case: Case, curve: StaticCurve | None, modes: ModalResult | None, solutions: Sequence[Solution], created_at: str = "",
    stress: StaticStress | None = None,
) -> SpringStudy:  # fmt: skip
    """Join results with their named quantities and the case's published values."""
    stages = stages_of(case.lift_law)
    quantities = study_quantities(curve, modes, solutions, precompression=case.installation.precompression, stages=stages)
    for solution in solutions:
        quantities |= _stress_quantities(case, solution, stress)
    if modes is not None:
        quantities |= named(natural_quantities(modes, [value.quantity for value in case.published]), None, "")
    told = (*spread_sentences(case, load_spread(case)), *_firmness(case, quantities), *_stage_words(case, solutions, stages))
    return SpringStudy(
        case=case, static_curve=curve, modal_result=modes, solutions=tuple(solutions), quantities=quantities,
        comparisons=compare(case.published, quantities), notes=(*case.remarks, *told),
        provenance=_provenance(case, "spring study", 0.0, created_at), static_stress=stress,
    )  # fmt: skip


def _stage_words(case: Case, solutions: Sequence[Solution], stages: Stages | None) -> tuple[str, ...]:
    """Why there are no quantities by stage, where there is a lift."""
    if stages is not None or not any(len(run.time) and np.max(run.channel("valve_lift")) > 0 for run in solutions):
        return ()
    return ("The lift event spans the zero of the cam angle, so the cycle has no stages before and after it; move the event to have them.",)


def _firmness(case: Case, quantities: Mapping[Quantity, float]) -> tuple[str, ...]:
    """Sentences on the uncertainty that ships with the case, for the speeds that were run."""
    rows = load_uncertainty(case)
    run = {key.engine_speed for key in quantities if key.label == "finite-element"}
    return uncertainty_sentences(tuple(row for row in rows if any(same_speed(row.engine_speed, speed) for speed in run)), meshes_of(case))


def _stress_quantities(case: Case, solution: Solution, stress: StaticStress | None) -> dict[Quantity, float]:
    if case.spring is None or not solution.has(*LOADS):
        return {}
    found = stress_quantities(with_stress(solution, case.spring), stress, case.installation.precompression)
    return named(found, solution.engine_speed, solution.model)


def static_reach(case: Case, model: FiniteElementRod) -> float:
    """Largest compression (m) of the static curve: a little beyond the largest lift, or near solid when there is no lift."""
    definition = model.definition
    travel = definition.free_length - definition.solid_height
    angle = np.linspace(0.0, 2 * np.pi, 721)
    top = float(np.max(build_lift_law(case.lift_law).lift(angle))) if case.lift_law is not None else 0.8 * travel
    return min(case.installation.precompression + 1.06 * top, 0.98 * travel)


def _check_models(models: Sequence[str]) -> None:
    unknown = [name for name in models if name not in MODELS]
    if unknown:
        raise InputError(f"spring model '{unknown[0]}' is not one of {', '.join(MODELS)}; choose from these")


def _provenance(case: Case, model: str, engine_speed: float, created_at: str) -> Provenance:
    options: dict[str, Option] = {
        "elements_per_coil": case.rod.elements_per_coil, "contact_stiffness": case.rod.contact_stiffness,
        "contact_damping_time": case.rod.contact_damping_time, "output_step": case.rod.output_step,
        "curvature_correction": case.rod.curvature_correction, "cycles": case.operation.cycles,
        "mass_damping": case.damping.mass_damping, "stiffness_damping": case.damping.stiffness_damping,
    }  # fmt: skip
    digest = hashlib.sha256(repr(case).encode()).hexdigest()[:16]
    cited = tuple(cite(key) for key in case.cite())
    return collect_provenance(
        case.name, model, engine_speed=engine_speed, case_digest=digest, options=options, created_at=created_at, citations=cited
    )


class _Steps:
    """Counts finished steps and tells the share done."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.progress, self.total, self.done = progress, total, 0

    def __call__(self, text: str) -> None:
        self.done += 1
        if self.progress is not None:
            self.progress(min(1.0, self.done / self.total), text)


def _wait(job: Future[Any], tell: _Steps, text: str) -> Any:
    result = job.result()
    tell(text)
    return result
