"""A quantity of a case that a study varies: which key, set, multiplied or shifted, in which unit,
and over what.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from valvetrain.errors import InputError
from valvetrain.studies.points.distributions import Distribution, Values
from valvetrain.units import DIMENSIONS, dimension_of, unit_factor

Operation = Literal["value", "factor", "offset"]
#: Key that stands for the engine speed of a point (rad/s of the crank) instead of for a quantity of
#: its case.
ENGINE_SPEED = "engine_speed"
#: Words of an operation in the name of a varied quantity.
_WORDS = {"value": "", "factor": " factor", "offset": " offset"}


@dataclass(frozen=True, slots=True)
class Varied:
    """One varied quantity of a case.

    ``key``: as ``--set`` takes it, such as ``"spring.wire_diameter"`` or ``"spring.pitch"``.
    ``unit``: that of its values where they are
    shown; inside they are SI. ``operation``: the ``value`` itself, or a ``factor`` on or an
    ``offset`` to what stands in the case, a
    number, a list or a curve with all its knots. ``distribution``: what it goes through. ``label``:
    plain words, the key by default.
    Raises :class:`InputError` for an unknown unit or operation and for a factor with a unit.

    >>> Varied("spring.pitch", operation="factor").name
    'spring.pitch factor'
    """

    key: str
    unit: str = ""
    operation: Operation = "value"
    distribution: Distribution = Values((1.0,))
    label: str = ""

    def __post_init__(self) -> None:
        if not self.key or not all(part.strip() for part in self.key.split(".")):
            raise InputError(
                f"'{self.key[:60]}' is no key of a case; write one such as 'spring.wire_diameter'"
            )
        if self.operation not in _WORDS:
            raise InputError(
                f"'{str(self.operation)[:40]}' is no way to vary a quantity; choose value, factor or offset",
                self.key,
            )
        if self.operation == "factor" and self.unit:
            raise InputError(
                f"a factor is a plain number, it has no unit '{self.unit[:20]}'; leave the unit out",
                self.key,
            )
        if self.unit and self.dimension is None:
            raise InputError(
                f"unit '{self.unit[:20]}' measures nothing known here; write such as mm, N/mm or rpm",
                self.key,
            )

    @property
    def name(self) -> str:
        """Key and operation; tells the varied quantities of a study apart."""
        return self.key + _WORDS[self.operation]

    @property
    def words(self) -> str:
        """What people read."""
        return self.label or self.name.replace("_", " ")

    @property
    def dimension(self) -> str | None:
        """Dimension of its values; None for a unit that measures none of those known."""
        return dimension_of(self.unit) if self.unit else "ratio"

    @property
    def si_unit(self) -> str:
        """SI unit of its values, empty for plain numbers."""
        dimension = self.dimension
        return DIMENSIONS[dimension].si_unit if dimension is not None else ""

    def shown(self, value: float) -> float:
        """A value (SI) in the unit."""
        return value / unit_factor(self.unit) if self.unit else value
