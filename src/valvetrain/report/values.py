"""The values of a case with their status, as rows for a page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any

from valvetrain.parameters.case import Case
from valvetrain.parameters.curves import Constant, PiecewiseLinear, Table
from valvetrain.parameters.material import Material
from valvetrain.report.words import in_unit, number, unit_words

#: Last word of a key path -> unit shown.
_UNITS = {
    "wire_diameter": "mm", "mean_diameter": "mm", "outer_diameter": "mm", "pitch": "mm", "precompression": "mm", "installed_height": "mm",
    "ratio_frequency": "Hz", "engine_speeds": "rpm", "inactive_coils": "turns", "ground_coils": "turns", "total_coils": "turns",
    "youngs_modulus": "GPa", "shear_modulus": "GPa", "density": "kg/m^3", "mass_damping": "1/s", "stiffness_damping": "s",
    "maximum_lift": "mm", "ramp_lift": "mm", "ramp_start": "deg", "event_start": "deg", "nose": "deg", "lifts": "mm", "cam_angles": "deg",
    "rate": "N/mm", "preload": "N", "mass": "g", "open_load": "N", "open_lift": "mm", "solid_height": "mm", "cam_speeds": "rpm",
    "lash": "mm", "base_radius": "mm", "width": "mm", "radius": "mm", "rod_length": "mm", "clearance": "mm", "offset": "mm",
    "pivot": "mm", "lower_end": "mm", "drive_arm": "mm", "valve_arm": "mm", "tip_radius": "mm", "full_damping_depth": "mm",
    "drive_angle": "deg", "valve_angle": "deg", "direction": "deg", "opening_direction": "deg", "tilt": "deg",
    "top_dead_centre": "deg", "valve_inclination": "deg", "inertia": "kg mm^2", "holding_torque": "N m", "friction": "N",
    "stiffness": "kN/mm", "stem_stiffness": "kN/mm", "damping": "N s/m", "stem_damping": "N s/m", "valve_damping": "N s/m",
    "rubbing_force": "N", "friction_velocity": "m/s",
}  # fmt: skip

#: Laws whose ``damping`` is the factor q (s/m) of F = K d^n (1 + q d').
_FACTOR_LAWS = ("hunt-crossley",)


def case_rows(case: Case) -> list[tuple[str, str, str, str]]:
    """Key path, value, status and source of everything in the case that carries a note, in the case's order."""
    return [(path, _value(case, path), note.status or "", note.source) for path, note in case.notes.items()]


def _value(case: Case, path: str) -> str:
    item: Any = case
    for key in path.split("."):
        if isinstance(item, (list, tuple)) and key.isdigit() and int(key) < len(item):
            item = item[int(key)]
        elif hasattr(item, key):
            item = getattr(item, key)
        elif isinstance(item, Mapping) and key in item:
            item = item[key]
        elif isinstance(getattr(item, "values", None), Mapping) and key in item.values:
            item = item.values[key]  # a lift law keeps the values of its kind in one mapping
        else:
            return ""
    words = value_words(item, path.rsplit(".", 1)[-1])
    return f"{words} (SI)" if path == "train.spring_options.contact_stiffness" else words


def value_words(item: Any, key: str) -> str:
    """One value as text: numbers and curves in the unit its key is shown in, others in short words."""
    unit = _UNITS.get(key, "")
    if isinstance(item, bool) or item is None:
        return "" if item is None else str(item).lower()
    if isinstance(item, (int, float)):
        return _number(float(item), unit)
    if isinstance(item, Constant):
        return _number(item.level, unit)
    if isinstance(item, (PiecewiseLinear, Table)):
        pairs = ", ".join(f"{number(_shown(value, unit))} at {coil:g}" for coil, value in zip(item.coils, item.values, strict=True))
        return f"{pairs} ({unit} at coil number)"
    if isinstance(item, tuple) and all(isinstance(entry, (int, float)) for entry in item):
        return ", ".join(number(_shown(float(entry), unit)) for entry in item) + (f" {unit}" if unit else "")
    if isinstance(item, Material):
        parts = (("E", item.youngs_modulus, "GPa"), ("G", item.shear_modulus, "GPa"), ("density", item.density, "kg/m^3"))
        return f"{item.name}: " + ", ".join(f"{name} {_number(value, shown)}" for name, value, shown in parts)
    if isinstance(item, str):
        return item
    if is_dataclass(item) and hasattr(item, "law") and hasattr(item, "values"):
        return _contact_words(item)
    if is_dataclass(item) and type(item).__name__.endswith("Parameters") and not hasattr(item, "kind"):
        own = [(one.name, getattr(item, one.name)) for one in fields(item) if getattr(item, one.name) != _default(one)]
        return ", ".join(f"{name.replace('_', ' ')} {value_words(value, name)}" for name, value in own)
    return str(getattr(item, "kind", type(item).__name__)).replace("_", " ")


def _default(one: Field[Any]) -> Any:
    return None if one.default is MISSING else one.default


def _contact_words(contact: Any) -> str:
    """A contact law with its numbers as given; the unit of K d^n depends on the exponent, that of the damping on what it stands for."""
    from valvetrain.contact.library import LAWS

    law, values = contact.law, contact.values
    defaults = {one.name: one.default for one in fields(LAWS[law])} if law in LAWS else {}
    exponent = contact.stiffness_exponent or float(values.get("exponent", defaults.get("exponent", 1.0)))
    words = [law]
    for key, value in values.items():
        if key == "contact_stiffness":
            shown = _number(value, "kN/mm") if exponent == 1.0 else f"{number(value)} N/m^{number(exponent, 3)}"
        elif key == "damping" and (contact.damping_unit == "s/m" if contact.damping_unit else law in _FACTOR_LAWS):
            shown = f"{number(value)} s/m"
        else:
            shown = value_words(value, key)
        words.append(f"{key.replace('_', ' ')} {shown}")
    return ", ".join(words)


def _shown(value: float, unit: str) -> float:
    return value if unit in ("", "turns", "s", "1/s") else in_unit(value, unit)


def _number(value: float, unit: str) -> str:
    return f"{number(_shown(value, unit))} {unit_words(unit)}".strip()
