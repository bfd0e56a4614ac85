"""Springs reduced from their rods, compared with those rods: both under the motion of the retainer that a run
found, over two revolutions.
"""

from __future__ import annotations

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
from valvetrain.quantities.clash import clash_events, clash_numbers
from valvetrain.quantities.signal import fine_series, low_pass
from valvetrain.solution.force_peak import FORCE_BANDWIDTH, bandwidth_of, filtered_cycle
from valvetrain.solution.result import Solution
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]
#: Shares of the seat force below ``CUTOFF`` (Hz) from which a run says that its rod is to be taken: rms of
#: the difference over rms, peak over peak, minimum over the force as installed.
TOO_FAR, PEAK_TOO_FAR, MINIMUM_TOO_FAR, CUTOFF = 0.03, 0.01, 0.02, 20e3
#: Revolutions of both, the second compared.
REVOLUTIONS = 2
#: Spacing (s) of the end forces that are compared.
STEP = 2e-6


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
    """The springs of a finished run compared with their rods; None where they are no reduced rods, or rub."""
    springs = system.springs
    reduced = [spring for spring in springs if isinstance(spring, ReducedRod)]
    if not reduced or len(reduced) < len(springs):
        return None
    bandwidth = bandwidth_of(solution.provenance)
    motion = _motion(system, solution)
    return difference_from_rods(reduced, motion, solution.engine_speed / 2, bandwidth)


def difference_from_rods(
    reduced: Sequence[ReducedRod],
    law: LiftLaw,
    cam_speed: float,
    bandwidth: float = FORCE_BANDWIDTH,
) -> RodDifference | None:
    """Reduced rods and their rods, both driven by ``law`` at a cam speed (rad/s), peaks below
    ``bandwidth`` (Hz); None where a run failed.
    """
    found = _last_revolution(reduced, law, cam_speed)
    expected = _last_revolution([spring.rod for spring in reduced], law, cam_speed)
    if found is None or expected is None:
        return None
    own, rods = (low_pass(one.time, one.seat_force, CUTOFF) for one in (found, expected))
    numbers, others = (
        {
            f"{kind}_{end}_force": float(pick(force))
            for end, force in (("spring", one.seat_force), ("retainer", one.retainer_force))
            for kind, pick in (
                ("raw_peak", np.max),
                ("minimum", np.min),
                ("peak", lambda force: filtered_cycle(force, STEP, bandwidth).max()),
            )
        }
        | one.clashes
        for one in (found, expected)
    )
    installed = sum(spring.rod.installed.seat_force for spring in reduced)
    return RodDifference(
        float(np.sqrt(np.mean((own - rods) ** 2) / np.mean(rods**2))),
        float(abs(np.max(own) / np.max(rods) - 1)),
        float(abs(np.min(own) - np.min(rods)) / max(installed, 1e-12)),
        {name: value - others[name] for name, value in numbers.items() if name in others},
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


class _LastRevolution(NamedTuple):
    """End forces (N) of all springs at even times (s) of a last revolution, and numbers of their clashes."""

    time: Array
    seat_force: Array
    retainer_force: Array
    clashes: dict[str, float]


def _last_revolution(
    springs: Sequence[SpringModel], law: LiftLaw, cam_speed: float
) -> _LastRevolution | None:
    """The last revolution of springs that are driven side by side; None of a run that failed."""
    grid = np.arange(0.0, 2 * np.pi / cam_speed, STEP)
    forces, clashes = np.zeros((2, len(grid))), []
    for spring in springs:
        alone = PrescribedSpring((spring,), law)
        one = integrate(alone, cam_speed, Cycles(REVOLUTIONS), RunOptions(keep="ends"))
        if not one.status.completed:
            return None
        for total, name in zip(forces, ("seat_force", "retainer_force"), strict=True):
            time, _, values = fine_series(one, name)
            total += np.interp(grid, time - time[0], values)
        begun = float(one.cam_angle[-1]) - 2 * np.pi
        late = tuple(event for event in clash_events(one) if event.cam_angle >= begun)
        clashes.append(clash_numbers(one, late))
    names = {name for found in clashes for name in found}
    joined = {
        name: (sum if name == "clash_energy" else max)(found.get(name, 0.0) for found in clashes)
        for name in names
    }
    return _LastRevolution(grid, forces[0], forces[1], joined)
