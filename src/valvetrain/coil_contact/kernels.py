"""Compiled law of contact between coils: overlap and closing speed to force and stored energy.

Chain, rod and statics evaluate the law here and nowhere else. A contact has a stiffness (N/m: that
of the law per metre of wire, times its length of wire) and a law, which is an address: ``LINEAR``
for the law that ships, else that of a compiled kernel of its own (``coil_contact.law``). ``row`` is
the address of the ``WIDTH`` numbers of such a law.

Functions are inlined before they are compiled, so that each takes the floating-point options of the
loop that uses it. Each returns what one loop needs at one place and no more: with the energy or the
damping next to the force, fast maths groups the sums of the rod's loops otherwise.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from valvetrain.compiled import njit

#: Address of the linear law, and how many numbers a law of its own may have.
LINEAR, WIDTH = 0, 8


@njit(inline="always")
def linear_contact(law, row, stiffness, damping_time, overlap, closing):
    """Kelvin and Voigt's law k (g + tau dg/dt), never adhesive, at an overlap g > 0 (m).

    Returns the force (N) and its elastic part.
    """
    force = stiffness * (overlap + damping_time * closing)
    return force if force > 0.0 else 0.0, stiffness * overlap


@njit(inline="always")
def linear_energy(law, row, stiffness, damping_time, overlap):
    """Stored energy (J) at an overlap > 0."""
    return 0.5 * stiffness * overlap * overlap


@njit(inline="always")
def linear_damping(law, row, stiffness, damping_time, overlap, closing):
    """What the force is beyond its elastic part (N), exact where the two nearly cancel."""
    return stiffness * max(-overlap, damping_time * closing)


@njit(inline="always")
def own_contact(law, row, stiffness, damping_time, overlap, closing):
    """As :func:`linear_contact` by the kernel at address ``law``; nothing where coils are apart."""
    if overlap <= 0.0:
        return 0.0, 0.0
    push, _, _, damping = call_law(law, row, damping_time, overlap)
    return stiffness * (push + max(-push, damping * closing)), stiffness * push


@njit(inline="always")
def own_damping(law, row, stiffness, damping_time, overlap, closing):
    """As :func:`linear_damping` by the kernel at address ``law``, at an overlap > 0."""
    push, _, _, damping = call_law(law, row, damping_time, overlap)
    return stiffness * max(-push, damping * closing)


@njit(inline="always")
def own_energy(law, row, stiffness, damping_time, overlap):
    """As :func:`linear_energy` by the kernel at address ``law``; none where coils are apart."""
    if overlap <= 0.0:
        return 0.0
    return stiffness * call_law(law, row, damping_time, overlap)[2]


@njit(inline="always")
def contact_response(law, row, stiffness, damping_time, overlap, closing):
    """Force and its elastic part (N) of any law at an overlap > 0."""
    if law == LINEAR:
        return linear_contact(law, row, stiffness, damping_time, overlap, closing)
    return own_contact(law, row, stiffness, damping_time, overlap, closing)


@njit(inline="always")
def contact_energy(law, row, stiffness, damping_time, overlap):
    """Stored energy (J) of any law at an overlap > 0."""
    if law == LINEAR:
        return linear_energy(law, row, stiffness, damping_time, overlap)
    return own_energy(law, row, stiffness, damping_time, overlap)


@njit(inline="always")
def contact_tangent(law, row, stiffness, damping_time, overlap):
    """Derivative (N/m) of the elastic force by the overlap, at an overlap > 0."""
    if law == LINEAR:
        return stiffness
    return stiffness * call_law(law, row, damping_time, overlap)[1]


@njit(cache=True, error_model="numpy")
def evaluate_contacts(law, numbers, damping_time, early, stiffness, overlap, closing, out):
    """Fill ``out`` (5, n) with force, elastic force, energy, tangent and damping of n contacts.

    ``early``: the damper of the linear law acts as soon as overlap and damping together press, even
    before the coils touch; at the jump of the damper a coarse implicit step finds no balance.
    """
    row = numbers.ctypes.data
    for i in range(len(overlap)):
        out[:, i] = 0.0
        if overlap[i] > 0.0:
            force, elastic = contact_response(
                law, row, stiffness[i], damping_time, overlap[i], closing[i]
            )
            out[0, i], out[1, i] = force, elastic
            out[2, i] = contact_energy(law, row, stiffness[i], damping_time, overlap[i])
        elif early and law == LINEAR:
            out[0, i] = max(stiffness[i] * (overlap[i] + damping_time * closing[i]), 0.0)
        if out[0, i] > 0.0:
            if law == LINEAR:
                out[3, i], out[4, i] = stiffness[i], stiffness[i] * damping_time
            else:
                _, tangent, _, damping = call_law(law, row, damping_time, overlap[i])
                out[3, i], out[4, i] = stiffness[i] * tangent, stiffness[i] * damping


@intrinsic
def _call(typing_context: Any, law: Any, row: Any, damping_time: Any, overlap: Any) -> Any:
    """Force (m), tangent, energy (m^2) and damping (s) of unit stiffness by the kernel at ``law``."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        number = ir.DoubleType()
        pointer = number.as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [pointer, number, number, pointer])
        found = cgutils.alloca_once(builder, number, size=4)
        entry = builder.inttoptr(values[0], kind.as_pointer())
        builder.call(entry, [builder.inttoptr(values[1], pointer), *values[2:], found])
        parts = [builder.load(cgutils.gep(builder, found, index)) for index in range(4)]
        return context.make_tuple(builder, signature.return_type, parts)

    answer = types.UniTuple(types.float64, 4)
    return answer(types.int64, types.int64, types.float64, types.float64), generate


#: Typed as numba sees it inside compiled functions, where the typing context is no argument.
call_law: Any = _call

#: Signature of the compiled entry at an address: numbers, damping time, overlap, what it fills.
ENTRY = types.void(
    types.CPointer(types.float64), types.float64, types.float64, types.CPointer(types.float64)
)
NO_NUMBERS = np.zeros(WIDTH)
