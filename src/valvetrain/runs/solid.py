"""Solid finite elements in a comparison: cost, statics and modes, and a short interval of
prescribed motion.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.cam.contract import LiftLaw
from valvetrain.cosserat.transient import simulate
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.stopping import noted
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.solid.calculix import find_solver
from valvetrain.springs.solid.installed import (
    COARSER_MESH,
    installed_statics,
    motion_seconds,
    statics_seconds,
)
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.spec import SolidOptions, solid_spring
from valvetrain.springs.solid.transient import MOTION_CONTACT, TransientJob, run_transient
from valvetrain.springs.spec import spring_model

Array = NDArray[np.float64]
Watch = Callable[[float], None]
#: Modes of the solid.
MODES = 12
#: Lift (m) and retainer velocity (m/s) that count as none at the start of an interval of motion.
REST_LIFT, REST_VELOCITY = 1e-5, 0.02
WHERE = "--solid-motion"
#: Name of the mesh error among the facts, and the coarsest mesh (elements per coil) for it.
MESH_ERROR, COARSEST = "force error of the mesh", 4


@dataclass(frozen=True)
class SolidMotion:
    """An interval of prescribed motion between two cam angles (rad) at ``engine_speed`` (crank
    rad/s).
    """

    first_cam_angle: float
    last_cam_angle: float
    engine_speed: float


class SolidCost(NamedTuple):
    """Cost of the solid part: unknowns, elements, seconds of statics and modes, increments and
    seconds of the motion.
    """

    unknowns: int
    elements: int
    statics: float
    increments: int
    motion: float


def solid_of(spring: InstalledSpring) -> SolidSpring:
    """The solid model of an installed wire by the options of its ``solid`` table."""
    options = spring_model("solid").read_options(spring.options_of("solid"))
    assert isinstance(options, SolidOptions)
    return solid_spring(spring, options)


def solid_cost(spring: InstalledSpring, motion: SolidMotion | None = None) -> SolidCost:
    """Estimated cost of the solid part, to a factor of two.

    Raises :class:`MissingExtraError` without the solver and :class:`InputError` for a mesh that
    cannot be.
    """
    find_solver()
    mesh = solid_of(spring).mesh
    increments = 0
    if motion is not None:
        duration = 2 * (motion.last_cam_angle - motion.first_cam_angle) / motion.engine_speed
        increments = int(np.ceil(duration / TransientJob.time_step)) + 10
    unknowns, statics = mesh.unknowns, COARSER_MESH * statics_seconds(mesh.unknowns)
    moving = motion_seconds(unknowns, increments)
    return SolidCost(unknowns, len(mesh.elements), statics, increments, moving)


def solid_rest(spring: InstalledSpring, reach: float, watch: Watch | None = None) -> SpringAtRest:
    """Static curve to ``reach`` (m) and modes about the installed state by solids; a solver that
    fails is their status.
    """
    model = replace(solid_of(spring), watch=watch)
    found, options = installed_statics(model, spring.precompression, reach, MODES), model.options
    facts: dict[str, float | int | str] = {
        "element": options.element_type, "elements per coil": options.elements_per_coil,
        "cells over the section": options.core**2 + 4 * options.core * options.rings, "elements": len(model.mesh.elements),
        "unknowns": model.mesh.unknowns,
    }  # fmt: skip
    if (error := force_error(model, found.curve, spring.precompression or reach)) is not None:
        facts[MESH_ERROR] = error
    return SpringAtRest(
        spring.name,
        "solid",
        spring.precompression,
        found.curve,
        found.modes,
        None,
        facts,
        found.wall_time,
    )


def force_error(model: SolidSpring, curve: StaticCurve, compression: float) -> float | None:
    """Relative mesh error of the force at ``compression`` (m), from a second mesh two thirds as
    fine along the wire.

    1.25 |f - f_coarse| / (f (r^2 - 1)), r the ratio of the meshes (roache1994) with order 2
    (quadratic elements along a helix show 2 to 4). None where the mesh is too coarse for it, or a
    solution ended early.
    """
    fine = model.options.elements_per_coil
    coarse = max(COARSEST, round(2 * fine / 3))
    if (
        coarse >= fine
        or not curve.status.completed
        or curve.compression[-1] < compression * (1 - 1e-9)
    ):
        return None
    other = replace(model, options=replace(model.options, elements_per_coil=coarse)).static_curve(
        compression, points=4
    )
    if not other.status.completed:
        return None
    force = float(np.interp(compression, curve.compression, curve.force))
    return float(1.25 * abs(force - other.force[-1]) / (abs(force) * ((fine / coarse) ** 2 - 1)))


def check_motion(lift_law: LiftLaw, motion: SolidMotion) -> None:
    """Raise :class:`InputError` for an empty interval or one that starts in motion."""
    if not motion.engine_speed > 0:
        raise InputError(
            "an interval of motion needs one engine speed; add such as --engine-speed '4200 rpm'",
            WHERE,
        )
    first, last = motion.first_cam_angle, motion.last_cam_angle
    if not 0 < last - first <= 2 * np.pi:
        raise InputError(
            "the last cam angle must lie beyond the first, by one revolution at most; write such as '85:105 deg'",
            WHERE,
        )
    cam_angle, cam_speed = np.radians(np.arange(0.0, 360.0)), motion.engine_speed / 2
    rests = (np.abs(lift_law.lift(cam_angle)) <= REST_LIFT) & (
        np.abs(lift_law.lift(cam_angle, 1)) * cam_speed <= REST_VELOCITY
    )
    start = float(lift_law.lift(first)), float(lift_law.lift(first, 1)) * cam_speed
    if abs(start[0]) > REST_LIFT or abs(start[1]) > REST_VELOCITY:
        before = np.degrees(cam_angle[rests & (cam_angle <= np.mod(first, 2 * np.pi))])
        hint = f"; start at {before[-1]:.0f} deg" if len(before) else ""
        state = f"at {np.degrees(first):g} cam degrees the valve is {1e3 * start[0]:.3g} mm open and moves at {start[1]:.3g} m/s"
        raise InputError(f"an interval of motion starts at rest, but {state}{hint}", WHERE)


def solid_motion(
    case_name: str,
    spring: InstalledSpring,
    lift_law: LiftLaw,
    motion: SolidMotion,
    watch: Watch | None = None,
) -> Solution:
    """The interval of motion by solids, mass-proportional damping only."""
    check_motion(lift_law, motion)
    model = replace(solid_of(spring), watch=watch)
    contact = (
        MOTION_CONTACT
        if model.contact is None
        else replace(MOTION_CONTACT, seats=model.contact.seats)
    )
    job = TransientJob(
        lift_law,
        motion.engine_speed,
        spring.precompression,
        motion.first_cam_angle,
        motion.last_cam_angle,
        mass_damping=spring.damping.mass_damping,
    )
    return run_transient(replace(model, contact=contact), job, case_name)


def rod_motion(
    case_name: str, rod: FiniteElementRod, lift_law: LiftLaw, solid: Solution
) -> Solution:
    """The rod over the interval of a solid from the same equilibrium, mass damping only, at the
    samples of the solid.

    Forces are means over the increments of the solid, which do not resolve faster changes.
    """
    angle, time, cam_speed = solid.cam_angle, solid.time, solid.engine_speed / 2
    interval = float(time[-1] / (len(time) - 1))
    dynamics = replace(rod.dynamics, stiffness_damping=0.0, ends=None)  # the solid's are bonded

    def compression(instant: Array) -> Array:
        return rod.precompression + np.asarray(lift_law.lift(angle[0] + cam_speed * instant))

    run = simulate(rod.mesh, rod.installed.state, compression, interval, len(time) + 1, dynamics)
    width = max(1, round(interval / float(run.dense_time[1] - run.dense_time[0])))
    values = {
        "valve_lift": np.asarray(lift_law.lift(angle)), "retainer_velocity": cam_speed * np.asarray(lift_law.lift(angle, 1)),
        "retainer_force": np.interp(time, run.dense_time, _mean(run.dense_retainer_force, width)),
        "seat_force": np.interp(time, run.dense_time, _mean(run.dense_seat_force, width)),
    }  # fmt: skip
    options = {
        "mass_damping": dynamics.mass_damping,
        "elements_per_coil": rod.elements_per_coil,
        "time_step": run.time_step,
    }
    label = f"{rod.name}, as the solid"
    provenance = collect_provenance(
        case_name, rod.name, engine_speed=solid.engine_speed, options=options, label=label
    )
    status = COMPLETED
    if not run.completed:
        end = run.steps_done * run.time_step
        status = Status("diverged", "the wire's velocity grew without bound", end)
    return Solution(
        spring_channels(time, angle, values),
        status=status,
        statistics={"steps": run.steps},
        provenance=provenance,
    )


def _mean(values: Array, width: int) -> Array:
    """Running mean over ``width`` samples, over fewer at the ends."""
    window = np.ones(width)
    return np.convolve(values, window, mode="same") / np.convolve(
        np.ones(len(values)), window, mode="same"
    )


class Cancel:
    """Callback of the loop of a solver: an interrupted study stops the solver and removes its
    files.
    """

    def __init__(self, tell: Watch | None = None) -> None:
        self.flag, self.tell = threading.Event(), tell

    def __call__(self, reached: float) -> None:
        if self.flag.is_set() or noted():
            raise InterruptedError("stopped")
        if self.tell is not None:
            self.tell(reached)
