"""The name under which a computed value meets a published one (docs/quantities.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

#: Last word of a quantity's name -> SI unit, as docs/quantities.md has it.
UNITS = {
    "force": "N", "preload": "N", "angle": "rad", "frequency": "Hz", "velocity": "m/s", "acceleration": "m/s2", "displacement": "m",
    "compression": "m", "gap": "m", "length": "m", "height": "m", "lift": "m", "diameter": "m", "duration": "s", "rate": "N/m",
    "impulse": "N s", "energy": "J", "stress": "Pa", "mass": "kg", "speed": "rad/s", "ratio": "1", "count": "1",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Quantity:
    """A named scalar: ``engine_speed`` in rad/s of the crank (None where none applies), ``model`` the spring model's name."""

    name: str
    engine_speed: float | None = None
    model: str = ""

    @property
    def unit(self) -> str:
        """SI unit, from the last word of the name."""
        return unit_of(self.name)


Quantities = Mapping[Quantity, float]


def unit_of(name: str) -> str:
    """SI unit of a quantity, from the last word of its name; a range has the unit of what ranges."""
    words = name.split("_")
    if words[-1] == "range" and len(words) > 1:
        return UNITS.get(words[-2], "1")
    return UNITS.get(words[-1], "1")


def named(values: Mapping[str, float], engine_speed: float | None, model: str) -> dict[Quantity, float]:
    """Plain names made :class:`Quantity` of one run."""
    return {Quantity(name, engine_speed, model): value for name, value in values.items()}
