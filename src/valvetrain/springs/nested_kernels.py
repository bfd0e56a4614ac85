"""Compiled step of two springs one inside the other, with Coulomb rubbing between their sections."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from valvetrain.compiled import njit

HEADER = 1
INTEGER_HEADER = 8
#: Nothing is allocated, so no reference counting.
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}


@njit(**OPTIONS)
def _rub(parameters, integers, state, outer_at, inner_at, time_step):
    """Friction impulse between each inner section and its nearest outer one: what stops the slip,
    at most mu N h; returns the loss.

    Sections are taken in turn. The members have drifted already, so positions follow the impulse:
    friction between kick and drift
    widens the stable step, friction after the drift would narrow it by up to sqrt(2) and make unstable a
    rod at Courant number one.
    """
    outer, inner, pairs = integers[0], integers[1], integers[6]
    partner, inverse = INTEGER_HEADER, HEADER + integers[2] + integers[3]
    limit, lost = parameters[0] * time_step, 0.0
    for j in range(pairs):
        first, second = (
            outer_at + outer + integers[partner + 2 * j],
            inner_at + inner + integers[partner + 2 * j + 1],
        )
        light, heavy = parameters[inverse + 2 * j], parameters[inverse + 2 * j + 1]
        slip = state[first] - state[second]
        impulse = slip / (light + heavy)
        impulse = min(max(impulse, -limit), limit)
        state[first] -= impulse * light
        state[second] += impulse * heavy
        state[first - outer] -= time_step * impulse * light
        state[second - inner] += time_step * impulse * heavy
        lost += impulse * (slip - 0.5 * impulse * (light + heavy))
    return lost


@njit(**OPTIONS)
def _copy(state, source, target, count):
    values, places = state[source : source + count], state[target : target + count]
    for i in range(count):
        places[i] = values[i]


@lru_cache(maxsize=32)
def nested_kernel(outer_kernel: Any, inner_kernel: Any) -> Any:
    """Kernel of a pair, built from the kernels of its members (one compiled function per pair of
    kinds).

    ``parameters`` = [friction limit per section (N), outer's, inner's, inverse masses of the
    section pairs (1/kg)].
    ``integers`` = [unknowns outer, inner, parameters outer, inner, integers outer, inner, section
    pairs,
    length of outer's buffer, pairs of section numbers, outer's, inner's].
    ``state`` = positions outer, inner, velocities outer, inner, rubbing loss, outer's buffer,
    inner's buffer.
    """

    @njit(**{**OPTIONS, "cache": False})
    def advance_nested(
        parameters, integers, state, retainer_displacement, retainer_velocity, time_step
    ):
        n, m, pairs = integers[0], integers[1], integers[6]
        outer_values, inner_values, outer_counts = integers[2], integers[3], integers[4]
        counts = INTEGER_HEADER + 2 * pairs
        outer_at = 2 * (n + m) + 1
        inner_at = outer_at + integers[7]
        _copy(state, 0, outer_at, n)
        _copy(state, n + m, outer_at + n, n)
        _copy(state, n, inner_at, m)
        _copy(state, 2 * n + m, inner_at + m, m)
        retainer, seat = outer_kernel(
            parameters[HEADER : HEADER + outer_values],
            integers[counts : counts + outer_counts],
            state[outer_at:inner_at],
            retainer_displacement,
            retainer_velocity,
            time_step,
        )
        more, below = inner_kernel(
            parameters[HEADER + outer_values : HEADER + outer_values + inner_values],
            integers[counts + outer_counts :],
            state[inner_at:],
            retainer_displacement,
            retainer_velocity,
            time_step,
        )
        if time_step > 0.0:
            if pairs > 0:
                state[2 * (n + m)] += _rub(
                    parameters, integers, state, outer_at, inner_at, time_step
                )
            _copy(state, outer_at, 0, n)
            _copy(state, outer_at + n, n + m, n)
            _copy(state, inner_at, n, m)
            _copy(state, inner_at + m, 2 * n + m, m)
        return retainer + more, seat + below

    return advance_nested
