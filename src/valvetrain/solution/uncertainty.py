"""What a number of a run is judged by: its error bar, and the published value."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

from valvetrain.solution.quantity import same_speed
from valvetrain.solution.status import Fact

Range = tuple[float, float]
#: Least order of convergence that is trusted.
MIN_ORDER = 0.5


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
    def contact_range(self) -> ContactRange | None:
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
        return (
            self.contact_range is None
            and self.value != 0
            and bool(OF_CONTACT.search(self.quantity))
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


@dataclass(frozen=True, slots=True)
class SampleRange:
    r"""What a source that stored samples could have read: the ``low``\ est and ``high``\ est value (SI)
    over ``phases`` phases of its samples, and the ``share`` of phases at or above the published value.
    """

    low: float
    high: float
    share: float
    phases: int


@dataclass(frozen=True, slots=True)
class Comparison:
    """A row of the table computed / published / difference.

    ``engine_speed`` in rad/s of the crank (None where none applies); ``published``, ``computed``,
    ``difference`` and ``tolerance`` in SI, ``unit`` the unit they are shown in; ``computed`` None when no run gave the quantity;
    ``tolerance`` None when source and task give none. ``origin`` of the published value (FE, AN,
    EX), its ``role`` (calibration, check or prediction), what it was ``used_for``, a ``doubt``:
    why it cannot be right, and the ``reading``: how its source read it. ``samples``: the range of
    what the source could have read, whose median is ``computed``; None where it stored no samples.
    ``blind``: what the case computes that was not fitted to the value, where it ships.

    >>> row = Comparison("preload", None, "massless", "FE", "N", 289.0, 288.9, -0.1, "check", 2.0, "agrees")
    >>> row.verdict
    'agrees'
    """

    quantity: str
    engine_speed: float | None
    model: str
    origin: str
    unit: str
    published: float
    computed: float | None
    difference: float | None
    role: str
    tolerance: float | None
    verdict: str
    source: str = ""
    used_for: str = ""
    doubt: str = ""
    reading: str = ""
    samples: SampleRange | None = None
    blind: float | None = None

    def __repr__(self) -> str:
        computed = "not computed" if self.computed is None else f"computed {self.computed:.5g}"
        values = f"published {self.published:.5g}, {computed} {self.unit}".rstrip()
        return f"Comparison of {self.quantity}, {self.model}: {values}; {self.verdict}"

    @property
    def relative_difference(self) -> float | None:
        """Difference over the published value; None where either is missing or the published value
        is zero.
        """
        if self.difference is None or self.published == 0:
            return None
        return self.difference / abs(self.published)


@dataclass(frozen=True, slots=True)
class Finding:
    """A published finding: its place in the source, its statement, the computed result and the
    verdict.
    """

    place: str
    statement: str
    computed: str
    verdict: str
