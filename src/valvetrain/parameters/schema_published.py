"""The [[published]] tables: groups of published numbers of one model at one speed."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import PlainValidator

from valvetrain.parameters.schema_names import Line, Name, Prose
from valvetrain.parameters.schema_types import AngularSpeed, StrictModel, guarded, placed, problem, validate_as
from valvetrain.solution.definition import definition_of
from valvetrain.solution.record import PublishedValue, Role
from valvetrain.units import dimension_of, parse_quantity


def dimension_of_quantity(name: str) -> str | None:
    """Dimension (see `valvetrain.units`) of a quantity by the table of quantities; None where its name promises none."""
    return definition_of(name).dimension or None


class ValueModel(StrictModel):
    """One number, with how firmly it is stated, how near a computed one should be, and what it was used for."""

    value: Any
    relation: Literal["equal", "about", "at-most", "at-least"] = "equal"
    tolerance: Any = None
    origin: Line = ""
    role: Role | None = None
    used_for: Prose = ""
    doubt: Prose = ""

    def read(self, quantity: str) -> tuple[float, str, float | None]:
        """SI value, the unit it was written in and the SI tolerance (given in percent or in the same dimension)."""
        dimension = dimension_of_quantity(quantity)
        value = guarded(parse_quantity, self.value, dimension, path=("value",))
        unit = str(self.value).strip().lstrip("+-0123456789.").strip()
        if unit[:1] in "eE" and unit[1:2] in tuple("+-0123456789"):
            unit = unit[1:].lstrip("+-0123456789").strip()
        if self.tolerance is None:
            return value, unit, None
        if isinstance(self.tolerance, str) and self.tolerance.strip().endswith("%"):
            return value, unit, abs(value) * guarded(parse_quantity, self.tolerance, "ratio", path=("tolerance",))
        tolerance = guarded(parse_quantity, self.tolerance, dimension or dimension_of(unit), path=("tolerance",))
        if tolerance < 0:
            raise problem("a tolerance is zero or more", ("tolerance",))
        return value, unit, tolerance


def _read_value(raw: Any) -> ValueModel:
    return validate_as(ValueModel, raw if isinstance(raw, dict) else {"value": raw})


class PublishedModel(StrictModel):
    """One group of published values."""

    model: Name
    role: Role
    source: Line
    origin: Line = ""
    engine_speed: AngularSpeed | None = None
    quantities: dict[str, Annotated[ValueModel, PlainValidator(_read_value)]]

    def build(self) -> tuple[PublishedValue, ...]:
        """The flat list of values; raises a located problem."""
        values = []
        for name, entry in self.quantities.items():
            value, unit, tolerance = placed(("quantities", name), entry.read, name)
            values.append(
                PublishedValue(
                    quantity=name,
                    value=value,
                    unit=unit,
                    origin=entry.origin or self.origin,
                    role=entry.role or self.role,
                    engine_speed=self.engine_speed,
                    model=self.model,
                    source=self.source,
                    tolerance=tolerance,
                    relation=entry.relation,
                    used_for=entry.used_for,
                    doubt=entry.doubt,
                )
            )
        return tuple(values)
