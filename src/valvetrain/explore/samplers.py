"""Samplers: the first points of a study, and the next ones once the outputs of those are there."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from valvetrain.errors import InputError
from valvetrain.explore.space import Space, Values, Varied
from valvetrain.registry import find

Array = NDArray[np.float64]
#: Most points of a study.
MAX_POINTS = 1_000_000
#: Points drawn, a power of two for the balance of Sobol's sequence, and levels of a grid by default.
COUNT, LEVELS = 128, 5


class SamplerOptions(BaseModel):
    """Options that a sampler takes; each declares its own."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class CountedOptions(SamplerOptions):
    """Options of samplers that draw a number of points."""

    count: int = Field(default=COUNT, ge=1, le=MAX_POINTS, description="points drawn")
    seed: int = Field(
        default=1,
        ge=0,
        le=2**31,
        description="seed of the random numbers; the same seed gives the same points",
    )


First = Callable[[Sequence[Varied], SamplerOptions], Array]
More = Callable[[Sequence[Varied], SamplerOptions, Array, Array], Array]


def no_more(
    varied: Sequence[Varied], options: SamplerOptions, points: Array, values: Array
) -> Array:
    """No further points."""
    return np.zeros((0, len(varied)))


@dataclass(frozen=True, slots=True)
class SamplerSpec:
    """A sampler: ``first`` gives points (n, d) in SI; ``more`` those that follow, from all points
    and the first output of each (nan where it failed), none at the end. ``independent``: its points
    are draws from the distributions, so that their percentiles mean something.
    """

    word: str
    shown_name: str
    options: type[SamplerOptions]
    first: First
    more: More = no_more
    independent: bool = False

    def read_options(self, given: dict[str, object]) -> SamplerOptions:
        """Checked options. Raises :class:`InputError` for those that the sampler does not have."""
        from pydantic import ValidationError

        from valvetrain.parameters.changes import nearest

        known = tuple(self.options.model_fields)
        for key in given:
            if key not in known:
                raise InputError(
                    f"sampler {self.word} has no option '{key[:40]}'; {nearest(key, known)}",
                    f"points.{key[:40]}",
                )
        try:
            return self.options.model_validate(given)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            index = ".".join(str(part) for part in first["loc"])
            raise InputError(
                f"{str(first['input'])[:40]!r} does not fit: {first['msg'][:1].lower()}{first['msg'][1:]}; correct it",
                f"points.{index}",
            ) from None


def sampler(word: str, where: str = "points.sampler") -> SamplerSpec:
    """The sampler of a name in the registry. Raises :class:`InputError` for an unknown one."""
    found: SamplerSpec = find("samplers", word, where)
    return found


def spread(varied: Sequence[Varied], shares: Array) -> Array:
    """Points (n, d) in SI of shares (n, d) in the unit cube, each column by its distribution,
    correlated where the space is.
    """
    return (varied if isinstance(varied, Space) else Space(varied)).points(shares)


class GridOptions(SamplerOptions):
    """Options of a grid."""

    levels: int = Field(
        default=LEVELS,
        ge=1,
        le=100_000,
        description="levels of each quantity that lists none of its own",
    )


def _first(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, GridOptions)
    levels = [one.distribution.levels(options.levels) for one in varied]
    count = math.prod(map(len, levels))
    if count > MAX_POINTS:
        raise InputError(
            f"a grid of {' x '.join(str(len(one)) for one in levels)} has {count:.3g} points; take fewer levels",
            "points.levels",
        )
    return np.stack([axis.ravel() for axis in np.meshgrid(*levels, indexing="ij")], axis=1)


GRID_SPEC = SamplerSpec("grid", "every combination of levels", GridOptions, _first)


class ListOptions(SamplerOptions):
    """Options of a list."""

    names: list[str] = Field(
        default=[], max_length=1000, description="names of the points, by which results call them"
    )


