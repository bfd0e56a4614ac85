"""The compiled loop of a spring under prescribed motion; it never sees which model it steps."""

from __future__ import annotations

from numba import types

from valvetrain.compiled import njit
from valvetrain.integrate.spring_slot import SPRING_FUNCTION, write_contacts

_f8, _vector, _matrix = (
    types.float64,
    types.Array(types.float64, 1, "C"),
    types.Array(types.float64, 2, "C"),
)


@njit(
    types.int64(
        SPRING_FUNCTION,
        _vector,
        types.Array(types.int64, 1, "C"),
        _vector,
        _vector,
        _vector,
        _f8,
        types.int64,
        _matrix,
        _matrix,
        types.Array(types.int64, 2, "C"),
        types.int64,
        _matrix,
        types.int64,
        types.int64,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def advance(
    kernel,
    parameters,
    integers,
    state,
    displacement,
    velocity,
    time_step,
    every,
    forces,
    states,
    stretches,
    spacing,
    pressed,
    first,
    stride,
):
    """One stretch of prescribed motion from step ``first`` of a revolution: end forces (N) at every
    ``stride``-th step, the state at every ``every``-th, the coil contacts (``stretches`` of the
    state) at every ``spacing``-th into ``pressed``; returns the steps done.

    The last call takes no step, so that the next stretch begins where this one ends.
    """
    last = first + displacement.shape[0] - 1
    for n in range(first, last + 1):
        if n % every == 0 and n // every < states.shape[0]:
            for i in range(states.shape[1]):
                states[n // every, i] = state[i]
        step = time_step if n < last else 0.0
        here = n - first
        retainer, seat = kernel(
            parameters, integers, state, displacement[here], velocity[here], step
        )
        if n % stride == 0:
            forces[n // stride, 0], forces[n // stride, 1] = retainer, seat
        if step > 0.0 and n % spacing == 0 and n // spacing < pressed.shape[0]:
            write_contacts(state, stretches, pressed[n // spacing])
        if not abs(retainer) + abs(seat) < 1e7:
            return n
    return last + 1
