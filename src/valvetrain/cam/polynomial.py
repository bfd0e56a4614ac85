"""Polynomial flanks such as 3-4-5 and 4-5-6-7."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.cam.contract import Array, LiftSpec
from valvetrain.cam.flanks import FlankEvents, FlankModel, flanked, polynomial_value, rise_factors
from valvetrain.parameters.schema_lift import Exponents


@dataclass(frozen=True, slots=True, kw_only=True)
class Polynomial(FlankEvents):
    """Dwell, rise, dwell, return with a polynomial flank of the given ``exponents``.

    As many derivatives vanish at the top as there are exponents less one, and at the foot as many as the lowest exponent less one.
    """

    exponents: tuple[int, ...] = (3, 4, 5)

    @property
    def continuity(self) -> int:
        return min(min(self.exponents), len(self.exponents)) - 1

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        factors = rise_factors(self.exponents)
        return flanked(self, lambda x, order: polynomial_value(self.exponents, factors, x, order), cam_angle, derivative)


class PolynomialModel(FlankModel):
    """The same with a polynomial flank such as 3-4-5."""

    exponents: Exponents = Field(default=(3, 4, 5), description="powers of the flank")


SPEC = LiftSpec(Polynomial, PolynomialModel)
