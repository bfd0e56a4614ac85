"""What users call the keys of a case file, for the answer to a key that no table has."""

from __future__ import annotations

import re

#: Name in use -> key that it means, the first that the table has.
SYNONYMS: dict[str, tuple[str, ...]] = {
    "seat_load": ("preload",), "seat_force": ("preload",), "seat_pressure": ("preload",), "closed_load": ("preload",),
    "closed_pressure": ("preload",), "installed_load": ("preload",), "open_force": ("open_load",), "open_pressure": ("open_load",),
    "nose_load": ("open_load",), "spring_rate": ("rate",), "stiffness": ("rate",), "coil_bind": ("solid_height",),
    "coil_bind_height": ("solid_height",), "bind_height": ("solid_height",), "block_height": ("solid_height",), "block_length": ("solid_height",),
    "fitted_height": ("installed_height",), "seat_height": ("installed_height",), "closed_height": ("installed_height",),
    "fitted_length": ("installed_height",), "wire": ("wire_diameter",), "wire_size": ("wire_diameter",), "od": ("outer_diameter",),
    "outside_diameter": ("outer_diameter",), "coil_diameter": ("mean_diameter", "outer_diameter"), "coils": ("active_coils", "total_coils"),
    "turns": ("active_coils", "total_coils"), "weight": ("mass",), "clearance": ("lash",), "valve_clearance": ("lash",),
    "tappet_clearance": ("lash",), "lift": ("valve_lift", "lobe_lift"), "cam_lift": ("lobe_lift",),
    "centreline": ("lobe_centre",), "centerline": ("lobe_centre",), "intake_centerline": ("lobe_centre",),
    "lobe_center": ("lobe_centre",), "rocker": ("rocker_ratio",), "seat_duration": ("advertised_duration",), "rpm": ("engine_speeds",),
    "speed": ("engine_speeds",), "speeds": ("engine_speeds",), "engine_speed": ("engine_speeds",), "rated_speed": ("red_line",),
    "redline": ("red_line",), "rev_limit": ("red_line",), "maximum_speed": ("red_line",), "maximum_engine_speed": ("red_line",),
    "base_circle": ("base_radius",),
    "base_diameter": ("base_radius",), "roller_radius": ("radius",), "roller_diameter": ("radius",), "arm": ("drive_arm", "valve_arm"),
}  # fmt: skip
#: Names of a diameter whose key is a radius.
_DIAMETERS = ("base_diameter", "base_circle", "roller_diameter")


#: Of a single lobe there is no separation, and taking it for the centreline would retard the cam.
_SEPARATION = "one lobe has no separation: give lobe_centre, its own centreline (of an intake the separation less the advance)"


#: Keys that are looked for at the top of a file -> where they belong.
BELONGS = {
    key: f"spring.options.finite-element.{key}" for key in ("time_step", "elements_per_coil")
}


def meant_key(name: str, valid: tuple[str, ...]) -> str:
    """A clause on the key of ``valid`` that ``name`` means; empty where it is none of the names in use.

    >>> meant_key("seat load", ("preload", "rate")), meant_key("OD", ("outer_diameter",)), meant_key("x", ("rate",))
    ('that is preload here', 'that is outer_diameter here', '')
    >>> meant_key("time_step", ("spring", "train"))
    'it belongs at spring.options.finite-element.time_step'
    >>> meant_key("lobe separation", ("lobe_centre",))[:28]
    'one lobe has no separation: '
    """
    word = re.sub(r"[\s-]+", "_", name[:60].strip().lower())
    if word in ("lobe_separation", "lsa", "separation") and "lobe_centre" in valid:
        return _SEPARATION
    key = next((one for one in SYNONYMS.get(word, ()) if one in valid), "")
    if not key:
        place = BELONGS.get(word, "") if "spring" in valid else ""
        return f"it belongs at {place}" if place else ""
    return f"that is {key} here" + (", half the diameter" if word in _DIAMETERS else "")
