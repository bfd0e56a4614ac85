"""Modes of a spring about a compressed state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.solution.status import COMPLETED, Status

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModalResult:
    """All modes found about the state at ``compression`` (m).

    ``natural_frequency`` (mode) Hz, ascending; ``shape`` (mode, wire_point, 3), largest component 1, z along the spring;
    ``coil_number`` (wire_point); ``axial_transmission`` (mode): force-transmission residue, how much of an axial push at
    one end each mode carries to the other; ``axial_modes``: indices of the axial modes, ascending in frequency.
    """

    compression: float
    natural_frequency: Array
    shape: Array
    coil_number: Array
    axial_transmission: Array
    axial_modes: tuple[int, ...]
    status: Status = COMPLETED

    def __post_init__(self) -> None:
        object.__setattr__(self, "axial_modes", tuple(int(index) for index in self.axial_modes))
        modes, points = len(self.natural_frequency), len(self.coil_number)
        for name, shape in {"shape": (modes, points, 3), "axial_transmission": (modes,)}.items():
            if np.shape(getattr(self, name)) != shape:
                raise InputError(f"{name} of a modal result must have shape {shape}; it has {np.shape(getattr(self, name))}")
        if any(not 0 <= index < modes for index in self.axial_modes):
            raise InputError(f"axial_modes of a modal result must lie between 0 and {modes - 1}; they are {self.axial_modes}")

    @property
    def axial_frequencies(self) -> Array:
        """Natural frequencies (Hz) of the axial modes, ascending."""
        return np.asarray(self.natural_frequency)[list(self.axial_modes)]
