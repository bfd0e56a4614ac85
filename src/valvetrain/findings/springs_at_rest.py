"""What rules and views read of springs at rest: loads, rates, coil bind and natural frequencies of each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array
from valvetrain.findings.words import Amount
from valvetrain.solution.definition import NESTED
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.solution.study import Study

#: Names of the largest lift: of a spring alone, and of a train.
LIFTS = ("maximum_lift", "rigid_maximum_valve_lift")
TOGETHER = "together"


@dataclass(frozen=True)
class State:
    """A spring at rest with its ``values`` (SI) by name.

    Parameters
    ----------
    one : the spring by one model
    name : what tells it from the others of its study; empty where there is one
    values : quantities that belong to no run
    """

    one: SpringAtRest
    name: str
    values: Mapping[str, float]

    @property
    def lift(self) -> float:
        """The largest lift (m); NaN where nothing lifts the spring."""
        return next((self.values[name] for name in LIFTS if name in self.values), math.nan)

    @property
    def full_lift(self) -> float:
        """Compression (m) at the largest lift; NaN without one."""
        return self.one.precompression + self.lift

    @property
    def solid(self) -> float:
        """Compression (m) at which all coils touch; NaN where it is not known."""
        return self.one.precompression + self.values.get("coil_bind_lift", math.nan)

    @property
    def left(self) -> Amount | None:
        """What is left to coil bind at the largest lift; None where either is not known."""
        left = self.solid - self.full_lift
        return Amount("coil_bind_clearance", left) if math.isfinite(left) else None

    def amount(self, name: str) -> Amount | None:
        """A quantity that belongs to no run; None where there is none."""
        return Amount(name, self.values[name]) if name in self.values else None

    @property
    def surge(self) -> Amount | None:
        """The first axial natural frequency; None without inner motion."""
        modes = self.one.modes
        if modes is None or not len(modes.axial_modes):
            return None
        return Amount("surge_frequency", float(modes.axial_frequencies[0]))

    def force(self, compression: float) -> Amount | None:
        """Force at a compression (m); None beyond the curve."""
        curve = self._reaches(compression)
        return None if curve is None else Amount("preload", curve.force_at(compression))

    def rate(self, compression: float) -> Amount | None:
        """Slope of the force at a compression (m); None beyond the curve."""
        curve = self._reaches(compression)
        return None if curve is None else Amount("installed_rate", curve.stiffness_at(compression))

    def shear(self, compression: float) -> Amount | None:
        """Largest shear of the wire at a compression (m), by its section loads or else by EN 13906-1."""
        force, per_force = self.force(compression), self.one.stress_per_force
        if force is not None and self.one.stress is not None:
            shear = self.one.stress.shear_at(np.array([compression]))
            return Amount("peak_shear_stress", float(shear.max()))
        if force is None or per_force is None:
            return None
        return Amount("nominal_shear_stress", per_force * force.value)

    def _reaches(self, compression: float) -> StaticCurve | None:
        curve = self.one.curve
        inside = curve is not None and curve.compression[0] <= compression <= curve.compression[-1]
        return curve if inside else None


def states_of(study: Study) -> tuple[State, ...]:
    """The springs at rest of a study in its order."""
    springs = {one.spring for one in study.rest}
    names = [one.spring for one in study.rest]
    several = len({one.model for one in study.rest if names.count(one.spring) > 1}) > 1
    found = []
    for one in study.rest:
        words = ((len(springs) > 1) * one.spring, several * one.model)
        label = f"{one.spring}, {one.model}"
        values = study.still.get(label, study.still.get("", {}))
        found.append(State(one, ", ".join(filter(None, words)), values))
    return tuple(found)


@dataclass(frozen=True)
class Together:
    """Both springs of a nested pair, whose loads and rates add up."""

    pair: tuple[State, State]
    name: str = TOGETHER

    @property
    def lift(self) -> float:
        """The largest lift (m); NaN where nothing lifts the springs."""
        return self.pair[0].lift

    def force(self, valve_lift: float) -> Amount | None:
        """Force of both at a lift (m); None beyond either curve."""
        return self._sum([one.force(one.one.precompression + valve_lift) for one in self.pair])

    def rate(self, valve_lift: float) -> Amount | None:
        """Rate of both at a lift (m); None beyond either curve."""
        return self._sum([one.rate(one.one.precompression + valve_lift) for one in self.pair])

    def curve(self) -> tuple[Array, Array, Array]:
        """Force (N) and rate (N/m) of both over the lift (m), from the free state of the longer to the first end; a
        spring that is not reached yet pushes with nothing.
        """
        known = [(one.one.precompression, one.one.curve) for one in self.pair if one.one.curve]
        least = min(-before for before, _ in known)
        most = min(curve.compression[-1] - before for before, curve in known)
        lifts = np.linspace(least, most, 201)
        shares = [
            [np.interp(lifts + before, curve.compression, one, left=0.0) for one in (curve.force, curve.stiffness)]
            for before, curve in known
        ]  # fmt: skip
        force, rate = np.sum(shares, axis=0)
        return lifts, force, rate

    def _sum(self, parts: list[Amount | None]) -> Amount | None:
        known = [one for one in parts if one is not None]
        if len(known) < len(parts):
            return None
        return Amount(known[0].name, sum(one.value for one in known))


def pair_of(states: tuple[State, ...]) -> Together | None:
    """The nested pair, each spring by the first model that knows it; None for other springs."""
    found = {one.one.spring: one for one in reversed(states)}
    if not all(name in found for name in NESTED):
        return None
    return Together((found[NESTED[0]], found[NESTED[1]]))


def marks_of(state: State) -> Iterator[tuple[str, float]]:
    """Name and compression (m) of the states that are marked on a curve."""
    if state.one.precompression:
        yield "installed", state.one.precompression
    curve = state.one.curve
    if curve is not None and curve.buckling is not None:
        yield "buckles", curve.buckling.compression
    if math.isfinite(state.full_lift):
        yield "full lift", state.full_lift
    if math.isfinite(state.solid):
        yield "solid", state.solid
