"""The solid model of one spring and its requests: static curve and modes about a compressed
state.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from validation.calculix import axis_motion
from validation.calculix import deck as steps
from validation.calculix.deck import (
    MILLIMETRE,
    SolidContact,
    comment,
    contact_pairs,
    model_text,
    seats_text,
)
from validation.calculix.results import Printed, read_printed
from validation.calculix.solver import SolverOutput, run_deck
from valvetrain.continuum import mesh as hexahedra
from valvetrain.continuum.mesh import MeshOptions, SolidMesh, sweep_spring
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.status import Status
from valvetrain.units import Given, si

Array = NDArray[np.float64]

#: Modes that transmit less than this (1 for a mode of a straight elastic rod) are never called
#: axial.
MIN_TRANSMISSION = 0.12


def jacobian_quality(mesh: SolidMesh) -> float:
    """Smallest Jacobian determinant over its element's largest, at the corners and 3 x 3 x 3 Gauss points; > 0 is usable."""
    points = np.vstack([hexahedra.gauss_points(3)[0], hexahedra.NODE_COORDINATES[:8]])
    determinants = hexahedra.jacobian_determinants(mesh.coordinates, mesh.elements, points)
    return float(np.min(determinants.min(axis=1) / np.abs(determinants).max(axis=1)))


@dataclass(frozen=True)
class SolidSpring:
    """Solid finite-element model of ``spring``. ``contact`` None leaves coils free to pass through
    each other.

    ``time_limit`` (s) and ``threads`` bound each run of the solver.

    >>> import valvetrain as vt
    >>> solid = SolidSpring(vt.load_case("uniform-spring").springs[0].wire)
    >>> solid.time_limit
    300.0
    """

    spring: SpringDefinition
    options: MeshOptions = field(default_factory=MeshOptions)
    contact: SolidContact | None = None
    time_limit: float = 300.0
    threads: int = 1
    name: str = "solid"

    @cached_property
    def mesh(self) -> SolidMesh:
        """The mesh, with the node set ``axis`` of the wire axis added."""
        mesh = sweep_spring(self.spring, self.options)
        if not jacobian_quality(mesh) > 0:
            remedy = (
                "take fewer cells over the section, grind less or hold the end turns"
                if self.options.ends == "ground"
                else "refine it"
            )
            raise InputError(
                f"the solid mesh of spring '{self.spring.name}' folds over itself; {remedy}"
            )
        return replace(mesh, node_sets={**mesh.node_sets, "axis": mesh.fibre(0.0, 0.0)})

    @cached_property
    def pairs(self) -> Array:
        """Coil number of the upper partner of each contact pair (none without contact)."""
        return (
            np.array([middle for middle, _, _ in contact_pairs(self.mesh, self.contact)])
            if self.contact
            else np.zeros(0)
        )

    def deck(self, *load_steps: str, before: str = "", mass_damping: float = 0.0) -> str:
        """The whole input deck with the given steps; ``before`` holds tables between
        model and steps.
        """
        title = f"** {comment(self.spring.name)}: {len(self.mesh.elements)} {self.options.element_type}; mm, N, s, tonne, MPa\n"
        model = model_text(
            self.mesh, self.spring.material, self.options, self.contact, mass_damping
        )
        if self.contact is not None and self.contact.seats and self.options.ends != "sections":
            model += seats_text(self.mesh, self.spring, self.options.ends == "ground")
        return title + model + before + "".join(load_steps)

    def run(self, deck: str, read_fields: bool = False) -> SolverOutput:
        """Run a deck of :meth:`deck` within this model's limits."""
        return run_deck(
            deck,
            time_limit=self.time_limit,
            threads=self.threads,
            read_fields=read_fields,
        )

    def static_curve(self, compression: Given, points: int = 20) -> StaticCurve:
        """Force over compression from the free state to ``compression`` (m), at least ``points``
        increments.

        A solver that gives up leaves the curve it reached and a status that says why.
        """
        compression = si(compression, "compression", f"compression of spring '{self.spring.name}'")
        printout = steps.Printout(axis=True, pairs=len(self.pairs))
        step = steps.static_step(compression, printout, first=0.5 / points, largest=1.0 / points)
        output = self.run(self.deck(step))
        return self.curve_from(read_printed(output.printed), compression, output.status)

    def curve_from(
        self, printed: Printed, compression: float, status: Status, reach: float | None = None
    ) -> StaticCurve:
        """The static curve in the printed results of a static step to ``compression`` (m), and of a
        second one on to ``reach``.
        """
        time, rows = printed.history("total force", "RETAINER")
        ends = [0.0, compression] if reach is None else [0.0, compression, reach]
        travel = np.interp(
            np.concatenate(([0.0], time[time <= len(ends) - 1 + 1e-9])), np.arange(len(ends)), ends
        )
        force = np.concatenate(([0.0], [-row[0, 2] for row in rows[: len(travel) - 1]]))
        positions = self._positions(printed, len(travel))
        gap = axis_motion.coil_gaps(
            self.spring, self.axis_coil, positions, self.pairs, self.contact
        )
        stiffness = (
            np.gradient(force, travel, edge_order=2)
            if len(travel) > 2
            else np.full(len(travel), np.nan)
        )
        status = replace(
            status,
            time=0.0,
            where="" if status.completed else f"compression {travel[-1] * 1e3:.3f} mm",
        )
        height = positions[:, :, 2] - self.spring.lower_seat_height
        return StaticCurve(
            compression=travel,
            force=force,
            stiffness=stiffness,
            coil_gap=gap,
            coil_contact_force=self.pair_forces(printed, len(travel)),
            upper_coil=self.pairs,
            axial_position=height,
            coil_number=self.axis_coil,
            status=status,
        )

    @property
    def axis_coil(self) -> Array:
        """Coil numbers of the wire-axis points in the results."""
        return axis_motion.axis_points(self.mesh)[0]

    def _positions(self, printed: Printed, count: int) -> Array:
        """Wire axis (state, point, 3) in m of the free state and each increment."""
        coil, index, free = axis_motion.axis_points(self.mesh)
        _, rows = printed.history("displacements", "AXIS")
        moved = [
            axis_motion.averaged(row, self.mesh, index, len(coil)) / MILLIMETRE
            for row in rows[: count - 1]
        ]
        return np.stack([free, *(free + move for move in moved)])

    def pair_forces(self, printed: Printed, count: int) -> Array:
        """Contact force (state, pair) in N of the free state and the first ``count`` - 1
        increments.
        """
        forces = np.zeros((count, len(self.pairs)))
        for number in range(len(self.pairs)):
            _, rows = printed.history("contact", f"ABOVE{number + 1}")
            values = [abs(row[-1, 1]) for row in rows[: count - 1]]
            forces[1 : 1 + len(values), number] = np.nan_to_num(values)
        return forces

    def modes(self, compression: Given = 0.0, count: int = 12, points: int = 10) -> ModalResult:
        """Lowest ``count`` modes about the state at ``compression`` (m); closed coils keep their
        contact stiffness.
        """
        compression = si(compression, "compression", f"compression of spring '{self.spring.name}'")
        printout = steps.Printout(axis=True)
        load = []
        if compression > 0:
            quiet = steps.Printout(pairs=0)
            load = [steps.static_step(compression, quiet, first=0.5 / points, largest=1.0 / points)]
        output = self.run(
            self.deck(*load, steps.frequency_step(count, printout, preloaded=compression > 0))
        )
        return self.modes_from(read_printed(output.printed), compression, output.status)

    def modes_from(
        self, printed: Printed, compression: float, status: Status, step: int = -1
    ) -> ModalResult:
        """Modes in the printed results of a frequency step (-1 the last one)."""
        if not printed.natural_frequencies:
            nothing = np.zeros(0)
            return ModalResult(
                compression,
                nothing,
                np.zeros((0, len(self.axis_coil), 3)),
                self.axis_coil,
                nothing,
                (),
                status,
            )
        retainer, tables = (
            printed.modal("total force", "RETAINER", step),
            printed.modal("displacements", "AXIS", step),
        )
        count = min(len(retainer), len(tables), len(printed.participation[step]))
        frequency = printed.natural_frequencies[step][:count]
        coil, index, _ = axis_motion.axis_points(self.mesh)
        shapes = np.array(
            [axis_motion.averaged(table, self.mesh, index, len(coil)) for table in tables[:count]]
        )
        shapes = shapes.reshape(count, len(coil), 3)
        largest = np.take_along_axis(
            flat := shapes.reshape(count, -1), np.abs(flat).argmax(axis=1)[:, None], axis=1
        )
        transmission = _transmission(
            frequency,
            np.array([row[0, 2] for row in retainer[:count]]),
            printed.participation[step][:count, 2],
            self._tangent(printed, compression),
        )
        axial = axial_modes(transmission)
        return ModalResult(
            compression, frequency, shapes / largest[:, :, None], coil, transmission, axial, status
        )

    def _tangent(self, printed: Printed, compression: float) -> float:
        """Stiffness (N/m) at the end of the printed static step, of elementary theory where there
        is none.
        """
        time, rows = printed.history("total force", "RETAINER")
        time = time[time <= 1.0 + 1e-9]  # a step beyond the state of the modes may follow
        if compression <= 0 or len(time) < 2:
            return axis_motion.estimated_rate(self.spring)
        last = len(time) - 1
        return float(
            -(rows[last][0, 2] - rows[last - 1][0, 2]) / ((time[-1] - time[-2]) * compression)
        )


