"""Whether what was read is possible at all: ranges of measured numbers, and doubts about the outcome."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError

#: SI unit -> bounds of the largest value of a measurement; wide enough for ship engines and for springs of models.
RANGES = {
    "N": (1e-3, 1e5), "m": (1e-6, 1.0), "Pa": (1.0, 1e10), "N/m^2": (1.0, 1e10), "m/s": (1e-6, 200.0), "m/s^2": (1e-3, 1e7), "1/s": (1e-3, 1e9),
    "rad": (1e-3, 1e3),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Doubt:
    """Why a file hardly says what was read from it: the ``code`` of the finding that shows it, ``what``
    is odd and ``where``, and the ``step`` that settles it.

    >>> str(Doubt("Z104", "the rate falls", "table.csv", "check the zero of the scale"))
    'table.csv: the rate falls; check the zero of the scale'
    """

    code: str
    what: str
    where: str
    step: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}; {self.step}"


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
