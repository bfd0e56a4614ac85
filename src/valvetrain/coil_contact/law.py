"""What a law of contact between coils answers, the linear law that ships, and how a case names one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numba
import numpy as np
from numba import cfunc
from numpy.typing import ArrayLike

from valvetrain import registry
from valvetrain.arrays import Array
from valvetrain.coil_contact import kernels
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import CoilContact
from valvetrain.parameters.schema_types import StrictModel

CoilKernel = Callable[[Array, float, float], tuple[float, float, float, float]]
"""``kernel(parameters, damping_time, overlap) -> (force, tangent, energy, damping)`` of a contact of
unit stiffness at an overlap > 0 (m): times the stiffness (N/m) of a contact they are its elastic
force (N), the derivative (N/m), the stored energy (J) and the damping coefficient (N s/m).
"""


@runtime_checkable
class CoilContactLaw(Protocol):
    """A law of contact between coils, and between coils and seats: overlap g (m, positive when they
    press) and closing speed dg/dt (m/s) to a force that never pulls.

    Every law is a shape times the stiffness of a contact (``stiffness`` of the case, N/m per m of
    wire, times its length of wire): force = stiffness * max(0, f(g) + c(g) dg/dt), energy =
    stiffness * (integral of f). ``damping_time`` (s) of the case is a damping over a stiffness.
    """

    @property
    def name(self) -> str: ...

    @property
    def kernel(self) -> CoilKernel | None:
        """Compiled function (``numba.njit``) of the shape; None for the linear law."""
        ...

    @property
    def steepest(self) -> float:
        """Largest tangent of a contact of unit stiffness that the time step must resolve, 1 for the
        linear law; ``damping_time`` times it bounds the damping.
        """
        ...

    def parameters(self) -> Sequence[float]:
        """Up to eight numbers for the kernel (SI)."""
        ...


@dataclass(frozen=True)
class LinearCoilContact:
    """k l (g + tau dg/dt), never adhesive: the law of every case that names no other.

    >>> isinstance(LinearCoilContact(), CoilContactLaw)
    True
    """

    name = "linear"
    kernel = None
    steepest = 1.0

    def parameters(self) -> Sequence[float]:
        return ()


LINEAR: CoilContactLaw = LinearCoilContact()


class ContactResponse(NamedTuple):
    """``force`` and its ``elastic`` part (N), stored ``energy`` (J), ``tangent`` (N/m) and
    ``damping`` (N s/m) of contacts, the last two where the force presses.
    """

    force: Array
    elastic: Array
    energy: Array
    tangent: Array
    damping: Array


def contact_response(
    law: CoilContactLaw,
    overlap: ArrayLike,
    closing: ArrayLike = 0.0,
    damping_time: float = 0.0,
    *,
    stiffness: ArrayLike = 1.0,
    early: bool = False,
) -> ContactResponse:
    """The law at arrays of overlap (m) and closing speed (m/s) of contacts of a ``stiffness`` (N/m),
    by default one; ``early`` as in :func:`~valvetrain.coil_contact.kernels.evaluate_contacts`.

    >>> found = contact_response(LINEAR, [-1e-6, 1e-6, 1e-6], [0.0, 0.0, -2.0], damping_time=1e-6)
    >>> found.force.tolist(), found.elastic.tolist()
    ([0.0, 1e-06, 0.0], [0.0, 1e-06, 1e-06])
    """
    if law.kernel is None and not damping_time:
        pressed = np.maximum(np.asarray(overlap, dtype=float), 0.0)
        each = np.asarray(stiffness, dtype=float)
        force, touching = each * pressed, each * (pressed > 0.0)
        return ContactResponse(
            force, force, 0.5 * force * pressed, touching, np.zeros_like(pressed)
        )
    given = (np.asarray(one, dtype=float) for one in (overlap, closing, stiffness))
    depth, rate, each = np.broadcast_arrays(*given)
    found = np.empty((5, depth.size))
    kernels.evaluate_contacts(
        law_address(law),
        law_numbers(law),
        damping_time,
        early,
        each.flatten(),  # a copy: numba warns of a broadcast view
        depth.flatten(),
        rate.flatten(),
        found,
    )
    return ContactResponse(*found.reshape(5, *depth.shape))


def law_numbers(law: CoilContactLaw) -> Array:
    """The parameters of a law as the row that compiled loops hold."""
    if law.kernel is None:
        return kernels.NO_NUMBERS
    given = np.asarray(law.parameters(), dtype=float)
    if len(given) > kernels.WIDTH:
        raise InputError(
            f"law '{law.name}' of contact between coils has {len(given)} parameters; give at most {kernels.WIDTH}"
        )
    return np.concatenate((given, np.zeros(kernels.WIDTH - len(given))))


def law_address(law: CoilContactLaw) -> int:
    """Address in this process of the compiled kernel of ``law``; it means nothing in another one."""
    return kernels.LINEAR if law.kernel is None else _address(law.kernel)


@cache
def _address(kernel: CoilKernel) -> int:
    compiled: Any = kernel if hasattr(kernel, "py_func") else numba.njit(kernel)
    carray: Any = numba.carray  # type: ignore[attr-defined]

    def entry(numbers: Any, damping_time: Any, overlap: Any, reply: Any) -> None:
        out = carray(reply, 4)
        out[0], out[1], out[2], out[3] = compiled(
            carray(numbers, kernels.WIDTH), damping_time, overlap
        )

    built = cfunc(kernels.ENTRY)(entry)
    _ENTRIES.append(built)
    address: Any = built.address
    return int(address)


#: Compiled entries live as long as the process: loops hold nothing but their addresses.
_ENTRIES: list[Any] = []


@dataclass(frozen=True, slots=True)
class CoilContactSpec:
    """``law``: dataclass of the law, whose fields are the values of its own. ``table``: the keys in
    a case file that it alone has. ``build``: makes a law that is more
    than its values from the contact of a spring.
    """

    law: type[Any]
    table: type[StrictModel] = StrictModel
    build: Callable[[CoilContact], CoilContactLaw] | None = None


LINEAR_SPEC = CoilContactSpec(LinearCoilContact)


def law_of(contact: CoilContact) -> CoilContactLaw:
    """The law that a spring's coil contact names. Raises :class:`InputError` with the nearest name
    for an unknown one, and for values that it does not take.
    """
    if contact.law == LINEAR.name and not contact.values:
        return LINEAR
    spec: CoilContactSpec = registry.find("coil_contacts", contact.law)
    own = [one.name for one in fields(spec.law) if one.init]
    for key in contact.values:
        if key not in own:
            raise InputError(
                f"law '{contact.law}' of contact between coils has no value '{key}'; it takes {', '.join(own) or 'none'}"
            )
    if spec.build is not None:
        return spec.build(contact)
    law: CoilContactLaw = spec.law(**contact.values)
    return law
