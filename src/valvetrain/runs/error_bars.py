"""Error bars: numerical uncertainty by the grid convergence index, and the range over the contact
constants.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.stopping import PointsStopped, Stopped
from valvetrain.runs.workers import map_points
from valvetrain.solution.critical import DAMPING_FACTORS
from valvetrain.solution.display import Saveable, verdict_first
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.uncertainty import MIN_ORDER, Range, Uncertainty
from valvetrain.springs.modal_uniform import oscillating_modes
from valvetrain.system.problem import Member

#: Factors on the stiffness of contacts, of coils and of the parts of a train: nobody knows it better. Those on
#: damping are the ones of critical speeds.
STIFFNESS_FACTORS = (0.5, 2.0)
Numbers = Mapping[str, float]
#: Headline numbers of a spring under prescribed motion, those it has; the forces in the table of a source study follow them.
SPRING_HEADLINES = (
    "peak_spring_force", "minimum_spring_force", "raw_peak_spring_force",
    "main_clash_peak_force", "main_clash_below_5_khz_peak_force", "main_clash_cam_angle",
    "main_clash_impulse", "clash_energy", "largest_clash_impulse", "peak_clash_force", "surge_clash_peak_force", "peak_shear_stress",
    "outer_peak_shear_stress", "inner_peak_shear_stress",
)  # fmt: skip
#: Headline numbers of a train, those that a run has.
TRAIN_HEADLINES = (
    "peak_spring_force", "minimum_spring_force", "peak_retainer_force", "minimum_retainer_force", "surge_amplitude_force",
    "peak_cam_contact_force", "peak_tappet_contact_force", "peak_rocker_contact_force", "peak_valve_tip_contact_force",
    "peak_seat_contact_force", "nose_cam_contact_force", "minimum_cam_contact_force", "peak_valve_lift", "lift_loss_displacement",
    "seating_velocity", "seating_cam_angle", "bounce_count", "bounce_height", "loft_gap", "loss_of_contact_duration",
    "minimum_piston_clearance_gap", "cycle_work_energy", "peak_valve_acceleration", "clash_count", "clash_energy", "largest_clash_impulse",
)  # fmt: skip
#: Values below this (SI) are rounding errors: the surge of a spring without mass.
ROUNDING = 1e-9
#: Options of spring models that set how finely a spring is divided.
DIVISIONS = ("elements", "masses_per_coil", "modes", "elements_per_coil", "bricks_per_coil")
#: The variant with the mesh and step of the case.
OWN = "mesh 1"


@dataclass(frozen=True)
class UncertaintyStudy(Saveable):
    """Error bars of a case, the meshes behind them (none: a train) and every number by variant,
    speed and quantity.

    ``stiffness_factors``, ``damping_factors``: ranges of the contact constants. ``runs`` were
    planned, ``finished`` of them ended; ``failures`` has a sentence for each that failed.
    """

    record: CaseRecord
    elements_per_coil: tuple[int, ...]
    rows: tuple[Uncertainty, ...]
    values: Mapping[str, Mapping[float | None, Numbers]]
    failures: tuple[str, ...] = ()
    stiffness_factors: Range = STIFFNESS_FACTORS
    damping_factors: Range = DAMPING_FACTORS
    runs: int = 0
    finished: int = 0

    def __repr__(self) -> str:
        failed = f", {len(self.failures)} failed" if self.failures else ""
        ended = f"{self.finished} of {self.runs} runs{failed}"
        return verdict_first(
            self, [f"UncertaintyStudy of {self.record.name}: {len(self.rows)} numbers, {ended}"]
        )


#: Safety factors of a series with a trusted order and of one without.
TRUSTED, DOUBTFUL = 1.25, 3.0
#: Order of the rod and its integrator, taken where a series seems to converge faster; bound of
#: the search.
DECLARED_ORDER, MAX_ORDER = 2.0, 20.0


@dataclass(frozen=True, slots=True)
class GridConvergence:
    """Convergence of one quantity on three meshes.

    ``observed_order``: None where the series is not monotonic. ``extrapolated``: Richardson value,
    or the finest one where the order is not trusted. ``uncertainty`` of the coarsest value,
    ``finest_index`` that of the finest (same unit).
    """

    observed_order: float | None
    trusted: bool
    extrapolated: float
    uncertainty: float
    finest_index: float


def observed_order(
    values: tuple[float, float, float], sizes: tuple[float, float, float]
) -> float | None:
    """Order p of values on element ``sizes``, both coarse to fine; None for a series that is
    constant or not monotonic.

    Solves p ln r21 = |ln|e32/e21| + q(p)| of Celik et al. by bisection, as their fixed-point
    iteration need not converge.
    """
    coarse, middle, fine = values
    far, near = coarse - middle, middle - fine
    first, second = sizes[1] / sizes[2], sizes[0] / sizes[1]
    if not (first > 1 and second > 1):
        raise InputError("sizes of three meshes must fall from coarse to fine; sort them")
    if near == 0 or far == 0 or far * near < 0:
        return None

    def excess(order: float) -> float:
        """Ratio of the two steps of a series of this order, less that of the values; rises with the
        order.
        """
        if abs(order) < 1e-9:
            return float(np.log(second) / np.log(first)) - far / near
        return float(first**order * (second**order - 1) / (first**order - 1)) - far / near

    low, high = -MAX_ORDER, MAX_ORDER
    if not excess(low) < 0 < excess(high):
        return low if excess(low) >= 0 else high
    for _ in range(100):
        middle_order = (low + high) / 2
        low, high = (middle_order, high) if excess(middle_order) < 0 else (low, middle_order)
    return (low + high) / 2


def grid_convergence(
    values: tuple[float, float, float], sizes: tuple[float, float, float]
) -> GridConvergence:
    """Numerical uncertainty of the coarsest of three values; element ``sizes``, coarse to fine.

    Raises :class:`InputError` when the sizes do not fall.
    """
    coarse, middle, fine = values
    order = observed_order(values, sizes)
    spread = max(values) - min(values)
    if order is None or order < MIN_ORDER:
        # Data range over the range of sizes, so that a wide set of meshes does not punish itself.
        uncertainty = DOUBTFUL * spread / (sizes[0] / sizes[2] - 1) if spread else 0.0
        return GridConvergence(
            order, False, fine, max(uncertainty, spread), max(uncertainty, spread)
        )
    used = min(order, DECLARED_ORDER)
    step = (middle - fine) / ((sizes[1] / sizes[2]) ** used - 1)
    extrapolated = fine - step
    return GridConvergence(
        order, True, extrapolated, TRUSTED * abs(coarse - extrapolated), TRUSTED * abs(step)
    )


def two_grids(
    value: float,
    finer: float,
    ratio: float,
    order: float = DECLARED_ORDER,
    safety: float = DOUBTFUL,
) -> GridConvergence:
    """Uncertainty of ``value`` from one grid ``ratio`` times as fine, with an assumed ``order`` and
    a ``safety`` factor, Roache's three.
    """
    finest = safety * abs(value - finer) / (ratio**order - 1)
    return GridConvergence(None, False, finer, finest * ratio**order, finest)


def grid_bar(
    value: float, grids: Sequence[tuple[float, float]], order: float, of_model: bool = False
) -> GridConvergence:
    """Uncertainty of ``value`` from (fineness, value) of further ``grids``, one at least; its own has fineness one.

    Of three grids the order that they show counts, up to ``order``, and their spread at least; where they show none,
    three times their spread over that of their sizes. Of two ``order`` is assumed. ``of_model``: the grids are those of
    another model, which ``value`` is judged by.
    """
    every = sorted(grids if of_model else [*grids, (1.0, value)])
    levels, values = [level for level, _ in every], [one for _, one in every]
    observed = None
    if len(every) == 3:
        coarse, middle, fine = every
        observed = observed_order(
            (coarse[1], middle[1], fine[1]), (1 / coarse[0], 1 / middle[0], 1 / fine[0])
        )
    spread = max(value, *values) - min(value, *values)
    trusted = observed is not None and observed >= MIN_ORDER
    if len(every) == 3 and not trusted:
        limit = values[-1]
        size = max(DOUBTFUL / (levels[-1] / levels[0] - 1), TRUSTED) * spread
    else:
        limit = values[-1]
        if len(every) > 1:
            used = order if observed is None else min(observed, order)
            limit += (values[-1] - values[-2]) / ((levels[-1] / levels[-2]) ** used - 1)
        size = (TRUSTED if trusted else DOUBTFUL) * abs(value - limit)
    size = max(size, spread) if len(every) == 3 else size
    return GridConvergence(observed, trusted, limit, size, size)


def convergence(
    value: float, finer: Sequence[float | None], fineness: Sequence[float]
) -> GridConvergence | None:
    """Uncertainty of ``value`` from those of two ``finer`` grids that have one; None where neither
    has.

    ``fineness`` of the three grids, such as elements per coil.
    """
    pairs = zip(finer, fineness[1:], strict=True)
    known = [(other, level / fineness[0]) for other, level in pairs if other is not None]
    if len(known) == 2:
        coarse, middle, fine = fineness
        return grid_convergence(
            (value, known[0][0], known[1][0]), (1 / coarse, 1 / middle, 1 / fine)
        )
    return two_grids(value, *known[0]) if known else None


def contact_ranges(value: float, of: Callable[[str], float | None]) -> tuple[Range, Range]:
    """Least and largest value over the variants of contact stiffness and of damping, ``value`` included."""

    def span(constant: str) -> Range:
        others = (of(f"{constant} {n}") for n in (1, 2))
        values = [value, *(other for other in others if other is not None)]
        return min(values), max(values)

    return span("contact stiffness"), span("damping")


def stiffened(spring: InstalledSpring, factor: float) -> InstalledSpring:
    """A spring whose coils are ``factor`` times as stiff where they touch."""
    contact = replace(spring.contact, stiffness=factor * spring.contact.stiffness)
    return replace(spring, contact=contact)


def damped(spring: InstalledSpring, factor: float) -> InstalledSpring:
    """A spring whose wire and whose coil contacts are damped ``factor`` times as much."""
    coils = replace(spring.contact, damping_time=factor * spring.contact.damping_time)
    return replace(wire_damped(spring, factor), contact=coils)


def wire_damped(spring: InstalledSpring, factor: float) -> InstalledSpring:
    """A spring whose wire is damped ``factor`` times as much."""
    damping = spring.damping
    mass, stiffness = factor * damping.mass_damping, factor * damping.stiffness_damping
    changed = damping.replace(mass_damping=mass, stiffness_damping=stiffness)
    return replace(spring, damping=changed)


def divided(member: Member, spring: InstalledSpring, factor: float) -> InstalledSpring:
    """A spring divided ``factor`` times as finely, by the options that its kind of data uses; modes that damping keeps from
    swinging are no finer division.
    """
    model = member.model
    unused = model.options.card_only if spring.card is None else model.options.wire_only
    options = model.read_options(spring.options_of(model.word)).model_dump()
    finer = {
        key: round(factor * options[key])
        for key in DIVISIONS
        if key not in unused and options.get(key)
    }
    if "modes" in finer:
        finer["modes"] = oscillating_modes(spring, finer["modes"])
        if finer["modes"] <= min(options["modes"], oscillating_modes(spring, options["modes"])):
            del finer["modes"]
    return spring.with_options(model.word, **finer) if finer else spring


class RefinementStopped(Stopped):
    """A refinement was stopped; ``study`` holds the complete error bars, and the numbers of every
    finished run.
    """

    def __init__(self, study: UncertaintyStudy) -> None:
        super().__init__("stopped")
        self.study = study


class Stages:
    """Stages of independent runs; once one is stopped, its finished runs are returned and no later
    stage starts.
    """

    def __init__(self) -> None:
        self.stopped = False

    def map(self, *arguments: Any, **options: Any) -> dict[int, Any]:
        """:func:`valvetrain.runs.workers.map_points`, its results by index."""
        if self.stopped:
            return {}
        try:
            return dict(enumerate(map_points(*arguments, **options)))
        except PointsStopped as stop:
            self.stopped = True
            return stop.results

    def closed(self, study: UncertaintyStudy) -> UncertaintyStudy:
        """The study. Raises :class:`RefinementStopped` with it where a stage was stopped."""
        if self.stopped:
            raise RefinementStopped(study)
        return study
