"""Identification of unknown parameters from calibration data: bounded Levenberg-Marquardt with priors.

Differences are taken in parallel over processes and the order of evaluation does not depend on their number, so the
same data give the same parameters for any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Unknown:
    """One parameter: bounds and a normal prior of mean ``start`` and standard deviation ``spread``; SI units."""

    name: str
    low: float
    high: float
    start: float
    spread: float

    def __post_init__(self) -> None:
        if not self.low <= self.start <= self.high or not self.spread > 0:
            raise InputError(f"unknown '{self.name}' must start within its bounds and have a positive spread")

    @property
    def step(self) -> float:
        """Step of the forward difference."""
        return 0.03 * self.spread


@dataclass(frozen=True, slots=True)
class Target:
    """One calibration value: published ``value`` and the ``scale`` (same unit) that makes misses comparable."""

    name: str
    value: float
    scale: float


@dataclass(frozen=True)
class Identified:
    """The end of an identification: parameters, computed values by target, sum of squared scaled misses, iterations.

    ``covariance`` (parameters x parameters) is the linearised posterior's.
    """

    parameters: Mapping[str, float]
    computed: Mapping[str, float]
    misfit: float
    iterations: int
    covariance: tuple[tuple[float, ...], ...]

    @property
    def standard_error(self) -> Mapping[str, float]:
        """Posterior standard deviation of each parameter."""
        return {name: float(np.sqrt(max(self.covariance[k][k], 0.0))) for k, name in enumerate(self.parameters)}

    def sample(self, unknowns: Sequence[Unknown], count: int, seed: int = 0) -> list[Array]:
        """Parameter vectors drawn from the linearised posterior, kept within the bounds of ``unknowns``."""
        centre = np.array([self.parameters[u.name] for u in unknowns])
        values, vectors = np.linalg.eigh(np.array(self.covariance))
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        draws = np.random.default_rng(seed).standard_normal((count, len(centre)))
        low, high = np.array([u.low for u in unknowns]), np.array([u.high for u in unknowns])
        return [np.clip(centre + root @ draw, low, high) for draw in draws]


Evaluate = Callable[[Array], Mapping[str, float] | None]


def identify(
    unknowns: Sequence[Unknown], targets: Sequence[Target], evaluate: Evaluate, pool: Executor, *,
    begin: Array | None = None, iterations: int = 12, prior_weight: float = 1.0, report: Callable[[str], None] = lambda text: None,
) -> Identified:  # fmt: skip
    """Most probable parameters given the ``targets`` (normal misses of their ``scale``) and the priors; search from ``begin``.

    What the data do not decide stays at its prior. ``evaluate`` maps a parameter vector to named values (None for an impossible
    spring) and must be picklable. Raises :class:`InputError` when the start itself is impossible.
    """
    low, high = np.array([u.low for u in unknowns]), np.array([u.high for u in unknowns])
    start, spread = np.array([u.start for u in unknowns]), np.array([u.spread for u in unknowns])
    steps = np.array([u.step for u in unknowns])
    point = start.copy() if begin is None else np.array(begin, dtype=float)

    def misses(values: Mapping[str, float] | None, at: Array) -> Array | None:
        if values is None or not all(np.isfinite(values.get(t.name, np.nan)) for t in targets):
            return None
        fit = [(values[t.name] - t.value) / t.scale for t in targets]
        return np.concatenate([fit, prior_weight * (at - start) / spread])

    values = evaluate(point)
    residual = misses(values, point)
    if residual is None or values is None:
        raise InputError("the start of the identification is no possible spring; choose other starting values")
    damping, done = 1.0, 0
    jacobian = np.zeros((len(residual), len(point)))
    for done in range(1, iterations + 1):
        jacobian = _differences(evaluate, misses, point, residual, steps, high, pool)
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ residual
        trials = [damping * 10.0**k for k in (-2, -1, 0, 1)]
        points = [np.clip(point - np.linalg.solve(normal + lam * np.diag(1 / spread**2), gradient), low, high) for lam in trials]
        outcomes = list(pool.map(evaluate, points))
        best, best_residual, best_values = None, residual, values
        for lam, trial, outcome in zip(trials, points, outcomes, strict=True):
            found = misses(outcome, trial)
            if found is not None and outcome is not None and found @ found < best_residual @ best_residual:
                best, best_residual, best_values, damping = trial, found, outcome, lam
        gain = residual @ residual - best_residual @ best_residual
        if best is None:
            damping *= 100.0
            if damping > 1e8:
                break
            continue
        point, residual, values = best, best_residual, best_values
        report(f"iteration {done}: misfit {residual @ residual:.4f}, damping {damping:.1e}")
        if gain < 1e-3 * (residual @ residual):
            break
    # Posterior standard errors: the prior rows are part of the Jacobian.
    jacobian[len(targets) :] = prior_weight * np.diag(1 / spread)
    covariance = np.linalg.pinv(jacobian.T @ jacobian)
    names = [u.name for u in unknowns]
    return Identified(
        dict(zip(names, map(float, point), strict=True)), dict(values), float(residual @ residual), done,
        tuple(tuple(map(float, line)) for line in covariance),
    )  # fmt: skip


def _differences(
    evaluate: Evaluate, misses: Callable[[Mapping[str, float] | None, Array], Array | None], point: Array, residual: Array,
    steps: Array, high: Array, pool: Executor,
) -> Array:  # fmt: skip
    """Jacobian (residuals, parameters) by one-sided differences, backward at an upper bound or where forward is impossible."""
    signs = np.where(point + steps > high, -1.0, 1.0)
    shifted = [point + np.where(np.arange(len(point)) == k, signs * steps, 0.0) for k in range(len(point))]
    jacobian = np.zeros((len(residual), len(point)))
    for k, outcome in enumerate(pool.map(evaluate, shifted)):
        found = misses(outcome, shifted[k])
        if found is not None:
            jacobian[:, k] = (found - residual) / (signs[k] * steps[k])
    return jacobian
