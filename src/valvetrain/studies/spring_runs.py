"""Single runs of a spring case: static curve, modes, transient by the finite-element rod."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.cam.build import build_lift_law
from valvetrain.cam.contract import LiftLaw
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.parameters.case import Case
from valvetrain.quantities.clash import clash_events
from valvetrain.quantities.stress import EQUIVALENT, SHEAR, StaticStress
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import interpolation, pair_values, rod_channels, static_section_loads, wire_points
from valvetrain.springs.stress import wire_stress

Array = NDArray[np.float64]

#: A force below this share of the curve's largest is what rounding leaves of zero, as in the free state.
ROUND_OFF_SHARE = 1e-11


def retainer_motion(law: LiftLaw, precompression: float, cam_speed: float) -> Callable[[Array], Array]:
    """Retainer displacement (m from the free state) over time (s) at ``cam_speed`` (rad/s)."""
    return lambda time: precompression + law.lift(cam_speed * np.asarray(time))


def static_curve(
    model: FiniteElementRod, largest_compression: float, steps: int = 64, visit: Callable[[Equilibrium], None] | None = None
) -> StaticCurve:
    """Static curve (SI) from the free state to ``largest_compression`` (m) in even steps; ends early with a status when stuck.

    ``visit`` is told each equilibrium as it is found.
    """
    compressions = np.linspace(0.0, largest_compression, steps + 1)
    start = model.statics.solve(free_state(model.mesh), 0.0)
    path = [start, *compress(model.statics, compressions[1:].tolist(), visit=visit)]
    reached = [point for point in path if point.converged]
    status = COMPLETED
    if len(reached) < len(path):
        stuck = path[-1].state.compression
        status = Status(
            "not-converged", f"no equilibrium beyond {reached[-1].state.compression * 1e3:.3f} mm compression", 0.0,
            f"{stuck * 1e3:.3f} mm", "the coils are solid or the spring buckles; compress less or refine the mesh",
        )  # fmt: skip
    return _static_result(model, reached, status)


def static_stress(model: FiniteElementRod, path: Sequence[Equilibrium]) -> StaticStress | None:
    """Stress at the inner fibre of the equilibria found; None when there are fewer than two."""
    states = [point.state for point in path if point.converged]
    if len(states) < 2:
        return None
    coil = wire_points(model.definition.total_coils)
    stress = wire_stress(static_section_loads(model, states), model.definition, coil)
    return StaticStress(np.array([state.compression for state in states]), coil, stress[SHEAR], stress[EQUIVALENT])


def _static_result(model: FiniteElementRod, path: list[Equilibrium], status: Status) -> StaticCurve:
    compression = np.array([point.state.compression for point in path])
    force = np.array([point.retainer_force for point in path])
    force[np.abs(force) < ROUND_OFF_SHARE * np.max(np.abs(force))] = 0.0
    coil = wire_points(model.definition.total_coils)
    heights = np.stack([point.state.position[:, 2] for point in path]) @ interpolation(model.mesh, coil).T
    gaps = np.stack([model.statics.gaps(point.state.position) for point in path])
    upper, gap, pressed = pair_values(model, gaps)
    return StaticCurve(
        compression=compression, force=force, stiffness=np.gradient(force, compression) if len(path) > 2 else np.full(len(path), np.nan),
        coil_gap=gap, coil_contact_force=pressed, upper_coil=upper,
        axial_position=heights - model.definition.lower_seat_height, coil_number=coil, status=status,
    )  # fmt: skip


def modal_result(model: FiniteElementRod, count: int = 24) -> ModalResult:
    """Modes about the installed state with both ends held and touching coils kept together."""
    modes = natural_modes(model.statics, model.installed.state, count)
    coil = wire_points(model.definition.total_coils)
    shape = np.einsum("mvc,pv->mpc", modes.shape, interpolation(model.mesh, coil))
    largest = np.abs(shape).max(axis=(1, 2), keepdims=True)
    return ModalResult(
        compression=model.precompression, natural_frequency=modes.natural_frequency, shape=shape / np.where(largest > 0, largest, 1.0),
        coil_number=coil, axial_transmission=modes.axial_transmission, axial_modes=tuple(modes.axial_modes(3).tolist()),
    )  # fmt: skip


def integrate_case(model: FiniteElementRod, law: LiftLaw, engine_speed: float, cycles: int, output_step: float) -> RodTransient:
    """March ``cycles`` cam turns from the installed state; the last turn is kept (``engine_speed`` rad/s, ``output_step`` cam rad)."""
    cam_speed = engine_speed / 2
    per_turn = max(8, round(2 * np.pi / output_step))
    return simulate(
        model.mesh, model.installed.state, retainer_motion(law, model.precompression, cam_speed), 2 * np.pi / per_turn / cam_speed,
        cycles * per_turn, model.dynamics, model.time_step, discard=(cycles - 1) * per_turn,
    )  # fmt: skip


def run_finite_element(case: Case, model: FiniteElementRod, engine_speed: float, provenance: Provenance) -> Solution:
    """Transient of the finite-element rod over the case's cycles; the last cycle is the result.

    A run that diverges is repeated once with half the step; when that fails too, what was computed is returned with a status.
    """
    law = build_lift_law(case.lift_law)
    run = integrate_case(model, law, engine_speed, case.operation.cycles, case.rod.output_step)
    retried = not run.completed
    if retried:
        from dataclasses import replace

        model = replace(model, time_step=run.time_step / 2)
        run = integrate_case(model, law, engine_speed, case.operation.cycles, case.rod.output_step)
    channels = rod_channels(model, run, engine_speed / 2)
    statistics: dict[str, float | int | str | bool] = {
        "time_step": run.time_step, "steps": run.steps, "elements": model.mesh.elements, "largest_velocity": run.fastest,
        "step_was_halved": retried,
    }  # fmt: skip
    status = COMPLETED if run.completed else _diverged(run, engine_speed)
    solution = Solution(channels, (), status, statistics, provenance)
    return Solution(channels, clash_events(solution), status, statistics, provenance)


def _diverged(run: RodTransient, engine_speed: float) -> Status:
    time = run.steps_done * run.time_step
    turns, part = divmod(engine_speed / 2 * time / (2 * np.pi), 1.0)
    return Status(
        "diverged", f"the wire's velocity grew without bound at {360 * part:.1f} cam degrees of turn {int(turns) + 1}", time,
        "finite-element rod", "give a smaller time_step or contact_stiffness, or check the lift law for jumps",
    )  # fmt: skip
