"""Springs reduced from their rods beside those rods: both under the motion of the retainer that a run
found, over two revolutions. The error bar of such a run, at the cost of the rod alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicHermiteSpline

from valvetrain.cam.contract import LiftLaw
from valvetrain.integrate.contract import Cycles, RunOptions
from valvetrain.integrate.run import run as integrate
from valvetrain.integrate.train_channels import position_name
from valvetrain.quantities.signal import fine_series, low_pass
from valvetrain.runs.prepared import FAILURES, PreparedRun, prepare
from valvetrain.runs.workers import map_points
from valvetrain.solution.result import Solution
from valvetrain.solution.uncertainty import TOO_HARD, Uncertainty
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.problem import Member, Problem, Rest
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]
#: Word of the springs whose rod is at hand.
REDUCED = "reduced-rod"
#: Shares of the seat force below ``CUTOFF`` (Hz) from which a run says that its rod is to be taken: rms of
#: the difference over rms, peak over peak, minimum over the force as installed.
TOO_FAR, PEAK_TOO_FAR, MINIMUM_TOO_FAR, CUTOFF = 0.03, 0.01, 0.02, 20e3
#: Revolutions of both, the second compared.
REVOLUTIONS = 2


class RodDifference(NamedTuple):
    """How far springs are from their rods: ``rms``, ``peak`` and ``minimum`` of the seat force below 20 kHz
    as shares, and the difference of numbers (SI) by the name of their quantities.
    """

    rms: float
    peak: float
    minimum: float
    differences: Mapping[str, float]

    @property
    def too_far(self) -> str:
        """What of the seat force is too far from the rod's, and by which share; empty for nothing.

        >>> RodDifference(0.008, 0.09, 0.001, {}).too_far
        'peak 9 %'
        """
        found = (
            ("", self.rms, TOO_FAR),
            ("peak ", self.peak, PEAK_TOO_FAR),
            ("minimum ", self.minimum, MINIMUM_TOO_FAR),
        )
        return ", ".join(
            f"{name}{100 * share:.2g} %" for name, share, limit in found if share > limit
        )


@dataclass(frozen=True)
class _Recorded:
    """A recorded motion of the retainer as a lift law."""

    curve: CubicHermiteSpline

    continuity: int = 1
    joints: tuple[float, ...] = ()

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return np.asarray(self.curve(np.mod(cam_angle, 2 * np.pi), derivative))


def rod_difference(system: System, solution: Solution) -> RodDifference | None:
    """The springs of a finished run beside their rods; None where they are no reduced rods, or rub."""
    springs = system.springs
    reduced = [spring for spring in springs if isinstance(spring, ReducedRod)]
    if not reduced or len(reduced) < len(springs):
        return None
    return difference_from_rods(reduced, _motion(system, solution), solution.engine_speed / 2)


def difference_from_rods(
    reduced: Sequence[ReducedRod], law: LiftLaw, cam_speed: float
) -> RodDifference | None:
    """Reduced rods and their rods, both driven by ``law`` at a cam speed (rad/s); None where a run
    failed.
    """
    found = _forces(reduced, law, cam_speed)
    expected = _forces([spring.rod for spring in reduced], law, cam_speed)
    if found is None or expected is None:
        return None
    own, rods = found["below_20_khz"], expected["below_20_khz"]
    differences = {
        f"{kind}_{end}_force": pick(found[channel]) - pick(expected[channel])
        for end, channel in (("spring", "seat_force"), ("retainer", "retainer_force"))
        for kind, pick in (("peak", np.max), ("minimum", np.min))
    }
    differences["below_20_khz_peak_spring_force"] = np.max(own) - np.max(rods)
    installed = sum(spring.rod.installed.seat_force for spring in reduced)
    return RodDifference(
        float(np.sqrt(np.mean((own - rods) ** 2) / np.mean(rods**2))),
        float(abs(np.max(own) / np.max(rods) - 1)),
        float(abs(np.min(own) - np.min(rods)) / max(installed, 1e-12)),
        {name: float(value) for name, value in differences.items()},
    )


def _motion(system: System, solution: Solution) -> LiftLaw:
    """The retainer of the last revolution as a law over the cam angle."""
    if not isinstance(system, TrainSystem):
        assert isinstance(system, PrescribedSpring)
        return system.valve_lift
    parts, at = system.mechanism.coordinates, system.arrays.retainer
    cycle = solution.cycle
    place = np.asarray(cycle[position_name(parts[at], system.mechanism.valve)])
    rate = np.asarray(cycle["retainer_velocity"]) / (solution.engine_speed / 2)
    angle = np.asarray(cycle["cam_angle"])
    around = [np.append(values, values[0]) for values in (place, rate)]
    return _Recorded(CubicHermiteSpline(np.append(angle, angle[0] + 2 * np.pi), *around))


def _forces(
    springs: Sequence[SpringModel], law: LiftLaw, cam_speed: float
) -> dict[str, Array] | None:
    """End forces of all springs over the last revolution at even times, and the seat force below
    20 kHz; None of a run that failed.
    """
    grid = np.arange(0.0, 2 * np.pi / cam_speed, 2e-6)
    total = {name: np.zeros(len(grid)) for name in ("seat_force", "retainer_force")}
    for spring in springs:
        alone = PrescribedSpring((spring,), law)
        one = integrate(alone, cam_speed, Cycles(REVOLUTIONS), RunOptions(keep="ends"))
        if not one.status.completed:
            return None
        for name in total:
            time, _, values = fine_series(one, name)
            total[name] += np.interp(grid, time - time[0], values)
    return total | {"below_20_khz": low_pass(grid, total["seat_force"], CUTOFF)}


def rod_bars(
    problem: Problem,
    members: Sequence[Member],
    solutions: Sequence[Solution],
    names: Sequence[str],
    rest: Rest,
    workers: int,
) -> tuple[tuple[Uncertainty, ...], tuple[str, ...]]:
    """Rows of ``names`` of the runs of ``members``, reduced rods, beside their rods, and sentences
    on them.
    """
    ready = {member.label: prepare(problem, member, rest, "") for member in members}
    runs = [
        run for run in solutions if run.label in ready and run.status.completed and run.quantities
    ]
    if not runs:
        return (), ()
    found = map_points(
        _rod_difference, (ready, runs), range(len(runs)), workers, lost=lambda _: None
    )
    rows, far, measured = [], [], []
    for run, one in zip(runs, found, strict=True):
        if one is None:
            continue
        measured.append(one.rms)
        if one.too_far:
            far.append(f"{run.engine_speed * 30 / math.pi:.6g} rpm ({one.too_far})")
        for name in set(names) & set(one.differences) & set(run.quantities):
            value, bar = run.quantities[name], abs(one.differences[name])
            bar += run.quantities.get(f"cycle_scatter_{name}", 0.0)
            same = (value, value)
            rows.append(
                Uncertainty(
                    name, run.engine_speed, value, bar, None, value, 0.0, same, same, run.label
                )
            )
    if not measured:
        return (), ()
    said = [
        f"± of {REDUCED}: beside its rod under the motion found; the seat force differs by up to "
        f"{100 * max(measured):.2g} % (rms below 20 kHz)."
    ]
    if far:
        said.append(f"{TOO_HARD} for {REDUCED} at {', '.join(far)}: take finite-element there.")
    return tuple(rows), tuple(said)


def _rod_difference(
    shared: tuple[Mapping[str, PreparedRun], Sequence[Solution]], place: int
) -> RodDifference | None:
    ready, runs = shared
    system = ready[runs[place].label].system
    try:
        return None if system is None else rod_difference(system, runs[place])
    except FAILURES:
        return None
