"""All named quantities of runs, static curve and modes in one call."""

from __future__ import annotations

from collections.abc import Iterable

from valvetrain.quantities.collisions import collision_quantities, separation_angle
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.energy import energy_quantities
from valvetrain.quantities.filters import bandwidth_quantities
from valvetrain.quantities.main_clash import find_clash_window, main_clash_quantities
from valvetrain.quantities.nodes import (
    acceleration_quantities,
    displacement_quantities,
    velocity_quantities,
)
from valvetrain.quantities.stages import Stages, stage_quantities
from valvetrain.quantities.statics import modal_quantities, static_quantities
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.quantity import Quantity, named
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve


def run_quantities(solution: Solution, *, surge_frequency: float | None = None, stages: Stages | None = Stages()) -> dict[Quantity, float]:
    """Every quantity that one spring run supports (docs/quantities.md); SI, angles in cam rad.

    ``surge_frequency`` (Hz): first axial natural frequency, which tells separate collisions from one. What the run does not
    cover, because it lacks the channel or ended early, is absent; so is what speaks of stages where ``stages`` is None.
    """
    if len(solution.time) < 3:
        return {}
    cycle = reported_cycle(solution)
    separation = separation_angle(cycle, surge_frequency)
    found = stage_quantities(cycle, separation, stages)
    found |= displacement_quantities(cycle, stages)
    found |= velocity_quantities(cycle, stages)
    if cycle.whole:
        found |= acceleration_quantities(cycle, separation)
        found |= collision_quantities(cycle, separation, surge_frequency, stages)
        found |= bandwidth_quantities(cycle, stages)
        window = find_clash_window(cycle, surge_frequency, stages) if surge_frequency and solution.has("coil_gap") else None
        found |= main_clash_quantities(cycle, window) if window is not None else {}
    found |= energy_quantities(solution)
    return named(found, solution.engine_speed, solution.model)


def study_quantities(
    static_curve: StaticCurve | None, modal_result: ModalResult | None, solutions: Iterable[Solution], *,
    precompression: float, stages: Stages | None = Stages(),
) -> dict[Quantity, float]:  # fmt: skip
    """Quantities of a whole spring study; statics and modes carry no engine speed and no model."""
    found: dict[Quantity, float] = {}
    surge_frequency = None
    if static_curve is not None:
        found |= named(static_quantities(static_curve, precompression), None, "")
    if modal_result is not None:
        found |= named(modal_quantities(modal_result), None, "")
        surge_frequency = float(modal_result.axial_frequencies[0]) if modal_result.axial_modes else None
    for solution in solutions:
        found |= run_quantities(solution, surge_frequency=surge_frequency, stages=stages)
    return found
