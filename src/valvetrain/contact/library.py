"""Contact laws by name, so that a case changes its law by one word."""

from __future__ import annotations

import difflib
from dataclasses import fields
from typing import Any

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


def build_contact_law(name: str, **values: float) -> ContactLaw:
    """Law ``name`` from its own fields (SI). Raises :class:`InputError` for an unknown name, a missing or an unknown field."""
    if name not in LAWS:
        near = difflib.get_close_matches(name, LAWS, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"use one of {', '.join(LAWS)}"
        raise InputError(f"contact law '{name}' is unknown; {hint}")
    known = [item.name for item in fields(LAWS[name]) if item.init and item.name != "name"]
    unknown = [key for key in values if key not in known]
    if unknown:
        raise InputError(f"contact law '{name}' has no value '{unknown[0]}'; it takes {', '.join(known)}")
    try:
        law: ContactLaw = LAWS[name](**values)
    except TypeError:
        raise InputError(f"contact law '{name}' needs {', '.join(known)} but got {', '.join(values) or 'nothing'}") from None
    return law
