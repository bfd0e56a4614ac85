"""Band of the difference between model and test over the cam angle that holds the true difference at all angles at once.

A Student band at each angle, widened until its chance to be left anywhere is the level: by the number of upcrossings of a field of
Student's t along the angle (Worsley 1994), whose only unknown is the length of the path of the repeats' directions (Taylor and
Worsley 2007), or by Bonferroni over the angles, whichever is narrower.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import chdtri, stdtr, stdtrit

from valvetrain.errors import InputError
from valvetrain.quantities.adequacy import LEVEL

Array = NDArray[np.float64]
#: Fewest repeats that make a band worth drawing.
FEWEST = 3
_LARGEST = 1e6


@dataclass(frozen=True, eq=False)
class DifferenceBand:
    """Difference of model and test over the cam angle with its band, SI, shapes (angles,).

    ``difference``: model less mean of the repeats. ``half_width``: the true difference lies within it of the computed one at all angles
    at once with the chance 1 - ``level``. ``factor``: half width in standard errors of the mean. ``level`` as in the test of adequacy.

    >>> import numpy as np
    >>> angle = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    >>> repeats = np.outer([1.0, -1.0, 0.5, -0.5], np.ones(90)) + np.outer([0.3, 0.3, -0.3, -0.3], np.sin(angle))
    >>> band = difference_band(repeats, np.full(90, 5.0))
    >>> bool(band.outside.all())
    True
    """

    difference: Array
    half_width: Array
    factor: float
    level: float = LEVEL

    @property
    def outside(self) -> NDArray[np.bool_]:
        """Angles at which the band leaves zero out: of a true model one turn in twenty has any."""
        found: NDArray[np.bool_] = np.abs(self.difference) > self.half_width
        return found


def difference_band(values: Array, model: Array, level: float = LEVEL, shared: Array | None = None) -> DifferenceBand:
    """The band for ``values`` (repeats, angles) round one cam turn and ``model`` (angles,); ``shared`` (errors, angles): standard
    deviations of errors that all repeats share, each in step along the turn, to which half of the level goes (Scheffe).

    Raises :class:`InputError` for fewer than :data:`FEWEST` repeats. Angles at which all repeats agree have no width.
    """
    repeats = len(values)
    if repeats < FEWEST:
        raise InputError(f"{repeats} repeats give no band worth drawing; give {FEWEST} or more")
    mean = values.mean(axis=0)
    residuals = values - mean
    size = np.sqrt(np.sum(residuals**2, axis=0))
    moving = size > 1e-12 * float(size.max(initial=0.0))
    count = 0 if shared is None else len(shared)
    factor = band_factor(residuals[:, moving] / size[moving], 0.5 * level if count else level)
    half = factor * size / math.sqrt((repeats - 1) * repeats)
    if shared is not None and count:
        half = half + math.sqrt(float(chdtri(count, 0.5 * level))) * np.sqrt(np.sum(shared**2, axis=0))
    return DifferenceBand(model - mean, half, factor, level)


def band_factor(directions: Array, level: float) -> float:
    """Standard errors on either side; ``directions`` (repeats, angles): residuals of each angle over their length."""
    repeats, places = directions.shape
    if places == 0:
        return 0.0
    freedom = repeats - 1
    by_angles = float(-stdtrit(freedom, 0.5 * level / places))
    steps = np.diff(directions, axis=1, append=directions[:, :1])
    length = float(np.sum(np.sqrt(np.sum(steps**2, axis=0))))

    def left(factor: float) -> float:
        crossings = length / math.pi * (1 + factor**2 / freedom) ** (-(freedom - 1) / 2)
        return float(crossings + 2 * stdtr(freedom, -factor) - level)

    if freedom < 2 or left(_LARGEST) > 0:
        return by_angles
    return min(by_angles, float(brentq(left, 0.0, _LARGEST, xtol=1e-9)) if left(0.0) > 0 else 0.0)
