"""Solid finite elements by CalculiX in a comparison: cost, statics and modes."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.stopping import noted
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.springs.solid.calculix import find_solver
from valvetrain.springs.solid.installed import (
    COARSER_MESH,
    installed_statics,
    statics_seconds,
)
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.spec import SolidOptions, solid_spring
from valvetrain.springs.spec import spring_model

Array = NDArray[np.float64]
Watch = Callable[[float], None]
#: Modes of the solid.
MODES = 12
#: Name of the mesh error among the facts, and the coarsest mesh (elements per coil) for it.
MESH_ERROR, COARSEST = "force error of the mesh", 4


class SolidCost(NamedTuple):
    """Cost of the solid part: unknowns, elements, seconds of statics and modes."""

    unknowns: int
    elements: int
    statics: float


def solid_of(spring: InstalledSpring) -> SolidSpring:
    """The solid model of an installed wire by the options of its ``solid`` table."""
    options = spring_model("solid").read_options(spring.options_of("solid"))
    assert isinstance(options, SolidOptions)
    return solid_spring(spring, options)


def solid_cost(spring: InstalledSpring) -> SolidCost:
    """Estimated cost of the solid part, to a factor of two.

    Raises :class:`MissingExtraError` without the solver and :class:`InputError` for a mesh that
    cannot be.
    """
    find_solver()
    mesh = solid_of(spring).mesh
    return SolidCost(
        mesh.unknowns, len(mesh.elements), COARSER_MESH * statics_seconds(mesh.unknowns)
    )


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
