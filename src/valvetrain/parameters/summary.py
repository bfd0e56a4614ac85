"""The values of a case as text: numbers and curves in the units in which they are usually given."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from typing import Any, get_args

from valvetrain import registry
from valvetrain.parameters.curves import Constant, PiecewiseLinear, Table
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import Material
from valvetrain.parameters.train import ContactParameters
from valvetrain.units import dimension_of, parse_quantities, si, unit_factor

#: Size below which a number, in any unit that is shown, is rounding alone.
ROUNDING = 1e-12
#: Last word of a key path -> unit shown.
_UNITS = {
    "wire_diameter": "mm", "mean_diameter": "mm", "outer_diameter": "mm", "pitch": "mm", "precompression": "mm", "installed_height": "mm",
    "ratio_frequency": "Hz", "engine_speeds": "rpm", "red_line": "rpm", "inactive_coils": "turns", "ground_coils": "turns", "total_coils": "turns",
    "youngs_modulus": "GPa", "shear_modulus": "GPa", "density": "kg/m^3", "mass_damping": "1/s", "stiffness_damping": "s",
    "maximum_lift": "mm", "ramp_lift": "mm", "ramp_start": "deg", "event_start": "deg", "nose": "deg", "lifts": "mm", "cam_angles": "deg",
    "rate": "N/mm", "preload": "N", "mass": "g", "open_load": "N", "open_lift": "mm", "solid_height": "mm", "cam_speeds": "rpm",
    "force_bandwidth": "kHz",
    "lash": "mm", "base_radius": "mm", "width": "mm", "radius": "mm", "rod_length": "mm", "clearance": "mm", "offset": "mm",
    "pivot": "mm", "lower_end": "mm", "drive_arm": "mm", "valve_arm": "mm", "tip_radius": "mm", "full_damping_depth": "mm",
    "drive_angle": "deg", "valve_angle": "deg", "direction": "deg", "opening_direction": "deg", "tilt": "deg", "face_diameter": "mm",
    "top_dead_centre": "deg", "valve_inclination": "deg", "inertia": "kg mm^2", "holding_torque": "N m", "friction": "N",
    "stiffness": "kN/mm", "stem_stiffness": "kN/mm", "damping": "N s/m", "stem_damping": "N s/m", "valve_damping": "N s/m",
    "normal_force": "N", "damping_time": "s", "output_step": "deg", "time_step": "s", "card_lift": "mm", "friction_velocity": "m/s",
}  # fmt: skip

#: Last word of a key path -> dimension, where its unit measures several.
_DIMENSIONS = {
    "youngs_modulus": "modulus",
    "shear_modulus": "modulus",
    "mass_damping": "damping rate",
}


#: Dimension of a lift law's number -> unit shown.
_LIFT_UNITS = {
    "angle": "deg", "length": "mm", "mass": "kg", "stiffness": "N/mm", "angular speed": "rpm", "cam velocity": "mm/deg",
    "cam acceleration": "mm/deg^2",
}  # fmt: skip


def _unit_at(keys: list[str]) -> str:
    """Unit that the value at the keys of a path is shown in; empty where none is known."""
    if keys[-2:] == ["contact", "stiffness"]:
        return "N/mm^2"
    if keys[-1] not in _UNITS and "lift_law" in keys:
        return _LIFT_UNITS.get(_lift_dimensions().get(keys[-1], ""), "")
    return _UNITS.get(keys[-1], "")


@cache
def _lift_dimensions() -> Mapping[str, str]:
    """Dimension of each number of any kind of lift law, by key."""
    from valvetrain.parameters.schema_types import Quantity

    found: dict[str, str] = {}
    for word in registry.names("lifts"):
        for name, one in registry.find("lifts", word).table.model_fields.items():
            kinds = (
                *one.metadata,
                *(
                    note
                    for part in get_args(one.annotation)
                    for note in getattr(part, "__metadata__", ())
                ),
            )
            for kind in kinds:
                if isinstance(kind, Quantity) and kind.dimension:
                    found[name] = kind.dimension
    return found


def si_at(path: str, value: Any) -> Any:
    """A value for a key path as given, text with a unit or a pint quantity made SI; others, and
    those their part reads itself, as they are.

    Raises :class:`valvetrain.errors.InputError` for a wrong or missing unit.
    """
    keys = path.split(".")
    unit = _unit_at(keys) or "turns"
    # speeds are read by Operation, a contact's numbers by their law
    if (
        unit in ("turns", "rpm")
        or "contacts" in keys
        or not (isinstance(value, str) or hasattr(value, "to_base_units"))
    ):
        return value
    dimension = dimension_of(unit)
    assert dimension is not None
    if isinstance(value, str) and "," in value:
        return parse_quantities(value, dimension, path)
    return si(value, _DIMENSIONS.get(keys[-1], dimension), path)


def value_text_at(holder: Any, path: str) -> str:
    """The value at a key path below ``holder`` as text; empty where it is stored in another form
    than the file's.
    """
    item, keys = holder, path.split(".")
    for key in keys:
        item = _part(item, key)
        if item is None:
            return ""
    return value_text(item, keys[-1], _unit_at(keys))


def _part(item: Any, key: str) -> Any:
    if isinstance(item, (list, tuple)):
        if not key.isdigit():  # a set of one spring may be written in the file as a table
            return _part(item[0], key) if len(item) == 1 else None
        return item[int(key)] if int(key) < len(item) else None
    for holder in (item, *((item.wire, item.card) if isinstance(item, InstalledSpring) else ())):
        if hasattr(holder, key):
            return getattr(holder, key)
    if isinstance(item, Mapping):
        return item.get(key)
    values = getattr(item, "values", None)  # a law stores the values of its kind in one mapping
    return values.get(key) if isinstance(values, Mapping) else None


def value_text(item: Any, key: str, unit: str = "") -> str:
    """One value as text: numbers and curves in ``unit``, by default the one its key is shown in,
    others in short words.
    """
    unit = unit or _UNITS.get(key, "")
    if isinstance(item, bool) or item is None:
        return "" if item is None else str(item).lower()
    if isinstance(item, (int, float)):
        return _number(float(item), unit)
    if isinstance(item, Constant):
        return _number(item.level, unit)
    if isinstance(item, (PiecewiseLinear, Table)):
        pairs = ", ".join(
            f"{number(_shown(value, unit))} at {coil:g}"
            for coil, value in zip(item.coils, item.values, strict=True)
        )
        return f"{pairs} ({unit} at coil number)"
    if isinstance(item, tuple) and all(isinstance(entry, (int, float)) for entry in item):
        return ", ".join(number(_shown(float(entry), unit)) for entry in item) + (
            f" {unit}" if unit else ""
        )
    if isinstance(item, Material):
        parts = (
            ("E", item.youngs_modulus, "GPa"),
            ("G", item.shear_modulus, "GPa"),
            ("density", item.density, "kg/m^3"),
        )
        return f"{item.name}: " + ", ".join(
            f"{name} {_number(value, shown)}" for name, value, shown in parts
        )
    if isinstance(item, str):
        return item
    if isinstance(item, ContactParameters):
        return _contact_text(item)
    if (
        is_dataclass(item)
        and type(item).__name__.endswith("Parameters")
        and not hasattr(item, "kind")
    ):
        own = [
            (one.name, getattr(item, one.name))
            for one in fields(item)
            if getattr(item, one.name) != _default(one)
        ]
        return ", ".join(
            f"{name.replace('_', ' ')} {value_text(value, name)}" for name, value in own
        )
    return str(getattr(item, "kind", type(item).__name__)).replace("_", " ")


def _default(one: Field[Any]) -> Any:
    return None if one.default is MISSING else one.default


def _contact_text(contact: ContactParameters) -> str:
    """A contact law with its numbers as given; the unit of K d^n depends on the exponent, that of
    the damping on its meaning.
    """
    spec = registry.find("contacts", contact.law)
    own = {one.name: one.default for one in fields(spec.law)}
    exponent = contact.stiffness_exponent or float(
        contact.values.get("exponent", own.get("exponent", 1.0))
    )
    parts = [contact.law]
    for key, value in contact.values.items():
        if key == "contact_stiffness":
            shown = (
                _number(value, "kN/mm")
                if exponent == 1.0
                else f"{number(value)} N/m^{number(exponent, 3)}"
            )
        elif key == "damping" and (contact.damping_unit or spec.damping_unit) == "s/m":
            shown = f"{number(value)} s/m"
        else:
            shown = value_text(value, key)
        parts.append(f"{key.replace('_', ' ')} {shown}")
    return ", ".join(parts)


def _shown(value: float, unit: str) -> float:
    return value if unit in ("", "turns", "s", "1/s") else in_unit(value, unit)


def _number(value: float, unit: str) -> str:
    return f"{number(_shown(value, unit))} {unit_text(unit)}".strip()


def in_unit(value: float, unit: str) -> float:
    """SI ``value`` in ``unit``; raises :class:`valvetrain.errors.InputError` for an unknown unit."""
    return value / unit_factor(unit) if unit not in ("", "1") else value


def number(value: float | None, digits: int = 4) -> str:
    """A number with ``digits`` significant digits, a real minus sign, and powers of ten as such; a
    dash for None, 0 for what rounding of sums leaves (below :data:`ROUNDING`).
    """
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    size = abs(value)
    if size < ROUNDING:
        return "0"
    if size >= 1e6 or size < 1e-4:
        mantissa, power = f"{value:.{max(digits - 2, 1)}e}".split("e")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return f"{mantissa.rstrip('0').rstrip('.')}·10{raised}".replace("-", "−")
    decimals = max(0, digits - 1 - math.floor(math.log10(size)))
    text = f"{value:.{min(decimals, 6)}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return text.replace("-", "−")


def share_text(share: float) -> str:
    """A share in per cent with two digits.

    >>> share_text(0.264), share_text(1e-5)
    ('26 %', '0.001 %')
    """
    return f"{number(100 * share, 2)} %"


def percent(share: float) -> str:
    """A share as a signed percentage with one decimal; what rounds to zero has no sign.

    >>> percent(0.035), percent(-0.0713), percent(-0.0002)
    ('+3.5 %', '−7.1 %', '0.0 %')
    """
    text = f"{100 * share:+.1f}"
    return ("0.0" if float(text) == 0 else text.replace("-", "−")) + " %"


def unit_text(unit: str) -> str:
    """A unit as printed: ``mm/s^2`` -> ``mm/s²``, ``us`` -> ``µs``, ``um`` -> ``µm``."""
    return unit.replace("^2", "²").replace("^3", "³").replace("us", "µs").replace("um", "µm")
