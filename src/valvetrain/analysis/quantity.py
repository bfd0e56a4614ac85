"""The name under which a computed value meets a published one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Quantity:
    """A named scalar: ``engine_speed`` in rad/s of the crank (None where none applies), ``model`` the spring model's name.

    ``unit`` is SI (deg only for names ending in ``_angle``, always cam degrees) and takes no part in equality.
    """

    name: str
    engine_speed: float | None = None
    model: str = ""
    unit: str = field(default="1", compare=False)


Quantities = Mapping[Quantity, float]
