"""The [train.contacts.PLACE] tables: keys of any contact table; the defaults of each law are
with it in `valvetrain.contact`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from pydantic import Field, PlainValidator

from valvetrain import registry
from valvetrain.errors import FrozenMapping, InputError
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.own_parts import carrying
from valvetrain.parameters.schema_types import (
    Force,
    Length,
    Ratio,
    StrictModel,
    guarded,
    problem,
    quantity,
    validate_as,
)
from valvetrain.units import dimension_powers

#: Their dimension depends on the law, so the units given decide (:func:`written_for`).
ContactStiffness = Annotated[float, quantity(None)]
ContactDamping = Annotated[float, quantity(None)]
Velocity = Annotated[float, quantity("velocity")]

#: In place of a table, or of all tables: a contact of steel parts of typical size
#: (:mod:`valvetrain.parameters.steel_contacts`).
STEEL = "steel"
#: Of steel on steel, where a law needs a loss and the table gives none.
RESTITUTION = 0.7

_FRICTION = ("friction_coefficient", "friction_velocity")
_DAMPING_UNITS: dict[tuple[tuple[str, float], ...], str] = {
    (("[mass]", 1.0), ("[time]", -1.0)): "N s/m",
    (("[length]", -1.0), ("[time]", 1.0)): "s/m",
}


@dataclass(frozen=True, slots=True)
class ContactParameters:
    """A contact law by its name and numbers (SI); ``values`` are keyword arguments of laws in
    `valvetrain.contact`.

    ``friction_coefficient`` (0: none) of regularised Coulomb friction, which creeps below
    ``friction_velocity`` (m/s). ``stiffness_exponent`` n of the N/m**n and ``damping_unit`` (``N
    s/m`` or ``s/m``) in which the values are given, so that another law can be named over them;
    None and empty: the units of the law named. ``origin``: where values come from that the case
    does not give.
    """

    law: str = "linear"
    values: Mapping[str, Any] = field(default_factory=FrozenMapping)
    friction_coefficient: float = 0.0
    friction_velocity: float = 0.01
    stiffness_exponent: float | None = None
    damping_unit: str = ""
    origin: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.friction_coefficient) and self.friction_coefficient >= 0):
            raise InputError(
                f"friction_coefficient of the contact must not be negative; it is {self.friction_coefficient:g}"
            )
        if not (math.isfinite(self.friction_velocity) and self.friction_velocity > 0):
            raise InputError(
                f"friction_velocity of the contact must be positive; it is {self.friction_velocity:g}"
            )
        object.__setattr__(self, "values", FrozenMapping(self.values))

    def replace(self, **changes: Any) -> ContactParameters:
        """A copy with another ``law`` or with ``values`` changed."""
        law = changes.pop("law", self.law)
        values = changes.pop("values", self.values)
        return replace(self, law=law, values={**values, **changes})


class ContactTable(StrictModel):
    """Keys that every contact table may hold, since it may be written for any law; a law's own
    table gives its defaults.
    """

    law: str
    contact_stiffness: ContactStiffness | None = Field(default=None, description="K of K d^n")
    exponent: Ratio | None = Field(default=None, description="n of K d^n")
    damping: ContactDamping | None = Field(
        default=None, description="c of c d' (N s/m) or q of 1 + q d' (s/m)"
    )
    restitution: Ratio | None = Field(
        default=None, description="velocity of rebound over that of approach"
    )
    full_damping_depth: Length | None = Field(
        default=None,
        description="penetration at which the damping is whole; else that at reference_force",
    )
    reference_force: Force = Field(
        default=500.0, description="force at which another law presses alike"
    )
    reference_velocity: Velocity = Field(
        default=0.2, description="approach velocity at which a restitution becomes a damping"
    )
    friction_coefficient: Ratio = Field(
        default=0.0, description="Coulomb friction along the contact"
    )
    friction_velocity: Velocity = Field(
        default=0.01, description="sliding velocity below which the contact creeps"
    )


def _read_contact(raw: Any) -> ContactParameters:
    if isinstance(raw, ContactParameters):
        return raw
    if raw == STEEL:
        return ContactParameters(STEEL)
    if not isinstance(raw, dict) or not isinstance(raw.get("law"), str):
        raise problem(f"a contact needs its law, such as law = 'impact', or the word '{STEEL}'")
    law = raw["law"]
    if law == STEEL:
        return _read_steel(raw)
    law = carrying(law)
    if registry.OWN_NAME.fullmatch(law) and law not in registry.names("contacts"):
        guarded(registry.find, "contacts", law, path=("law",))
    elif law not in registry.names("contacts"):
        raise problem(
            f"contact law '{law[:40]}' is unknown; {nearest(law, registry.names('contacts'))}",
            ("law",),
        )
    # Laws are loaded for keys of their own only: their files bring compiled kernels along.
    common = {key: value for key, value in raw.items() if key in ContactTable.model_fields}
    values = validate_as(ContactTable, common).model_dump(exclude_unset=True, exclude={"law"})
    for key, value in raw.items():
        if key not in common:
            values[key] = getattr(validate_as(_table_with(key, law), {"law": law, key: value}), key)
    friction = {key: values.pop(key) for key in _FRICTION if key in values}
    units = guarded(written_for, raw)
    built: ContactParameters = guarded(lambda: ContactParameters(law, values, **friction, **units))
    return built


def _read_steel(raw: dict[str, Any]) -> ContactParameters:
    """A contact by the word in place of a law, which takes its friction alone."""
    if other := next((key for key in raw if key not in ("law", *_FRICTION)), ""):
        raise problem(
            f"a contact of '{STEEL}' takes {' and '.join(_FRICTION)} alone; give a law, such as law = 'hunt-crossley', for '{other[:40]}'",
            (other,),
        )
    return ContactParameters(
        STEEL, **validate_as(ContactTable, raw).model_dump(exclude_unset=True, exclude={"law"})
    )


def _table_with(key: str, law: str) -> type[ContactTable]:
    """The table of ``law``, or of another law, that has ``key`` (it then waits unused); else that
    of ``law``, to refuse it.
    """
    laws = (law, *(word for word in registry.names("contacts") if word != law))
    tables: list[type[ContactTable]] = [
        guarded(registry.find, "contacts", word).table for word in laws
    ]
    return next((table for table in tables if key in table.model_fields), tables[0])


def written_for(raw: Mapping[str, Any]) -> dict[str, Any]:
    """The exponent of the stiffness and the kind of damping that follow from the units of a contact table;
    refuses other units.
    """
    found: dict[str, Any] = {}
    if isinstance(text := raw.get("contact_stiffness"), str):
        powers = dimension_powers(text)
        exponent = 1 - powers.pop("[length]", 0.0)
        if powers != {"[mass]": 1.0, "[time]": -2.0} or not 0.99 <= exponent <= 3:
            raise InputError(
                f"'{text[:40]}' is no contact stiffness; write a force over a length, such as '100 kN/mm' or '1e5 N/mm^1.5'"
            )
        found["stiffness_exponent"] = exponent
    if isinstance(text := raw.get("damping"), str):
        unit = _DAMPING_UNITS.get(tuple(sorted(dimension_powers(text).items())))
        if unit is None:
            raise InputError(
                f"'{text[:40]}' is no damping of a contact; write such as '300 N s/m', or '2 s/m' as factor of the elastic force"
            )
        found["damping_unit"] = unit
    return found


def _read_contacts(raw: Any) -> dict[str, ContactParameters]:
    """Contacts by place; the word alone, or of the place ``others``, applies to every place not
    named (stored under ''), and to tables that give friction and no law.
    """
    if raw == STEEL:
        return {"": ContactParameters(STEEL)}
    if not isinstance(raw, Mapping):
        raise problem(
            f"a table of places is needed here, such as [train.contacts.cam], or contacts = '{STEEL}'"
        )
    of_steel = {"law": STEEL} if raw.get("others") == STEEL else {}
    found = {
        place: guarded(
            _read_contact, of_steel | table if isinstance(table, dict) else table, path=(place,)
        )
        for place, table in raw.items()
    }
    if (rest := found.pop("others", None)) is not None:
        if rest.law != STEEL:
            raise problem(
                f"others applies to the contacts not named and can be '{STEEL}' only; name the contact",
                ("others",),
            )
        found[""] = rest
    return found


ContactsField = Annotated[dict[str, ContactParameters], PlainValidator(_read_contacts)]
