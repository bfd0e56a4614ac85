"""Samplers: the points of a study; and the Sobol indices of the points of Saltelli's design: which share of an output's variance each varied
quantity brings, alone and with all it acts together with.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from pydantic import Field, ValidationError

from valvetrain.arrays import Array
from valvetrain.errors import InputError, MissingExtraError
from valvetrain.explore.distributions import Values
from valvetrain.explore.outputs import Run
from valvetrain.explore.space import Space, Varied
from valvetrain.parameters.schema_types import StrictModel, first_problem
from valvetrain.registry import find

#: Most points of a study.
MAX_POINTS = 1_000_000
#: Points drawn, a power of two for the balance of Sobol's sequence, and levels of a grid by default.
COUNT, LEVELS = 128, 5
#: Resamples behind an interval, and its ends in per cent.
RESAMPLES, ENDS = 1000, (2.5, 97.5)
#: Rows of all resamples together, which bound the memory.
MOST_DRAWN = 10**7
#: Base rows below which there is no index; a spread (over the size of the mean) below which there is
#: nothing to explain.
MIN_ROWS, NO_SPREAD = 8, 1e-9
#: Base rows that are recommended where fewer cannot separate quantities.
ENOUGH_ROWS = 64


class SamplerOptions(StrictModel):
    """Options that a sampler takes; each declares its own."""


class CountedOptions(SamplerOptions):
    """Options of samplers that draw a number of points."""

    count: int = Field(default=COUNT, ge=1, le=MAX_POINTS, description="points drawn")
    seed: int = Field(
        default=1,
        ge=0,
        le=2**31,
        description="seed of the random numbers; the same seed gives the same points",
    )


Draw = Callable[[Sequence[Varied], SamplerOptions], Array]


@dataclass(frozen=True, slots=True)
class SamplerSpec:
    """A sampler: ``draw`` gives points (n, d) in SI. ``independent``: they are draws from the distributions, so that their
    percentiles mean something.
    """

    word: str
    shown_name: str
    options: type[SamplerOptions]
    draw: Draw
    independent: bool = False

    def read_options(self, given: Mapping[str, object]) -> SamplerOptions:
        """Checked options. Raises :class:`InputError` for those that the sampler does not have."""
        try:
            return self.options.model_validate(dict(given))
        except ValidationError as error:
            path, reason = first_problem(error)
            raise InputError(reason, ".".join(map(str, ("points", *path)))) from None


@contextmanager
def needs(package: str, extra: str = "studies") -> Iterator[None]:
    """Import a package of an extra in the block. Raises :class:`MissingExtraError` where it is not installed."""
    try:
        yield
    except ImportError as error:
        raise MissingExtraError(
            f"{package} is not installed; install it with pip install 'valvetrain[{extra}]'"
        ) from error


def sampler(word: str, where: str = "points.sampler") -> SamplerSpec:
    """The sampler of a name in the registry. Raises :class:`InputError` for an unknown one."""
    spec: SamplerSpec = find("samplers", word, where)
    return spec


def _drawn(
    word: str,
    name: str,
    cube: Callable[[int, int, int], Array],
    options: type[CountedOptions] = CountedOptions,
) -> SamplerSpec:
    """The sampler of a design ``cube(quantities, count, seed)`` in the unit cube."""

    def draw(varied: Sequence[Varied], given: SamplerOptions) -> Array:
        assert isinstance(given, CountedOptions)
        return Space(varied).points(cube(len(varied), given.count, given.seed))

    return SamplerSpec(word, name, options, draw, independent=True)


class GridOptions(SamplerOptions):
    """Options of a grid."""

    levels: int = Field(
        default=LEVELS,
        ge=1,
        le=100_000,
        description="levels of each quantity that lists none of its own",
    )


def _grid(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, GridOptions)
    levels = [one.distribution.levels(options.levels) for one in varied]
    count = math.prod(map(len, levels))
    if count > MAX_POINTS:
        raise InputError(
            f"a grid of {count:.3g} points is too large; take fewer levels", "points.levels"
        )
    return np.array(list(itertools.product(*levels)))


GRID_SPEC = SamplerSpec("grid", "every combination of levels", GridOptions, _grid)


class ListOptions(SamplerOptions):
    """Options of a list."""

    names: list[str] = Field(
        default=[], max_length=1000, description="names of the points, by which results call them"
    )


def _list(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, ListOptions)
    for one in varied:
        if not isinstance(one.distribution, Values):
            raise InputError(
                "is in a list of points, so it needs its values one by one; give 'values'",
                one.name,
            )
    columns = [one.distribution.levels(0) for one in varied]
    lengths = [len(column) for column in columns]
    if len(set(lengths)) > 1:
        raise InputError(
            f"in a list of points every quantity has as many values; here are {lengths}", "points"
        )
    if options.names and not len(set(options.names)) == len(options.names) == lengths[0]:
        raise InputError(
            f"a name for each of the {lengths[0]} points is needed, no two alike; here are {len(options.names)}",
            "points.names",
        )
    return np.array(columns, dtype=float).T


LISTED_SPEC = SamplerSpec("list", "your list", ListOptions, _list)


def listed(points: Array) -> SamplerSpec:
    """The sampler of given ``points`` (n, d) in SI."""
    return SamplerSpec("list", "your list", SamplerOptions, lambda varied, options: points)


def latin_hypercube(count: int, dimensions: int, seed: int | Sequence[int]) -> Array:
    """``count`` points (n, d) of the unit cube, one in each of ``count`` strata of every axis."""
    from scipy.stats import qmc

    return np.asarray(
        qmc.LatinHypercube(dimensions, seed=np.random.default_rng(seed)).random(count)
    )


def sequence(dimensions: int, count: int, seed: int) -> Array:
    """``count`` points (n, d) of Sobol's scrambled sequence in the unit cube."""
    from scipy.stats import qmc

    points = qmc.Sobol(dimensions, scramble=True, seed=np.random.default_rng(seed))
    return np.asarray(points.random_base2(max(0, math.ceil(math.log2(count)))))[:count]


