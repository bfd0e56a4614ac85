"""Fidelity of spring models: every model against a reference over engine speed, both with their
numerical error.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from valvetrain.solution.display import Shown, verdict_first

if TYPE_CHECKING:
    import pandas

#: Verdicts of a model at one speed: within the tolerance, error bars included; beyond it even so;
#: undecided, for the error bars or without a reference; no value of the model.
GOOD, POOR, OPEN, MISSING = "good", "poor", "open", "missing"
RPM = math.pi / 30


@dataclass(frozen=True, slots=True)
class FidelityRow:
    """One quantity of one model at one engine speed against the reference; values in SI.

    Parameters
    ----------
    quantity : name of the quantity
    model : name of the spring model
    engine_speed : crank speed (rad/s)
    value, error : of the model (NaN: none), and half the width of its numerical error bar: NaN for a model without one,
        infinite where the run for it gave no result
    reference, reference_error : the same of the reference
    scale : largest size of the reference over all speeds, by which differences are divided
    """

    quantity: str
    model: str
    engine_speed: float
    value: float
    error: float
    reference: float
    reference_error: float
    scale: float

    @property
    def difference(self) -> float:
        """Model less reference, as a share of ``scale``."""
        return (self.value - self.reference) / self.scale

    @property
    def doubt(self) -> float:
        """Half width of the error bar of the difference, as a share of ``scale``: the sum of the
        errors that exist.
        """
        errors = (self.error, self.reference_error)
        return sum(error for error in errors if not math.isnan(error)) / self.scale

    def verdict(self, tolerance: float) -> str:
        """``good``, ``poor``, ``open`` or ``missing`` at a tolerance (share of ``scale``)."""
        size = abs(self.difference)
        if not math.isfinite(self.value):
            return MISSING
        if math.isfinite(self.reference) and size + self.doubt <= tolerance:
            return GOOD
        return POOR if math.isfinite(self.reference) and size - self.doubt > tolerance else OPEN


@dataclass(frozen=True, slots=True)
class ValidSpeedRange:
    """Up to which engine speed a model is good enough for a quantity (rad/s of the crank, None
    where it never is).

    ``good_to``: the last speed of the unbroken good ones from the lowest; ``poor_from``: the first
    at which it is poor or has no value.
    """

    quantity: str
    model: str
    good_to: float | None
    poor_from: float | None
    everywhere: bool
    largest: float
    largest_doubt: float
    missing: bool = False

    @property
    def text(self) -> str:
        """``all``, ``none``, ``open``, ``to 6500`` or ``to 6500, then open`` (never poor): engine
        speeds in rpm.
        """
        if self.missing:
            return "missing"
        if self.everywhere:
            return "all"
        if self.good_to is None:
            return "none" if self.poor_from is not None else "open"
        return f"to {self.good_to / RPM:.6g}" + (", then open" if self.poor_from is None else "")


@dataclass(frozen=True, slots=True)
class FidelityMap(Shown):
    """Rows of every quantity, model and speed, the reference's own left out.

    Parameters
    ----------
    reference : name of the model that the others are judged by
    tolerance : share of the reference's largest value up to which a model is good enough
    rows : by quantity, model and speed
    costs : model -> seconds of one core per simulated second, as estimates take it; in ascending
        order of cost
    divided : models whose numerical error was found by dividing them more finely

    Examples
    --------
    >>> import valvetrain as vt
    >>> row = vt.fidelity("job-t", "2000 rpm", spring_models=["massless"], reference="wave-rod").fidelity.rows[0]
    >>> row.quantity, row.model, row.verdict(tolerance=0.05)
    ('peak_spring_force', 'massless', 'good')
    """

    reference: str = ""
    tolerance: float = 0.05
    rows: tuple[FidelityRow, ...] = ()
    costs: tuple[tuple[str, float], ...] = ()
    divided: tuple[str, ...] = ()

    def __repr__(self) -> str:
        models = ", ".join(self.models) or "no models"
        tolerance = f"tolerance {100 * self.tolerance:g} %"
        return verdict_first(self, [f"FidelityMap: {models} against {self.reference}, {tolerance}"])

    def __iter__(self) -> Iterator[FidelityRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def to_pandas(self) -> pandas.DataFrame:
        """All rows with difference, doubt and verdict."""
        import pandas

        names = (
            "quantity", "model", "engine_speed", "value", "error", "reference", "reference_error", "difference", "doubt",
        )  # fmt: skip
        columns = {name: [getattr(row, name) for row in self.rows] for name in names}
        return pandas.DataFrame(
            columns | {"verdict": [row.verdict(self.tolerance) for row in self.rows]}
        )

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities in order."""
        return tuple(dict.fromkeys(row.quantity for row in self.rows))

    @property
    def models(self) -> tuple[str, ...]:
        """Models that are judged, the cheapest first."""
        there = {row.model for row in self.rows}
        return tuple(name for name, _ in self.costs if name in there)

    def of(self, quantity: str, model: str) -> tuple[FidelityRow, ...]:
        """Rows of one quantity and model in order of speed."""
        rows = (row for row in self.rows if row.quantity == quantity and row.model == model)
        return tuple(sorted(rows, key=lambda row: row.engine_speed))

    def reach(self, quantity: str, model: str) -> ValidSpeedRange:
        """Where one model is good enough for one quantity."""
        rows = self.of(quantity, model)
        verdicts = [row.verdict(self.tolerance) for row in rows]
        first = next((n for n, one in enumerate(verdicts) if one != GOOD), len(rows))
        poor = next((n for n, one in enumerate(verdicts) if one in (POOR, MISSING)), None)
        known = [row for row in rows if math.isfinite(row.difference)]
        worst = max(known, key=lambda row: abs(row.difference), default=None)
        size, doubt = (
            (math.nan, math.nan) if worst is None else (abs(worst.difference), worst.doubt)
        )
        good_to = rows[first - 1].engine_speed if first else None
        poor_from = None if poor is None else rows[poor].engine_speed
        return ValidSpeedRange(
            quantity,
            model,
            good_to,
            poor_from,
            bool(rows) and first == len(rows),
            size,
            doubt,
            bool(rows) and not known,
        )

    def cheapest(self, quantity: str) -> str:
        """The cheapest model that is good enough for a quantity at every speed, the reference where
        none is.
        """
        return next(
            (model for model in self.models if self.reach(quantity, model).everywhere),
            self.reference,
        )
