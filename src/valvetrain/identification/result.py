"""What an identification found: branches with intervals, what the data determine, where each
measurement lies in its prediction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.identification.conflicts import Conflict
from valvetrain.identification.datum import Datum
from valvetrain.identification.information import Information
from valvetrain.identification.posterior import Unknown
from valvetrain.identification.profiles import Profile
from valvetrain.solution.display import table

Array = NDArray[np.float64]
#: Ends of the intervals that are told (percent).
LOW, HIGH = 2.5, 97.5


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
    """A separate part of the posterior with its probability ``share``; ``misfit``: least sum of
    squared scaled misses, priors included.
    """

    share: float
    misfit: float
    quantities: Mapping[str, Interval]
    correlation: Array
    information: Information


@dataclass(frozen=True, slots=True)
class Predicted:
    """A measurement beside its prediction (SI): computed at the ``best`` point, 2.5, 50 and 97.5 %
    of the computed values over the
    posterior, and the ``percentile`` at which the measured value lies among what would be measured
    (0 to 100)."""

    datum: Datum
    best: float
    low: float
    middle: float
    high: float
    percentile: float


@dataclass(frozen=True, slots=True)
class Prediction:
    """A computed number that nobody measured (SI; shown in ``unit``): at the ``best`` point, and
    2.5, 50 and 97.5 % over the posterior.
    """

    key: str
    unit: str
    best: float
    low: float
    middle: float
    high: float


@dataclass(frozen=True, eq=False)
class Identified:
    """The answer of :func:`valvetrain.identify`. SI throughout.

    ``branches``, the most probable first; ``values`` (draw, quantity) with ``weights`` (draw) and
    ``branch_of`` (draw); ``predicted``:
    every measurement beside its prediction; ``predictions`` of what was not measured;
    ``conflicts``: what meeting a missed measurement
    costs the others; ``computed``: each computed quantity over the draws; ``log_evidence`` with its
    error (NaN where it was not found);
    ``notes`` on the search; ``evaluations``: points that were computed, beside those ``kept`` of an
    earlier start; ``whole``: False where
    it was cut short.

    >>> import valvetrain as vt
    >>> found = vt.identify({"rate": vt.Prior("uniform", 20e3, 60e3)}, [vt.Datum("force", 280.0, 2.0)],
    ...                     lambda points: [{"force": 7e-3 * rate} for (rate,) in points])
    >>> found
    Identified by least-squares: 1 branch
      rate 4e+04 (3.94e+04 to 4.06e+04)
    >>> round(found.percentile("force"))
    50
    """

    method: str
    unknowns: tuple[Unknown, ...]
    branches: tuple[Branch, ...]
    values: Array
    weights: Array
    branch_of: NDArray[np.int64]
    predicted: tuple[Predicted, ...]
    predictions: tuple[Prediction, ...]
    computed: Mapping[str, Array]
    log_evidence: float = np.nan
    evidence_error: float = np.nan
    evidence_kind: str = ""
    profiles: tuple[Profile, ...] = ()
    notes: tuple[str, ...] = ()
    evaluations: int = 0
    kept: int = 0
    whole: bool = True
    wall_time: float = field(default=0.0, compare=False)
    name: str = ""
    conflicts: tuple[Conflict, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities that were looked for."""
        return tuple(one.name for one in self.unknowns)

    @property
    def best(self) -> Mapping[str, float]:
        """The likeliest point of the most probable branch, by quantity."""
        return {name: one.best for name, one in self.branches[0].quantities.items()}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what the data do not tell, and on the search."""
        found = [words for branch in self.branches for words in branch.information.warnings]
        return tuple(dict.fromkeys((*found, *self.notes)))

    def percentile(self, measurement: str) -> float:
        """Percentile at which a measurement of one value lies. Raises :class:`InputError` unless
        one of that name has one value.
        """
        fits = [one for one in self.predicted if measurement in (one.datum.name, one.datum.key)]
        if len(fits) != 1:
            raise InputError(
                f"{len(fits) or 'no'} measured values are called '{measurement[:60]}'; look through 'predicted'"
            )
        return fits[0].percentile

    def __repr__(self) -> str:
        count = len(self.branches)
        lines = [f"Identified by {self.method}: {count} branch{'es' * (count > 1)}"]
        for branch in self.branches:
            if count > 1:
                lines.append(f"probability {branch.share:.2f}:")
            lines += [
                f"{name} {one.best:.3g} ({one.low:.3g} to {one.high:.3g})"
                for name, one in branch.quantities.items()
            ]
        return "\n  ".join([*lines, *self.warnings])

    def _repr_html_(self) -> str:
        rows = [
            (
                str(number),
                f"{branch.share:.3f}",
                name,
                f"{one.best:.6g}",
                f"{one.low:.6g}",
                f"{one.high:.6g}",
            )
            for number, branch in enumerate(self.branches, start=1)
            for name, one in branch.quantities.items()
        ]
        return table(
            repr(self), ("branch", "probability", "quantity", "best", "2.5 %", "97.5 %"), rows
        )


def percentiles(values: Array, weights: Array, shares: tuple[float, ...]) -> tuple[float, ...]:
    """Weighted percentiles (0 to 100) of values that are not NaN, by the middle of each weight; NaN
    where there is none.
    """
    known = np.isfinite(values) & (weights > 0)
    if not known.any():
        return (np.nan,) * len(shares)
    order = np.argsort(values[known], kind="stable")
    sorted_values, sorted_weights = values[known][order], weights[known][order]
    middle = np.cumsum(sorted_weights) - 0.5 * sorted_weights
    return tuple(
        float(one)
        for one in np.interp(np.array(shares) / 100.0, middle / sorted_weights.sum(), sorted_values)
    )
