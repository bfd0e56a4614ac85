"""A number of a run with its error bar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

Range = tuple[float, float]
#: Least order of convergence that is trusted.
MIN_ORDER = 0.5


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """One headline number (SI) on the case's own mesh, at ``engine_speed`` (rad/s of the crank;
    None: statics, modes).

    ``numerical``: uncertainty from meshes and step. ``observed_order``: None where the series is
    not monotonic. ``extrapolated``: Richardson value, or the finest one. ``step_part``:
    contribution of the step. ``contact_stiffness``, ``contact_damping``: least and largest value
    over the range of each constant; the value twice where that was not varied. ``label``: variant
    of a train, or label of a run.
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

    @property
    def trusted_order(self) -> float | None:
        """The observed order where it is trusted, else None."""
        return (
            None
            if self.observed_order is None or self.observed_order < MIN_ORDER
            else self.observed_order
        )


#: How the sentence of error bars begins on reduced rods that their rods contradict.
TOO_HARD = "Coils clash or swing too hard"


class ErrorBars(NamedTuple):
    """Rows of the runs of a study, and sentences on what they are, which are large, and where there
    are none.
    """

    rows: tuple[Uncertainty, ...] = ()
    sentences: tuple[str, ...] = ()
