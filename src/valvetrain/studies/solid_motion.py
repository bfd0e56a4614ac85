"""A short ride on the lift law by solid finite elements and by the rod, started alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from valvetrain.cam.build import build_lift_law
from valvetrain.cosserat.transient import simulate
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.springs.finite_element import FiniteElementRod

Array = NDArray[np.float64]

#: A ride starts at rest: the lift (m) and the retainer velocity (m/s) that count as none.
REST_LIFT, REST_VELOCITY = 1e-5, 0.02
WHERE = "--solid-motion"


def check_motion(case: Case, ride: tuple[float, float], engine_speed: float) -> None:
    """Raise :class:`InputError` for a case without a lift law, an empty ride (cam rad) or one that starts in motion."""
    if case.lift_law is None:
        raise InputError(f"case '{case.name}' has no lift law to ride on; add a [lift_law] table", WHERE)
    if not engine_speed > 0:
        raise InputError("a ride needs one engine speed; add such as --engine-speed '4200 rpm'", WHERE)
    first, last = ride
    if not 0 < last - first <= 2 * np.pi:
        raise InputError("the last cam angle must lie beyond the first, by one turn at most; write such as '85:105 deg'", WHERE)
    law, cam_angle = build_lift_law(case.lift_law), np.radians(np.arange(0.0, 360.0))
    rests = (np.abs(law.lift(cam_angle)) <= REST_LIFT) & (np.abs(law.lift(cam_angle, 1)) * engine_speed / 2 <= REST_VELOCITY)
    start = float(law.lift(first)), float(law.lift(first, 1)) * engine_speed / 2
    if abs(start[0]) > REST_LIFT or abs(start[1]) > REST_VELOCITY:
        before = np.degrees(cam_angle[rests & (cam_angle <= np.mod(first, 2 * np.pi))])
        hint = f"; start at {before[-1]:.0f} deg" if len(before) else ""
        place = f"at {np.degrees(first):g} cam degrees the valve is {1e3 * start[0]:.3g} mm open and moves at {start[1]:.3g} m/s"
        raise InputError(f"a ride starts at rest, but {place}{hint}", WHERE)


def rod_motion(case: Case, rod: FiniteElementRod, solid: Solution) -> Solution:
    """The rod over the time of a solid ride from the same state at rest, mass damping only, at the samples of the solid.

    Forces are means over the solid's increments, which cannot follow what is faster.
    """
    law, angle, time = build_lift_law(case.lift_law), solid.cam_angle, solid.time
    cam_speed = solid.engine_speed / 2
    interval = float(time[-1] / (len(time) - 1))
    dynamics = replace(rod.dynamics, stiffness_damping=0.0)

    def motion(at: Array) -> Array:
        return rod.precompression + np.asarray(law.lift(angle[0] + cam_speed * at))

    run = simulate(rod.mesh, rod.installed.state, motion, interval, len(time) + 1, dynamics)
    width = max(1, round(interval / float(run.dense_time[1] - run.dense_time[0])))
    values = {
        "valve_lift": np.asarray(law.lift(angle)), "retainer_velocity": cam_speed * np.asarray(law.lift(angle, 1)),
        "retainer_force": np.interp(time, run.dense_time, _mean(run.dense_retainer_force, width)),
        "seat_force": np.interp(time, run.dense_time, _mean(run.dense_seat_force, width)),
    }  # fmt: skip
    options = {"mass_damping": dynamics.mass_damping, "elements_per_coil": rod.elements_per_coil, "time_step": run.time_step}
    provenance = collect_provenance(case.name, rod.name, engine_speed=solid.engine_speed, options=options)
    status = COMPLETED if run.completed else Status("diverged", "the wire's velocity grew without bound", run.steps_done * run.time_step)
    return Solution(spring_channels(time, angle, values), status=status, statistics={"steps": run.steps}, provenance=provenance)


def _mean(values: Array, width: int) -> Array:
    """Running mean over ``width`` samples, over those there are at the ends."""
    window = np.ones(width)
    return np.convolve(values, window, mode="same") / np.convolve(np.ones(len(values)), window, mode="same")