def _transmission(
    frequency: Array, retainer: Array, participation: Array, stiffness: float
) -> Array:
    """Product of both axial end reactions of unit-mass modes over 2 k omega^2: +-1 for a uniform
    straight rod.

    The seat's reaction follows from the retainer's and the mode's axial momentum: the printed one
    is wrong where coils rest
    on inactive turns. Reactions are in N per mm for a modal mass of one tonne, so k in N/mm makes
    the result a pure number.
    """
    square = (2 * np.pi * frequency) ** 2
    seat = -square * participation - retainer
    return retainer * seat / (2 * stiffness / MILLIMETRE * square)


def axial_modes(transmission: Array) -> tuple[int, ...]:
    """The axial modes: end reactions of successive ones have alternating sign, so each run of equal
    sign yields its strongest mode.

    Axial motion is spread over clusters of modes that mix with lateral and torsional ones; weak
    ones are passed over.
    """
    chosen: list[int] = []
    for mode in np.flatnonzero(np.abs(transmission) >= MIN_TRANSMISSION):
        if chosen and np.sign(transmission[chosen[-1]]) == np.sign(transmission[mode]):
            chosen[-1] = (
                int(mode) if abs(transmission[mode]) > abs(transmission[chosen[-1]]) else chosen[-1]
            )
        else:
            chosen.append(int(mode))
    return tuple(chosen)
