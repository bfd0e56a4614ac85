"""Error bars of a refinement: one number with its uncertainty, and all of a case with the runs
behind them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from valvetrain.solution.record import CaseRecord

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
