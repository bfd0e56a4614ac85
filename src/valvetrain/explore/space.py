"""The space of an experiment: varied quantities and the distribution of each.

A distribution is flat or normal in a working coordinate, the value itself or its logarithm, between
bounds. Studies read it as a scatter or a range, identifications as a prior.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, get_args, overload

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.summary import number, unit_text
from valvetrain.units import DIMENSIONS, Given, dimension_of, numbers_of, unit_factor
from valvetrain.units.reader import reader_factor, reader_unit

Kind = Literal["uniform", "log-uniform", "normal", "lognormal"]
KINDS: tuple[str, ...] = get_args(Kind)
#: A tolerance is this many standard deviations by default, as shops draw their limits.
SIGMAS = 3.0
#: Bounds of a normal distribution that has none, in standard deviations: values beyond have a
#: probability of 1e-15.
FAR = 8.0


@dataclass(frozen=True)
class Prior:
    """Distribution of one quantity (SI): its scatter, its range, or its prior before any
    measurement.

    ``kind``: ``uniform`` or ``log-uniform`` between ``low`` and ``high``; ``normal`` of mean
    ``centre`` and standard deviation ``spread``; ``lognormal`` of median ``centre`` whose logarithm
    has the standard deviation ``spread``. Bounds truncate a normal and a lognormal one. ``source``:
    where it comes from. ``dimension``: that of the units it was given in, None for SI numbers; a case
    must agree. Raises :class:`InputError` for bounds or spreads that make no density.

    >>> wire = Prior("normal", low=3.5e-3, centre=3.8e-3, spread=0.05e-3, source="tolerance of the wire")
    >>> float(wire.at(0.5).round(6))
    0.0038
    """

    kind: Kind
    low: float = -math.inf
    high: float = math.inf
    centre: float = math.nan
    spread: float = math.nan
    source: str = ""
    dimension: str | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(
                f"distribution '{str(self.kind)[:40]}' is unknown; use one of {', '.join(KINDS)}"
            )
        if not self.low < self.high:
            raise InputError(
                f"low ({self.low:g}) is not below high ({self.high:g}); correct the bounds"
            )
        needed = (self.low, self.high) if self.flat else (self.centre, self.spread)
        if not all(map(math.isfinite, needed)) or self.spread <= 0:
            words = "two finite bounds" if self.flat else "a finite middle and a positive spread"
            raise InputError(f"a {self.kind} distribution needs {words}; give both")
        if self.logarithmic and needed[0] <= 0:
            raise InputError(
                f"a {self.kind} distribution is of positive values; give positive numbers"
            )
        if not self.flat and not (self.low <= self.centre <= self.high and self.inside > 0):
            raise InputError(
                f"the middle {self.centre:g} is outside the bounds {self.low:g} to {self.high:g}; widen them"
            )

    @property
    def flat(self) -> bool:
        """Whether no value between the bounds is likelier than another, in the working coordinate."""
        return self.kind in ("uniform", "log-uniform")

    @property
    def logarithmic(self) -> bool:
        """Whether the working coordinate is the logarithm of the value."""
        return self.kind in ("log-uniform", "lognormal")

    def work(self, value: Array | float) -> Array:
        """Working coordinate of a value (SI)."""
        return np.log(value) if self.logarithmic else np.asarray(value, dtype=float)

    def value(self, work: Array | float) -> Array:
        """Value (SI) of a working coordinate, clipped to the bounds against rounding."""
        found = np.asarray(work, dtype=float)
        if self.logarithmic:  # one by one: the bits of a value do not depend on its neighbours
            found = np.array([math.exp(one) for one in found.ravel()]).reshape(found.shape)
        return np.asarray(np.clip(found, self.low, self.high))

    @cached_property
    def work_centre(self) -> float:
        """Middle of the prior in the working coordinate."""
        return 0.5 * sum(self.work_bounds) if self.flat else float(self.work(self.centre))

    @cached_property
    def work_spread(self) -> float:
        """Standard deviation of the prior in the working coordinate, that of the normal one before
        its bounds truncate it.
        """
        low, high = self.work_bounds
        return (high - low) / math.sqrt(12.0) if self.flat else self.spread

    @cached_property
    def work_bounds(self) -> tuple[float, float]:
        """Lowest and highest working coordinate; where a normal one has no bound, :data:`FAR`
        deviations away.
        """
        low, high = (
            -math.inf if self.logarithmic and bound <= 0 else float(self.work(bound))
            for bound in (self.low, self.high)
        )
        if self.flat:
            return low, high
        middle, reach = float(self.work(self.centre)), FAR * self.spread
        return max(low, middle - reach), min(high, middle + reach)

    @cached_property
    def inside(self) -> float:
        """Share of the normal density between the bounds."""
        low, high = (
            (bound - float(self.work(self.centre))) / self.spread for bound in self.work_bounds
        )
        return float(ndtr(high) - ndtr(low))

    def at(self, share: ArrayLike) -> Array:
        """Values (SI) below which ``share`` (0 to 1) of all are, in the shape of ``share``."""
        return self.value(self.from_share(np.asarray(share, dtype=float)))

    def levels(self, count: int) -> tuple[float, ...]:
        """``count`` values (SI) that a grid steps through: evenly spaced with both ends, of a
        normal one the middles of parts of equal probability.
        """
        if count == 1:
            return (self.middle,)
        shares = np.linspace(0.0, 1.0, count) if self.flat else (np.arange(count) + 0.5) / count
        if self.kind == "uniform":
            return tuple(np.linspace(self.low, self.high, count).tolist())
        return tuple(self.at(shares).tolist())

    @property
    def middle(self) -> float:
        """Median (SI)."""
        return float(self.at(0.5))

    def from_share(self, share: Array | float) -> Array:
        """Working coordinate below which the prior has the probability ``share``."""
        low, high = self.work_bounds
        if self.flat:
            return np.asarray(low + np.asarray(share) * (high - low))
        begin = ndtr((low - self.work_centre) / self.spread)
        scores = ndtri(begin + np.asarray(share) * self.inside)
        return np.asarray(np.clip(self.work_centre + self.spread * scores, low, high))

    def share(self, work: Array | float) -> Array:
        """Probability of the prior below a working coordinate."""
        low, high = self.work_bounds
        at = np.clip(work, low, high)
        if self.flat:
            return np.asarray((at - low) / (high - low))
        begin = ndtr((low - self.work_centre) / self.spread)
        return np.asarray(
            np.clip((ndtr((at - self.work_centre) / self.spread) - begin) / self.inside, 0.0, 1.0)
        )

    def share_of(self, value: float) -> float:
        """Probability of the prior below a value (SI), nan of one beyond the bounds."""
        return float(self.share(self.work(value))) if self.low <= value <= self.high else math.nan

    def log_density(self, work: Array | float) -> Array:
        """Logarithm of the density over the working coordinate; minus infinity beyond the bounds."""
        low, high = self.work_bounds
        at = np.asarray(work, dtype=float)
        outside = (at < low) | (at > high)
        if self.flat:
            return np.where(outside, -np.inf, -math.log(high - low))
        normal = -0.5 * ((at - self.work_centre) / self.spread) ** 2 - math.log(
            self.spread * math.sqrt(2 * math.pi) * self.inside
        )
        return np.where(outside, -np.inf, normal)

    def pull(self, work: Array | float) -> Array:
        """What least squares add for the prior: distance from its middle in standard deviations,
        zero of a flat one.
        """
        off = np.asarray(work, dtype=float) - self.work_centre
        return np.zeros(off.shape) if self.flat else off / self.spread


def Uniform(low: Given, high: Given) -> Prior:
    """Every value from ``low`` to ``high`` alike; SI, or text with a unit, as of all distributions.

    Parameters
    ----------
    low, high : smallest and largest value: SI, text with a unit, or a pint quantity

    Returns
    -------
    Prior

    Raises
    ------
    InputError : numbers that make no distribution, a unit that is not known

    Examples
    --------
    >>> Uniform(1.0, 3.0).levels(3)
    (1.0, 2.0, 3.0)
    """
    (least, largest), dimension = numbers_of(low, high)
    return Prior("uniform", least, largest, dimension=dimension)


def Normal(
    mean: Given, standard_deviation: Given, low: Given = -math.inf, high: Given = math.inf
) -> Prior:
    """Gauss about ``mean`` with ``standard_deviation``, truncated at ``low`` and ``high``.

    Parameters
    ----------
    mean, standard_deviation : SI, text with a unit, or a pint quantity
    low, high : bounds, likewise

    Returns
    -------
    Prior

    Raises
    ------
    InputError : numbers that make no distribution, a unit that is not known

    Examples
    --------
    >>> round(float(Normal(10.0, 1.0).at(0.975)), 3)
    11.96
    """
    (least, largest, middle, spread), dimension = numbers_of(low, high, mean, standard_deviation)
    return Prior("normal", least, largest, middle, spread, dimension=dimension)


def LogNormal(median: Given, factor: float) -> Prior:
    """The logarithm is normal: half of all values are below ``median``, two thirds within a factor
    of ``factor`` about it.

    Parameters
    ----------
    median : SI, text with a unit, or a pint quantity
    factor : above 1

    Returns
    -------
    Prior

    Raises
    ------
    InputError : numbers that make no distribution, a unit that is not known

    Examples
    --------
    >>> round(float(LogNormal(2.0, 1.5).at(0.5)), 6)
    2.0
    """
    if not (math.isfinite(factor) and factor > 1):
        raise InputError("a lognormal distribution has a finite factor above 1; correct it")
    (middle,), dimension = numbers_of(median)
    return Prior("lognormal", centre=middle, spread=math.log(factor), dimension=dimension)


@dataclass(frozen=True)
class Values:
    """One of ``values`` (SI, text with units or pint quantities), each as likely as the others; a
    grid steps through them in their order.

    >>> Values((1.0, 2.0, 4.0)).at([0.1, 0.9]).tolist()
    [1.0, 4.0]
    """

    values: tuple[float, ...]
    dimension: str | None = field(default=None, compare=False, repr=False)
    kind = "values"

    if TYPE_CHECKING:  # arguments may have other types than the fields

        def __init__(self, values: Sequence[Given], dimension: str | None = None) -> None: ...

    def __post_init__(self) -> None:
        values, dimension = numbers_of(*self.values, dimension=self.dimension)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "dimension", dimension)
        if not self.values or not np.all(np.isfinite(self.values)):
            raise InputError(
                "a list of values holds at least one, and finite numbers only; correct it"
            )

    def at(self, share: ArrayLike) -> Array:
        """Values (SI) at ``share`` (0 to 1), each over an equal part."""
        index = np.minimum(
            (np.asarray(share, dtype=float) * len(self.values)).astype(int), len(self.values) - 1
        )
        return np.asarray(np.asarray(self.values)[index])

    def share_of(self, value: float) -> float:
        """The middle of the part of a value, nan of one that is not listed."""
        here = value in self.values
        return (self.values.index(value) + 0.5) / len(self.values) if here else math.nan

    def levels(self, count: int) -> tuple[float, ...]:
        """The values themselves."""
        return self.values

    @property
    def middle(self) -> float:
        """The value in the middle of the list."""
        return self.values[len(self.values) // 2]


Distribution = Prior | Values
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


@dataclass(frozen=True, init=False)
class Space(Sequence[Varied]):
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

    varied: tuple[Varied, ...]

    def __init__(self, varied: Mapping[str, Distribution] | Sequence[Varied]) -> None:
        if isinstance(varied, Mapping):
            varied = [Varied(name, distribution=one) for name, one in varied.items()]
        object.__setattr__(self, "varied", tuple(varied))
        names = self.names
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f"'{twice[:60]}' is varied twice; give it once")

    @overload
    def __getitem__(self, index: int) -> Varied: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Varied]: ...
    def __getitem__(self, index: int | slice) -> Varied | Sequence[Varied]:
        return self.varied[index]

    def __len__(self) -> int:
        return len(self.varied)

    def __iter__(self) -> Iterator[Varied]:
        return iter(self.varied)

    @property
    def names(self) -> tuple[str, ...]:
        """Name of every quantity: its key, with ``factor`` or ``offset`` behind."""
        return tuple(one.name for one in self.varied)

    @property
    def identity(self) -> list[Any]:
        """What the values of a point mean, whatever their distributions."""
        return [[one.key, one.also, one.operation, one.si_unit] for one in self.varied]

    def points(self, shares: ArrayLike) -> Array:
        """Points (n, d) in SI of shares (n, d) in the unit cube."""
        # half of the last bit off either end, where a distribution without bounds is infinite
        inside = np.clip(np.asarray(shares, dtype=float), 2.0**-53, 1 - 2.0**-53)
        return np.column_stack(
            [one.distribution.at(inside[:, index]) for index, one in enumerate(self.varied)]
        )
