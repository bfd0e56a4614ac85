"""Contact laws by name, so that a case changes its law by one word."""

from __future__ import annotations

from dataclasses import fields

from valvetrain import registry
from valvetrain.contact.common_values import law_values
from valvetrain.contact.law import ContactLaw
from valvetrain.contact.spec import ContactSpec
from valvetrain.errors import InputError


def build_contact_law(name: str, *, stiffness_exponent: float | None = None, damping_unit: str = "", **values: float) -> ContactLaw:
    """Law ``name`` from a contact table (SI), which may have been written for another law (``contact.common_values``).

    ``stiffness_exponent`` n of the N/m**n of ``contact_stiffness`` and ``damping_unit`` (``N s/m``, ``s/m``): None and empty for the
    law's own. Raises :class:`InputError` for an unknown name, no stiffness, and a value that no law has.
    """
    spec: ContactSpec = registry.find("contacts", name)
    chosen = law_values(name, spec, values, stiffness_exponent, damping_unit)
    try:
        law: ContactLaw = spec.law(**chosen)
    except TypeError:
        known = [item.name for item in fields(spec.law) if item.init and item.name != "name"]
        raise InputError(f"contact law '{name}' needs {', '.join(known)} but got {', '.join(values) or 'nothing'}") from None
    return law
