"""Surrogates: a Gaussian process for one output, with the error that it has at points left out of it,
in closed form, and the range in which it is valid.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_solve

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.explore.outputs import Run
from valvetrain.solution.definition import definition_of, label_of, shown

Array = NDArray[np.float64]
HINT = "a surrogate needs scikit-learn, which is not installed; install the extra: pip install 'valvetrain[studies]'"
#: Least points that a surrogate is made of; most that it is fitted to, for its time grows with the
#: cube of their number.
LEAST, MOST = 12, 1000
#: Error over scatter above which a surrogate cannot replace a run.
POOR = 0.3


@dataclass(frozen=True, eq=False)
class Surrogate:
    """A Gaussian process for one ``output`` at one ``run`` over the quantities ``names`` (d), fitted to
    all ``computed`` values (n, SI).

    ``predicted`` (n): prediction of each point from the others alone; ``error``: root of
    the mean square of those misses (SI), ``share``: that over the standard deviation of the values,
    ``covered``: share of the misses within two standard deviations of the prediction. ``low``,
    ``high`` (d, SI): the range of its points, beyond which it is not used.
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

    @property
    def fitted(self) -> int:
        """Points that it is fitted to."""
        return len(self.computed)

    @property
    def sentence(self) -> str:
        """What its error is, in words."""
        unit = definition_of(self.output).unit_word
        error = float(shown(self.output, self.error)[0])
        reported = (
            f"The surrogate of the {label_of(self.output)} errs by {error:.3g} {unit} (rms) at each of its "
            f"{self.fitted} points left out in turn"
        )
        good = "" if self.share < POOR else ", so it cannot replace a run"
        return f"{reported}, {100 * self.share:.2g} % of their scatter{good}."

    def predict(self, inputs: ArrayLike) -> tuple[Array, Array]:
        """Mean and standard deviation (m,) in SI at ``inputs`` (m, d) in SI, in the order of the
        varied quantities.

        Raises :class:`InputError` for points beyond the range of those it was fitted to by more than
        their mean distance along that quantity: there it predicts nothing.
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
        mean, deviation = self.process.predict((points - self.centre) / self.scale, return_std=True)
        return np.asarray(mean), np.asarray(deviation)


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
    )


def left_out(process: Any) -> tuple[Array, Array]:
    """Predicted less computed, and its standard deviation (n), at each point from all others, the
    process as it is: from the inverse of the covariance of all points (S. Sundararajan, S. S.
    Keerthi, Neural Computation 13 (2001) 1103).
    """
    inverse = cho_solve((process.L_, True), np.eye(len(process.L_)))
    own, scale = np.diag(inverse), process._y_train_std
    return -scale * np.ravel(process.alpha_) / own, scale / np.sqrt(own)
