"""Forces on end coils that lift, and their motion: compiled parts of the rod's step."""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.coil_contact.kernels import LINEAR, linear_contact, own_contact
from valvetrain.compiled import njit
from valvetrain.cosserat.layout import ROW

Z, VZ, FZ, CZ, END = (ROW[n] for n in ("Z", "VZ", "FZ", "CZ", "END"))
#: Of the row ``END``, a pair each for the ends at seat and retainer: mass (kg), stiffness (N/m) and
#: height (m) of their support, force (N) and its share by damping; closing speed of the retainer.
MASS, STIFFNESS, SEAT, FORCE, DAMPING, RATE = (np.uint64(n) for n in (0, 2, 4, 6, 8, 10))
ONE = np.uint64(1)
OPTIONS: dict[str, Any] = {
    "cache": True, "nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True,
}  # fmt: skip


@njit(**OPTIONS)
def end_contacts(b, first, last, displacement, damping_time, law, row):
    """Force (N) of retainer and seat on their end coils at a ``displacement`` (m) of the retainer."""
    for end in range(2):
        e = END + np.uint64(end)
        if end == 0:
            depth, closing = b[e + SEAT] - b[Z + first], -b[VZ + first]
        else:
            depth = b[Z + last] - (b[e + SEAT] - displacement)
            closing = b[VZ + last] + b[END + RATE]
        force, elastic = 0.0, 0.0
        if depth > 0.0:
            if law == LINEAR:
                force, elastic = linear_contact(
                    law, row, b[e + STIFFNESS], damping_time, depth, closing
                )
            else:
                force, elastic = own_contact(
                    law, row, b[e + STIFFNESS], damping_time, depth, closing
                )
        b[e + FORCE] = force
        b[e + DAMPING] = force - elastic
    return b[END + FORCE + ONE], b[END + FORCE]


@njit(**OPTIONS)
def move_end_coils(b, first, last, vertices, dt):
    """Advance both end coils by the forces of this step; returns the energy (J) that their seats
    took.
    """
    low = b[FZ + first + ONE] + b[END + FORCE]
    for i in range(np.uint64(0), first + ONE):
        low += b[CZ + i]
    high = -b[FZ + last] - b[END + FORCE + ONE]
    for i in range(last, vertices):
        high += b[CZ + i]
    low = b[VZ + first] + dt * low / b[END + MASS]
    high = b[VZ + last] + dt * high / b[END + MASS + ONE]
    closing = 0.5 * (high + b[VZ + last]) + b[END + RATE]
    lost = b[END + DAMPING + ONE] * closing - b[END + DAMPING] * 0.5 * (low + b[VZ + first])
    for i in range(np.uint64(0), first + ONE):
        b[VZ + i] = low
        b[Z + i] += dt * low
    for i in range(last, vertices):
        b[VZ + i] = high
        b[Z + i] += dt * high
    return dt * lost
