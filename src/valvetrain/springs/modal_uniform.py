"""Modal spring of fixed stiffness: the static shape moving with the retainer plus any number of
surge modes.

Equations 1, 2 and 5 of Gu, Hou, Keating and Ye (2021) in the time domain. With
U = x xi + sum q_n sin(n pi xi) (xi = 0 at the seat, 1 at the retainer) mode n obeys
q'' + 2 z w q' + w**2 q = -c x'', c = 2 (-1)**(n+1) / (n pi). Stepping p = q + c x removes x'' and
leaves exact bookkeeping:
the retainer feels k x - sum c kappa q and the residual mass that the modes do not carry.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs import modal_kernels
from valvetrain.springs.contract import EndForces, Kernel, SpringEnergy, SpringOutputs
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.spec import SpringModelSpec
from valvetrain.units import keep_si, si_each

#: Places along the spring at which section motion is shown.
SECTIONS = 25


@dataclass(frozen=True)
class ModalUniform:
    """``modes`` surge modes of ``spring``; ``natural_frequencies`` (Hz) replace those of the
    uniform bar, n f1, where given.

    ``damping_ratio`` acts on every mode's departure from the static shape (the source's zeta),
    ``stiffness_damping`` (s) adds
    w * s / 2 to it; ``mass_damping`` (1/s) acts on the absolute modal velocity. Where it
    does not pull (``pulls``) its end forces stop at zero; its modes, which are those of fixed ends,
    continue. Residual inertia and inactive
    coils move with the retainer.

    >>> import valvetrain as vt
    >>> model = ModalUniform(vt.springs.EquivalentSpring(30e3, 250.0, 0.04), modes=3)
    >>> [round(float(value) / 6.283185) for value in model.circular_frequencies]
    [433, 866, 1299]
    """

    spring: EquivalentSpring
    modes: int = 5
    natural_frequencies: tuple[float, ...] = ()
    damping_ratio: float = 0.0
    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    name: str = "modal-uniform"
    pulls: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(
            self,
            "natural_frequencies",
            si_each(self.natural_frequencies, "frequency", "natural_frequencies"),
        )
        keep_si(
            self,
            f"modal spring '{self.spring.name}'",
            mass_damping="damping rate",
            stiffness_damping="time",
        )
        label = f"modal spring '{self.spring.name}'"
        if self.modes < 1:
            raise InputError(f"{label} has {self.modes} modes; give at least 1")
        if self.natural_frequencies and len(self.natural_frequencies) != self.modes:
            raise InputError(
                f"{label} has {self.modes} modes but {len(self.natural_frequencies)} frequencies; give one per mode"
            )
        if self.natural_frequencies and (
            min(self.natural_frequencies) <= 0 or np.any(np.diff(self.natural_frequencies) <= 0)
        ):
            raise InputError(f"frequencies of {label} must be positive and rising")
        for key in ("damping_ratio", "mass_damping", "stiffness_damping"):
            if not getattr(self, key) >= 0:
                raise InputError(
                    f"{key} of {label} is {getattr(self, key)}; give zero or a positive number"
                )
        if np.max(self.ratios) >= 1:
            raise InputError(
                f"damping of {label} exceeds critical in its highest mode; lower stiffness_damping or take fewer modes"
            )

    @cached_property
    def numbers(self) -> Array:
        """Mode numbers 1 .. modes."""
        return np.arange(1.0, self.modes + 1)

    @cached_property
    def circular_frequencies(self) -> Array:
        """Circular frequency of every mode (rad/s), shape (modes,)."""
        if self.natural_frequencies:
            return 2 * np.pi * np.asarray(self.natural_frequencies)
        return np.pi * self.numbers * self.spring.wave_speed

    @cached_property
    def ratios(self) -> Array:
        """Damping ratio of every mode on its departure from the static shape."""
        return self.damping_ratio + self.stiffness_damping * self.circular_frequencies / 2

    @cached_property
    def shares(self) -> Array:
        """Fourier coefficients c_n of the moving static shape: xi = sum c_n sin(n pi xi)."""
        return 2 * (-1.0) ** (self.numbers + 1) / (np.pi * self.numbers)

    @cached_property
    def modal_stiffness(self) -> Array:
        """k (n pi)**2 / 2 (N/m) of mode n."""
        return self.spring.rate * (np.pi * self.numbers) ** 2 / 2

    @cached_property
    def sections(self) -> tuple[Array, Array]:
        """Places (0 seat, 1 retainer) at which motion is shown, and every mode's shape there,
        (sections, modes).
        """
        share = np.linspace(0.0, 1.0, SECTIONS)
        return share, np.sin(np.pi * np.outer(share, self.numbers))

    @property
    def unknowns(self) -> int:
        return self.modes

    @property
    def kernel(self) -> Kernel:
        kernel: Kernel = modal_kernels.advance_modal
        return kernel

    def parameters(self) -> Array:
        per_mode = np.column_stack(
            (
                self.shares,
                self.circular_frequencies,
                self.ratios,
                self.modal_stiffness,
                self.spring.rate * np.pi * self.numbers,
            )
        )
        return np.concatenate(
            (
                [self.spring.preload, self.spring.rate, self.mass_damping, float(not self.pulls)],
                per_mode.ravel(),
            )
        )

    def integers(self) -> Ints:
        return np.array([self.modes], dtype=np.int64)

    def with_time_step(self, time_step: float) -> ModalUniform:
        return self

    def initial_state(self, retainer_displacement: float) -> Array:
        state = np.zeros(4 * self.modes + 2)
        state[: self.modes] = self.shares * retainer_displacement
        return state

    def stable_time_step(self) -> float:
        """2 / highest circular frequency (s): the modes themselves are exact, their coupling to the
        train is not.
        """
        return float(2 / self.circular_frequencies[-1])

    def _departures(self, state: Array, displacement: float) -> Array:
        return state[: self.modes] - self.shares * displacement

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Elastic energy counted from the installed position; the residual mass belongs to the
        valve.
        """
        departure, velocity = (
            self._departures(state, retainer_displacement),
            state[self.modes : 2 * self.modes],
        )
        omega = self.circular_frequencies
        if time_step > 0:
            relative = velocity - self.shares * retainer_velocity
            velocity = velocity - time_step / 2 * (
                omega**2 * departure
                + 2 * self.ratios * omega * relative
                + self.mass_damping * velocity
            )
        static = (
            self.spring.preload * retainer_displacement
            + self.spring.rate * retainer_displacement**2 / 2
        )
        kinetic = np.sum(self.modal_stiffness / omega**2 * velocity**2) / 2
        return SpringEnergy(
            float(kinetic),
            float(static + self.modal_stiffness @ departure**2 / 2),
            0.0,
            float(state[2 * self.modes]),
        )

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        departure = self._departures(state, retainer_displacement)
        relative = state[self.modes : 2 * self.modes] - self.shares * retainer_velocity
        pull = departure + 2 * self.ratios / self.circular_frequencies * relative
        static = self.spring.preload + self.spring.rate * retainer_displacement
        seat = static + self.spring.rate * np.pi * (self.numbers @ pull)
        ends = np.array([static - (self.shares * self.modal_stiffness) @ pull, seat])
        return EndForces(*(ends if self.pulls else np.maximum(ends, 0.0)).tolist())

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        return float(self.spring.rate + self.modal_stiffness @ self.shares**2)

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        """``coil_number`` is the share 0..1 of the active length."""
        share, shapes = self.sections
        velocity = state[self.modes : 2 * self.modes] - self.shares * retainer_velocity
        shift = share * retainer_displacement + shapes @ self._departures(
            state, retainer_displacement
        )
        return SpringOutputs(
            *self.force(state, retainer_displacement, retainer_velocity),
            share,
            -shift,
            -(share * retainer_velocity + shapes @ velocity),
        )

    def retainer_mass(self) -> float:
        """A third of the active mass less what the modes carry, plus the inactive coils (kg)."""
        carried = float(
            np.sum(self.modal_stiffness / self.circular_frequencies**2 * self.shares**2)
        )
        return max(self.spring.active_mass / 3 - carried, 0.0) + self.spring.inactive_mass


