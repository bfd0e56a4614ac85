"""Contact laws that bring a compiled kernel of their own: the train's loop, compiled once for all,
calls them by address.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numba
from llvmlite import ir  # type: ignore[import-untyped]
from numba import cfunc, types
from numba.extending import intrinsic

from valvetrain.compiled import njit
from valvetrain.contact.kernels import WIDTH
from valvetrain.contact.law import LawKernel

_POINTER = types.CPointer(types.float64)
_SIGNATURE = types.void(
    _POINTER,
    _POINTER,
    types.int64,
    types.float64,
    types.float64,
    types.float64,
    types.float64,
    _POINTER,
)


@cache
def law_address(kernel: LawKernel) -> int:
    """Address in this process of the compiled ``kernel`` of a law (``contact.law.OwnLaw``), which
    stays compiled.
    """
    compiled: Any = kernel if hasattr(kernel, "py_func") else njit(kernel)
    carray: Any = numba.carray  # type: ignore[attr-defined]

    def entry(
        parameters: Any,
        memory: Any,
        states: Any,
        pen: Any,
        before: Any,
        rate: Any,
        step: Any,
        reply: Any,
    ) -> None:
        force, damping = compiled(
            carray(parameters, WIDTH), carray(memory, states), pen, before, rate, step
        )
        out = carray(reply, 2)
        out[0], out[1] = force, damping

    built = cfunc(_SIGNATURE)(entry)
    _COMPILED.append(built)
    address: Any = built.address
    return int(address)


#: Compiled entries live as long as the process: the loop holds nothing but their addresses.
_COMPILED: list[Any] = []


@intrinsic
def _call(
    typing_context: Any,
    address: Any,
    parameters: Any,
    memory: Any,
    states: Any,
    pen: Any,
    before: Any,
    rate: Any,
    step: Any,
    reply: Any,
) -> Any:
    """Call the law at ``address``; ``parameters``, ``memory`` and ``reply`` (force, damping) are
    addresses of float64.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        number, whole = ir.DoubleType(), ir.IntType(64)
        pointer = number.as_pointer()
        kind = ir.FunctionType(
            ir.VoidType(), [pointer, pointer, whole, number, number, number, number, pointer]
        )
        first, second, last = (builder.inttoptr(values[place], pointer) for place in (1, 2, 8))
        builder.call(
            builder.inttoptr(values[0], kind.as_pointer()), [first, second, *values[3:8], last]
        )
        return context.get_dummy_value()

    return types.void(*(types.int64,) * 4, *(types.float64,) * 4, types.int64), generate


#: Typed as numba sees it inside compiled functions, where the typing context is no argument.
call_law: Any = _call
