"""How well a model meets its data: chi-square at the likeliest point, a posterior predictive p value
over draws, and intervals widened where the model cannot meet them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from valvetrain.explore.posterior import Outcome, Posterior

Array = NDArray[np.float64]
#: With a p value below this the model is reported as unable to meet the data, which happens to one correct model in a
#: hundred.
REFUSED = 0.01
#: Degrees of freedom below which nothing is left to test.
NOTHING_LEFT = 0.5
#: A quantity is on its bound within this share of the prior's deviation.
ON_BOUND = 1e-6


@dataclass(frozen=True, slots=True)
class Fit:
    """``chi_square`` of the residuals and the pulls of the priors with its degrees of ``freedom``;
    ``p_value``: how often a correct model has a larger one, NaN where no freedom is left.

    ``predictive``: posterior predictive p value over draws (A. Gelman, X.-L. Meng, H. Stern, Statistica
    Sinica 6 (1996) 733), NaN without a sampled posterior.

    >>> Fit(470.0, 38.0, 0.0).phrase
    'chi-square 470 for 38 degrees of freedom, p < 1e-06'
    >>> round(Fit(470.0, 38.0, 0.0).widening, 2)
    3.52
    """

    chi_square: float
    freedom: float
    p_value: float
    predictive: float = math.nan

    @property
    def missed(self) -> bool:
        """Whether the model cannot meet the data."""
        return any(value < REFUSED for value in (self.p_value, self.predictive))

    @property
    def widening(self) -> float:
        """Factor on the scatter of all data that makes the misfit the expected one (R. T. Birge,
        Physical Review 40 (1932) 207); 1 where the model meets them.
        """
        if not self.missed:
            return 1.0
        return math.sqrt(max(self.chi_square / max(self.freedom, 1.0), 1.0))

    @property
    def phrase(self) -> str:
        """Chi-square, degrees of freedom and p values."""
        if math.isnan(self.p_value):
            said = f"chi-square {self.chi_square:.4g}, no degree of freedom left to test by"
        else:
            said = (
                f"chi-square {self.chi_square:.4g} for {self.freedom:.3g} degrees of freedom, "
                f"p {_odds(self.p_value)}"
            )
        if math.isnan(self.predictive):
            return said
        return f"{said}, posterior predictive p {_odds(self.predictive)}"


def _odds(value: float) -> str:
    return "< 1e-06" if value < 1e-6 else f"{value:.2g}"


def fit_of(posterior: Posterior, work: Array, outcome: Outcome, jacobian: Array) -> Fit:
    """The fit at the likeliest point ``work`` (quantities) by the slopes there (data, quantities).

    Every datum and every normal prior counts one degree of freedom; every quantity takes one, a flat
    one as far as the data determine it, one on its bound none. Student errors enter by the normal
    score of their probability.

    >>> from valvetrain.explore.posterior import Datum, Unknown
    >>> from valvetrain.explore.space import Prior
    >>> data = tuple(Datum(f"load {k}", value, 1.0) for k, value in enumerate((9.0, 10.0, 14.0)))
    >>> posterior = Posterior((Unknown("load", Prior("uniform", 0.0, 1e3)),), data, lambda points: [])
    >>> found = fit_of(posterior, np.array([11.0]), {one.key: 11.0 for one in data}, np.full((3, 1), 288.7))
    >>> print(found.phrase)
    chi-square 14 for 2 degrees of freedom, p 0.00091
    """
    computed = {key: np.array([value]) for key, value in (outcome or {}).items()}
    scores = scores_of(posterior, computed)
    chi_square = float(np.sum(scores**2) + np.sum(posterior.pulls(work) ** 2))
    low, high = posterior.bounds
    near = ON_BOUND * posterior.spread
    free = (work > low + near) & (work < high - near)
    flat = np.array([one.prior.flat for one in posterior.unknowns])
    determined = 1.0 - np.diag(np.linalg.inv(posterior.precision + jacobian.T @ jacobian))
    freedom = len(posterior.used) + np.sum(~flat) - np.sum(np.where(flat, determined, 1.0)[free])
    p_value = float(chdtrc(freedom, chi_square)) if freedom > NOTHING_LEFT else math.nan
    return Fit(chi_square, float(freedom), p_value)


def scores_of(posterior: Posterior, computed: Mapping[str, Array]) -> Array:
    """Misses (draws, data) of the fitted data as normal scores; NaN where a number is missing."""
    return np.column_stack(
        [one.score(computed.get(one.key, np.full(1, np.nan))) for one in posterior.used]
    )


def predictive(posterior: Posterior, computed: Mapping[str, Array], weights: Array) -> float:
    """Posterior predictive p value: how often data drawn again at a draw are farther from it than the
    measured ones, over draws with ``weights``.
    """
    misfit = np.sum(scores_of(posterior, computed) ** 2, axis=1)
    known = np.isfinite(misfit)
    if not known.any():
        return math.nan
    odds = chdtrc(float(len(posterior.used)), misfit[known])
    return float(np.average(odds, weights=weights[known]))


def widenings(posterior: Posterior, jacobian: Array, scatter: float) -> Array:
    """Factor (quantities) on each deviation once all data have ``scatter`` times theirs and the
    priors stay as they are.
    """
    data = jacobian.T @ jacobian
    narrow, wide = (
        np.diag(np.linalg.inv(posterior.precision + data / factor**2)) for factor in (1.0, scatter)
    )
    return np.asarray(np.sqrt(wide / narrow))
