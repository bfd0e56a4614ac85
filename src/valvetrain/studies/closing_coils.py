"""Coils that close one after the other: a pitch law from a few numbers, its force over height, and the fit of both to a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from valvetrain.measurements.catalogue_card import POSSIBLE_INACTIVE, CatalogueCard, Winding
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.spring import EndCoil, SpringDefinition
from valvetrain.parameters.wire_ends import RAMP
from valvetrain.studies.spring_card import forces_at

Array = NDArray[np.float64]
Closes = Literal["lower", "upper", "both"]
#: Places along the wire and forces on which the closing of the coils is computed; stiffness of closed coils (N/m).
PLACES, FORCES, CLOSED = 481, 400, 1e8
#: Corrections by the rod, and the change of its forces (of their largest) below which they end.
CORRECTIONS, SETTLED = 8, 3e-4
#: Scatter of a station before it is known, and the least that is believed, as shares of the largest force.
FIRST_SCATTER, LEAST_SCATTER = 3e-3, 2e-4
#: Standard deviations of the rise of the gap from station to station and of the change of that rise, in wire diameters: what is usual
#: among progressive springs. They decide where the table does not.
RISE, BEND = 0.5, 0.15
#: What a height of a table is true to (m): where the force rises steeply, it decides how well a station is known.
HEIGHT_SCATTER = 20e-6


@dataclass(frozen=True)
class PitchLaw:
    """How numbers become a spring: active turns, the first gap and the steps to the next ones, from the end that closes first."""

    card: CatalogueCard
    total: float | None
    ground: float
    closes: Closes
    stations: int

    def winding(self, active: float) -> tuple[float, float]:
        """All turns, and inactive turns at either end."""
        if self.total is None:
            return active + 2.0, 1.0
        return self.total, (self.total - active) / 2

    def gaps(self, steps: Array) -> Array:
        """Gap (m) at each station along the wire."""
        rising: Array = np.cumsum(steps)
        if self.closes == "lower":
            return rising
        if self.closes == "upper":
            return rising[::-1]
        half = rising[: (self.stations + 1) // 2]
        return np.concatenate([half, half[::-1][self.stations % 2 :]])

    @property
    def steps(self) -> int:
        """Numbers behind the gaps."""
        return (self.stations + 1) // 2 if self.closes == "both" else self.stations

    def places(self, active: float) -> Array:
        """Coil numbers (turns) of the stations."""
        total, inactive = self.winding(active)
        return np.linspace(inactive + RAMP / 2, total - inactive - RAMP / 2, self.stations)

    def definition(self, numbers: Array) -> SpringDefinition:
        """The spring of ``numbers``: active turns, then steps of the gaps (m)."""
        wire = self.card.wire_diameter
        total, inactive = self.winding(numbers[0])
        knots = np.concatenate([[0.0, inactive - RAMP / 2], self.places(numbers[0]), [total - inactive + RAMP / 2, total]])
        pitch = wire + np.concatenate([[0.0, 0.0], self.gaps(numbers[1:]), [0.0, 0.0]])
        keep = np.append(True, np.diff(knots) > 1e-9)
        end = EndCoil("closed-ground", inactive, self.ground)
        return SpringDefinition(
            Constant(wire), self.card.mean_diameter(total), PiecewiseLinear(tuple(knots[keep]), tuple(pitch[keep])), total, self.card.wire,
            end, end, name=self.card.name,
        )  # fmt: skip


def closing_forces(definition: SpringDefinition, heights: Array) -> Array:
    """Forces (N) at heights (m) of a wire in torsion whose turns close one after the other.

    Under F the wire gives 8 D^3 / (G d^4) F per turn until the turn about a place has used up its gap: x(F) = integral of
    min(F c(u), gap(u)) du, gap(u) = rise over the turn about u less the wire.
    """
    coil = np.linspace(*definition.free_coils, PLACES)
    low, high = np.maximum(coil - 0.5, 0.0), np.minimum(coil + 0.5, definition.total_coils)
    wire = definition.wire_diameter.value(coil)
    gap = np.maximum(definition.axial_position(high) - definition.axial_position(low) - wire * (high - low), 0.0)
    give = 8 * definition.mean_diameter.value(coil) ** 3 / (definition.material.shear_modulus * wire**4)
    force = np.linspace(0.0, 3 * float(np.max(gap / give)) + 1.0, FORCES)
    shorter = np.trapezoid(np.minimum(force[:, None] * give, gap), coil, axis=1) + force / CLOSED
    found: Array = np.interp(definition.free_length - heights, shorter, force)
    return found


def fit_closing(law: PitchLaw, start: Winding, active: float, heights: Array, forces: Array) -> tuple[Array, Array, float]:
    """Numbers of ``law``, their covariance and the scatter (N): least squares on closing coils, with the difference to the rod added.

    Closing coils have slopes everywhere and one best answer, which the rod, whose coils close node after node, has not.
    """
    wire, top = law.card.wire_diameter, float(np.max(forces))
    even = max((start.free_length - wire * (start.total_coils + 1 - 2 * start.ground)) / max(active - RAMP, 0.5), 0.05 * wire)
    numbers = np.append(active, np.where(np.arange(law.steps) == 0, even, 0.05 * wire))
    most = 40.0 if law.total is None else law.total - 2 * POSSIBLE_INACTIVE[0]
    least = 1.0 if law.total is None else max(law.total - 2 * POSSIBLE_INACTIVE[1], 0.6)
    low, high = np.append(least, np.full(law.steps, 1e-6 * wire)), np.append(most, np.full(law.steps, 20 * wire))
    numbers = np.clip(numbers, low * 1.001, high * 0.999)
    scatter, apart = FIRST_SCATTER * top, np.zeros(len(heights))
    steps = np.append(1e-4, np.full(law.steps, 1e-4 * wire))

    def misses(values: Array) -> Array:
        rise = values[2:] / wire
        found = closing_forces(law.definition(values), heights) + apart
        return np.concatenate([(found - forces) / np.hypot(scatter, steep), rise / RISE, np.diff(rise) / BEND])

    def slopes(values: Array) -> Array:
        here, columns = misses(values), []
        for place, step in enumerate(steps):
            away = step if values[place] + step <= high[place] else -step
            columns.append((misses(values + np.where(np.arange(len(values)) == place, away, 0.0)) - here) / away)
        return np.array(columns).T

    steep = HEIGHT_SCATTER * np.gradient(-forces, heights)
    for number in range(CORRECTIONS):
        found = least_squares(misses, numbers, jac=slopes, bounds=(low, high), x_scale=np.append(0.1, np.full(law.steps, 0.1 * wire)))
        numbers, before = found.x, apart
        definition = law.definition(numbers)
        rod = forces_by_rod(definition, heights)
        left = rod - forces
        spare = max(len(heights) - len(numbers), 1)
        scatter = max(float(np.sqrt(left @ left / spare)), LEAST_SCATTER * top)
        apart = rod - closing_forces(definition, heights)
        if float(np.max(np.abs(apart - before))) < SETTLED * top:
            break
        if number:  # the difference itself swings about its end
            apart = (apart + before) / 2
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    return numbers, covariance, scatter


def forces_by_rod(definition: SpringDefinition, heights: Array) -> Array:
    """Forces (N) of the rod at heights (m); 0 above the free length, and those of all but closed coils below."""
    lowest = definition.solid_height + 0.02 * definition.solid_compression
    asked = np.clip(heights, lowest, definition.free_length)
    return np.array(forces_at(definition, asked.tolist()))
