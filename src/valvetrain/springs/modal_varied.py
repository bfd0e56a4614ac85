"""Modal model with varied stiffness, equations 1 to 5 of Gu, Hou, Keating and Ye (2021), solved
exactly in Fourier space.

Over one cam cycle every harmonic exp(i j theta) of the lift y gives the same harmonic of mode n:
G_n = (2 / (n pi)) j**2 Y / (w**2 - j**2 + 2 i z w j), w = natural over cam frequency (equation 2
without approximation).

Signs. With G driven by -2/(n pi) y'' (equation 2) the wave equation gives k x0 + k y + pi k sum
(-1)**(n+1) n G_n at the fixed end and
k x0 + k y - pi k sum n G_n at the moving one. Equation 5 as printed adds + n G_n for every mode:
right at the fixed end for odd
modes, wrong for even ones. Both are returned. Stiffness k(x) is the secant of the static curve, so
slow motion follows it exactly.

Stepped in a train (the contract of ``springs.contract``) the same equations run in time. Where k(x)
is not constant the model's forces are
no exact gradient of an energy: its published form scales the modes' force with k(x) and keeps their
frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs import modal_kernels
from valvetrain.springs.contract import EndForces, SpringEnergy, SpringOutputs
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.modal_uniform import SECTIONS
from valvetrain.springs.spec import NoOptions, SpringModelSpec
from valvetrain.units import Given, keep_si, si, si_each

SAMPLES = 4096


@dataclass(frozen=True)
class ModalSolution:
    """One cam cycle: ``cam_angle`` (s,) rad, ``valve_lift`` (s,) m, ``modal_coordinates`` (modes,
    s) m, forces (s,) N.

    ``seat_force``: fixed end, signs of the wave equation. ``seat_force_as_printed``: equation 5
    letter by letter.
    """

    cam_angle: Array
    valve_lift: Array
    modal_coordinates: Array
    seat_force: Array
    seat_force_as_printed: Array
    retainer_force: Array


@dataclass(frozen=True)
class ModalVaried:
    """``natural_frequencies`` (Hz, one per mode), ``damping_ratio``, static curve ``compressions``
    (m from free) -> ``forces`` (N).

    ``precompression`` (m) is the installed compression x0; ``residual_mass`` (kg) what of the
    spring's inertia the modes do not carry.
    Where it does not pull (``pulls``) its end forces in time stop at zero; its modes, which are
    those of fixed ends, continue.
    Raises :class:`InputError` for a curve or frequencies that cannot be.

    >>> model = ModalVaried((433.0, 866.0), 0.02, (0.0, 10e-3, 20e-3), (0.0, 300.0, 640.0), precompression=8e-3)
    >>> round(model.force(model.initial_state(2e-3), 2e-3, 0.0).retainer)
    300
    """

    natural_frequencies: tuple[float, ...]
    damping_ratio: float
    compressions: tuple[float, ...]
    forces: tuple[float, ...]
    precompression: float
    residual_mass: float = 0.0
    name: str = "modal-varied"
    pulls: bool = True

    def __post_init__(self) -> None:
        for key, quantity in (
            ("natural_frequencies", "frequency"),
            ("compressions", "length"),
            ("forces", "force"),
        ):
            object.__setattr__(
                self, key, si_each(getattr(self, key), quantity, f"{key} of spring '{self.name}'")
            )
        keep_si(self, f"spring '{self.name}'", precompression="compression", residual_mass="mass")
        if (
            not self.natural_frequencies
            or min(self.natural_frequencies) <= 0
            or np.any(np.diff(self.natural_frequencies) <= 0)
        ):
            raise InputError(
                f"spring '{self.name}' needs positive, rising natural frequencies, one per mode"
            )
        if not 0 <= self.damping_ratio < 1:
            raise InputError(
                f"damping_ratio of spring '{self.name}' is {self.damping_ratio}; it must be between 0 and 1"
            )
        if (
            len(self.compressions) != len(self.forces)
            or len(self.forces) < 2
            or np.any(np.diff(self.compressions) <= 0)
        ):
            raise InputError(
                f"static curve of spring '{self.name}' needs two or more points of rising compression"
            )
        if not self.precompression > 0:
            raise InputError(
                f"precompression of spring '{self.name}' is {self.precompression} m; the model needs a preloaded spring"
            )

    def secant_stiffness(self, compression: ArrayLike) -> Array:
        """k(x) = F(x) / x (N/m) on the static curve; compression in m from the free state.

        Raises :class:`InputError` beyond the curve.
        """
        x = np.asarray(compression, dtype=float)
        if (
            np.any(x > self.compressions[-1] * (1 + 1e-9))
            or np.any(x < self.compressions[0])
            or np.any(x <= 0)
        ):
            raise InputError(
                f"static curve of spring '{self.name}' spans {1e3 * self.compressions[0]:g} to {1e3 * self.compressions[-1]:g} mm, "
                f"but the motion needs {1e3 * float(np.min(x)):.3f} to {1e3 * float(np.max(x)):.3f} mm; extend the curve"
            )
        found: Array = np.interp(x, self.compressions, self.forces) / x
        return found

    def solve(
        self,
        valve_lift: Callable[[Array], ArrayLike] | ArrayLike,
        cam_speed: Given,
        samples: int = SAMPLES,
    ) -> ModalSolution:
        """Steady periodic response over one cam revolution.

        ``valve_lift`` (m): function of the cam angle (rad), sampled at ``samples`` angles, or
        samples over one turn (end point left out);
        ``cam_speed`` in rad/s, text with a unit or a pint quantity.
        """
        cam_speed = si(cam_speed, "cam_speed", "cam_speed")
        if not cam_speed > 0:
            raise InputError(f"cam_speed is {cam_speed} rad/s; give a positive speed")
        moved, cam_angle = _sampled(valve_lift, samples)
        modal = self.modal_coordinates(moved, cam_speed)
        number = np.arange(1, len(self.natural_frequencies) + 1)
        stiffness = self.secant_stiffness(self.precompression + moved)
        static = stiffness * (self.precompression + moved)
        alternating = np.pi * stiffness * (((-1.0) ** (number + 1) * number) @ modal)
        printed = np.pi * stiffness * (number @ modal)
        return ModalSolution(
            cam_angle, moved, modal, static + alternating, static + printed, static - printed
        )

    def modal_coordinates(self, valve_lift: Array, cam_speed: float) -> Array:
        """G_n (m) at the samples of one cam revolution, shape (modes, samples), harmonic by harmonic."""
        harmonic = np.arange(len(valve_lift) // 2 + 1)
        spectrum = np.fft.rfft(valve_lift)
        number = np.arange(1, len(self.natural_frequencies) + 1)[:, None]
        ratio = 2 * np.pi * np.asarray(self.natural_frequencies)[:, None] / cam_speed
        transfer = (
            2
            / (np.pi * number)
            * harmonic**2
            / (ratio**2 - harmonic**2 + 2j * self.damping_ratio * ratio * harmonic)
        )
        return np.fft.irfft(transfer * spectrum, n=len(valve_lift), axis=1)

    @property
    def unknowns(self) -> int:
        return len(self.natural_frequencies)

    @property
    def kernel(self) -> Any:
        return modal_kernels.advance_modal_varied

    @cached_property
    def _numbers(self) -> Array:
        """Mode numbers 1, 2, ..."""
        return np.arange(1.0, self.unknowns + 1)

    @cached_property
    def _frequencies(self) -> Array:
        """Circular frequencies (rad/s)."""
        return 2 * np.pi * np.asarray(self.natural_frequencies)

    @cached_property
    def shares(self) -> Array:
        """Fourier coefficients c_n of the moving static shape: xi = sum c_n sin(n pi xi)."""
        return 2 * (-1.0) ** (self._numbers + 1) / (np.pi * self._numbers)

    @cached_property
    def modal_stiffness(self) -> Array:
        """Stiffness of mode n over k(x): (n pi)**2 / 2."""
        return (np.pi * self._numbers) ** 2 / 2

    def parameters(self) -> Array:
        ratio = np.full(self.unknowns, self.damping_ratio)
        per_mode = np.column_stack(
            (self.shares, self._frequencies, ratio, self.modal_stiffness, np.pi * self._numbers)
        )
        return np.concatenate(
            (
                [self.precompression, 0.0, 0.0, float(not self.pulls)],
                per_mode.ravel(),
                self.compressions,
                self.forces,
            )
        )

    def integers(self) -> Ints:
        return np.array([self.unknowns, len(self.forces)], dtype=np.int64)

    def with_time_step(self, time_step: float) -> ModalVaried:
        return self

    def initial_state(self, retainer_displacement: float) -> Array:
        state = np.zeros(4 * self.unknowns + 2)
        state[: self.unknowns] = self.shares * retainer_displacement
        return state

    def stable_time_step(self) -> float:
        """2 / highest circular frequency (s): the modes themselves are exact, their coupling to the
        train is not.
        """
        return float(2 / self._frequencies[-1])

    def _static(self, retainer_displacement: float) -> tuple[float, float, float]:
        """Static force (N), its slope (N/m) and the secant stiffness (N/m); beyond the curve the
        last slopes continue.
        """
        x, f = self.compressions, self.forces
        at = self.precompression + retainer_displacement
        place = int(np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2))
        slope = (f[place + 1] - f[place]) / (x[place + 1] - x[place])
        force = f[place] + slope * (at - x[place])
        return force, slope, force / at if at > 0 else slope

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Energies (J) with the modes at the present k(x); elastic energy is counted from the
        installed position.
        """
        n, omega = self.unknowns, self._frequencies
        departure, velocity = state[:n] - self.shares * retainer_displacement, state[n : 2 * n]
        if time_step > 0:
            relative = velocity - self.shares * retainer_velocity
            velocity = velocity - time_step / 2 * (
                omega**2 * departure + 2 * self.damping_ratio * omega * relative
            )
        stiffness = self._static(retainer_displacement)[2] * self.modal_stiffness
        grid = np.linspace(0.0, retainer_displacement, 65)
        force = np.array([self._static(float(x))[0] for x in grid])
        kinetic = np.sum(stiffness / omega**2 * velocity**2) / 2
        elastic = np.trapezoid(force, grid) + stiffness @ departure**2 / 2
        return SpringEnergy(float(kinetic), float(elastic), 0.0, float(state[2 * n]))

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        n = self.unknowns
        departure = state[:n] - self.shares * retainer_displacement
        relative = state[n : 2 * n] - self.shares * retainer_velocity
        pull = departure + 2 * self.damping_ratio / self._frequencies * relative
        static, _, stiffness = self._static(retainer_displacement)
        retainer = static - stiffness * float((self.shares * self.modal_stiffness) @ pull)
        seat = static + stiffness * np.pi * float(self._numbers @ pull)
        return (
            EndForces(retainer, seat)
            if self.pulls
            else EndForces(max(retainer, 0.0), max(seat, 0.0))
        )

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        """Slope of the curve plus the modes' share at the present k(x)."""
        _, slope, stiffness = self._static(retainer_displacement)
        departure = state[: self.unknowns] - self.shares * retainer_displacement
        at = self.precompression + retainer_displacement
        change = (slope - stiffness) / at if at > 0 else 0.0
        modes = stiffness * self.shares**2 - change * self.shares * departure
        return float(slope + self.modal_stiffness @ modes)

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        """``coil_number`` is the share 0..1 of the active length."""
        share, n = np.linspace(0.0, 1.0, SECTIONS), self.unknowns
        shapes = np.sin(np.pi * np.outer(share, self._numbers))
        departure = state[:n] - self.shares * retainer_displacement
        velocity = state[n : 2 * n] - self.shares * retainer_velocity
        shift = share * retainer_displacement + shapes @ departure
        forces = self.force(state, retainer_displacement, retainer_velocity)
        return SpringOutputs(
            *forces, share, -shift, -(share * retainer_velocity + shapes @ velocity)
        )

    def retainer_mass(self) -> float:
        """What of the spring's inertia the modes do not carry (kg)."""
        return self.residual_mass


