"""Errors that all cycles of a test share, of calibration, zero and angle: scatter does not show them, so they are stated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.units import dimension_of, dimension_powers, parse_quantity
from valvetrain.units.text import split_quantity

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SharedErrors:
    """Standard deviations of what all cycles share: ``offset`` (unit of the quantity, SI), ``gain`` (a share), ``cam_angle`` (rad).

    >>> SharedErrors(offset=2.0, gain=0.01).words("N")
    'offset 2 N, gain 1 %'
    """

    offset: float = 0.0
    gain: float = 0.0
    cam_angle: float = 0.0

    def __bool__(self) -> bool:
        return max(self.offset, self.gain, self.cam_angle) > 0

    def shapes(self, cam_angle: Array, curve: Array) -> Array:
        """Standard deviation of each error along the turn, (errors, angles): level, in step with ``curve`` and with its slope."""
        around = np.concatenate([cam_angle[-1:] - 2 * np.pi, cam_angle, cam_angle[:1] + 2 * np.pi])
        slope = np.gradient(np.concatenate([curve[-1:], curve, curve[:1]]), around)[1:-1]
        rows = [self.offset * np.ones(len(curve)), self.gain * curve, self.cam_angle * slope]
        return np.array([row for row in rows if np.any(row)]).reshape(-1, len(curve))

    def words(self, unit: str, factor: float = 1.0) -> str:
        """The errors in words, the offset in ``unit``, which is ``factor`` of the SI unit."""
        told = [
            f"offset {self.offset * factor:.3g} {unit}" if self.offset else "", f"gain {100 * self.gain:.3g} %" if self.gain else "",
            f"angle {math.degrees(self.cam_angle):.3g} cam deg" if self.cam_angle else "",
        ]  # fmt: skip
        return ", ".join(filter(None, told))


def read_shared(texts: str | Sequence[str], unit: str) -> SharedErrors:
    """Errors from texts such as ``"2 N, 0.5 %, 0.1 deg"``; ``unit``: SI unit of the quantity.

    Raises :class:`InputError` for an amount that is neither of the quantity, nor a share, nor an angle, or given twice.
    """
    listed = [part.strip() for text in ([texts] if isinstance(texts, str) else texts) for part in text.split(",") if part.strip()]
    found: dict[str, float] = {}
    for part in listed:
        _, own = split_quantity(part, None, "shared")
        if own == "%":
            key = "gain"
        elif dimension_powers(f"1 {own}".strip()) == dimension_powers(f"1 {'' if unit == '1' else unit}".strip()):
            key = "offset"
        elif own and dimension_of(own) == "angle":
            key = "cam_angle"
        else:
            raise InputError(
                f"'{part[:40]}' is no error of a quantity in {unit or 'no unit'}; give an offset, a share in %, an angle", "shared"
            )
        if key in found:
            raise InputError(f"'{part[:40]}' is the second {key.replace('_', ' ')}; give one standard deviation of each kind", "shared")
        found[key] = parse_quantity(part, None, "shared")
        if not found[key] > 0:
            raise InputError(f"'{part[:40]}' is no standard deviation; give it above zero", "shared")
    return SharedErrors(**found)
