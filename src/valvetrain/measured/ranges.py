"""Ranges of measured numbers, checked where files and arrays are read."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError

#: SI unit -> bounds of the largest value of a measurement; wide enough for ship engines and for springs of models.
RANGES = {
    "N": (1e-3, 1e5), "m": (1e-6, 1.0), "Pa": (1.0, 1e10), "N/m^2": (1.0, 1e10), "m/s": (1e-6, 200.0), "m/s^2": (1e-3, 1e7), "1/s": (1e-3, 1e9)
}  # fmt: skip


def refuse_beyond(values: ArrayLike, unit: str, what: str) -> None:
    """Refuse ``values`` (SI, of ``unit``) whose largest size no valvetrain has; zeros and NaN pass.

    Raises :class:`InputError` with ``what`` was measured.

    >>> refuse_beyond([320.0, 0.0], "N", "spring_force")
    """
    low, high = RANGES.get(unit, (0.0, 1e12))
    size = np.abs(np.asarray(values, dtype=float))
    largest = float(np.max(size, initial=0.0, where=~np.isnan(size)))
    if largest and not low <= largest <= high:
        raise InputError(
            f"{what} reaches {f'{largest:.4g} {unit}'.strip()}, outside {low:g} to {f'{high:g} {unit}'.strip()} of valvetrains; "
            "check the numbers and their unit"
        )
