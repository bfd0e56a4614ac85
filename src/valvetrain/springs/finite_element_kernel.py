"""Stepping of the finite-element rod inside a train: the contract's one signature around the rod's
own step.
"""

from __future__ import annotations

import numpy as np

from valvetrain.coil_contact.kernels import WIDTH
from valvetrain.compiled import njit
from valvetrain.cosserat.layout import SIZE
from valvetrain.cosserat.time_stepping import (
    DT,
    GROUPS,
    LAW_NUMBERS,
    STRETCHES,
    VERTICES,
    WATCH_MARGIN,
    WATCH_STEPS,
    fastest_vertex,
    forces_now,
    kick_and_drift,
    place_retainer,
    watch_contacts,
)

# Tail of the state behind the rod's buffer.
TRAVEL, COUNTER, WATCHED, LOST, STRETCH = SIZE, SIZE + 1, SIZE + 2, SIZE + 3, SIZE + 4
STATE_SIZE = STRETCH + 2 * STRETCHES
#: Places in the parameters: precompression and whether it pulls first, then the numbers of the time
#: integration and the contact places.
NUMBERS, NUMBER_COUNT = 2, LAW_NUMBERS + WIDTH


@njit(cache=True, nogil=True, error_model="numpy")
def advance_rod(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """Both end forces at t_n, then one step of the rod; contract in ``springs.contract``."""
    buffer = state[:SIZE]
    stretches = state[STRETCH:STATE_SIZE].reshape((STRETCHES, 2))
    numbers = parameters[NUMBERS : NUMBERS + NUMBER_COUNT]
    places = parameters[NUMBERS + NUMBER_COUNT :].reshape((integers[GROUPS], 2))
    compression = parameters[0] + retainer_displacement
    place_retainer(buffer, integers, compression - state[TRAVEL], retainer_velocity)
    state[TRAVEL] = compression
    if state[COUNTER] % WATCH_STEPS == 0.0 or time_step == 0.0:
        fastest = fastest_vertex(buffer, np.uint64(0), np.uint64(integers[VERTICES]))
        reach = 2.0 * (min(fastest, 1e3) + 2.0) * WATCH_STEPS * numbers[DT] + WATCH_MARGIN
        state[WATCHED] = watch_contacts(buffer, integers, reach, stretches)
    retainer, seat = forces_now(
        buffer, integers, numbers, places, stretches, int(state[WATCHED]), compression
    )
    if time_step > 0.0:
        state[LOST] += kick_and_drift(buffer, integers, numbers)
        state[COUNTER] += 1.0
    if parameters[1] == 0.0:
        retainer, seat = max(retainer, 0.0), max(seat, 0.0)
    return retainer, seat
