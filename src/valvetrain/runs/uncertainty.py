"""Numbers with error bars: meshes and steps refined, contact constants varied, for the headline
numbers of springs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.clash import ClashWindow, find_clash_window, main_clash_quantities
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.statics import modal_quantities
from valvetrain.runs.cost import Limits
from valvetrain.runs.engine import Progress, map_points
from valvetrain.runs.error_bars import (
    DAMPING_FACTORS,
    STIFFNESS_FACTORS,
    TRUSTED,
    GridConvergence,
    Numbers,
    Uncertainty,
    UncertaintyStudy,
    grid_convergence,
    two_grids,
)
from valvetrain.runs.notes import refuse_implausible, refuse_speeds
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    integrate_point,
    judge,
    prepare,
    provenance_of,
)
from valvetrain.runs.statics import MODES
from valvetrain.runs.stopping import PointsStopped, RefinementStopped
from valvetrain.solution.definition import pattern_of, tables
from valvetrain.solution.partial_failures import reason
from valvetrain.solution.result import Solution
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_statics import modal_result
from valvetrain.system.build import build
from valvetrain.system.prescribed import names_of
from valvetrain.system.problem import Problem


class Stages:
    """Independent runs of several stages; once one of them is stopped, what it has is handed back
    and no other begins.
    """

    def __init__(self) -> None:
        self.stopped = False

    def map(self, *given: Any, **options: Any) -> dict[int, Any]:
        """:func:`valvetrain.runs.engine.map_points`, its results by place."""
        if self.stopped:
            return {}
        try:
            return dict(enumerate(map_points(*given, **options)))
        except PointsStopped as cut:
            self.stopped = True
            return cut.results

    def closed(self, study: UncertaintyStudy) -> UncertaintyStudy:
        """The study. Raises :class:`RefinementStopped` with it where a stage was stopped."""
        if self.stopped:
            raise RefinementStopped(study)
        return study


#: Elements per coil over those of the case.
REFINEMENTS = (1.0, 1.5, 2.25)
#: Headline numbers of a run; those that a case does not have are left out. The forces of a source
#: study's own table follow them.
HEADLINES = (
    "peak_spring_force", "minimum_spring_force", "below_20_khz_peak_spring_force", "below_10_khz_peak_spring_force",
    "main_clash_peak_force", "main_clash_below_20_khz_peak_force", "main_clash_below_10_khz_peak_force", "main_clash_cam_angle",
    "main_clash_impulse", "peak_shear_stress", "outer_peak_shear_stress", "inner_peak_shear_stress",
)  # fmt: skip

#: The case's own mesh.
OWN = "mesh 1"


def uncertainty_study(
    case: Case,
    engine_speeds: Sequence[float] | None = None,
    *,
    refinements: Sequence[float] = REFINEMENTS,
    workers: int = 2,
    progress: Progress | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> UncertaintyStudy:
    """Refine meshes and step, vary the contact, and state the uncertainty of each headline number.

    ``engine_speeds`` in rad/s of the crank (None: the case's own). Runs go over ``workers``
    threads. A variant that fails is one of the
    ``failures``; of two meshes the declared order is taken. Raises :class:`InputError` for a
    valvetrain, a case without wire or lift law,
    other than three meshes, and what :func:`valvetrain.runs.run.run_study` refuses;
    :class:`RefinementStopped` when it is stopped.
    """
    if len(refinements) != 3 or list(refinements) != sorted(set(refinements)):
        raise InputError(
            "three meshes are needed, coarse to fine, such as 1, 1.5 and 2.25 times the elements per coil"
        )
    if case.train is not None:
        raise InputError(
            f"case '{case.name}' is a valvetrain; refine it with valvetrain.runs.refine.refined"
        )
    if (
        case.lift_law is None
        or not case.springs
        or any(spring.wire is None for spring in case.springs)
    ):
        raise InputError(
            f"case '{case.name}' needs a [spring] with its wire and a [lift_law] to be refined; give it both"
        )
    problem = build(case, spring_models=("finite-element",))
    speeds = (
        problem.engine_speeds
        if engine_speeds is None
        else tuple(float(speed) for speed in engine_speeds)
    )
    refuse_speeds(problem, speeds)
    if not implausible:
        refuse_implausible(problem, speeds)
    samples = round(2 * np.pi / problem.output_step)
    plan = Plan(
        samples=samples, cycles=problem.cycles, most_bytes=limits.bytes, implausible=implausible
    )
    # the case's own mesh comes first: its surge frequency and its clash windows name the numbers of
    # every variant
    base, still = _prepare((problem, ()), problem.members[0].springs)
    changed, failures, stages = _variants(base, refinements), list[str](), Stages()
    surge = base.frame.surge_frequencies
    shown = _part(progress, 0.0, 0.05, "statics and modes")
    ready = stages.map(
        _prepare_or_say, (problem, surge), tuple(changed.items()), workers, tell=shown
    )
    failures += [words for _, _, words in ready.values() if words]
    names = tuple(changed)
    made = {
        names[place]: (one, at_rest)
        for place, (one, at_rest, _) in sorted(ready.items())
        if one is not None
    }
    variants = {OWN: (base, still)} | made
    points = [(base, speed) for speed in speeds]
    raw = stages.map(
        _run, (problem, plan), points, workers, tell=_part(progress, 0.05, 0.1, "own mesh")
    )
    own = {speeds[place]: solution for place, solution in raw.items()}
    windows = {speed: _window(base, solution) for speed, solution in own.items()}

    def one(shared: tuple[Problem, Plan], job: tuple[float, str]) -> tuple[Numbers, str]:
        speed, name = job
        place = f"{name} at {speed * 30 / np.pi:.0f} rpm"
        try:
            solution = own[speed] if name == OWN else _run(shared, (variants[name][0], speed))
            failed = "" if solution.status.completed else f"{place}: {solution.status.sentence()}"
            return _moving(solution, windows[speed], problem.record.study), failed
        except FAILURES as error:
            return {}, f"{place}: {reason(error)}"

    jobs = [(speed, name) for speed in speeds for name in variants]
    moving = stages.map(
        one, (problem, plan), jobs, workers, tell=_part(progress, 0.1, 1.0, "variants")
    )
    values: dict[str, dict[float | None, Numbers]] = {
        name: {None: numbers} for name, (_, numbers) in variants.items()
    }
    for place, (numbers, words) in moving.items():
        values[jobs[place][1]][jobs[place][0]] = numbers
        failures += [words] if words else []
    if not moving:  # stopped before: the own mesh is there
        values[OWN] |= {
            speed: _moving(solution, windows[speed], problem.record.study)
            for speed, solution in own.items()
        }
    missing = (
        {jobs[place][0] for place in range(len(jobs)) if place not in moving}
        if raw
        else set(speeds)
    )
    whole = [
        speed
        for speed in (None, *speeds)
        if speed not in missing and (speed is not None or len(ready) == len(changed))
    ]
    elements = _meshes(base, refinements)
    return stages.closed(
        UncertaintyStudy(
            problem.record,
            elements,
            tuple(_rows(values, elements, whole)),
            values,
            tuple(failures),
            runs=len(speeds) * (1 + len(changed)),
            finished=len(moving) or len(own),
        )
    )


def _part(
    progress: Progress | None, begin: float, end: float, words: str
) -> Callable[[int, int], None]:
    """Reports a stage of the study as its share of the whole."""

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress(begin + (end - begin) * done / total, f"{words}, {done} of {total}")

    return tell


def _prepare(
    shared: tuple[Problem, tuple[float, ...]], springs: tuple[InstalledSpring, ...]
) -> tuple[PreparedRun, Numbers]:
    """The member with other springs, ready to run and named by the surge frequencies given (none:
    its own), and its numbers at rest.
    """
    problem, surge = shared
    one = prepare(problem, replace(problem.members[0], springs=springs), {}, problem.record.study)
    rods = _rods(one)
    if one.refusal or len(rods) != len(springs):
        raise InputError(
            one.refusal
            or "springs that rub on each other cannot be refined; leave the rubbing out of the case"
        )
    found = [
        {"preload": float(rod.installed.retainer_force)}
        | modal_quantities(modal_result(rod, MODES))
        for rod in rods
    ]
    surge = surge or tuple(
        numbers["mode_1_frequency"] for numbers in found if "mode_1_frequency" in numbers
    )
    names = [f"{name}_" if len(rods) > 1 else "" for name in names_of(rods)]
    still = {
        name + key: value
        for name, numbers in zip(names, found, strict=True)
        for key, value in numbers.items()
    }
    return replace(one, frame=replace(one.frame, surge_frequencies=surge)), still


def _prepare_or_say(
    shared: tuple[Problem, tuple[float, ...]], variant: tuple[str, tuple[InstalledSpring, ...]]
) -> tuple[PreparedRun | None, Numbers, str]:
    """A named variant as :func:`_prepare` makes it, or why it cannot be made."""
    try:
        return (*_prepare(shared, variant[1]), "")
    except FAILURES as error:
        return None, {}, f"{variant[0]}: {reason(error)}"


def _rods(ready: PreparedRun) -> tuple[FiniteElementRod, ...]:
    return (
        tuple(spring for spring in ready.system.springs if isinstance(spring, FiniteElementRod))
        if ready.system is not None
        else ()
    )


def _run(shared: tuple[Problem, Plan], point: tuple[PreparedRun, float]) -> Solution:
    (problem, plan), (ready, speed) = shared, point
    return judge(
        ready,
        integrate_point(ready, speed, plan, provenance_of(problem, ready.member, speed, "")),
        plan,
        {},
    )


def _variants(
    base: PreparedRun, refinements: Sequence[float]
) -> dict[str, tuple[InstalledSpring, ...]]:
    """Installed springs of every variant but the case's own mesh."""
    springs, rods = base.member.springs, _rods(base)

    def refined(ratio: float) -> tuple[InstalledSpring, ...]:
        pairs = zip(springs, rods, strict=True)
        return tuple(
            one.with_options(
                "finite-element", elements_per_coil=round(rod.elements_per_coil * ratio)
            )
            for one, rod in pairs
        )

    def contacts(stiffness: float, damping: float) -> tuple[InstalledSpring, ...]:
        return tuple(
            replace(
                one,
                contact=replace(
                    one.contact,
                    stiffness=stiffness * one.contact.stiffness,
                    damping_time=damping * one.contact.damping_time,
                ),
            )
            for one in springs
        )

    halves = (0.5 * (rod.time_step or rod.stable_time_step()) for rod in rods)
    return (
        {f"mesh {n}": refined(ratio) for n, ratio in enumerate(refinements, start=1) if n > 1}
        | {
            "half step": tuple(
                one.with_options("finite-element", time_step=half)
                for one, half in zip(springs, halves, strict=True)
            )
        }
        | {
            f"contact stiffness {n}": contacts(factor, 1.0)
            for n, factor in enumerate(STIFFNESS_FACTORS, start=1)
        }
        | {
            f"contact damping {n}": contacts(1.0, factor)
            for n, factor in enumerate(DAMPING_FACTORS, start=1)
        }
    )


def _meshes(base: PreparedRun, refinements: Sequence[float]) -> tuple[int, ...]:
    """Elements per coil of the case's own mesh and of the finer ones."""
    own = _rods(base)[0].elements_per_coil
    return (own, *(round(own * ratio) for ratio in refinements[1:]))


def _window(base: PreparedRun, solution: Solution) -> ClashWindow | None:
    """The main clash of the case's own mesh: all variants are read within its window."""
    surge, event = base.frame.surge_frequency, base.frame.lift_event
    if surge is None or event is None or len(solution.time) < 3:
        return None
    return find_clash_window(reported_cycle(solution), surge, event)


def _moving(solution: Solution, window: ClashWindow | None, study: str) -> dict[str, float]:
    if not solution.status.completed:
        return {}
    found = dict(solution.quantities)
    if window is not None:
        found |= main_clash_quantities(reported_cycle(solution), window)
    patterns = [
        pattern_of(row.name) for row in tables().get(study, ()) if row.name.endswith("_force")
    ]
    sourced = (name for name in found if any(pattern.fullmatch(name) for pattern in patterns))
    return {
        name: float(found[name]) for name in dict.fromkeys((*HEADLINES, *sourced)) if name in found
    }


def _rows(
    values: Mapping[str, Mapping[float | None, Numbers]],
    elements: tuple[int, ...],
    speeds: Sequence[float | None],
) -> list[Uncertainty]:
    """Numbers with bars at ``speeds`` (None: statics and modes); none of a number without a finer
    mesh or the halved step.
    """
    rows = []
    for speed in speeds:
        for name, value in values[OWN].get(speed, {}).items():

            def of(variant: str, speed: float | None = speed, name: str = name) -> float | None:
                return values.get(variant, {}).get(speed, {}).get(name)

            halved = of("half step")
            mesh = _mesh_part((value, of("mesh 2"), of("mesh 3")), elements)
            if mesh is None or (halved is None and speed is not None):
                continue
            # Second order in the step: a quarter of its error is left after halving.
            step = 0.0 if halved is None or speed is None else TRUSTED * 4 / 3 * abs(value - halved)
            ranges = []
            for word in ("contact stiffness", "contact damping"):
                known = [
                    value,
                    *(other for n in (1, 2) if (other := of(f"{word} {n}")) is not None),
                ]
                ranges.append((min(known), max(known)))
            rows.append(
                Uncertainty(
                    name,
                    speed,
                    value,
                    mesh.uncertainty + step,
                    mesh.observed_order,
                    mesh.extrapolated,
                    step,
                    ranges[0],
                    ranges[1],
                )
            )
    return rows


def _mesh_part(
    values: tuple[float, float | None, float | None], elements: tuple[int, ...]
) -> GridConvergence | None:
    """What the mesh contributes, from three meshes or, where one of the finer two failed, from two;
    None where both did.
    """
    value, middle, fine = values
    if middle is not None and fine is not None:
        return grid_convergence(
            (value, middle, fine), (1 / elements[0], 1 / elements[1], 1 / elements[2])
        )
    finer, ratio = (
        (fine, elements[2] / elements[0]) if middle is None else (middle, elements[1] / elements[0])
    )
    return None if finer is None else two_grids(value, finer, ratio)
