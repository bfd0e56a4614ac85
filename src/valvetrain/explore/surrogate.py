"""Surrogates: a Gaussian process for one output, with the error that it has at points left out of it,
in closed form, and the region in which it is valid.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_solve
from scipy.special import ndtri

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.explore.outputs import Run

Array = NDArray[np.float64]
HINT = "a surrogate needs scikit-learn, which is not installed; install the extra: pip install 'valvetrain[studies]'"
#: Least points that a surrogate is made of; most that it is fitted to, for its time grows with the
#: cube of their number.
LEAST, MOST = 12, 1000
#: Error over scatter from which a surrogate cannot replace a run.
POOR = 0.3
#: Probability that quantities which vary independently are taken for dependent, and how far beyond the
#: furthest of its points, as a multiple, a surrogate of dependent ones is used.
CHANCE, WIDER = 1e-3, 1.25


@dataclass(frozen=True)
class Dependence:
    """Two quantities (indices ``first``, ``second``) whose points depend on each other: their
    ``correlation``, and the largest distance ``reach`` of a point from the centre (standard deviations,
    the correlation taken into account).
    """

    first: int
    second: int
    correlation: float
    reach: float

    def distance(self, scaled: Array) -> Array:
        """Distance (m,) of points (m, d), in standard deviations from the centre (Mahalanobis 1936)."""
        one, other = scaled[:, self.first], scaled[:, self.second]
        free = max(1.0 - self.correlation**2, 1e-9)
        squares = (one - self.correlation * other) ** 2 / free + other**2
        return np.asarray(np.sqrt(squares))


@dataclass(frozen=True, eq=False)
class Surrogate:
    """A Gaussian process for one ``output`` at one ``run`` over the quantities ``names`` (d), fitted to
    all ``computed`` values (n, SI).

    ``predicted`` (n): prediction of each point from the others alone; ``error``: root of
    the mean square of those misses (SI), ``share``: that over the standard deviation of the values,
    ``covered``: share of the misses within two standard deviations of the prediction. ``low``,
    ``high`` (d, SI): the range of its points, beyond which it is not used, nor off the points of two
    quantities that depend on each other (``dependences``).
    """

    output: str
    run: Run
    names: tuple[str, ...]
    error: float
    share: float
    covered: float
    predicted: Array
    computed: Array
    low: Array
    high: Array
    centre: Array
    scale: Array
    process: Any = field(repr=False)
    dependences: tuple[Dependence, ...] = ()

    @property
    def fitted(self) -> int:
        """Points that it is fitted to."""
        return len(self.computed)

    def predict(self, inputs: ArrayLike) -> tuple[Array, Array]:
        """Mean and standard deviation (m,) in SI at ``inputs`` (m, d) in SI, in the order of the
        varied quantities.

        Raises :class:`InputError` for points beyond the range of those it was fitted to by more than
        their mean distance along that quantity, and for points off those of two quantities that depend
        on each other: there it predicts nothing.
        """
        points = np.atleast_2d(np.asarray(inputs, dtype=float))
        if points.shape[1] != len(self.centre):
            raise InputError(
                f"the surrogate takes {len(self.centre)} inputs a point; given are {points.shape[1]}"
            )
        margin = (self.high - self.low) / (self.fitted - 2)  # what a stratum at an end may leave
        beyond = ~((points >= self.low - margin) & (points <= self.high + margin))
        if beyond.any():
            row, column = np.argwhere(beyond)[0]
            raise InputError(
                f"the surrogate knows {self.low[column]:.6g} to {self.high[column]:.6g} (SI), and {points[row, column]:.6g} is beyond; "
                "compute that point, or widen the study",
                self.names[column],
            )
        scaled = (points - self.centre) / self.scale
        for pair in self.dependences:
            self._refuse_off(pair, points, scaled)
        mean, deviation = self.process.predict(scaled, return_std=True)
        return np.asarray(mean), np.asarray(deviation)

    def _refuse_off(self, pair: Dependence, points: Array, scaled: Array) -> None:
        """Raise :class:`InputError` for points off those of a dependent pair."""
        distance = pair.distance(scaled)
        row = int(np.argmax(distance))
        if distance[row] <= WIDER * pair.reach:
            return
        one, other = self.names[pair.first], self.names[pair.second]
        raise InputError(
            f"the surrogate knows {one} and {other} as they depend on each other (correlation {pair.correlation:.2g}), up to "
            f"{pair.reach:.2g} standard deviations from their centre, and {points[row, pair.first]:.6g} with "
            f"{points[row, pair.second]:.6g} (SI) is {distance[row]:.2g} off; compute that point, or widen the study",
            one,
        )


def surrogate_of(
    output: str, run: Run, names: Sequence[str], inputs: Array, values: Array, seed: int = 1
) -> Surrogate | None:
    """Fit a process with a length of its own per quantity to the points (n, d) and ``values`` (n);
    None with fewer than :data:`LEAST`.

    Raises :class:`MissingExtraError` without scikit-learn.
    """
    try:
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
    except ImportError as error:
        raise MissingExtraError(HINT) from error
    chosen = np.flatnonzero(np.isfinite(values))
    if len(chosen) > MOST:
        chosen = np.random.default_rng(seed).permutation(chosen)[:MOST]
    points, found = inputs[chosen], values[chosen]
    if len(points) < LEAST or not np.std(found) > 0 or not np.all(np.std(points, axis=0) > 0):
        return None
    centre, scale = np.mean(points, axis=0), np.std(points, axis=0)
    kernel = ConstantKernel(1.0, (1e-3, 1e3)) * RBF(
        np.ones(points.shape[1]), (1e-2, 1e3)
    ) + WhiteKernel(1e-2, (1e-10, 1.0))
    process = GaussianProcessRegressor(
        kernel, normalize_y=True, n_restarts_optimizer=2, random_state=seed
    )
    with (
        warnings.catch_warnings()
    ):  # that a length reaches its bound: the error shows how good it is
        warnings.simplefilter("ignore")
        process.fit((points - centre) / scale, found)
    miss, deviation = left_out(process)
    error_found = float(np.sqrt(np.mean(miss**2)))
    return Surrogate(
        output,
        run,
        tuple(names),
        error_found,
        error_found / float(np.std(found)),
        float(np.mean(np.abs(miss) <= 2 * deviation)),
        found + miss,
        found,
        np.min(points, axis=0),
        np.max(points, axis=0),
        centre,
        scale,
        process,
        dependences_of((points - centre) / scale),
    )


def dependences_of(scaled: Array) -> tuple[Dependence, ...]:
    """The pairs of quantities whose points (n, d), less their mean and over their standard deviation,
    depend on each other beyond :data:`CHANCE` (Fisher's transformation of the correlation).

    >>> line = np.linspace(-1.7, 1.7, 20)
    >>> [(one.first, one.second) for one in dependences_of(np.column_stack([line, line, line**2 - 1]))]
    [(0, 1)]
    """
    count, size = scaled.shape
    pairs = [(i, j) for i in range(size) for j in range(i)]
    found = []
    for second, first in pairs:
        correlation = float(np.mean(scaled[:, first] * scaled[:, second]))
        least = np.tanh(-ndtri(CHANCE / (2 * len(pairs))) / np.sqrt(count - 3))
        if abs(correlation) > least:
            pair = Dependence(first, second, correlation, 0.0)
            found.append(replace(pair, reach=float(np.max(pair.distance(scaled)))))
    return tuple(found)


def left_out(process: Any) -> tuple[Array, Array]:
    """Predicted less computed, and its standard deviation (n), at each point from all others, the
    process as it is: from the inverse of the covariance of all points (S. Sundararajan, S. S.
    Keerthi, Neural Computation 13 (2001) 1103).
    """
    inverse = cho_solve((process.L_, True), np.eye(len(process.L_)))
    own, scale = np.diag(inverse), process._y_train_std
    return -scale * np.ravel(process.alpha_) / own, scale / np.sqrt(own)
