"""Static equilibrium of a solid wire by Newton iteration with the exact sparse tangent, and its
modes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import eigsh, splu

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import contact_response, law_address, law_numbers
from valvetrain.continuum import contact_kernels
from valvetrain.continuum.wire import ContactPoints, SolidWire
from valvetrain.errors import InputError

#: Largest residual (N), Newton steps, and largest and smallest increment of travel (m).
TOLERANCE, ITERATIONS, MAX_INCREMENT, MIN_INCREMENT = 1e-6, 30, 2e-3, 1e-5
#: Sweeps of Newton steps for the feet of contact points in one evaluation.
FOOT_SWEEPS = 6


@dataclass(frozen=True, eq=False)
class SolidEquilibrium:
    """``position`` (nodes, 3, stations) in m at a ``compression`` (m from the free state), forces on
    retainer and seat (N, compressive positive), contact points with their feet, Newton record.
    """

    position: Array
    compression: float
    retainer_force: float
    seat_force: float
    points: ContactPoints
    residual: float
    iterations: int


@dataclass(frozen=True, eq=False)
class SolidModes:
    """``natural_frequency`` (modes,) in Hz, ascending; ``shape`` (modes, nodes, 3, stations) of unit modal
    mass (1/sqrt(kg)); ``participation`` (modes,) in sqrt(kg) of an axial motion; forces (N at unit
    amplitude) on retainer and seat.
    """

    natural_frequency: Array
    shape: Array
    participation: Array
    retainer_force: Array
    seat_force: Array


class SolidStatics:
    """Residual, tangent, equilibria and modes of one wire; holds no state of its own."""

    def __init__(self, wire: SolidWire) -> None:
        self.wire = wire
        first, last = wire.ends
        inside = np.zeros(wire.free_position.shape, dtype=bool)
        inside[:, :, first + 1 : last] = True
        #: Flat places of the free unknowns, station after station: a narrow band without contact.
        order = np.arange(inside.size).reshape(inside.shape).transpose(2, 0, 1)
        self.free = order[inside.transpose(2, 0, 1)]
        self._lifted = np.zeros(inside.shape)
        self._lifted[:, 2, last:] = -1.0

    @cached_property
    def _to_centres(self) -> sparse.csr_matrix:
        """Matrix from flat positions to flat section centres."""
        weights = self.wire.weights[None, :]
        return sparse.kron(weights, sparse.eye(3 * self.wire.stations)).tocsr()

    def _contact(
        self, position: Array, travel: float, points: ContactPoints
    ) -> tuple[Array, Array]:
        """Forces on the section centres (3, stations), and on the planes of seat and retainer (N)."""
        wire, law = self.wire, self.wire.contact.law
        stations = wire.stations
        centre, push = wire.centres(position).ravel(), np.zeros(3 * stations)
        row = law_numbers(law)
        totals = np.zeros(contact_kernels.TOTALS)
        contact_kernels.follow_feet(centre, stations, points, 1.0, FOOT_SWEEPS)
        contact_kernels.coil_forces(
            centre, np.zeros(3 * stations), push, stations, points, law_address(law),
            row.ctypes.data, 0.0, totals,
        )  # fmt: skip
        planes = contact_kernels.plane_forces(
            centre, push, stations, wire.seat_planes, travel, law_address(law), row.ctypes.data, totals
        )  # fmt: skip
        return push.reshape(3, stations), np.array(planes)

    def forces(
        self, position: Array, compression: float, points: ContactPoints
    ) -> tuple[Array, float, float]:
        """Forces on the nodes (nodes, 3, stations) of bricks and contact, and those on retainer and
        seat (N).
        """
        wire, (first, last) = self.wire, self.wire.ends
        inner = wire.bricks.forces(position)
        push, planes = self._contact(position, compression, points)
        retainer = inner[:, 2, last:].sum() + push[2, last:].sum() + planes[1]
        seat = planes[0] - inner[:, 2, : first + 1].sum() - push[2, : first + 1].sum()
        return inner + wire.weights[:, None, None] * push, float(retainer), float(seat)

    def _contact_tangent(
        self, position: Array, compression: float, points: ContactPoints
    ) -> sparse.csr_matrix | None:
        """Normal stiffness of the contacts that press, on the section centres."""
        wire, law, size = self.wire, self.wire.contact.law, 3 * self.wire.stations
        centre = wire.centres(position)
        where, weight = wire.contact_line(points)
        vector = np.einsum("pj,kpj->pk", weight, centre[:, where])
        apart = np.linalg.norm(vector, axis=1)
        found = contact_response(law, points.distance - apart, stiffness=points.stiffness)
        on = found.tangent > 0
        normal = vector[on] / apart[on, None]
        rates = (weight[on][:, None, :] * normal[:, :, None]).reshape(-1, 18)
        places = (where[on][:, None, :] + wire.stations * np.arange(3)[None, :, None]).reshape(
            -1, 18
        )
        values = found.tangent[on, None, None] * rates[:, :, None] * rates[:, None, :]
        planes = wire.seat_planes
        limit = planes.height - np.where(planes.side > 0, 0.0, compression)
        depth = planes.side * (limit - centre[2, planes.station])
        seats = contact_response(law, depth, stiffness=planes.stiffness).tangent
        axial = 2 * wire.stations + planes.station
        if not (on.any() or seats.any()):
            return None
        rows = np.concatenate([np.repeat(places, 18, axis=1).ravel(), axial])
        columns = np.concatenate([np.tile(places, (1, 18)).ravel(), axial])
        data = np.concatenate([values.ravel(), seats])
        return sparse.csr_matrix((data, (rows, columns)), shape=(size, size))

    def tangent(
        self, position: Array, compression: float, points: ContactPoints | None
    ) -> sparse.csr_matrix:
        """Stiffness (N/m) of all nodes; of the bricks alone without ``points``."""
        elements, places = self.wire.bricks.tangent(position)
        rows, columns = np.repeat(places, 24, axis=1).ravel(), np.tile(places, (1, 24)).ravel()
        size = position.size
        whole = sparse.csr_matrix((elements.ravel(), (rows, columns)), shape=(size, size))
        contact = None if points is None else self._contact_tangent(position, compression, points)
        if contact is None:
            return whole
        return (whole + self._to_centres.T @ contact @ self._to_centres).tocsr()

    def _factor(self, matrix: sparse.csr_matrix) -> Any:
        inner = matrix[self.free][:, self.free].tocsc()
        return splu(inner, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def start(self) -> SolidEquilibrium:
        """The free state."""
        points = self.wire.contact_points.copy()
        return SolidEquilibrium(self.wire.free_position, 0.0, 0.0, 0.0, points, 0.0, 0)

    def solve(self, near: SolidEquilibrium, compression: float) -> SolidEquilibrium | None:
        """The equilibrium at ``compression`` (m) in one increment from one nearby; None where Newton
        does not converge.
        """
        position, points = near.position.copy(), near.points.copy()
        moved = (self._lifted * (compression - near.compression)).ravel()
        smallest = np.inf
        for iteration in range(ITERATIONS):
            try:
                matrix = self.tangent(position, compression, points)
                load = self.forces(position, compression, points)[0].ravel()[self.free]
                if iteration == 0:
                    load = load - (matrix @ moved)[self.free]
                step = self._factor(matrix).solve(load)
            except RuntimeError:  # singular
                return None
            if iteration == 0:
                position = position + moved.reshape(position.shape)
            flat = position.ravel().copy()
            flat[self.free] += step
            position = flat.reshape(position.shape)
            force, retainer, seat = self.forces(position, compression, points)
            residual = float(np.abs(force.ravel()[self.free]).max())
            if not np.isfinite(residual):
                return None
            if residual < TOLERANCE:
                return SolidEquilibrium(
                    position, compression, retainer, seat, points, residual, iteration + 1
                )
            smallest = min(smallest, residual)
            if iteration > 8 and residual > 1e3 * smallest:
                return None
        return None

    def compress(
        self,
        compressions: Sequence[float],
        begin: SolidEquilibrium | None = None,
        watch: Callable[[float], None] | None = None,
    ) -> list[SolidEquilibrium]:
        """Equilibria at ``compressions`` (m), each from the one before, in increments that are halved
        where Newton fails. ``watch`` is called with every compression that is reached.

        Raises :class:`InputError` where no equilibrium is found.
        """
        state, found = begin or self.start(), []
        for target in compressions:
            count = max(1, int(np.ceil(abs(target - state.compression) / MAX_INCREMENT)))
            increment = (target - state.compression) / count
            while state.compression != target:
                left = target - state.compression
                goal = (
                    target if abs(left) <= 1.001 * abs(increment) else state.compression + increment
                )
                reached = self.solve(state, goal)
                if reached is None:
                    increment /= 2
                    if abs(increment) < MIN_INCREMENT:
                        raise InputError(
                            f"the solid of spring '{self.wire.spring.name}' finds no equilibrium beyond "
                            f"{1e3 * state.compression:.3g} mm; compress it less"
                        )
                    continue
                state = reached
                if watch is not None:
                    watch(state.compression)
            found.append(state)
        return found

    def modes(self, state: SolidEquilibrium, count: int = 12) -> SolidModes:
        """The lowest ``count`` modes about an equilibrium, both ends fixed, contacts as they press.

        Raises :class:`InputError` for less than one mode.
        """
        if count < 1:
            raise InputError(f"one mode or more can be requested; count is {count}", "count")
        whole = self.tangent(state.position, state.compression, state.points)
        inner = whole[self.free][:, self.free]
        mass = np.repeat(self.wire.bricks.mass[:, None, :], 3, axis=1)
        own = mass.ravel()[self.free]
        scale = sparse.diags(1 / np.sqrt(own))
        start = np.random.default_rng(1).standard_normal(len(own))
        value, vector = eigsh(
            (scale @ ((inner + inner.T) / 2) @ scale).tocsc(), k=count, sigma=0.0, v0=start
        )
        order = np.argsort(value)
        shape = np.zeros((count, state.position.size))
        shape[:, self.free] = (vector[:, order] / np.sqrt(own)[:, None]).T
        reaction = (whole @ shape.T).T.reshape(count, *state.position.shape)
        shape = shape.reshape(count, *state.position.shape)
        first, last = self.wire.ends
        return SolidModes(
            np.sqrt(np.maximum(value[order], 0.0)) / (2 * np.pi),
            shape,
            np.sum(mass[None, :, 2] * shape[:, :, 2], axis=(1, 2)),
            -reaction[:, :, 2, last:].sum(axis=(1, 2)),
            reaction[:, :, 2, : first + 1].sum(axis=(1, 2)),
        )
