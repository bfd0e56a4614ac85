"""Elastic material of a wire or a part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from valvetrain.errors import InputError
from valvetrain.units import Given, si


@dataclass(frozen=True, slots=True)
class Material:
    """Isotropic elastic material: moduli in Pa, density in kg/m3; each given in SI or with its unit (:func:`valvetrain.units.si`).

    Raises :class:`InputError` for values that are not positive, slips of units or moduli that no isotropic solid has.

    >>> Material("a steel", "206 GPa", "79.6 GPa", "7850 kg/m^3").density
    7850.0
    """

    name: str
    youngs_modulus: float
    shear_modulus: float
    density: float

    if TYPE_CHECKING:  # what may be given is wider than what is kept

        def __init__(self, name: str, youngs_modulus: Given, shear_modulus: Given, density: Given) -> None: ...

    def __post_init__(self) -> None:
        for key, quantity in (("youngs_modulus", "modulus"), ("shear_modulus", "modulus"), ("density", "density")):
            object.__setattr__(self, key, si(getattr(self, key), quantity, f"{key} of material '{self.name}'"))
            if not getattr(self, key) > 0:
                raise InputError(f"{key} of material '{self.name}' must be positive; it is {getattr(self, key)}")
        if not -1.0 < self.poisson_ratio < 0.5:
            raise InputError(
                f"material '{self.name}' has E / (2 G) - 1 = {self.poisson_ratio:.3f}, outside -1 to 0.5; check Young's and shear modulus"
            )

    @property
    def poisson_ratio(self) -> float:
        """Poisson ratio nu = E / (2 G) - 1 of the isotropic solid."""
        return self.youngs_modulus / (2 * self.shear_modulus) - 1


OTEVA_90_SC = Material("OTEVA 90 SC", 206e9, 79.6e9, 7850.0)
