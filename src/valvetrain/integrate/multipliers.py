"""Multipliers of a periodic orbit: by which factors a revolution stretches small disturbances. It knows no trains."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array

ComplexArray = NDArray[np.complex128]
CycleMap = Callable[[Array], Array]
#: Directions from which the largest multipliers are read, and size of a disturbance in scaled states: so large that an
#: impact passes over several time steps, within which its bounce hardly depends on when it begins (1e-6: 1.24 for 0.51).
DIRECTIONS, DISTURBANCE = 16, 1e-2
#: Length of a new direction, over that of an image, below which it adds nothing.
EXHAUSTED = 1e-9
#: Share of its size up to which the imaginary part of a multiplier is none.
REAL = 1e-6


def multipliers(
    cycle: CycleMap,
    orbit: Array,
    basis: Array,
    directions: int = DIRECTIONS,
    disturbance: float = DISTURBANCE,
) -> ComplexArray:
    """The largest eigenvalues of the derivative of a cycle map, by Arnoldi's method on central differences
    (W. E. Arnoldi, Quart. Appl. Math. 9 (1951) 17).

    Parameters
    ----------
    cycle : map of scaled states
    orbit : state (n,) that the map returns
    basis : columns (n, n) in which the known part of the derivative is nearly normal; in states as they are a
        helical transient grows so far that few cycles show a wrong value
    directions : in each of which two cycles are run; all n of a smaller state
    disturbance : size of the disturbances

    Returns
    -------
    Complex multipliers, the largest first; NaN alone where a disturbed cycle is not finite
    """
    count = min(directions, len(orbit))
    inverse = np.linalg.inv(basis)
    vectors, hessenberg = np.zeros((count + 1, len(orbit))), np.zeros((count + 1, count))
    first = np.random.default_rng(0).standard_normal(len(orbit))
    vectors[0] = first / np.linalg.norm(first)
    for place in range(count):
        step = basis @ vectors[place]
        size = disturbance / np.linalg.norm(step)
        ends = cycle(orbit + size * step), cycle(orbit - size * step)
        moved = inverse @ (ends[0] - ends[1]) / (2 * size)
        if not np.all(np.isfinite(moved)):
            return np.full(1, np.nan + 0j)
        length = np.linalg.norm(moved)
        for _ in range(2):  # once more against what rounding leaves
            shares = vectors[: place + 1] @ moved
            hessenberg[: place + 1, place] += shares
            moved = moved - shares @ vectors[: place + 1]
        rest = float(np.linalg.norm(moved))
        if rest <= EXHAUSTED * length:
            count = place + 1
            break
        hessenberg[place + 1, place] = rest
        vectors[place + 1] = moved / rest
    values = np.linalg.eigvals(hessenberg[:count, :count]).astype(np.complex128)
    return values[np.argsort(-np.abs(values), kind="stable")]


def loss_of_stability(multiplier: complex) -> str:
    """How an orbit with this largest multiplier repels: ``fold`` (it jumps away), ``flip`` (every second revolution
    becomes alike), ``torus`` (it begins to swing); empty where it attracts.

    >>> [loss_of_stability(one) for one in (0.9, 1.2, -1.1, 0.8 + 0.8j)]
    ['', 'fold', 'flip', 'torus']
    """
    if not abs(multiplier) > 1:
        return ""
    if abs(multiplier.imag) > REAL * abs(multiplier):
        return "torus"
    return "fold" if multiplier.real > 0 else "flip"


def lyapunov_exponent(
    cycle: CycleMap, start: Array, cycles: int, disturbance: float = 1e-3
) -> float:
    """Largest Lyapunov exponent per cycle of a map from a state of its motion: above zero where that is chaotic.

    Parameters
    ----------
    cycle : map of scaled states
    start : state (n,) of the motion
    cycles : over which the growth is averaged, the first quarter left out; each runs the map twice
    disturbance : size of the disturbance, taken back after every cycle (G. Benettin et al., Meccanica 15 (1980) 9)

    Returns
    -------
    Mean logarithm of the growth of a disturbance in a cycle; NaN where a cycle is not finite
    """
    step = np.random.default_rng(0).standard_normal(len(start))
    step, state, growths = step / np.linalg.norm(step), start, list[float]()
    for _ in range(cycles):
        image = cycle(state)
        moved = (cycle(state + disturbance * step) - image) / disturbance
        growths.append(float(np.linalg.norm(moved)))
        if not (np.isfinite(growths[-1]) and growths[-1] > 0):
            return float("nan")
        step, state = moved / growths[-1], image
    return float(np.mean(np.log(growths[len(growths) // 4 :])))
