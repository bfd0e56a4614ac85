"""Contact laws by name, so that a case changes its law by one word."""

from __future__ import annotations

import difflib
from dataclasses import fields
from typing import Any

from valvetrain.contact.common_values import law_values
from valvetrain.contact.flores import Flores
from valvetrain.contact.hertz_line import HertzLine
from valvetrain.contact.hertz_point import HertzPoint
from valvetrain.contact.hunt_crossley import HuntCrossley
from valvetrain.contact.impact import ImpactAsPrinted, ImpactContact
from valvetrain.contact.lankarani_nikravesh import LankaraniNikravesh
from valvetrain.contact.law import ContactLaw
from valvetrain.contact.linear import LinearContact
from valvetrain.errors import InputError

LAWS: dict[str, type[Any]] = {
    "linear": LinearContact,
    "hertz-point": HertzPoint,
    "hertz-line": HertzLine,
    "hunt-crossley": HuntCrossley,
    "lankarani-nikravesh": LankaraniNikravesh,
    "flores": Flores,
    "impact": ImpactContact,
    "impact-as-printed": ImpactAsPrinted,
}


def build_contact_law(name: str, *, stiffness_exponent: float | None = None, damping_unit: str = "", **values: float) -> ContactLaw:
    """Law ``name`` from a contact table (SI), which may have been written for another law (``contact.common_values``).

    ``stiffness_exponent`` n of the N/m**n of ``contact_stiffness`` and ``damping_unit`` (``N s/m``, ``s/m``): None and empty for the
    law's own. Raises :class:`InputError` for an unknown name, no stiffness, and a value that no law has.
    """
    if name not in LAWS:
        near = difflib.get_close_matches(name, LAWS, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"use one of {', '.join(LAWS)}"
        raise InputError(f"contact law '{name}' is unknown; {hint}")
    known = [item.name for item in fields(LAWS[name]) if item.init and item.name != "name"]
    every = {item.name for law in LAWS.values() for item in fields(law) if item.init and item.name != "name"}
    chosen = law_values(name, LAWS[name], values, every, stiffness_exponent, damping_unit)
    try:
        law: ContactLaw = LAWS[name](**chosen)
    except TypeError:
        raise InputError(f"contact law '{name}' needs {', '.join(known)} but got {', '.join(values) or 'nothing'}") from None
    return law
