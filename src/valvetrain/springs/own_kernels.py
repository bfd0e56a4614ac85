"""The compiled step of a spring given in Python: it calls the spring's functions by address, so that
one kernel, compiled once, serves all of them.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import cfunc, types
from numba.extending import intrinsic

from valvetrain.compiled import njit

_POINTER = types.CPointer(types.float64)
#: ``entry(what, state, count, displacement, velocity, found)``: end forces (``what`` 0) or the
#: derivatives of the state by time (1) into ``found``.
ENTRY = types.void(types.int64, _POINTER, types.int64, types.float64, types.float64, _POINTER)
_DOUBLES = ctypes.POINTER(ctypes.c_double)
_PLAIN_ENTRY = ctypes.CFUNCTYPE(
    None, ctypes.c_int64, _DOUBLES, ctypes.c_int64, ctypes.c_double, ctypes.c_double, _DOUBLES
)
FORCES, RATES = 0, 1


@intrinsic
def _call(
    typing_context: Any, address: Any, what: Any, state: Any, count: Any, x: Any, v: Any, reply: Any
) -> Any:
    """Call the entry at ``address``; ``state`` and ``reply`` are addresses of float64."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        number, whole = ir.DoubleType(), ir.IntType(64)
        pointer = number.as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [whole, pointer, whole, number, number, pointer])
        state, reply = (builder.inttoptr(values[place], pointer) for place in (2, 6))
        entry = builder.inttoptr(values[0], kind.as_pointer())
        builder.call(entry, [values[1], state, *values[3:6], reply])
        return context.get_dummy_value()

    return types.void(*(types.int64,) * 4, *(types.float64,) * 2, types.int64), generate


call_spring: Any = _call


def state_size(count: int) -> int:
    """Length of the state of a spring with ``count`` states of its own."""
    return 7 * count + 4


@njit(cache=True, error_model="numpy", _nrt=False)
def advance_own(parameters, integers, state, displacement, velocity, time_step):
    """Both end forces now. ``integers``: address of the entry, count m of own states.

    ``state``: m states at the call before, the displacement then (m), the step since (s); behind
    them forces and scratch. States follow by Runge and Kutta's fourth order, once it is known where
    the retainer went in the step.
    """
    address, m = integers[0], integers[1]
    base, out, now, rate, trial = state.ctypes.data, m + 2, m + 4, 2 * m + 4, 6 * m + 4
    step, before = state[m + 1], state[m]
    for i in range(m):
        state[now + i] = state[i]
    if m > 0 and step > 0.0:
        drift = (displacement - before) / step
        for stage in range(4):
            part = 0.0 if stage == 0 else 0.5 if stage < 3 else 1.0
            for i in range(m):
                state[trial + i] = state[i]
                if stage > 0:
                    state[trial + i] += part * step * state[rate + (stage - 1) * m + i]
            call_spring(
                address,
                RATES,
                base + 8 * trial,
                m,
                before + part * step * drift,
                drift,
                base + 8 * (rate + stage * m),
            )
        for i in range(m):
            first, second, third, last = rate + i, rate + m + i, rate + 2 * m + i, rate + 3 * m + i
            state[now + i] += (
                step / 6.0 * (state[first] + 2.0 * (state[second] + state[third]) + state[last])
            )
    call_spring(address, FORCES, base + 8 * now, m, displacement, velocity, base + 8 * out)
    if time_step > 0.0:
        for i in range(m):
            state[i] = state[now + i]
        state[m], state[m + 1] = displacement, time_step
    return state[out], state[out + 1]


def compiled_entry(forces: Any, rates: Any) -> Any:
    """The entry of two compiled functions of state, displacement and velocity. Raises what numba
    raises where it cannot compile them.
    """
    carray: Any = numba.carray  # type: ignore[attr-defined]

    def entry(what: Any, state: Any, count: Any, x: Any, v: Any, reply: Any) -> None:
        own = carray(state, count)
        if what == FORCES:
            out = carray(reply, 2)
            out[0], out[1] = forces(own, x, v)
        else:
            change, given = carray(reply, count), rates(own, x, v)
            for i in range(count):
                change[i] = given[i]

    return cfunc(ENTRY)(entry)


def plain_entry(forces: Callable[..., Any], rates: Callable[..., Any]) -> Any:
    """The same of functions that numba does not take; what they raise becomes a force that is no
    number.
    """

    def entry(what: int, state: Any, count: int, x: float, v: float, reply: Any) -> None:
        own = np.ctypeslib.as_array(state, (count,)) if count else np.zeros(0)
        try:
            given = forces(own, x, v) if what == FORCES else rates(own, x, v)
        except Exception:
            given = [np.nan] * (2 if what == FORCES else count)
        for i, value in enumerate(given):
            reply[i] = float(value)

    return _PLAIN_ENTRY(entry)


def address_of(entry: Any) -> int:
    """Address of an entry in this process."""
    if isinstance(entry, _PLAIN_ENTRY):
        return int(ctypes.cast(entry, ctypes.c_void_p).value or 0)
    return int(entry.address)
