"""A law of contact between coils given in Python: force per length of wire as a function of overlap."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from pydantic import Field

from valvetrain import registry
from valvetrain.coil_contact.law import CoilContactLaw, CoilContactSpec, CoilKernel
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import CoilContact
from valvetrain.parameters.own_parts import compiled_number
from valvetrain.parameters.schema_types import PositiveLength, StrictModel

#: Share of an overlap over which its tangent is taken, and the least (m).
STEP, LEAST = 1e-4, 1e-13
_NODES, _WEIGHTS = (
    0.5 * (1 + np.polynomial.legendre.leggauss(10)[0]),
    0.5 * np.polynomial.legendre.leggauss(10)[1],
)


@dataclass(frozen=True)
class FunctionCoilContact:
    """The function given under ``name``, over ``stiffness`` (N/m per m of wire) of the case, up to a
    ``deepest_overlap`` (m) that the time step resolves.
    """

    name: str
    stiffness: float
    deepest_overlap: float = 1e-4

    @property
    def kernel(self) -> CoilKernel:
        kernel: CoilKernel = _compiled(self.name)[1]
        return kernel

    @cached_property
    def steepest(self) -> float:
        function = _compiled(self.name)[0]
        places = self.deepest_overlap * np.linspace(0.0, 1.0, 65)
        forces = np.array([0.0, *(function(float(g)) for g in places[1:])])
        return float(np.max(np.diff(forces) / np.diff(places))) / self.stiffness

    def parameters(self) -> tuple[float, ...]:
        return (self.stiffness,)


class FunctionCoilContactTable(StrictModel):
    """The key that it has beside those of the linear law."""

    deepest_overlap: PositiveLength = Field(
        default=1e-4, description="overlap up to which the time step is stable"
    )


def spec_of(word: str, part: Any) -> CoilContactSpec:
    """The entry of the registry for a law given in Python: a function, a law or its spec."""
    if isinstance(part, CoilContactSpec):
        return part
    if isinstance(part, CoilContactLaw) and not isinstance(part, type):
        return CoilContactSpec(type(part), StrictModel, lambda contact: part)
    return CoilContactSpec(FunctionCoilContact, FunctionCoilContactTable, _build)


def _build(contact: CoilContact) -> CoilContactLaw:
    _compiled(contact.law)  # what is no law is refused where the spring is built
    return FunctionCoilContact(contact.law, contact.stiffness, **contact.values)


@cache
def _compiled(name: str) -> tuple[Any, Any]:
    """The function of the overlap, and the kernel of the law, both compiled."""
    import numba

    label = f"law '{registry.plain_name(name)}' of contact between coils"
    given, _ = compiled_number(registry.OWN[name], (1,), label, "the overlap (m) alone", (1e-6,))
    function = numba.njit(lambda overlap: 1.0 * given(overlap))
    if not function(1e-5) > 0:
        raise InputError(
            f"{label} gives {function(1e-5):g} N/m at an overlap of 0.01 mm, which presses nothing apart; a force is positive where coils overlap"
        )
    nodes, weights = _NODES, _WEIGHTS

    @numba.njit
    def kernel(parameters, damping_time, overlap):  # type: ignore[no-untyped-def]
        scale, step = 1.0 / parameters[0], STEP * overlap + LEAST
        low = max(overlap - step, 0.0)
        tangent = scale * (function(overlap + step) - function(low)) / (overlap + step - low)
        energy = 0.0
        for i in range(
            nodes.shape[0]
        ):  # the overlap as a square: a law may begin with a fractional power
            energy += weights[i] * 2.0 * nodes[i] * function(overlap * nodes[i] * nodes[i])
        return (
            scale * function(overlap),
            tangent,
            scale * overlap * energy,
            damping_time * max(tangent, 0.0),
        )

    return function, kernel
