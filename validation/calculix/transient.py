"""Transient of the solid model under a prescribed lift, on a mesh coarse enough for an implicit
solid run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from validation.calculix import axis_motion
from validation.calculix import deck as steps
from validation.calculix.deck import MILLIMETRE, SolidContact
from validation.calculix.jobs import SolidSpring
from validation.calculix.results import read_printed
from validation.calculix.solver import SolverOutput
from valvetrain.errors import InputError
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.provenance import Provenance, collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Status

Array = NDArray[np.float64]

#: Increments in which the spring is brought to its installed length.
PRELOAD_INCREMENTS = 10
#: Coils that meet at speed exhaust the solver's cutbacks with the stiffer contact of statics.
MOTION_CONTACT = SolidContact(stiffness=1e13)


class Lift(Protocol):
    """What is needed of a lift law: lift (m) or its derivative by the cam angle (m per
    rad**derivative), vectorised.
    """

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array: ...


@dataclass(frozen=True)
class TransientJob:
    """Prescribed motion of the retainer over ``lift_law``, ``first_angle`` to ``last_angle`` (cam
    rad), at ``engine_speed`` (crank rad/s).

    The spring starts at rest at ``precompression`` (m) plus the first lift, so the lift law should
    rest there.
    ``time_step`` (s) is the largest increment; the solver may take smaller ones. ``alpha`` (-1/3 to
    0) is the numerical damping of
    the Hilber-Hughes-Taylor method. ``mass_damping`` (1/s) is the only physical damping: the
    stiffness-proportional one of
    CalculiX 2.20 brakes the wire as if a prescribed retainer were fixed (measured:
    docs/solid-reference.md).
    """

    lift_law: Lift
    engine_speed: float
    precompression: float
    first_angle: float
    last_angle: float
    time_step: float = 4e-5
    mass_damping: float = 0.0
    alpha: float = -0.05

    def __post_init__(self) -> None:
        if not (
            self.engine_speed > 0 and self.last_angle > self.first_angle and self.time_step > 0
        ):
            raise InputError(
                "a transient needs a positive engine speed and time step, and a last cam angle beyond the first"
            )

    @property
    def duration(self) -> float:
        """Length of the run (s)."""
        return (self.last_angle - self.first_angle) / self.cam_speed

    @property
    def cam_speed(self) -> float:
        """Half the engine speed (rad/s)."""
        return self.engine_speed / 2

    def displacement(self, time: Array) -> Array:
        """Downward way (m) of the retainer from the free state at ``time`` (s) after the start."""
        return self.precompression + np.asarray(
            self.lift_law.lift(self.first_angle + self.cam_speed * time)
        )


def transient_deck(model: SolidSpring, job: TransientJob) -> str:
    """Deck of the run: preload in a static step, then the lift law in an implicit dynamic one."""
    printout = steps.Printout(axis=True, pairs=len(model.pairs), energy=True)
    time = np.linspace(0.0, job.duration, int(np.ceil(job.duration / job.time_step)) + 1)
    table = steps.amplitude_text("LIFT", time, -job.displacement(time) * MILLIMETRE)
    start = float(job.displacement(np.zeros(1))[0])
    # The solver prints total time to seven digits: a preload as long as the motion in solver time
    # reserves them for it.
    preload = steps.static_step(
        start,
        printout,
        first=0.5 / PRELOAD_INCREMENTS,
        largest=1 / PRELOAD_INCREMENTS,
        period=job.duration,
    )
    motion = steps.dynamic_step(
        job.duration, float(time[1]), printout, amplitude="LIFT", alpha=job.alpha
    )
    return model.deck(preload, motion, before=table, mass_damping=job.mass_damping)


def run_transient(model: SolidSpring, job: TransientJob, case_name: str = "") -> Solution:
    """Run and read back. A run cut short by the time limit or the solver gives what it reached,
    with the reason in its status.
    """
    deck = transient_deck(model, job)
    output = model.run(deck)
    return transient_solution(model, job, output, case_name or model.spring.name)


def transient_solution(
    model: SolidSpring, job: TransientJob, output: SolverOutput, case_name: str
) -> Solution:
    """The channels in the printed results of :func:`transient_deck`; increments cut far below the
    time step are left out.
    """
    printed = read_printed(output.printed)
    solver_time, retainer = printed.history("total force", "RETAINER")
    _, seat = printed.history("total force", "SEAT")
    _, axis = printed.history("displacements", "AXIS")
    chosen = _evenly_spaced(solver_time[: min(len(retainer), len(seat), len(axis))], job)
    if len(chosen) < 3:
        return _empty_solution(model, job, output, case_name)
    time = np.maximum(solver_time[chosen] - job.duration, 0.0)
    angle = job.first_angle + job.cam_speed * time
    coil, index, free = axis_motion.axis_points(model.mesh)
    moved = np.stack(
        [axis_motion.averaged(axis[i], model.mesh, index, len(coil)) / MILLIMETRE for i in chosen]
    )
    force = np.array([-retainer[i][0, 2] for i in chosen])
    values: dict[str, Array] = {
        "valve_lift": np.asarray(job.lift_law.lift(angle), dtype=float),
        "retainer_velocity": np.asarray(job.lift_law.lift(angle, 1), dtype=float) * job.cam_speed,
        "retainer_force": force,
        "seat_force": np.array([seat[i][0, 2] for i in chosen]),
        "axial_displacement": moved[:, :, 2] - moved[0, :, 2],
        "axial_position": free[None, :, 2] + moved[:, :, 2] - model.spring.lower_seat_height,
    }
    if len(model.pairs):
        values["seat_force"] = _balanced_seat_force(model, job, time, force, moved[:, :, 2])
        values["coil_gap"] = axis_motion.coil_gaps(
            model.spring, coil, free + moved, model.pairs, model.contact
        )
        values["coil_contact_force"] = model.pair_forces(printed, len(retainer) + 1)[1:][chosen]
    channels = spring_channels(
        time, angle, values, coil_number=coil, upper_coil=model.pairs if len(model.pairs) else None
    )
    return Solution(
        channels,
        status=replace(output.status, time=float(time[-1])),
        statistics=_statistics(model, output, len(chosen) - 1),
        provenance=_provenance(model, job, case_name),
    )


def _evenly_spaced(solver_time: Array, job: TransientJob) -> list[int]:
    """Printed increments from the end of the preload (at solver time job.duration) on, at least
    half a time step apart.
    """
    chosen: list[int] = []
    for number, time in enumerate(solver_time):
        late = time >= job.duration * (1 - 1e-5)
        if late and (not chosen or time - solver_time[chosen[-1]] >= 0.45 * job.time_step):
            chosen.append(number)
    return chosen


def _balanced_seat_force(
    model: SolidSpring, job: TransientJob, time: Array, retainer_force: Array, height: Array
) -> Array:
    """Seat force (N) from the retainer's and the axial momentum of the free wire.

    The printed reaction of inactive turns that other coils rest on chatters with the contact for a
    millisecond after the preload.
    """
    coil, spring = model.axis_coil, model.spring
    first, last = spring.free_coils
    free = (coil >= first - 1e-9) & (coil <= last + 1e-9)
    line_mass = (
        spring.material.density
        * np.pi
        / 4
        * spring.wire_diameter.value(coil) ** 2
        * spring.line_speed(coil)
    )
    momentum = np.trapezoid(
        (np.gradient(height, time, axis=0) * line_mass)[:, free], coil[free], axis=1
    )
    return retainer_force + np.gradient(momentum, time) + job.mass_damping * momentum


def _empty_solution(
    model: SolidSpring, job: TransientJob, output: SolverOutput, case_name: str
) -> Solution:
    status = output.status
    if status.completed:
        status = Status(
            "not-converged",
            "CalculiX printed no result",
            remedy="look at the deck with another tool",
        )
    channels = spring_channels(
        np.zeros(0), np.zeros(0), {"retainer_force": np.zeros(0), "seat_force": np.zeros(0)}
    )
    return Solution(
        channels,
        status=status,
        statistics=_statistics(model, output, 0),
        provenance=_provenance(model, job, case_name),
    )


def _statistics(
    model: SolidSpring, output: SolverOutput, increments: int
) -> Mapping[str, float | int | str | bool]:
    return {
        "unknowns": model.mesh.unknowns,
        "elements": len(model.mesh.elements),
        "increments": increments,
        "wall_time": output.wall_time,
    }


def _provenance(model: SolidSpring, job: TransientJob, case_name: str) -> Provenance:
    options: dict[str, float | int | str | bool | None] = {
        "solver": "CalculiX", "element_type": model.options.element_type, "elements_per_coil": model.options.elements_per_coil,
        "core": model.options.core, "rings": model.options.rings, "ends": model.options.ends,
        "time_step": float(job.time_step), "alpha": float(job.alpha), "mass_damping": float(job.mass_damping),
    }  # fmt: skip
    return collect_provenance(case_name, model.name, engine_speed=job.engine_speed, options=options)
