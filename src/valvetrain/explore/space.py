"""How a quantity of a case scatters or is stepped through, as the value at a share of its
probability.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.errors import InputError
from valvetrain.units import DIMENSIONS, dimension_of, unit_factor

Array = NDArray[np.float64]
#: A tolerance is this many standard deviations where nobody says otherwise, as shops draw their
#: limits.
SIGMAS = 3.0


class Distribution(Protocol):
    """Values of one quantity over the share of its probability."""

    def at(self, share: ArrayLike) -> Array:
        """Values (SI) below which ``share`` (0 to 1) of all lie, in the shape of ``share``."""
        ...

    def levels(self, count: int) -> tuple[float, ...]:
        """``count`` values (SI) that a grid steps through; a list has its own."""
        ...

    @property
    def middle(self) -> float:
        """Median (SI)."""
        ...


def _refuse(found: str) -> None:
    if found:
        raise InputError(found)


def _finite(one: object) -> str:
    bad = next(
        (field.name for field in fields(one) if not np.isfinite(getattr(one, field.name))),  # type: ignore[arg-type]
        "",
    )
    return f"{bad} of a distribution is no finite number; give one" if bad else ""


@dataclass(frozen=True, slots=True)
class Uniform:
    """Every value from ``low`` to ``high`` alike.

    >>> Uniform(1.0, 3.0).levels(3)
    (1.0, 2.0, 3.0)
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        _refuse(
            _finite(self)
            or (
                ""
                if self.low < self.high
                else f"low ({self.low:g}) is not below high ({self.high:g}); swap them"
            )
        )

    def at(self, share: ArrayLike) -> Array:
        return np.asarray(self.low + (self.high - self.low) * np.asarray(share, dtype=float))

    def levels(self, count: int) -> tuple[float, ...]:
        return (
            tuple(float(value) for value in np.linspace(self.low, self.high, count))
            if count > 1
            else (self.middle,)
        )

    @property
    def middle(self) -> float:
        return 0.5 * (self.low + self.high)


@dataclass(frozen=True, slots=True)
class Normal:
    """Gauss about ``mean`` with ``standard_deviation``, cut off at ``low`` and ``high`` where these
    are finite.

    >>> round(float(Normal(10.0, 1.0).at(0.975)), 3)
    11.96
    """

    mean: float
    standard_deviation: float
    low: float = -np.inf
    high: float = np.inf

    def __post_init__(self) -> None:
        if not (
            np.isfinite(self.mean)
            and np.isfinite(self.standard_deviation)
            and self.standard_deviation > 0
        ):
            raise InputError(
                "a normal distribution has a finite mean and a positive standard deviation; correct them"
            )
        if not (self.low < self.high and self._shares()[1] > self._shares()[0]):
            raise InputError(
                f"no value of the normal distribution lies between {self.low:g} and {self.high:g}; widen the bounds"
            )

    def _shares(self) -> tuple[float, float]:
        from scipy.special import ndtr

        low, high = (
            (bound - self.mean) / self.standard_deviation for bound in (self.low, self.high)
        )
        return float(ndtr(low)), float(ndtr(high))

    def at(self, share: ArrayLike) -> Array:
        from scipy.special import ndtri

        low, high = self._shares()
        inside = low + (high - low) * np.asarray(share, dtype=float)
        found = self.mean + self.standard_deviation * np.asarray(ndtri(inside))
        return np.asarray(np.clip(found, self.low, self.high))

    def levels(self, count: int) -> tuple[float, ...]:
        return _even_shares(self, count)

    @property
    def middle(self) -> float:
        return float(self.at(0.5))


@dataclass(frozen=True, slots=True)
class LogNormal:
    """The logarithm is normal: half of all values lie below ``median``, two thirds within a factor
    of ``factor`` about it.

    >>> round(float(LogNormal(2.0, 1.5).at(0.5)), 6)
    2.0
    """

    median: float
    factor: float

    def __post_init__(self) -> None:
        _refuse(_finite(self))
        if not (self.median > 0 and self.factor > 1):
            raise InputError(
                "a lognormal distribution has a positive median and a factor above 1; correct them"
            )

    def at(self, share: ArrayLike) -> Array:
        from scipy.special import ndtri

        return np.asarray(
            self.median * self.factor ** np.asarray(ndtri(np.asarray(share, dtype=float)))
        )

    def levels(self, count: int) -> tuple[float, ...]:
        return _even_shares(self, count)

    @property
    def middle(self) -> float:
        return self.median


@dataclass(frozen=True, slots=True)
class Values:
    """One of ``values``, each as likely as the others; a grid steps through them in their order.

    >>> Values((1.0, 2.0, 4.0)).at([0.1, 0.9]).tolist()
    [1.0, 4.0]
    """

    values: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", tuple(float(value) for value in self.values))
        if not self.values or not np.all(np.isfinite(self.values)):
            raise InputError(
                "a list of values holds at least one, and finite numbers only; correct it"
            )

    def at(self, share: ArrayLike) -> Array:
        place = np.minimum(
            (np.asarray(share, dtype=float) * len(self.values)).astype(int), len(self.values) - 1
        )
        return np.asarray(np.asarray(self.values)[place])

    def levels(self, count: int) -> tuple[float, ...]:
        return self.values

    @property
    def middle(self) -> float:
        return self.values[len(self.values) // 2]


def _even_shares(one: Distribution, count: int) -> tuple[float, ...]:
    """Middles of ``count`` parts of equal probability."""
    return tuple(float(value) for value in one.at((np.arange(count) + 0.5) / count))


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
