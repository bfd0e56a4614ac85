"""A Gaussian process in place of a run: fitted to most points of a study, its error told on those
kept out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.studies.points.plan import Run

Array = NDArray[np.float64]
HINT = "a surrogate needs scikit-learn, which is not installed; install the extra: pip install 'valvetrain[studies]'"
#: Share of the points kept out of the fit; least points that a surrogate is made of; most that it
#: is fitted to, for its time grows with
#: the cube of their number.
KEPT_OUT, LEAST, MOST = 0.2, 12, 1000


@dataclass(frozen=True, eq=False)
class Surrogate:
    """A Gaussian process for one ``output`` at one ``run``.

    ``error``: root of the mean square error (SI) on the ``kept_out`` points; ``share``: that over
    their standard deviation; ``covered``:
    share of them within two standard deviations that the process itself tells; ``predicted`` and
    ``computed``: their values.
    """

    output: str
    run: Run
    fitted: int
    kept_out: int
    error: float
    share: float
    covered: float
    predicted: Array
    computed: Array
    centre: Array
    scale: Array
    process: Any = field(repr=False)

    @property
    def sentence(self) -> str:
        """What its error is, in words."""
        unit = definition_of(self.output).shown_unit
        error = float(shown(self.output, self.error)[0])
        told = f"The surrogate of the {label_of(self.output)} errs by {error:.3g} {unit} (rms) on {self.kept_out} points kept out of its fit"
        good = "" if self.share < 0.3 else ", so it does not stand for a run"
        return f"{told}, {100 * self.share:.0f} % of their scatter{good}."

    def predict(self, inputs: ArrayLike) -> tuple[Array, Array]:
        """Mean and standard deviation (m,) in SI at ``inputs`` (m, d) in SI, in the order of the
        varied quantities.
        """
        points = np.atleast_2d(np.asarray(inputs, dtype=float))
        if points.shape[1] != len(self.centre):
            raise InputError(
                f"the surrogate takes {len(self.centre)} inputs a point; given are {points.shape[1]}"
            )
        mean, deviation = self.process.predict((points - self.centre) / self.scale, return_std=True)
        return np.asarray(mean), np.asarray(deviation)


def surrogate_of(
    output: str, run: Run, inputs: Array, values: Array, seed: int = 1
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
    there = np.isfinite(values)
    points, found = inputs[there], values[there]
    scale = np.std(points, axis=0)
    if len(points) < LEAST or not np.std(found) > 0 or not np.all(scale > 0):
        return None
    order = np.random.default_rng(seed).permutation(len(points))
    out = max(2, round(KEPT_OUT * len(points)))
    kept_out, fitted = order[:out], order[out : out + MOST]
    centre = np.mean(points, axis=0)
    cube = (points - centre) / scale
    kernel = ConstantKernel(1.0, (1e-3, 1e3)) * RBF(
        np.ones(points.shape[1]), (1e-2, 1e3)
    ) + WhiteKernel(1e-4, (1e-10, 1.0))
    process = GaussianProcessRegressor(
        kernel, normalize_y=True, n_restarts_optimizer=2, random_state=seed
    )
    _quiet_fit(process, cube[fitted], found[fitted])
    mean, deviation = process.predict(cube[kept_out], return_std=True)
    miss = mean - found[kept_out]
    error_found = float(np.sqrt(np.mean(miss**2)))
    covered = float(np.mean(np.abs(miss) <= 2 * deviation))
    share = error_found / max(float(np.std(found[kept_out])), 1e-300)
    return Surrogate(
        output,
        run,
        len(fitted),
        out,
        error_found,
        share,
        covered,
        np.asarray(mean),
        found[kept_out],
        centre,
        scale,
        process,
    )


def _quiet_fit(process: Any, points: Array, values: Sequence[float] | Array) -> None:
    """Fit; that a length reaches its bound is no news to a user: the error on points kept out tells
    how good it is.
    """
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        process.fit(points, values)