def _sampled(
    valve_lift: Callable[[Array], ArrayLike] | ArrayLike, samples: int
) -> tuple[Array, Array]:
    if callable(valve_lift):
        cam_angle = 2 * np.pi * np.arange(samples) / samples
        return np.asarray(valve_lift(cam_angle), dtype=float), cam_angle
    given = np.asarray(valve_lift, dtype=float)
    if given.ndim != 1 or len(given) < 16 or not np.all(np.isfinite(given)):
        raise InputError(
            "lift samples must be a row of at least 16 finite numbers over one cam revolution"
        )
    return given, 2 * np.pi * np.arange(len(given)) / len(given)


def _make(spring: InstalledSpring, options: NoOptions, rest: SpringAtRest | None) -> ModalVaried:
    """k(x) and frequencies of the spring at rest; of a card the straight line and the frequencies
    of the uniform bar.
    """
    if spring.card is not None:
        equivalent = EquivalentSpring.from_installed(spring)
        first, x0 = equivalent.surge_frequency, max(spring.precompression, 1e-6)
        frequencies, compressions = tuple(first * n for n in (1.0, 2.0, 3.0)), (x0 * 1e-3, 100 * x0)
        forces = tuple(equivalent.rate * x for x in compressions)
    else:
        if rest is None or rest.curve is None or rest.modes is None:
            raise InputError(
                f"the modal model of spring '{spring.name}' needs its static curve and modes; compute them first"
            )
        equivalent = None
        frequencies = tuple(float(value) for value in rest.modes.axial_frequencies)
        if not frequencies:
            raise InputError(
                f"spring '{spring.name}' shows no axial mode; refine its mesh or choose another model"
            )
        compressions, forces = (
            tuple(rest.curve.compression.tolist()),
            tuple(rest.curve.force.tolist()),
        )
    damping = spring.damping
    ratio = damping.ratio if damping.ratio is not None else damping.ratio_at(frequencies[0])
    model = ModalVaried(
        frequencies,
        ratio,
        compressions,
        forces,
        max(spring.precompression, 1e-6),
        pulls=spring.pulls,
    )
    uniform = equivalent or EquivalentSpring.from_installed(spring)
    stiffness = model._static(0.0)[2]
    carried = float(
        np.sum(
            stiffness
            * model.modal_stiffness
            / (2 * np.pi * np.asarray(frequencies)) ** 2
            * model.shares**2
        )
    )
    return replace(
        model, residual_mass=max(uniform.active_mass / 3 - carried, 0.0) + uniform.inactive_mass
    )


SPEC = SpringModelSpec(
    "modal-varied",
    "modal model with varied stiffness",
    "#d9772b",
    NoOptions,
    _make,
    shows=("sections",),
    needs_rest=True,
    processor_time=0.2,
    beside=("wave-rod",),
    knows="surge modes, k(x) as published",
    leaves_out="clash",
    citation="gu2021",
)
