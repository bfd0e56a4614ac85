"""Error bars of a refinement: one number with its uncertainty, and all of a case with the runs
behind them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution.provenance import CaseRecord

#: Contact stiffness over the case's (7e9 to 5e10 Pa for 2e10) and contact damping time over the
#: case's (0 to 2 us for 1 us).
STIFFNESS_FACTORS, DAMPING_FACTORS = (0.35, 2.5), (0.0, 2.0)
#: Contact stiffness and damping of a train over the case's: contacts between parts of an engine are
#: known to a factor of two.
CONTACT_FACTORS = (0.5, 2.0)
Range = tuple[float, float]
Numbers = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """One headline number (SI) of the case's own mesh, at ``engine_speed`` (rad/s of the crank;
    None for statics and modes).

    ``numerical``: uncertainty from meshes and step. ``observed_order``: None where the series is
    not monotonic. ``extrapolated``:
    Richardson value, or the finest one. ``step_part``: what the step alone contributes.
    ``contact_stiffness`` and ``contact_damping``:
    least and largest value over the range of each constant, the case's own included. ``label``:
    variant of a train.
    """

    quantity: str
    engine_speed: float | None
    value: float
    numerical: float
    observed_order: float | None
    extrapolated: float
    step_part: float
    contact_stiffness: Range
    contact_damping: Range
    label: str = ""


@dataclass(frozen=True)
class UncertaintyStudy:
    """All rows of one case with the meshes behind them (none: a train); ``values`` holds every
    number by (variant, speed, quantity),
    the factors what the contact constants of the case were multiplied by; ``runs`` were asked for,
    of which ``finished`` came to an
    end, and ``failures`` tells of each that failed."""

    record: CaseRecord
    elements_per_coil: tuple[int, ...]
    rows: tuple[Uncertainty, ...]
    values: Mapping[str, Mapping[float | None, Numbers]]
    failures: tuple[str, ...] = ()
    stiffness_factors: Range = STIFFNESS_FACTORS
    damping_factors: Range = DAMPING_FACTORS
    runs: int = 0
    finished: int = 0


#: Safety factors of a series with a trusted order and of one without.
TRUSTED, DOUBTFUL = 1.25, 3.0
#: Order that the rod and its integrator declare; a series that seems to converge faster is taken to
#: have this one.
DECLARED_ORDER = 2.0
#: Observed orders below this one are not trusted.
MIN_ORDER = 0.5
#: Beyond this size an order says nothing.
HIGHEST_ORDER = 20.0


@dataclass(frozen=True, slots=True)
class GridConvergence:
    """Outcome for one quantity on three meshes, coarse to fine.

    ``observed_order`` is None where the series is not monotonic; ``extrapolated`` the Richardson
    value, or the finest one where the
    order is not trusted; ``uncertainty`` that of the coarsest value, ``finest_index`` the index of
    the finest one (same unit).
    """

    values: tuple[float, float, float]
    observed_order: float | None
    trusted: bool
    extrapolated: float
    uncertainty: float
    finest_index: float


def observed_order(
    values: tuple[float, float, float], sizes: tuple[float, float, float]
) -> float | None:
    """Order p of values on element ``sizes``, both coarse to fine; None for a series that is not
    monotonic or stands still.

    Solves p ln r21 = |ln|e32/e21| + q(p)| of Celik et al. by bisection, as their fixed-point
    iteration need not converge.
    """
    coarse, middle, fine = values
    far, near = coarse - middle, middle - fine
    first, second = sizes[1] / sizes[2], sizes[0] / sizes[1]
    if not (first > 1 and second > 1):
        raise InputError("sizes of three meshes must fall from coarse to fine; sort them")
    if near == 0 or far == 0 or far * near < 0:
        return None

    def excess(order: float) -> float:
        """Ratio of the two steps of a series of this order, less that of the values; rises with the
        order.
        """
        if abs(order) < 1e-9:
            return float(np.log(second) / np.log(first)) - far / near
        return float(first**order * (second**order - 1) / (first**order - 1)) - far / near

    low, high = -HIGHEST_ORDER, HIGHEST_ORDER
    if not excess(low) < 0 < excess(high):
        return low if excess(low) >= 0 else high
    for _ in range(100):
        middle_order = (low + high) / 2
        low, high = (middle_order, high) if excess(middle_order) < 0 else (low, middle_order)
    return (low + high) / 2


def grid_convergence(
    values: tuple[float, float, float], sizes: tuple[float, float, float]
) -> GridConvergence:
    """Numerical uncertainty of the coarsest of three values; ``sizes`` of their elements, coarse to
    fine.

    Raises :class:`InputError` when the sizes do not fall.
    """
    coarse, middle, fine = values
    order = observed_order(values, sizes)
    spread = max(values) - min(values)
    if order is None or order < MIN_ORDER:
        # Data range over the range of sizes, so that a wide set of meshes does not punish itself.
        uncertainty = DOUBTFUL * spread / (sizes[0] / sizes[2] - 1) if spread else 0.0
        return GridConvergence(
            values, order, False, fine, max(uncertainty, spread), max(uncertainty, spread)
        )
    used = min(order, DECLARED_ORDER)
    step = (middle - fine) / ((sizes[1] / sizes[2]) ** used - 1)
    extrapolated = fine - step
    return GridConvergence(
        values, order, True, extrapolated, TRUSTED * abs(coarse - extrapolated), TRUSTED * abs(step)
    )


def two_grids(value: float, finer: float, ratio: float) -> GridConvergence:
    """Uncertainty of ``value`` from one grid that is ``ratio`` times as fine: the declared order is
    assumed, and Roache's safety factor
    of three for two grids is taken."""
    finest = DOUBTFUL * abs(value - finer) / (ratio**DECLARED_ORDER - 1)
    return GridConvergence(
        (value, value, finer), None, False, finer, finest * ratio**DECLARED_ORDER, finest
    )
