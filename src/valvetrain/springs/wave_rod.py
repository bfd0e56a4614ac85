"""Equivalent rod: the damped wave equation U'' + 2 mu U' = a**2 U_xixi, on a grid that a wave
crosses cell by cell.

With cell length a h (Courant number one) the explicit step IS d'Alembert's solution: a step of the
end velocity travels undistorted.
Source: Vasilyev, Bakhracheva and Storojakov, valve
gear model, equations 1 to 3.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs import wave_rod_kernels
from valvetrain.springs.contract import EndForces, Kernel, SpringEnergy, SpringOutputs
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.spec import NoOptions, SpringModelSpec
from valvetrain.units import keep_si

#: More cells than this add cost and no physics: the grid is then finer than any train excites.
MAX_CELLS = 1000


def cells_for_step(wave_speed: float, time_step: float, courant: float) -> int:
    """Largest number of cells that a step (s) of the train carries at a Courant number up to
    ``courant``.
    """
    if not time_step > 0:
        raise InputError(f"time step {time_step} s of the rod must be positive")
    return int(np.clip(np.floor(courant / (wave_speed * time_step) * (1 + 1e-9)), 3, MAX_CELLS))


@dataclass(frozen=True)
class WaveRod:
    """Uniform rod of ``cells`` cells with the rate, preload and mass of ``spring``.

    ``friction`` mu (1/s) of the wave equation (20 to 30 without a damper). Where it does not pull
    (``pulls``), an end cell longer than
    free is open: the rod has left its seat or its retainer. Half a cell and the inactive coils move
    with the retainer.

    >>> import valvetrain as vt
    >>> spring = WaveRod(vt.springs.EquivalentSpring(30e3, 250.0, 0.04))
    >>> round(spring.force(spring.initial_state(10e-3), 10e-3, 0.0).retainer)
    550
    """

    spring: EquivalentSpring
    cells: int = 200
    friction: float = 0.0
    name: str = "wave-rod"
    pulls: bool = True

    def __post_init__(self) -> None:
        keep_si(self, f"the rod of spring '{self.spring.name}'", friction="damping rate")
        if self.cells < 3:
            raise InputError(
                f"the rod of spring '{self.spring.name}' has {self.cells} cells; give at least 3 (200 is typical)"
            )
        if not self.friction >= 0:
            raise InputError(
                f"friction of the rod of spring '{self.spring.name}' is {self.friction} 1/s; give zero or a positive number"
            )

    @property
    def unknowns(self) -> int:
        return self.cells - 1

    @property
    def cell_stiffness(self) -> float:
        """Stiffness of one cell (N/m)."""
        return self.spring.rate * self.cells

    @property
    def cell_mass(self) -> float:
        """Mass of one cell (kg)."""
        return self.spring.active_mass / self.cells

    @property
    def kernel(self) -> Kernel:
        kernel: Kernel = wave_rod_kernels.advance_rod
        return kernel

    def parameters(self) -> Array:
        return np.array(
            [
                self.spring.preload,
                self.cell_stiffness,
                self.cell_mass,
                2 * self.friction,
                self._free,
            ]
        )

    @property
    def _free(self) -> float:
        """Shortening (m) of an end cell from the installed state at which it opens; below all
        others where the ends are held.
        """
        return -np.inf if self.pulls else -self.spring.preload / self.cell_stiffness

    def integers(self) -> Ints:
        return np.array([self.unknowns], dtype=np.int64)

    def with_time_step(self, time_step: float) -> WaveRod:
        """The grid whose Courant number at ``time_step`` (s) is as near one from below as whole
        cells allow.
        """
        return replace(self, cells=cells_for_step(self.spring.wave_speed, time_step, 1.0))

    def initial_state(self, retainer_displacement: float) -> Array:
        state = np.zeros(2 * self.unknowns + 1)
        shortening = (
            retainer_displacement
            if self.pulls
            else max(retainer_displacement, -self.spring.preload / self.spring.rate)
        )
        state[: self.unknowns] = shortening * np.arange(1, self.cells) / self.cells
        return state

    def stable_time_step(self) -> float:
        """Time (s) in which a wave crosses one cell: Courant number one."""
        return 1 / (self.spring.wave_speed * self.cells)

    def _nodes(self, state: Array, displacement: float) -> Array:
        return np.concatenate(([0.0], state[: self.unknowns], [displacement]))

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Elastic energy counted from the installed position."""
        n, nodes = self.unknowns, self._nodes(state, retainer_displacement)
        velocity, cells = state[n : 2 * n], np.diff(nodes)
        cells[[0, -1]] = np.maximum(cells[[0, -1]], self._free)
        if time_step > 0:
            kick = (
                self.cell_stiffness / self.cell_mass * np.diff(cells) - 2 * self.friction * velocity
            )
            velocity = velocity + time_step / 2 * kick
        elastic = self.spring.preload * np.sum(cells) + self.cell_stiffness * np.sum(cells**2) / 2
        return SpringEnergy(
            float(self.cell_mass * np.sum(velocity**2) / 2),
            float(elastic),
            0.0,
            float(state[2 * n]),
        )

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        ends = np.maximum([retainer_displacement - state[self.unknowns - 1], state[0]], self._free)
        return EndForces(*(self.spring.preload + self.cell_stiffness * ends).tolist())

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        return (
            self.cell_stiffness
            if retainer_displacement - state[self.unknowns - 1] >= self._free
            else 0.0
        )

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        """``coil_number`` is the share 0..1 of the active length: a uniform rod knows no turns."""
        velocity = np.concatenate(
            ([0.0], state[self.unknowns : 2 * self.unknowns], [retainer_velocity])
        )
        share = np.linspace(0.0, 1.0, self.cells + 1)
        return SpringOutputs(
            *self.force(state, retainer_displacement),
            share,
            -self._nodes(state, retainer_displacement),
            -velocity,
        )

    def retainer_mass(self) -> float:
        """Half a cell plus the inactive end coils (kg); the rest of the inertia acts through the
        waves.
        """
        return self.cell_mass / 2 + self.spring.inactive_mass


def wave_friction(spring: InstalledSpring, equivalent: EquivalentSpring) -> float:
    """Friction mu (1/s) of the wave equation that damps the first surge mode as the spring's own
    damping does: ratio * 2 pi f1.
    """
    frequency = equivalent.surge_frequency
    return float(spring.damping.ratio_at(frequency) * 2 * np.pi * frequency)


def _make(spring: InstalledSpring, options: NoOptions, rest: SpringAtRest | None) -> WaveRod:
    equivalent = EquivalentSpring.from_installed(spring)
    return WaveRod(equivalent, friction=wave_friction(spring, equivalent), pulls=spring.pulls)


SPEC = SpringModelSpec(
    "wave-rod",
    "equivalent rod",
    "#16877a",
    NoOptions,
    _make,
    shows=("sections",),
    processor_time=0.15,
    beside=("modal-uniform",),
    knows="the wave equation; a step travels undistorted",
    leaves_out="clash, change of rate while surging",
    citation="vasilyev2016",
)
