"""Contact laws by name, so that a case changes its law by one word."""

from __future__ import annotations

from dataclasses import fields

from valvetrain import registry
from valvetrain.contact.common_values import law_values
from valvetrain.contact.function_law import own_law
from valvetrain.contact.law import ContactLaw, ContactSpec
from valvetrain.errors import InputError
from valvetrain.parameters.schema_contact import written_for
from valvetrain.parameters.schema_types import Quantity
from valvetrain.units import Given, parse_quantity


def build_contact_law(
    name: str, *, stiffness_exponent: float | None = None, damping_unit: str = "", **values: Given
) -> ContactLaw:
    """Law of normal contact ``name`` from the numbers of a contact table, which may have been
    written for another law.

    Parameters
    ----------
    name : name of the law: linear, hertz-point, hertz-line, hunt-crossley, lankarani-nikravesh,
        flores, impact or impact-as-printed
    stiffness_exponent : n of the N/m**n in which ``contact_stiffness`` is given as a number; None
        for the law's own
    damping_unit : ``N s/m`` or ``s/m``, in which ``damping`` is given as a number; empty for the
        law's own
    values : numbers of the law, each SI, text with a unit ("60 kN/mm") or a pint quantity:
        ``contact_stiffness`` (N/m**n),
        ``exponent``, ``damping``, ``restitution``, ``full_damping_depth`` (m), ``reference_force``
        (N), ``reference_velocity`` (m/s)

    Returns
    -------
    ContactLaw that gives force, tangent and lost power of arrays of penetration (m) and rate (m/s),
    of any one shape

    Raises
    ------
    InputError : unknown name, no stiffness, a value that no law has, a wrong unit

    Examples
    --------
    >>> import valvetrain as vt
    >>> law = vt.contact.build_contact_law("linear", contact_stiffness="60 kN/mm", damping="300 N s/m")
    >>> round(float(law.force(1e-6, 0.0)), 6)
    60.0
    """
    spec: ContactSpec = registry.find("contacts", name)
    if name in registry.OWN and not isinstance(registry.OWN[name], ContactSpec):
        return own_law(name)  # its numbers are in its Python code
    written = {
        key: str(value.to_base_units()) if hasattr(value, "to_base_units") else value
        for key, value in values.items()
    }
    units = {"stiffness_exponent": stiffness_exponent, "damping_unit": damping_unit} | written_for(
        written
    )
    chosen = law_values(
        name,
        spec,
        {key: _number(name, spec, key, value) for key, value in written.items()},
        **units,
    )
    try:
        law: ContactLaw = spec.law(**chosen)
    except TypeError:
        known = [item.name for item in fields(spec.law) if item.init and item.name != "name"]
        raise InputError(
            f"contact law '{name}' needs {', '.join(known)} but got {', '.join(values) or 'nothing'}"
        ) from None
    return law


def _number(name: str, spec: ContactSpec, key: str, value: Given) -> float:
    """SI number of one value; text is read in the dimension that the law's table gives its key."""
    if not isinstance(value, str):
        return value  # type: ignore[return-value]
    field = spec.table.model_fields.get(key)
    dimension = next(
        (one.dimension for one in (field.metadata if field else ()) if isinstance(one, Quantity)),
        None,
    )
    return parse_quantity(value, dimension, f"{key} of contact law '{name}'")
