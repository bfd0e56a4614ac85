"""Periodic steady state of any cycle map: plain repetition, Anderson acceleration, and the period
of what never settles.

Works on plain vectors and a callable ``cycle(vector) -> vector``, so it is judged on toy maps as
well as on trains.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array

PROBE_CYCLES = 4
"""Plain cycles that test whether an orbit found by acceleration attracts."""
TRUSTED, WINDOWS = 0.6, (4, 6, 8, 12)
"""Largest multiplier of the map that the last cycles show with which an orbit is taken to attract
untested: those that repel despite such had 0.7 and more (245 orbits of a card, 144 of a chain, 157 of a reduced rod).
"""
FAST = 0.1
"""Contraction per cycle, of corrected cycles, below which an orbit attracts untested: of 156 such none repelled."""
BEYOND = 2.0
"""How far an extrapolation may leave the range of the states seen, in scales of its unknown or in
widths of that range.
"""

CycleMap = Callable[[Array], Array]


@dataclass(frozen=True)
class SteadyState:
    """How a search for the periodic orbit ended.

    ``state``: vector at the start of the last cycle run. ``residuals``: weighted change over each
    cycle run. ``period``: cycles after which the motion repeats: 1 settled, 2 and more
    sub-harmonic, 0 none found. ``cycles``: cycles run. ``method`` as requested.
    """

    state: Array
    residuals: tuple[float, ...]
    period: int
    cycles: int
    method: str
    tolerance: float

    @property
    def converged(self) -> bool:
        """True when every cycle repeats the one before."""
        return self.period == 1

    @property
    def contraction(self) -> float:
        """Ratio of the change of one cycle to that of the cycle before, in the mean of the search, up to 1."""
        first, last, count = self.residuals[0], self.residuals[-1], len(self.residuals)
        return min(1.0, (last / first) ** (1 / (count - 1))) if count > 1 and first > 0 else FAST


def residual_norm(change: Array, weights: Array) -> float:
    """Weighted maximum norm: 1 means a change as large as the scale of its unknown."""
    return float(np.max(np.abs(change) * weights, initial=0.0))


def repeat_cycles(
    cycle: CycleMap,
    start: Array,
    weights: Array,
    tolerance: float = 1e-6,
    cycles: int = 60,
    longest_period: int = 8,
    least: int = 1,
    patient: bool = True,
) -> SteadyState:
    """Repeat until a cycle changes the state by less than ``tolerance`` (the classical method) after
    ``least`` cycles, or until its image is not finite: the ``state`` is then the one that this cycle started from.

    When ``cycles`` are spent, the last states are compared over 2, 3, ... ``longest_period`` cycles
    (tolerance times ten, since the approach to a sub-harmonic is no faster than to a settled
    orbit). Unless ``patient`` that is so already when four changes are not half those of the four cycles before.
    """
    states, residuals = [np.array(start, dtype=float)], list[float]()
    for _ in range(cycles):
        if not patient and len(residuals) >= 8 and max(residuals[-4:]) > max(residuals[-8:-4]) / 2:
            break
        states.append(cycle(states[-1]))
        residuals.append(residual_norm(states[-1] - states[-2], weights))
        if residuals[-1] <= tolerance and len(residuals) >= least:
            return SteadyState(states[-1], tuple(residuals), 1, len(residuals), "repeat", tolerance)
        if not np.all(np.isfinite(states[-1])):
            return SteadyState(states[-2], tuple(residuals), 0, len(residuals), "repeat", tolerance)
    return SteadyState(
        states[-1],
        tuple(residuals),
        _period(states, weights, tolerance, longest_period),
        len(residuals),
        "repeat",
        tolerance,
    )


def accelerate(
    cycle: CycleMap,
    start: Array,
    weights: Array,
    tolerance: float = 1e-6,
    cycles: int = 60,
    memory: int = 20,
    settle: int = 2,
    longest_period: int = 8,
    probed: bool = True,
    patient: bool = True,
    correct: CycleMap | None = None,
) -> SteadyState:
    """Anderson acceleration of the cycle map (D. G. Anderson, J. ACM 12 (1965) 547; Walker and Ni,
    SIAM J. Numer. Anal. 49 (2011)).

    ``settle`` plain cycles first; then each new start is the combination of the last ``memory``
    cycles with the least residual. A step that raises the residual tenfold clears the memory; one
    that would leave the states seen by far (:data:`BEYOND`), or whose image is not finite, gives
    way to the plain cycle. Acceleration finds unstable orbits too, which no train shows: unless what the search saw of
    the map contracts well (:data:`TRUSTED`), or not ``probed``, an orbit is accepted only when plain cycles from a
    small disturbance come back to it. Falls back to plain cycles (``patient``: :func:`repeat_cycles`), and looks
    for a sub-harmonic, when half of ``cycles`` are spent or the orbit found repels. ``correct``: makes of a cycle's
    change a step to where it would vanish, by what is known of the map; none settle then, and an orbit that they
    approach fast (:data:`FAST`) is not tested.
    """
    settle = 0 if correct else settle
    x, residuals = np.array(start, dtype=float), []
    inputs: list[Array] = []
    changes: list[Array] = []
    best, allowance = np.inf, max(cycles // 2, settle + 2)
    plain, low, high = x, x, x
    seen: list[tuple[Array, Array]] = []
    for count in range(allowance):
        image = cycle(x)
        change = image - x
        seen = [*seen, (x, change)][-max(WINDOWS) :]
        residuals.append(residual_norm(change, weights))
        fast = correct is not None and residuals[-1] <= residuals[0] * FAST ** max(count, 1)
        if residuals[-1] <= tolerance and (not probed or fast or not _doubtful(seen, weights)):
            return SteadyState(image, tuple(residuals), 1, len(residuals), "anderson", tolerance)
        if residuals[-1] <= tolerance:
            attracts, ended = _attracts(cycle, image, weights, tolerance)
            x = ended if np.all(np.isfinite(ended)) else image
            if attracts:
                return SteadyState(
                    image, tuple(residuals), 1, len(residuals) + PROBE_CYCLES, "anderson", tolerance
                )
            break
        if not np.all(np.isfinite(image)):
            if x is plain:
                break
            inputs, changes, seen, x = [], [], [], plain
            continue
        plain, low, high = image, np.minimum(low, image), np.maximum(high, image)
        if count < settle:
            x = image
            continue
        step = correct(change) if correct else change
        if residuals[-1] > 10 * best:
            inputs, changes, x, best = [], [], x + step, residuals[-1]
            continue
        best = min(best, residuals[-1])
        inputs, changes = [*inputs, x][-memory:], [*changes, step][-memory:]
        x = _mixed(inputs, changes, weights)
        if _far(x, low, high, weights):
            inputs, changes, x = [], [], image
    rest = repeat_cycles(
        cycle,
        x,
        weights,
        tolerance,
        max(cycles - len(residuals), 2 * longest_period),
        longest_period,
        patient=patient,
    )
    residuals.extend(rest.residuals)
    return SteadyState(
        rest.state, tuple(residuals), rest.period, len(residuals), "anderson", tolerance
    )


def _doubtful(seen: list[tuple[Array, Array]], weights: Array) -> bool:
    """Whether the map, on the starts and changes ``seen`` last, shows a multiplier beyond :data:`TRUSTED`."""
    if len(seen) < 3:
        return True
    starts, changes = (
        np.diff(values, axis=0).T for values in map(np.array, zip(*seen, strict=True))
    )
    sizes = np.linalg.norm(starts * weights[:, None], axis=0)
    if not np.all(sizes > 0):
        return True
    starts, changes = starts * weights[:, None] / sizes, changes * weights[:, None] / sizes
    for count in WINDOWS:
        first = starts[:, 1 - count :]
        left, values, right = np.linalg.svd(first, full_matrices=False)
        held = values > 1e-3 * values[0]
        moved = (first + changes[:, 1 - count :]) @ right[held].T / values[held]
        if np.max(np.abs(np.linalg.eigvals(left[:, held].T @ moved))) > TRUSTED:
            return True
        if count >= len(seen):
            break
    return False


def _attracts(
    cycle: CycleMap, orbit: Array, weights: Array, tolerance: float
) -> tuple[bool, Array]:
    """Whether plain cycles from a disturbance of a hundred tolerances draw nearer to each other,
    and where they ended.
    """
    kick = np.random.default_rng(1).choice((-1.0, 1.0), len(orbit)) * 100 * tolerance
    x, sizes = orbit + np.where(weights > 0, kick / np.where(weights > 0, weights, 1.0), 0.0), []
    for _ in range(PROBE_CYCLES):
        image = cycle(x)
        sizes.append(float(np.linalg.norm((image - x) * weights)))
        x = image
    grows = (
        sizes[-1] > sizes[-2] > sizes[-3]
    )  # what decays fast hides what grows slowly in the first cycles
    return bool((sizes[-1] < sizes[0] and not grows) or sizes[-1] <= tolerance), x


def _far(state: Array, low: Array, high: Array, weights: Array) -> bool:
    """Whether a state is beyond the range ``low`` to ``high`` by more than :data:`BEYOND`."""
    outside = np.maximum(np.maximum(low - state, state - high), 0.0) * weights
    return bool(np.any(outside > BEYOND * np.maximum((high - low) * weights, 1.0)))


def _mixed(inputs: list[Array], changes: list[Array], weights: Array) -> Array:
    """Next start: image of the affine combination of past starts with the least weighted change."""
    if len(inputs) == 1:
        return inputs[0] + changes[0]
    moved = np.array([(changes[-1] - past) * weights for past in changes[:-1]]).T
    factors, *_ = np.linalg.lstsq(moved, changes[-1] * weights, rcond=1e-10)
    result = inputs[-1] + changes[-1]
    for factor, start, change in zip(factors, inputs[:-1], changes[:-1], strict=True):
        result = result - factor * ((inputs[-1] + changes[-1]) - (start + change))
    return result


def _period(states: list[Array], weights: Array, tolerance: float, longest: int) -> int:
    """Smallest number of cycles after which the last states repeat, 0 when none does."""
    for period in range(1, longest + 1):
        if len(states) < 2 * period + 1:
            break
        pairs = [
            residual_norm(states[-1 - k] - states[-1 - k - period], weights) for k in range(period)
        ]
        if max(pairs) <= 10 * tolerance:
            return period
    return 0