#: Modes by default: forces of trains are within 1 % of their limit up to float speed.
MODES = 40


class ModalUniformOptions(SpringOptions):
    """Options of the modal model of a uniform spring."""

    modes: int = Field(
        default=MODES,
        ge=1,
        le=500,
        description="natural modes taken along; where it is not given, only those below critical damping",
    )


def oscillating_modes(spring: InstalledSpring, most: int) -> int:
    """How many of the ``most`` lowest modes damping leaves below critical, at least one."""
    first = 2 * np.pi * EquivalentSpring.from_installed(spring).surge_frequency
    circular = first * np.arange(1, most + 1)
    damping = spring.damping
    ratios = 0.5 * (damping.mass_damping / circular + damping.stiffness_damping * circular)
    return max(int(np.argmin(np.append(ratios < 0.95, False))), 1)


def _make(
    spring: InstalledSpring, options: ModalUniformOptions, rest: SpringAtRest | None
) -> ModalUniform:
    damping, uniform = spring.damping, EquivalentSpring.from_installed(spring)
    modes = options.modes
    if "modes" not in options.model_fields_set:
        modes = oscillating_modes(spring, MODES)
    return ModalUniform(
        uniform,
        modes,
        mass_damping=damping.mass_damping,
        stiffness_damping=damping.stiffness_damping,
        pulls=spring.pulls,
    )


SPEC = SpringModelSpec(
    "modal-uniform",
    "modal model",
    "#b0891e",
    ModalUniformOptions,
    _make,
    shows=("sections",),
    processor_time=0.2,
    beside=("wave-rod",),
    knows="surge modes of a uniform spring of equal rate, mass and first frequency",
    leaves_out="clash, change of rate",
    citation="gu2021",
)
