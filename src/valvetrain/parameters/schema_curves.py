"""Curves over the coil number as a case file writes them: a constant, knots, a table or a named
formula.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import PlainValidator

from valvetrain.errors import InputError
from valvetrain.parameters.constructors import pitch_with_closed_ends
from valvetrain.parameters.curves import (
    Constant,
    Curve,
    Parabola,
    PiecewiseLinear,
    SlopeOf,
    Table,
    add_curves,
)
from valvetrain.parameters.schema_types import (
    Lengths,
    Number,
    Numbers,
    PositiveLength,
    StrictModel,
    guarded,
    validate_as,
)
from valvetrain.units import parse_quantity


class KnotsForm(StrictModel):
    """``{ coils = [0, 4, 7], values = "22, 22, 17 mm" }``, straight between knots, or smooth with
    ``kind = "table"``.

    ``clearances`` in place of ``values`` gives a pitch less the wire diameter.
    """

    kind: Literal["piecewise-linear", "table"] = "piecewise-linear"
    coils: Numbers
    values: Lengths | None = None
    clearances: Lengths | None = None

    def build(self, total_coils: float, wire: Curve | None = None) -> Curve:
        """The curve; raises :class:`InputError` when this form lacks or repeats something."""
        if (self.values is None) == (self.clearances is None):
            raise InputError(
                "a curve over coils has either values or clearances (pitch less wire diameter); give one of them"
            )
        numbers = self.values if self.values is not None else self.clearances
        assert numbers is not None
        curve: Curve = (
            Table(self.coils, numbers)
            if self.kind == "table"
            else PiecewiseLinear(self.coils, numbers)
        )
        if self.clearances is None:
            return curve
        if wire is None:
            raise InputError("clearances belong to a pitch; give values here")
        return add_curves(curve, wire)


class FormulaForm(StrictModel):
    """A named law: linear (conical), parabolic (barrel, hourglass), beehive, closed-ends (a pitch)."""

    formula: Literal["linear", "conical", "barrel", "hourglass", "beehive", "closed-ends"]
    lower: PositiveLength | None = None
    upper: PositiveLength | None = None
    ends: PositiveLength | None = None
    middle: PositiveLength | None = None
    taper_from_coil: Number | None = None
    pitch: PositiveLength | None = None
    closed_lower: Number = 1.0
    closed_upper: Number = 1.0
    ramp: Number = 0.5

    def build(self, total_coils: float, wire: Curve | None = None) -> Curve:
        """The curve; raises :class:`InputError` when this form lacks or repeats something."""
        if self.formula in ("linear", "conical"):
            lower, upper = self._need("lower", "upper")
            return PiecewiseLinear((0.0, total_coils), (lower, upper))
        if self.formula in ("barrel", "hourglass"):
            ends, middle = self._need("ends", "middle")
            if (middle > ends) != (self.formula == "barrel"):
                raise InputError(
                    f"formula {self.formula} has middle {middle:g} m and ends {ends:g} m, the wrong way round; swap them"
                )
            return Parabola(ends, middle, total_coils)
        if self.formula == "beehive":
            lower, upper, start = self._need("lower", "upper", "taper_from_coil")
            return PiecewiseLinear((0.0, start, total_coils), (lower, lower, upper))
        (pitch,) = self._need("pitch")
        if not isinstance(wire, Constant):
            raise InputError(
                "formula closed-ends is a pitch for a wire of constant diameter; write the pitch over coils instead"
            )
        return pitch_with_closed_ends(
            total_coils,
            wire.level,
            pitch,
            self.closed_lower,
            self.closed_upper,
            self.ramp,
        )

    def _need(self, *names: str) -> tuple[float, ...]:
        for name in names:
            if getattr(self, name) is None:
                raise InputError(f"formula {self.formula} needs {' and '.join(names)}; add {name}")
        return tuple(getattr(self, name) for name in names)


class HeightForm(StrictModel):
    """Height of the wire axis over the coil number, interpolated smoothly: another way to give the
    pitch.
    """

    kind: Literal["table"] = "table"
    coils: Numbers
    values: Lengths

    def build(self, total_coils: float, wire: Curve | None = None) -> Curve:
        """The pitch; raises :class:`InputError` for knots that make no curve."""
        return SlopeOf(Table(self.coils, self.values))


CurveForm = Constant | KnotsForm | FormulaForm


def curve_of(form: CurveForm | HeightForm, total_coils: float, wire: Curve | None = None) -> Curve:
    """The curve of what a file has, over ``total_coils`` turns of a ``wire``; raises :class:`InputError`."""
    return form if isinstance(form, Constant) else form.build(total_coils, wire)


def _read_curve(raw: Any) -> CurveForm:
    if not isinstance(raw, dict):
        return Constant(float(guarded(parse_quantity, raw, "length")))
    return validate_as(FormulaForm, raw) if "formula" in raw else validate_as(KnotsForm, raw)


CurveField = Annotated[CurveForm, PlainValidator(_read_curve)]
