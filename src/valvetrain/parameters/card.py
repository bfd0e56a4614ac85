"""A spring known only by its catalogue card."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SpringCard:
    """A spring known only by its catalogue card: ``rate`` (N/m), ``preload`` at the seat (N), the rest where known (kg, m, N)."""

    rate: float
    preload: float
    mass: float | None = None
    installed_height: float | None = None
    open_load: float | None = None
    open_lift: float | None = None
    solid_height: float | None = None
    name: str = "spring card"

    @property
    def surge_frequency(self) -> float | None:
        """First surge frequency (Hz), both ends fixed: 0.5 sqrt(rate / mass); None without a mass."""
        return None if self.mass is None else 0.5 * math.sqrt(self.rate / self.mass)
