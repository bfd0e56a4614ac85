"""The space of an experiment: varied quantities and the distribution of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.explore.distributions import Distribution, Prior, Values
from valvetrain.parameters.summary import number, unit_text
from valvetrain.units import DIMENSIONS, dimension_of, unit_factor
from valvetrain.units.reader import reader_factor, reader_unit

Operation = Literal["value", "factor", "offset"]
#: Key of the engine speed of a point (rad/s of the crank), which is no quantity of
#: its case.
ENGINE_SPEED = "engine_speed"
#: Suffix of an operation in the name of a varied quantity.
_SUFFIXES = {"value": "", "factor": " factor", "offset": " offset"}


@dataclass(frozen=True, slots=True)
class Varied:
    """One varied quantity of a case or argument of a function.

    ``key``: as ``--set`` takes it, such as ``"spring.wire_diameter"``. ``unit``: that of its values
    where they are shown; inside they are SI. ``operation``: the ``value`` itself, or a ``factor``
    on or an ``offset`` to the case's own number, list or curve. ``label``: shown name, the key by
    default. ``also``: further keys that move alike. Raises :class:`InputError` for an unknown unit or operation and for a factor with a unit.

    >>> Varied("spring.pitch", operation="factor").name
    'spring.pitch factor'
    """

    key: str
    unit: str = ""
    operation: Operation = "value"
    distribution: Distribution = Values((1.0,))
    label: str = ""
    also: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        reason = ""
        if not all(part.strip() for part in self.key.split(".")):
            reason = (
                f"'{self.key[:60]}' is no key of a case; write one such as 'spring.wire_diameter'"
            )
        elif ENGINE_SPEED in self.also:
            reason = "is an engine speed, which moves alone; vary it by itself"
        elif self.operation not in _SUFFIXES:
            reason = "is varied in no way that there is; choose value, factor or offset"
        elif self.operation == "factor" and self.unit:
            reason = (
                f"a factor is a plain number, it has no unit '{self.unit[:20]}'; leave the unit out"
            )
        elif self.dimension is None:
            reason = f"unit '{self.unit[:20]}' measures nothing known here; write such as mm, N/mm or rpm"
        if reason:
            raise InputError(reason, self.key)

    @property
    def name(self) -> str:
        """Key and operation, unique among the varied quantities of a study."""
        return self.key + _SUFFIXES[self.operation]

    @property
    def parts(self) -> tuple[Varied, ...]:
        """The same for each of its keys."""
        return self, *(replace(self, key=key, also=()) for key in self.also)

    @property
    def title(self) -> str:
        """Its label, else its name: what it is called in an identification."""
        return self.label or self.name

    @property
    def prior(self) -> Prior:
        """Its distribution. Raises :class:`InputError` for a list of values."""
        if not isinstance(self.distribution, Prior):
            reason = "is a list of values, which is no prior; give a distribution"
            raise InputError(reason, self.name)
        return self.distribution

    @property
    def shown_name(self) -> str:
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

    @property
    def ends(self) -> tuple[float, float]:
        """Least and most (SI) of its range or list."""
        low, high = self.distribution.at([0.0, 1.0]).tolist()
        return low, high

    def shown(self, value: float) -> float:
        """A value (SI) in the unit."""
        return value / unit_factor(self.unit) if self.unit else value

    @property
    def axis_label(self) -> str:
        """The shown name with the unit, or with what a factor is of.

        >>> Varied("spring.pitch.clearances", operation="factor", label="gaps").axis_label
        'gaps, × case'
        """
        unit = "× case" if self.operation == "factor" else unit_text(self.unit)
        return ", ".join(filter(None, (self.shown_name, unit)))

    def text(self, value: float, digits: int = 5) -> str:
        """Shown name and value (SI) with its unit; a factor after its sign of times, an offset with
        its sign.

        >>> Varied("spring.pitch.clearances", operation="factor", label="gaps").text(1.3)
        'gaps × 1.3'
        """
        return f"{self.shown_name} {self.value_text(value, digits)}"

    def value_text(self, value: float, digits: int = 5) -> str:
        """The value of :meth:`text` alone, in the unit of the reader."""
        of_reader = self.shown(float(value)) * reader_factor(self.unit)
        said = f"{number(of_reader, digits)} {unit_text(reader_unit(self.unit))}".strip()
        if not self.label or self.operation == "value":
            return said
        return f"× {said}" if self.operation == "factor" else f"{'+' if value >= 0 else ''}{said}"


class Space(tuple[Varied, ...]):
    """Varied quantities with their distributions, each independent of the others.

    ``varied``: a mapping of names to distributions, or :class:`Varied` quantities. A name is a key
    of the case (``spring.wire_diameter``, or ``springs.0.wire.wire_diameter`` as
    :meth:`Case.replace` takes it) or an argument of the function that is evaluated.

    >>> import valvetrain as vt
    >>> space = vt.Space(
    ...     {"rate": vt.explore.Prior("uniform", 20e3, 60e3), "mass": vt.explore.Prior("normal", centre=0.05, spread=0.01)}
    ... )
    >>> space.names, space.points([[0.5, 0.5]]).tolist()
    (('rate', 'mass'), [[40000.0, 0.05]])
    """

    __slots__ = ()

    def __new__(cls, varied: Mapping[str, Distribution] | Sequence[Varied]) -> Space:
        """The space, each quantity once."""
        if isinstance(varied, Mapping):
            varied = [Varied(name, distribution=one) for name, one in varied.items()]
        made = super().__new__(cls, varied)
        names = made.names
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f"'{twice[:60]}' is varied twice; give it once")
        return made

    @property
    def names(self) -> tuple[str, ...]:
        """Name of every quantity: its key, with ``factor`` or ``offset`` behind."""
        return tuple(one.name for one in self)

    @property
    def identity(self) -> list[Any]:
        """What the values of a point mean, whatever their distributions."""
        return [[one.key, one.also, one.operation, one.si_unit] for one in self]

    def points(self, shares: ArrayLike) -> Array:
        """Points (n, d) in SI of shares (n, d) in the unit cube."""
        # half of the last bit off either end, where a distribution without bounds is infinite
        inside = np.clip(np.asarray(shares, dtype=float), 2.0**-53, 1 - 2.0**-53)
        return np.column_stack(
            [one.distribution.at(inside[:, index]) for index, one in enumerate(self)]
        )
