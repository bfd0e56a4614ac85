"""A contact law given in Python as a function of penetration and its rate, compiled for the loops."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain import registry
from valvetrain.arrays import Array
from valvetrain.contact.kernels import OWN_LAW
from valvetrain.contact.law import SLOWEST_IMPACT, ContactLaw, ContactSpec, LawKernel
from valvetrain.errors import InputError
from valvetrain.parameters.own_parts import compiled_number
from valvetrain.parameters.schema_contact import ContactTable

#: Slowest rate (m/s) whose share of the force counts as damping, and step of differences over a
#: penetration, with the least (m).
SLOW, STEP, LEAST = 1e-9, 1e-4, 1e-12


@dataclass(frozen=True)
class FunctionContact:
    """The force of the function given under ``name``, zero without overlap and never pulling."""

    name: str
    states: ClassVar[int] = 0
    code: ClassVar[int] = OWN_LAW

    @property
    def kernel(self) -> LawKernel:
        kernel: LawKernel = _compiled(self.name)[1]
        return kernel

    def parameters(self) -> Array:
        return np.zeros(8)

    def force(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        function = _compiled(self.name)[0]
        depth, rate = np.broadcast_arrays(
            np.asarray(penetration, dtype=float), np.asarray(penetration_rate, dtype=float)
        )
        pairs = zip(depth.ravel().tolist(), rate.ravel().tolist(), strict=True)
        found = [max(function(*pair), 0.0) if pair[0] > 0 else 0.0 for pair in pairs]
        return np.array(found).reshape(depth.shape)

    def tangent(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        depth = np.asarray(penetration, dtype=float)
        step = STEP * np.maximum(depth, 0.0) + LEAST
        rise = self.force(depth + step, penetration_rate) - self.force(
            np.maximum(depth - step, LEAST), penetration_rate
        )
        slope = rise / (depth + step - np.maximum(depth - step, LEAST))
        return np.where(self.force(depth, penetration_rate) > 0, slope, 0.0)

    def dissipated_power(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        elastic = self.force(penetration, np.zeros_like(np.asarray(penetration_rate, dtype=float)))
        power: Array = (self.force(penetration, penetration_rate) - elastic) * np.asarray(
            penetration_rate
        )
        return power

    def stiffness(self, penetration: float) -> float:
        return float(self.tangent(max(penetration, 1e-9), 0.0))


def spec_of(word: str, part: Any) -> ContactSpec:
    """The entry of the registry for a law given in Python: a function, a law or its ``ContactSpec``."""
    return part if isinstance(part, ContactSpec) else ContactSpec(FunctionContact, ContactTable)


def own_law(name: str) -> ContactLaw:
    """The law given in Python under ``name``. Raises :class:`InputError` for what is no law."""
    part = registry.OWN[name]
    if isinstance(part, ContactLaw) and not isinstance(part, type):
        return part
    _compiled(name)
    return FunctionContact(name)


@cache
def _compiled(name: str) -> tuple[Any, Any]:
    """The function of penetration and rate, and the kernel of the law, both compiled."""
    import numba

    part, label = registry.OWN[name], f"contact law '{registry.plain_name(name)}'"
    needs = "the penetration (m), or of it and its rate (m/s)"
    given, count = compiled_number(part, (1, 2), label, needs, (1e-6, 1e-3))
    if count == 1:
        function = numba.njit(lambda depth, rate: 1.0 * given(depth))
    else:
        function = numba.njit(lambda depth, rate: 1.0 * given(depth, rate))
    still = function(1e-5, 0.0)
    if not still > 0:
        raise InputError(
            f"{label} gives {still:g} N at a penetration of 0.01 mm, which presses nothing apart; a force is positive where bodies overlap"
        )

    @numba.njit
    def kernel(parameters, memory, penetration, before, rate, step):  # type: ignore[no-untyped-def]
        if penetration <= 0.0:
            return 0.0, 0.0
        elastic = max(function(penetration, 0.0), 0.0)
        way = rate if abs(rate) > SLOW else SLOW
        return elastic, max((function(penetration, way) - elastic) / way, 0.0)

    return function, kernel
