"""Elastic material of a wire or a part."""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.errors import InputError


@dataclass(frozen=True, slots=True)
class Material:
    """Isotropic elastic material: moduli in Pa, density in kg/m3.

    Raises :class:`InputError` for values that are not positive or moduli that no isotropic solid has.
    """

    name: str
    youngs_modulus: float
    shear_modulus: float
    density: float

    def __post_init__(self) -> None:
        for key in ("youngs_modulus", "shear_modulus", "density"):
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
