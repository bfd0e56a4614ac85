"""One word changes the law: what a contact table was written for, turned into the values of any
other law.

Two laws are taken as equal where they press alike: same penetration and same damping at a reference
force (docs/case-files-trains.md).
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any

from valvetrain import registry
from valvetrain.contact.dissipative import damping_number
from valvetrain.contact.law import ContactSpec
from valvetrain.errors import InputError
from valvetrain.parameters.schema_contact import RESTITUTION, ContactTable

_DEFAULTS = {name: field.default for name, field in ContactTable.model_fields.items()}
REFERENCE_FORCE: float = _DEFAULTS["reference_force"]
"""Force (N) at which laws of different exponents have the same penetration: a typical cam force."""
REFERENCE_VELOCITY: float = _DEFAULTS["reference_velocity"]
"""Approach velocity (m/s) at which a restitution becomes a damping: a typical seating velocity."""
HERTZ_EXPONENT = 1.5


def law_values(
    name: str,
    spec: ContactSpec,
    values: Mapping[str, float],
    stiffness_exponent: float | None,
    damping_unit: str,
) -> dict[str, float]:
    """The fields of ``spec.law`` (SI) from a table that may have been written for another law.

    ``stiffness_exponent`` n of the N/m**n in which the stiffness is given (None: the law's own);
    ``damping_unit`` ``N s/m`` or ``s/m`` (empty: the law's own). Raises :class:`InputError` for a
    key no law has and for values that are
    no positive number where one is needed.
    """
    _refuse_unknown(name, values)
    own = {item.name: item for item in fields(spec.law) if item.name != "name"}
    chosen = {key: value for key, value in values.items() if key in own and own[key].init}
    if "contact_stiffness" not in values:
        return chosen
    force = _positive(name, "reference_force", values.get("reference_force", REFERENCE_FORCE))
    stiffness = _positive(name, "contact_stiffness", values["contact_stiffness"])
    exponent = _exponent(own, values)
    written = exponent if stiffness_exponent is None else stiffness_exponent
    depth = (force / stiffness) ** (1 / written)
    if not 1e-12 < depth < 1e3:
        raise InputError(
            f"contact '{name}' would be {depth * 1e3:.3g} mm deep at {force:.4g} N; check contact_stiffness and its unit"
        )
    if abs(written - exponent) > 1e-3:  # a unit holds three decimals of 10/9
        chosen["contact_stiffness"] = force / depth**exponent
    if "damping" in own:
        chosen |= _damping(name, spec, values, force, damping_unit)
    if "restitution" in own:
        chosen.setdefault("restitution", RESTITUTION)
    if "full_damping_depth" in own:
        chosen.setdefault("full_damping_depth", depth)
    return chosen


def _refuse_unknown(name: str, values: Mapping[str, float]) -> None:
    if all(key in ContactTable.model_fields for key in values):
        return
    known = {
        key: None
        for word in registry.names("contacts")
        for key in registry.find("contacts", word).table.model_fields
        if key != "law"
    }
    for key in values:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = (
                f"did you mean '{near[0]}'?" if near else f"contact tables hold {', '.join(known)}"
            )
            raise InputError(
                f"contact law '{name}' has no value '{key}', nor has any other law; {hint}"
            )


def _exponent(fields: Mapping[str, Any], values: Mapping[str, float]) -> float:
    """The law's exponent n: its own where fixed, else as given, else Hertz's."""
    if "exponent" not in fields:
        return 1.0
    fixed = fields["exponent"]
    default = HERTZ_EXPONENT if fixed.default is MISSING else float(fixed.default)
    return float(values.get("exponent", default)) if fixed.init else default


def _damping(
    name: str, spec: ContactSpec, values: Mapping[str, float], force: float, unit: str
) -> dict[str, float]:
    """``damping`` in the law's own unit: q F = c at the reference force F; from a restitution q =
    (q v) / v at the reference velocity.
    """
    viscous = spec.damping_unit == "N s/m"
    if "damping" in values:
        given_viscous = viscous if not unit else unit == "N s/m"
        if given_viscous == viscous:
            return {"damping": values["damping"]}
        return {"damping": values["damping"] * force if viscous else values["damping"] / force}
    if "restitution" not in values and any(
        item.name == "damping" and item.default is not MISSING for item in fields(spec.law)
    ):
        return {}
    velocity = _positive(
        name, "reference_velocity", values.get("reference_velocity", REFERENCE_VELOCITY)
    )
    factor = damping_number(values.get("restitution", RESTITUTION)) / velocity
    return {"damping": factor * force if viscous else factor}


def _positive(name: str, key: str, value: float) -> float:
    if not 0 < value < float("inf"):
        raise InputError(f"{key} of contact law '{name}' is {value}; give a positive number")
    return float(value)