def saltelli(dimensions: int, count: int, seed: int) -> Array:
    """Points of the unit cube in rows: A, B, then for every quantity A with its column of B.

    There are at most ``count`` of them; the base rows are a power of two, for then the sequence is balanced, at least 2.
    """
    rows = 1 << max(1, int(math.log2(max(2, count // (dimensions + 2)))))
    both = sequence(2 * dimensions, rows, seed)
    a, b = both[:, :dimensions], both[:, dimensions:]
    mixed = [np.where(np.arange(dimensions) == index, b, a) for index in range(dimensions)]
    return np.concatenate([a, b, *mixed])


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


LATIN_HYPERCUBE_SPEC = _drawn(
    "latin-hypercube",
    "Latin hypercube",
    lambda size, count, seed: latin_hypercube(count, size, seed),
)
SOBOL_SPEC = _drawn("sobol", "Sobol's sequence", sequence)
MONTE_CARLO_SPEC = _drawn(
    "monte-carlo",
    "random draws",
    lambda size, count, seed: np.random.default_rng(seed).random((count, size)),
)
SALTELLI_SPEC = _drawn("saltelli", "Saltelli's design for Sobol indices", saltelli, SaltelliOptions)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Indices of one ``output`` at one ``run`` by varied quantity (d): ``first`` order and
    ``total``, with 95 % intervals (d, 2).

    ``rows``: base rows used; ``dropped``: those left out because a point of them failed.
    """

    output: str
    run: Run
    names: tuple[str, ...]
    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    rows: int
    dropped: int


def sensitivity_of(
    output: str, run: Run, names: Sequence[str], values: Array
) -> Sensitivity | None:
    """Indices from ``values`` of the rows of Saltelli's design (A, B, then A with each column of
    B); nan where a point failed.

    First order by Saltelli et al. (2010), total by Jansen (1999), intervals by bootstrap over the
    base rows, by SALib. None with fewer than :data:`MIN_ROWS` whole base rows. Raises
    :class:`MissingExtraError` without SALib.
    """
    size = len(names)
    parts = values.reshape(size + 2, -1)
    whole = np.all(np.isfinite(parts), axis=0)
    rows = int(np.count_nonzero(whole))
    if rows < MIN_ROWS:
        return None
    indices = {order: np.zeros((size, 3)) for order in ("S1", "ST")}
    by_row = parts[[0, *range(2, size + 2), 1]][:, whole].T  # SALib's order: A, its mixtures, B
    if np.std(by_row) > NO_SPREAD * abs(np.mean(by_row)):
        with needs("SALib"):
            from SALib.analyze import sobol
        problem = {"num_vars": size, "names": list(names), "bounds": [[0.0, 1.0]] * size}
        made = sobol.analyze(
            problem,
            by_row.ravel(),
            calc_second_order=False,
            num_resamples=min(RESAMPLES, max(100, MOST_DRAWN // rows)),
            keep_resamples=True,
            seed=1,
        )
        for order, columns in indices.items():
            ends = np.nanpercentile(made[f"{order}_conf_all"], ENDS, axis=0)
            columns[:] = np.column_stack([made[order], *ends])
    first, total = indices.values()
    return Sensitivity(
        output, run, tuple(names), first[:, 0], total[:, 0], first[:, 1:], total[:, 1:], rows, len(whole) - rows,
    )  # fmt: skip
