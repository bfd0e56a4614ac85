"""Static compression of a spring: force and stiffness over compression, with coils closing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.status import COMPLETED, Status

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StaticCurve:
    """Static curve from the free state; SI, shapes beside the names.

    ``compression`` (step) m, ``force`` (step) N, ``stiffness`` (step) N/m tangent; ``coil_gap`` (step, coil_pair) m and
    ``coil_contact_force`` (step, coil_pair) N with ``upper_coil`` (coil_pair); ``axial_position`` (step, wire_point) m
    with ``coil_number`` (wire_point). Arrays that a model does not compute have zero pairs or points.
    """

    compression: Array
    force: Array
    stiffness: Array
    coil_gap: Array
    coil_contact_force: Array
    upper_coil: Array
    axial_position: Array
    coil_number: Array
    status: Status = COMPLETED

    def __post_init__(self) -> None:
        steps, pairs, points = len(self.compression), len(self.upper_coil), len(self.coil_number)
        expected = {
            "force": (steps,), "stiffness": (steps,), "coil_gap": (steps, pairs),
            "coil_contact_force": (steps, pairs), "axial_position": (steps, points),
        }  # fmt: skip
        for name, shape in expected.items():
            if np.shape(getattr(self, name)) != shape:
                raise InputError(f"{name} of a static curve must have shape {shape}; it has {np.shape(getattr(self, name))}")

    def force_at(self, compression: float) -> float:
        """Force (N) at a compression (m), straight between steps; :class:`InputError` outside the curve."""
        return self._interpolate(compression, self.force)

    def stiffness_at(self, compression: float) -> float:
        """Tangent stiffness (N/m) at a compression (m), straight between steps; :class:`InputError` outside the curve."""
        return self._interpolate(compression, self.stiffness)

    def _interpolate(self, compression: float, values: Array) -> float:
        first, last = float(self.compression[0]), float(self.compression[-1])
        if not first - 1e-12 <= compression <= last + 1e-12:
            reach = f"{first * 1e3:g} to {last * 1e3:g} mm"
            raise InputError(f"compression {compression * 1e3:g} mm lies outside the static curve ({reach}); compute it further")
        return float(np.interp(compression, self.compression, values))


@dataclass(frozen=True, eq=False)
class StaticStress:
    """Stress at the inner fibre over compression: ``compression`` (n,) m, ``coil_number`` (p,), ``shear`` and ``equivalent`` (n, p) Pa."""

    compression: Array
    coil_number: Array
    shear: Array
    equivalent: Array

    def shear_at(self, compression: Array) -> Array:
        """Shear (m, p) Pa at compressions (m,) m, straight between the steps and level beyond them."""
        return np.stack([np.interp(compression, self.compression, column) for column in self.shear.T], axis=-1)


@dataclass(frozen=True, eq=False)
class SpringAtRest:
    """One installed spring by one model at rest: ``spring`` names the spring, ``model`` what computed it.

    ``curve``: static curve from the free state; ``modes``: natural frequencies about the installed state; ``stress``: stress over
    compression; each None where the model does not give it. ``facts``: mesh and cost in words; ``wall_time`` (s).
    """

    spring: str
    model: str
    precompression: float = 0.0
    curve: StaticCurve | None = None
    modes: ModalResult | None = None
    stress: StaticStress | None = None
    facts: Mapping[str, float | int | str] = field(default_factory=dict)
    wall_time: float = 0.0
