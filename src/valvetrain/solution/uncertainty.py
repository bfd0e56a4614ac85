"""A number of a run with its error bar."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

from valvetrain.solution.facts import Fact
from valvetrain.solution.quantity import same_speed

Range = tuple[float, float]
#: Least order of convergence that is trusted.
MIN_ORDER = 0.5


#: What stands in place of an error bar that is larger than its value.
NOT_RESOLVED = "not resolved"
#: Constants whose ranges a number is computed over.
CONSTANTS = ("contact stiffness", "damping")
#: Kinds of quantities that these constants move by more than 5 %: raw peaks, blows of coils and at the seat.
OF_CONTACT = re.compile(
    r"^(?!.*below_)(raw_peak_|.*clash.*_(force|energy|impulse)$|peak_seat_contact_force$|peak_valve_acceleration$)"
)


class ContactRange(NamedTuple):
    """Least and largest value (SI) over the constants that nobody knows, and the names of those that move it."""

    low: float
    high: float
    by: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """One headline number (SI) on the case's own mesh, at ``engine_speed`` (rad/s of the crank;
    None: statics, modes).

    ``numerical``: uncertainty from meshes and step. ``observed_order``: None where the series is
    not monotonic. ``extrapolated``: Richardson value, or the finest one. ``step_part``:
    contribution of the step. ``contact_stiffness``, ``damping``: least and largest value
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
    damping: Range
    label: str = ""

    @property
    def resolved(self) -> bool:
        """Whether the error bar is at most as large as the value itself."""
        return self.numerical <= abs(self.value)

    @property
    def range(self) -> ContactRange | None:
        """The range over contact stiffness and damping; None where neither was varied."""
        varied = {
            name: values
            for name, values in zip(CONSTANTS, (self.contact_stiffness, self.damping), strict=True)
            if values[0] < values[1]
        }
        if not varied:
            return None
        return ContactRange(
            min(low for low, _ in varied.values()),
            max(high for _, high in varied.values()),
            tuple(varied),
        )

    @property
    def rests_on_contact_constants(self) -> bool:
        """Whether contact constants decide a quantity of this kind and no range of it was computed."""
        return self.range is None and self.value != 0 and bool(OF_CONTACT.search(self.quantity))

    @property
    def trusted_order(self) -> float | None:
        """The observed order where it is trusted, else None."""
        return (
            None
            if self.observed_order is None or self.observed_order < MIN_ORDER
            else self.observed_order
        )


class NoErrorBar(NamedTuple):
    """A completed run without error bars: label, engine speed (rad/s) and the code of its reason, a key of
    :data:`REASONS`.
    """

    label: str
    engine_speed: float
    reason: str


#: Why a run has no error bars, by code.
REASONS = {
    "no-division": "its spring has no division",
    "not-repeated": "that run or its repeat did not settle",
}


class ErrorBars(NamedTuple):
    """Rows of the runs of a study, those stored beside a library case and those computed; the completed
    runs that have none; and facts of models that the further runs contradict.

    >>> ErrorBars().of("peak_spring_force", "massless", 400.0) is None
    True
    """

    rows: tuple[Uncertainty, ...] = ()
    missing: tuple[NoErrorBar, ...] = ()
    facts: tuple[Fact, ...] = ()

    def of(
        self, quantity: str, label: str = "", engine_speed: float | None = None
    ) -> Uncertainty | None:
        """The row of a quantity of a run (``engine_speed`` in rad/s; None: at rest, whatever label); None
        where there is none.
        """
        return next(
            (
                row
                for row in self.rows
                if row.quantity == quantity
                and same_speed(row.engine_speed, engine_speed)
                and (engine_speed is None or row.label == label)
            ),
            None,
        )
