"""Numbers with error bars: meshes and steps refined, contact constants varied, for the headline numbers of a spring case."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from valvetrain.quantities.stages import stages_of
from valvetrain.studies.spring_runs import modal_result, run_finite_element

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.evaluate import run_quantities
from valvetrain.quantities.main_clash import ClashWindow, find_clash_window, main_clash_quantities
from valvetrain.quantities.statics import modal_quantities
from valvetrain.quantities.stress import stress_quantities
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.stress import with_stress
from valvetrain.studies.grid_convergence import TRUSTED, grid_convergence

#: Elements per coil over those of the case.
REFINEMENTS = (1.0, 1.5, 2.25)
#: Contact stiffness over the case's (7e9 to 5e10 Pa for 2e10) and contact damping time over the case's (0 to 2 us for 1 us).
STIFFNESS_FACTORS, DAMPING_FACTORS = (0.35, 2.5), (0.0, 2.0)

#: Headline numbers; those that a case does not have are left out.
STATIC_HEADLINES = ("preload", "mode_1_frequency", "mode_2_frequency", "mode_3_frequency")
RUN_HEADLINES = (
    "stage_1_minimum_force", "stage_1_maximum_force", "stage_2_peak_force", "stage_2_first_peak_force", "stage_2_valley_force",
    "stage_2_second_peak_force", "stage_3_peak_force", "stage_3_below_20_khz_peak_force", "stage_3_below_10_khz_peak_force",
    "main_clash_peak_force", "main_clash_below_20_khz_peak_force", "main_clash_below_10_khz_peak_force", "main_clash_cam_angle",
    "main_clash_impulse", "peak_shear_stress",
)  # fmt: skip

Progress = Callable[[float, str], None]
Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """One headline number (SI) of the case's own mesh, at ``engine_speed`` (rad/s of the crank; None for statics and modes).

    ``numerical``: uncertainty from meshes and step. ``observed_order``: None where the series is not monotonic. ``extrapolated``:
    Richardson value, or the finest one. ``step_part``: what the step alone contributes. ``contact_stiffness`` and ``contact_damping``:
    least and largest value over the range of each constant, the case's own included.
    """

    quantity: str
    engine_speed: float | None
    value: float
    numerical: float
    observed_order: float | None
    extrapolated: float
    step_part: float
    contact_stiffness: Range
    contact_damping: Range


@dataclass(frozen=True)
class UncertaintyStudy:
    """All rows of one case with the meshes behind them; ``values`` holds every number by (variant, speed, quantity)."""

    case: Case
    elements_per_coil: tuple[int, ...]
    rows: tuple[Uncertainty, ...]
    values: Mapping[str, Mapping[float | None, Mapping[str, float]]]
    failures: tuple[str, ...] = ()


def uncertainty_study(
    case: Case, *, engine_speeds: Sequence[float] | None = None, refinements: Sequence[float] = REFINEMENTS, workers: int = 2,
    progress: Progress | None = None,
) -> UncertaintyStudy:  # fmt: skip
    """Refine meshes and step, vary the contact, and state the uncertainty of each headline number.

    Runs go over ``workers`` threads. Raises :class:`InputError` for a case without spring or lift law, or other than three meshes.
    """
    if len(refinements) != 3 or list(refinements) != sorted(set(refinements)):
        raise InputError("three meshes are needed, coarse to fine, such as 1, 1.5 and 2.25 times the elements per coil")
    if case.lift_law is None or case.spring is None:
        raise InputError(f"case '{case.name}' needs a [spring] and a [lift_law] to be refined; give it both")
    speeds = case.operation.engine_speeds if engine_speeds is None else tuple(engine_speeds)
    variants = _variants(case, refinements)
    jobs = [(name, speed) for speed in speeds for name in variants]
    done, total = 0, 1 + len(variants) + len(jobs)

    def tell(text: str) -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / total, text)

    values: dict[str, dict[float | None, dict[str, float]]] = {name: {} for name in variants}
    failures: list[str] = []
    with ThreadPoolExecutor(max(1, workers)) as pool:
        for name, still in zip(variants, pool.map(_still, variants.values()), strict=True):
            values[name][None] = still
            tell(f"statics and modes, {name}")
        surge = values["mesh 1"][None].get("mode_1_frequency")
        bases = list(pool.map(lambda speed: _run(case, variants["mesh 1"], speed), speeds))
        windows = {speed: _window(case, base, surge) for speed, base in zip(speeds, bases, strict=True)}
        tell("runs on the case's own mesh")
        own = dict(zip(speeds, bases, strict=True))

        def job(item: tuple[str, float]) -> tuple[dict[str, float], str]:
            name, speed = item
            solution = own[speed] if name == "mesh 1" else _run(case, variants[name], speed)
            failed = "" if solution.status.completed else f"{name} at {speed * 30 / np.pi:.0f} rpm: {solution.status.sentence()}"
            return _moving(case, solution, surge, windows[speed]), failed

        for (name, speed), (found, failed) in zip(jobs, pool.map(job, jobs), strict=True):
            values[name][speed] = found
            failures += [failed] if failed else []
            tell(f"{name} at {speed * 30 / np.pi:.0f} rpm")
    elements = tuple(variants[f"mesh {n}"].elements_per_coil for n in (1, 2, 3))
    return UncertaintyStudy(case, elements, tuple(_rows(values, elements)), values, tuple(failures))


def _variants(case: Case, refinements: Sequence[float]) -> dict[str, FiniteElementRod]:
    base = FiniteElementRod.from_case(case)
    own, dynamics = case.rod.elements_per_coil, base.dynamics
    found = {f"mesh {n}": replace(base, elements_per_coil=round(own * ratio)) for n, ratio in enumerate(refinements, start=1)}
    found["half step"] = base.with_time_step(0.5 * (base.time_step or base.stable_time_step()))
    for n, factor in enumerate(STIFFNESS_FACTORS, start=1):
        stiffer = replace(dynamics, contact_stiffness=factor * dynamics.contact_stiffness)
        found[f"contact stiffness {n}"] = replace(base, dynamics=stiffer)
    for n, factor in enumerate(DAMPING_FACTORS, start=1):
        damped = replace(dynamics, contact_damping_time=factor * dynamics.contact_damping_time)
        found[f"contact damping {n}"] = replace(base, dynamics=damped)
    return found


def _still(model: FiniteElementRod) -> dict[str, float]:
    model.stable_time_step()  # kept by the model, so that its runs need not ask for it one by one
    found = {"preload": model.installed.retainer_force} | modal_quantities(modal_result(model))
    return {name: float(found[name]) for name in STATIC_HEADLINES if name in found}


def _run(case: Case, model: FiniteElementRod, engine_speed: float) -> Solution:
    return run_finite_element(case, model, engine_speed, Provenance(case.name, model.name, engine_speed=engine_speed))


def _window(case: Case, solution: Solution, surge_frequency: float | None) -> ClashWindow | None:
    if surge_frequency is None or len(solution.time) < 3:
        return None
    return find_clash_window(reported_cycle(solution), surge_frequency, stages_of(case.lift_law))


def _moving(case: Case, solution: Solution, surge_frequency: float | None, window: ClashWindow | None) -> dict[str, float]:
    if not solution.status.completed:
        return {}
    stages = stages_of(case.lift_law)
    found = {key.name: value for key, value in run_quantities(solution, surge_frequency=surge_frequency, stages=stages).items()}
    if window is not None:
        found |= main_clash_quantities(reported_cycle(solution), window)
    found |= stress_quantities(with_stress(solution, case.require_spring()))
    return {name: float(found[name]) for name in RUN_HEADLINES if name in found}


def _rows(values: Mapping[str, Mapping[float | None, Mapping[str, float]]], elements: tuple[int, ...]) -> list[Uncertainty]:
    sizes = (1 / elements[0], 1 / elements[1], 1 / elements[2])
    rows = []
    for speed, base in values["mesh 1"].items():
        for name, value in base.items():

            def of(variant: str, speed: float | None = speed, name: str = name) -> float | None:
                return values[variant].get(speed, {}).get(name)

            middle, fine = of("mesh 2"), of("mesh 3")
            if middle is None or fine is None:
                continue
            mesh = grid_convergence((value, middle, fine), sizes)
            halved = of("half step")
            # Second order in the step: a quarter of its error is left after halving.
            step = 0.0 if halved is None or speed is None else TRUSTED * 4 / 3 * abs(value - halved)
            ranges = []
            for word in ("contact stiffness", "contact damping"):
                known = [value, *(other for n in (1, 2) if (other := of(f"{word} {n}")) is not None)]
                ranges.append((min(known), max(known)))
            rows.append(
                Uncertainty(name, speed, value, mesh.uncertainty + step, mesh.observed_order, mesh.extrapolated, step, ranges[0], ranges[1])
            )
    return rows
