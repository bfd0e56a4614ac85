"""Values that a table begins with which a case does not have yet, each said to be assumed."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.templates import template_text

#: Difference of diameters of nested springs, and of a spring and a bore (m); the gap on either side
#: is half of it.
GAP = 1e-3
#: Share of the loads and of the mass of a spring that one inside it begins with, where both are
#: known by their cards.
SHARE = 0.4
ASSUMED: dict[str, Any] = {"status": "assumed", "source": "to begin with; put your own"}


@dataclass(frozen=True)
class Start:
    """A table that a case may get: words, what it is, and its first values where they do not depend on the case."""

    label: str
    help: str
    values: Mapping[str, Any] = field(default_factory=dict)


#: Last part of the key of a table -> how it begins. The gas load begins without any force.
STARTS = {
    "spring": Start("spring", "a spring by its wire"),
    "lift_law": Start("lift law", "the lift over the cam angle"),
    "guide": Start("guide", "a bore around the spring, or a rod inside it"),
    "gas": Start("gas load", "force of the gas on the valve over the cam angle",
                 {"cam_angles": "0, 90, 180, 270 deg", "forces": "0, 0, 0, 0 N"}),
    "crank": Start("crank and piston", "for the clearance of valve and piston",
                   {"radius": "45 mm", "rod_length": "150 mm", "clearance": "8 mm", "top_dead_centre": "120 deg"}),
}  # fmt: skip
#: Key of a lift law -> what it begins with where another kind does not give it.
LAW_STARTS = {
    "maximum_lift": "9 mm", "opening_start": "115 deg", "opening_end": "180 deg", "closing_start": "180 deg", "closing_end": "245 deg",
    "ramp_lift": "0.2 mm", "ramp_start": "100 deg", "event_start": "115 deg", "nose": "180 deg", "event_end": "245 deg", "ramp_end": "260 deg",
    "flank_shape": [1.0, 1.0, -1.0, -1.0], "base_radius": "16 mm", "nose_radius": "6 mm", "follower_radius": "10 mm",
    "valve_lift": "9 mm", "duration": "115 deg", "lift_of": "valve", "angle_of": "cam", "angle_unit": "deg", "lift_unit": "mm",
}  # fmt: skip
#: Kind of a lift law -> keys that it begins with, in addition to those that it cannot be without.
LAW_KEYS = {
    "three-arc": ("opening_start",), "cam-card": ("lift_of", "valve_lift", "duration"),
}  # fmt: skip
#: Keys with which a law begins that reads a file.
FILE_KEYS = ("lift_of", "angle_of", "angle_unit", "lift_unit")


def first_values(case: Case, tree: Mapping[str, Any], key: str) -> dict[str, Any]:
    """What the table at ``key`` begins with in ``case``, whose bare ``tree`` is as in its file.

    Raises :class:`InputError` for a second spring that has no room.
    """
    heads, name = key.split(".")[:-1], key.rpartition(".")[2]
    if name in ("spring", "lift_law"):
        return {**ASSUMED, **tomllib.loads(template_text("spring"))[name]}
    if name not in ("1", "guide"):
        return {**ASSUMED, **STARTS[name].values}
    springs, given = case.springs, tree["spring"] if heads[0] == "spring" else {}
    if case.train is not None:
        springs, given = case.train.springs[heads[2]], tree["train"]["springs"][heads[2]]
    place = int(heads[-1]) if name == "guide" and isinstance(given, list) else 0
    if name == "1":
        return ASSUMED | inner_spring(springs[0], given[0] if isinstance(given, list) else given)
    wire = springs[place].wire
    assert wire is not None  # a card has no guide
    outer = wire.outer_diameter(np.linspace(0.0, wire.total_coils, 257))
    return ASSUMED | {"bore": _length(float(np.max(outer)) + GAP)}


def inner_spring(outer: InstalledSpring, given: Mapping[str, Any]) -> dict[str, Any]:
    """A spring that fits inside the ``outer`` one, whose bare table in the file is ``given``: as
    slender, of its material, wound the other way; by its card where the outer one is.
    """
    name = {"name": "inner" if outer.name != "inner" else "second"}
    wire, card = outer.wire, outer.card
    if card is not None:
        mass = {} if card.mass is None else {"mass": f"{SHARE * card.mass * 1e3:.3g} g"}
        rate = f"{SHARE * card.rate / 1e3:.3g} N/mm"
        return name | {"preload": f"{SHARE * card.preload:.3g} N", "rate": rate} | mass
    assert wire is not None  # a spring has a card or a wire
    coil = np.linspace(0.0, wire.total_coils, 257)
    mean, thick = wire.mean_diameter.value(coil), wire.wire_diameter.value(coil)
    narrow = int(np.argmin(mean - thick))
    scale = (mean[narrow] - thick[narrow] - GAP) / (mean[narrow] + thick[narrow])
    if scale <= 0:
        raise InputError("no second spring fits inside this one; widen it first", "spring")
    height = {"precompression": _length(outer.precompression)}
    if "installed_height" in given:
        height = {"installed_height": _length(wire.free_length - outer.precompression)}
    return name | {
        "wire_diameter": _length(scale * thick[narrow]),
        "mean_diameter": _length(scale * mean[narrow]),
        "total_coils": float(f"{wire.total_coils:.4g}"),
        "free_length": _length(wire.free_length),
        "hand": "left" if wire.hand == "right" else "right",
        "material": given["material"],
        "ends": "closed-ground",
        **height,
    }


def _length(value: float) -> str:
    return f"{value * 1e3:.4g} mm"
