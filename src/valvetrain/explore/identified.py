"""What an identification found: branches with intervals, what the data determine, where each
measurement is in its prediction.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.explore.draws import even_places
from valvetrain.explore.least_squares import Fit, Information
from valvetrain.explore.posterior import Datum
from valvetrain.explore.samplers import CountedOptions, SamplerOptions, SamplerSpec, needs
from valvetrain.explore.space import Varied
from valvetrain.parameters.changes import nearest
from valvetrain.solution.definition import si_unit_text
from valvetrain.solution.display import Reported, verdict_first
from valvetrain.solution.netcdf import load_result
from valvetrain.units import dimension_of

if TYPE_CHECKING:
    import xarray


#: Shares of the draws below the ends and the middle of an interval.
SHARES = (0.025, 0.5, 0.975)


def si_unit(unit: str) -> str:
    """SI unit of what is shown in ``unit``; ``SI`` where a number came without one.

    >>> si_unit("N/mm"), si_unit("deg"), si_unit("%"), si_unit("")
    ('N/m', 'rad', '1', 'SI')
    """
    dimension = dimension_of(unit) if unit else None
    return si_unit_text(dimension) if dimension else "SI"


@dataclass(frozen=True, slots=True)
class Interval:
    """A quantity as it was found (SI): ``best``, at the likeliest point; ``mean``, ``deviation``
    and the interval that holds 95 %.
    """

    best: float
    mean: float
    deviation: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Branch:
    """A separate part of the posterior with its probability ``share``; ``misfit``: least sum of squared scaled misses, priors
    included; ``fit``: how well it meets the data, None of a search that was stopped. Intervals are
    widened where it does not.
    """

    share: float
    misfit: float
    quantities: Mapping[str, Interval]
    correlation: Array
    information: Information
    fit: Fit | None = None


@dataclass(frozen=True, slots=True)
class Prediction:
    """A computed number (SI; shown in ``unit``): at the ``best`` point, and 2.5, 50 and 97.5 % over
    the posterior.
    """

    key: str
    unit: str
    best: float
    low: float
    middle: float
    high: float


@dataclass(frozen=True, slots=True)
class Predicted(Prediction):
    """The prediction of a measured ``datum``, with the ``percentile`` of the measured value among
    what would be measured (0 to 100). ``start``: computed at the start, NaN where that cannot be.
    """

    datum: Datum
    percentile: float
    start: float = np.nan

    @property
    def off(self) -> float:
        """Computed less measured at the ``best`` point, in scatters of the measured value."""
        return float(self.datum.deviation(self.best))


@dataclass(frozen=True, eq=False)
class Identified(Reported):
    """The answer of :func:`valvetrain.identify`. SI throughout.

    ``branches``, the most probable first; ``values`` (draw, quantity) and ``branch_of`` (draw) of draws of one weight;
    ``predicted``: every measurement with its prediction; ``predictions`` of what was not measured; ``computed``: each computed
    quantity over the draws; ``log_evidence``; ``note``: where a linearised posterior does not hold;
    ``start``: values that the case has, or the middles of the priors;
    ``case_file``: text of the case with the likeliest values, ``text``: that of the identification
    file (empty without one); ``evaluations``: points that were computed, ``reused``: those of an
    earlier start; ``whole``: False where
    it was cut short.

    >>> import valvetrain as vt
    >>> found = vt.identify({"rate": vt.explore.Prior("uniform", 20e3, 60e3)}, [vt.explore.Datum("force", 280.0, 2.0)],
    ...                     lambda points: [{"force": 7e-3 * rate} for (rate,) in points])
    >>> found
    fitted, not checked: measured 1, unknown 1, so almost any model meets the data
      Identified by least-squares: rate
    >>> round(found.predicted[0].percentile)
    50
    """

    method: str
    unknowns: tuple[Varied, ...]
    branches: tuple[Branch, ...]
    values: Array
    branch_of: Ints
    predicted: tuple[Predicted, ...]
    predictions: tuple[Prediction, ...]
    computed: Mapping[str, Array]
    log_evidence: float = np.nan
    note: str = ""
    evaluations: int = 0
    reused: int = 0
    whole: bool = True
    wall_time: float = field(default=0.0, compare=False)
    name: str = ""
    start: Mapping[str, float] = field(default_factory=dict)
    case_file: str = ""
    text: str = ""

    @property
    def fit(self) -> Fit | None:
        """How well the most probable branch meets the data; None of a search that was stopped."""
        return self.branches[0].fit

    @property
    def evidence_kind(self) -> str:
        """How the evidence was found."""
        return "nested sampling" if self.method == "nested" else "linearised"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities that were looked for."""
        return tuple(one.title for one in self.unknowns)

    @property
    def best(self) -> Mapping[str, float]:
        """The likeliest point of the most probable branch, by quantity."""
        return {name: one.best for name, one in self.branches[0].quantities.items()}

    def to_xarray(self) -> xarray.Dataset:
        """A Dataset over draw: the quantities (SI), the branch of each draw, and every computed number."""
        import xarray

        units = {one.key: one.unit for one in (*self.predictions, *self.predicted)}
        data: dict[str, Any] = {
            one.title: ("draw", column, {"units": si_unit(one.unit)})
            for one, column in zip(self.unknowns, self.values.T, strict=True)
        } | {
            f"computed {key}": ("draw", column, {"units": si_unit(units.get(key, ""))})
            for key, column in self.computed.items()
        }
        return xarray.Dataset(
            {**data, "branch": ("draw", self.branch_of)},
            attrs={"method": self.method, "title": self.name},
        )

    def to_arviz(self) -> Any:
        """The draws of the posterior as ArviZ takes them. Raises :class:`MissingExtraError` where ArviZ is not installed."""
        with warnings.catch_warnings(), needs("arviz", "posterior"):  # of its next version
            warnings.simplefilter("ignore")
            arviz = import_module("arviz")
        posterior = {name: self.values[None, :, k] for k, name in enumerate(self.names)}
        try:
            return arviz.from_dict(posterior=posterior)
        except TypeError:  # from ArviZ 1.0
            return arviz.from_dict({"posterior": posterior})

    def __repr__(self) -> str:
        return verdict_first(self, [f"Identified by {self.method}: {', '.join(self.names)}"])


class PosteriorOptions(CountedOptions):
    """Options of the draws of a posterior."""

    file: str = Field(default="", description="draws.nc of an identification")


def _first_posterior(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    """Draws (count, d) in SI of equal weight, every quantity by its label or name."""
    assert isinstance(options, PosteriorOptions)
    source = load_result(options.file)
    if not isinstance(source, Identified):
        raise InputError("holds no draws; give draws.nc of an identification", options.file)
    columns = []
    for one in varied:
        name = next((name for name in (one.label, one.name) if name in source.names), None)
        if name is None:
            raise InputError(
                f"the draws have no '{one.shown_name[:60]}'; {nearest(one.shown_name, source.names)}",
                "points.file",
            )
        columns.append(source.values[:, source.names.index(name)])
    places = even_places(len(source.values), options.count, options.seed)
    return np.column_stack(columns)[places]


POSTERIOR_SPEC = SamplerSpec(
    "posterior",
    "draws of a posterior",
    PosteriorOptions,
    _first_posterior,
    independent=True,
)