def _first_listed(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    columns = []
    for one in varied:
        if not isinstance(one.distribution, Values):
            raise InputError(
                "is in a list of points, so it needs its values one by one; give 'values'",
                one.name,
            )
        columns.append(one.distribution.values)
    if len({len(column) for column in columns}) > 1:
        lengths = ", ".join(
            f"{one.name} {len(column)}" for one, column in zip(varied, columns, strict=True)
        )
        raise InputError(
            f"in a list of points every quantity has as many values; here are {lengths}", "points"
        )
    names = getattr(options, "names", [])
    if names and (len(names) != len(columns[0]) or len(set(names)) < len(names)):
        raise InputError(
            f"a name for each of the {len(columns[0])} points is needed, no two alike; here are {len(names)}",
            "points.names",
        )
    return np.array(columns, dtype=float).T


LISTED_SPEC = SamplerSpec("list", "your list", ListOptions, _first_listed)


def listed(points: Array) -> SamplerSpec:
    """The sampler of given ``points`` (n, d) in SI."""
    return SamplerSpec("list", "your list", SamplerOptions, lambda varied, options: points)


def latin_hypercube(count: int, dimensions: int, seed: int | Sequence[int]) -> Array:
    """``count`` points (n, d) of the unit cube, one in each of ``count`` strata of every axis."""
    from scipy.stats import qmc

    sampler = qmc.LatinHypercube(dimensions, seed=np.random.default_rng(seed))
    return np.asarray(sampler.random(count))


def _first_latin_hypercube(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, CountedOptions)
    return spread(varied, latin_hypercube(options.count, len(varied), options.seed))


LATIN_HYPERCUBE_SPEC = SamplerSpec(
    "latin-hypercube", "Latin hypercube", CountedOptions, _first_latin_hypercube, independent=True
)


def sequence(dimensions: int, count: int, seed: int) -> Array:
    """``count`` points (n, d) of the scrambled sequence in the unit cube."""
    from scipy.stats import qmc

    power = max(0, int(np.ceil(np.log2(count))))
    drawn = qmc.Sobol(dimensions, scramble=True, seed=np.random.default_rng(seed)).random_base2(
        power
    )
    return np.asarray(drawn[:count])


def _first_sobol(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, CountedOptions)
    return spread(varied, sequence(len(varied), options.count, options.seed))


SOBOL_SPEC = SamplerSpec(
    "sobol", "Sobol's sequence", CountedOptions, _first_sobol, independent=True
)


def _first_monte_carlo(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, CountedOptions)
    return spread(varied, np.random.default_rng(options.seed).random((options.count, len(varied))))


MONTE_CARLO_SPEC = SamplerSpec(
    "monte-carlo", "random draws", CountedOptions, _first_monte_carlo, independent=True
)


class SaltelliOptions(CountedOptions):
    """Options of the design; ``count`` is that of all points, of which the largest power of two of
    base rows is made.
    """

    count: int = Field(
        default=1024,
        ge=8,
        le=MAX_POINTS,
        description="points at most: base rows times (quantities + 2)",
    )


def base_rows(count: int, dimensions: int) -> int:
    """Base rows of a design of ``count`` points at most: a power of two, for then the sequence is
    balanced; at least 2.
    """
    return int(max(2, 2 ** int(np.floor(np.log2(max(2, count // (dimensions + 2)))))))


def _first_saltelli(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    """Rows: A, B, then for every quantity A with its column of B."""
    assert isinstance(options, SaltelliOptions)
    size, rows = len(varied), base_rows(options.count, len(varied))
    both = sequence(2 * size, rows, options.seed)
    a, b = both[:, :size], both[:, size:]
    mixed = [np.where(np.arange(size) == index, b, a) for index in range(size)]
    return spread(varied, np.concatenate([a, b, *mixed]))


SALTELLI_SPEC = SamplerSpec(
    "saltelli",
    "Saltelli's design for Sobol indices",
    SaltelliOptions,
    _first_saltelli,
    independent=True,
)


class AdaptiveOptions(CountedOptions):
    """Options of the refinement."""

    first: int = Field(default=16, ge=2, le=10_000, description="points of the first round")
    per_round: int = Field(default=8, ge=1, le=1000, description="points added in each round")


def _first_adaptive(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, AdaptiveOptions)
    for one in varied:
        if one.distribution.kind != "uniform":
            raise InputError(
                "is refined where an output changes, so it needs a range; give low and high",
                one.name,
            )
    if len(varied) == 1:  # ends included, so that every location is between two points
        return spread(varied, np.linspace(0.0, 1.0, min(options.first, options.count))[:, None])
    size = len(varied)
    corners = (
        np.array(np.meshgrid(*([[0.0, 1.0]] * size), indexing="ij")).reshape(size, -1).T
        if size <= 4
        else np.zeros((0, size))
    )
    inner = sequence(size, max(1, options.first - len(corners)), options.seed)
    return spread(varied, np.concatenate([corners, inner])[: options.count])


def _more(varied: Sequence[Varied], options: SamplerOptions, points: Array, values: Array) -> Array:
    """Middles between neighbours, the largest change over distance weighed by the distance first;
    none at the bound or without change.
    """
    assert isinstance(options, AdaptiveOptions)
    from scipy.spatial import cKDTree

    left = min(options.per_round, options.count - len(points))
    known = np.isfinite(values)
    if left < 1 or np.count_nonzero(known) < 2:
        return np.zeros((0, len(varied)))
    low, span = (
        np.array([getattr(one.distribution, name) for one in varied]) for name in ("low", "high")
    )
    span = span - low
    cube, found = ((points - low) / span)[known], values[known]
    near = min(2 * len(varied), len(cube) - 1)
    distances, neighbours = cKDTree(cube).query(cube, k=near + 1)
    pairs = {
        (min(i, int(j)), max(i, int(j))): float(d)
        for i, row in enumerate(neighbours)
        for j, d in zip(row[1:], distances[i, 1:], strict=True)
    }
    if len(varied) == 1:  # the neighbours on either side, however far
        order = np.argsort(cube[:, 0], kind="stable").tolist()
        pairs = {(a, b): float(abs(cube[b, 0] - cube[a, 0])) for a, b in itertools.pairwise(order)}
    scored = sorted(
        ((-abs(found[b] - found[a]) * d, a, b) for (a, b), d in pairs.items() if d > 1e-6),
        key=lambda one: one,
    )
    chosen: list[Array] = []
    for score, a, b in scored:
        middle = 0.5 * (cube[a] + cube[b])
        if score < 0 and all(np.max(np.abs(middle - other)) > 1e-9 for other in (*chosen, *cube)):
            chosen.append(middle)
        if len(chosen) == left:
            break
    return low + span * np.array(chosen) if chosen else np.zeros((0, len(varied)))


ADAPTIVE_SPEC = SamplerSpec(
    "adaptive", "refined where an output changes most", AdaptiveOptions, _first_adaptive, _more
)
