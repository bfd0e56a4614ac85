"""Comparisons of computed with published values."""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.solution.display import Shown


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
class Comparison(Shown):
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
