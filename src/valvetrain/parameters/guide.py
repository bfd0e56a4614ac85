"""What keeps a slender spring straight: a bore around it, a rod inside it, or both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.units import keep_si

#: Stiffness of a wall (N/m per m of wire): that of coil on coil.
GUIDE_STIFFNESS = 2e10


@dataclass(frozen=True, slots=True)
class Guide:
    """Walls on the axis of the seats along the whole spring: ``bore``, inner diameter around it, and ``rod``, outer diameter inside it (m).

    ``stiffness`` (N/m per m of wire) of the contact. The wire slides on a wall without friction. One of the two must be given; raises
    :class:`InputError` otherwise.

    >>> Guide(bore=30e-3).stiffness
    20000000000.0
    """

    bore: float | None = None
    rod: float | None = None
    stiffness: float = GUIDE_STIFFNESS

    def __post_init__(self) -> None:
        keep_si(self, "the guide", bore="length", rod="length", stiffness="line stiffness")
        if self.bore is None and self.rod is None:
            raise InputError("a guide needs the diameter of its bore, of its rod, or both; give one, or leave the guide out")
        for name in ("bore", "rod", "stiffness"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise InputError(f"{name} of the guide must be positive; it is {value:g}")

    def check_fit(self, spring: SpringDefinition) -> None:
        """Raise :class:`InputError` where the free spring does not fit in the bore or over the rod."""
        coil = np.linspace(0.0, spring.total_coils, 1025)
        mean, wire = spring.mean_diameter.value(coil), spring.wire_diameter.value(coil)
        outer, inner = float(np.max(mean + wire)), float(np.min(mean - wire))
        if self.bore is not None and self.bore <= outer:
            raise InputError(
                f"spring '{spring.name}' does not fit in a bore of {self.bore * 1e3:.4g} mm: its outer diameter is {outer * 1e3:.4g} mm; "
                "widen the bore"
            )
        if self.rod is not None and self.rod >= inner:
            raise InputError(
                f"spring '{spring.name}' does not go over a rod of {self.rod * 1e3:.4g} mm: its inner diameter is {inner * 1e3:.4g} mm; "
                "make the rod thinner"
            )

    def words(self) -> str:
        """What it is, for people."""
        parts = [f"{word} of {value * 1e3:.5g} mm" for word, value in (("bore", self.bore), ("rod", self.rod)) if value is not None]
        return " and ".join(parts)
