"""Values that a table of a case begins with, each said to be assumed."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.annotations import split_notes
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.templates import template_text

#: Difference of diameters of nested springs, and of a spring and a bore (m); the gap on either side is half of it.
GAP = 1e-3
#: Share of the loads and of the mass of a spring that one inside it begins with, where both are known by their cards.
SHARE = 0.4
_SOURCE = "to begin with; put your own"
#: Parts of a train that may be absent -> label, what they are, values to begin with. The gas load begins without any force.
PARTS: dict[str, tuple[str, str, Mapping[str, str]]] = {
    "gas": ("Gas load", "force of the gas on the valve over the cam angle",
            {"cam_angles": "0, 90, 180, 270 deg", "forces": "0, 0, 0, 0 N"}),
    "crank": ("Crank and piston", "for the clearance of valve and piston",
              {"radius": "45 mm", "rod_length": "150 mm", "clearance": "8 mm", "top_dead_centre": "120 deg"}),
}  # fmt: skip


def assumed(value: Any) -> dict[str, Any]:
    """A value with a note that it is assumed."""
    return {"value": value, "status": "assumed", "source": _SOURCE}


def of_template(name: str) -> dict[str, Any]:
    """The table called ``name`` of the template of a spring alone."""
    found: dict[str, Any] = tomllib.loads(template_text("spring"))[name]
    return {"status": "assumed", "source": _SOURCE, **found}


def guide_of(spring: InstalledSpring) -> dict[str, Any]:
    """The guide of a ``spring`` by its wire: a bore around it. Raises :class:`InputError` for one known by its card."""
    return {"bore": assumed(_length(_outer(spring.wire) + GAP))}


def inner_spring(outer: InstalledSpring, given: Mapping[str, Any]) -> dict[str, Any]:
    """A spring that fits inside the ``outer`` one, whose table in the file is ``given``: as slender, of its material, wound the other way.

    By its card where the outer one is. Raises :class:`InputError` where none fits.
    """
    head = {"status": "assumed", "source": _SOURCE, "name": "inner" if outer.name != "inner" else "second"}
    if outer.wire is None:
        card = outer.card
        if card is None:
            raise InputError("the first spring is not known; give it first", "spring")
        mass = {} if card.mass is None else {"mass": f"{SHARE * card.mass * 1e3:.3g} g"}
        return head | {"preload": f"{SHARE * card.preload:.3g} N", "rate": f"{SHARE * card.rate / 1e3:.3g} N/mm"} | mass
    wire = outer.wire
    coil = np.linspace(0.0, wire.total_coils, 257)
    mean, thick = wire.mean_diameter.value(coil), wire.wire_diameter.value(coil)
    narrow = int(np.argmin(mean - thick))
    index = float(mean[narrow] / thick[narrow])
    inner_wire = (float(mean[narrow] - thick[narrow]) - GAP) / (index + 1)
    if inner_wire <= 0:
        raise InputError("no second spring fits inside this one; widen it first", "spring")
    bare, _, _ = split_notes({"material": given["material"]})  # its notes tell where the outer one's comes from
    height = {"precompression": _length(outer.precompression)}
    if "installed_height" in given:
        height = {"installed_height": _length(wire.free_length - outer.precompression)}
    return head | {
        "wire_diameter": _length(inner_wire), "mean_diameter": _length(index * inner_wire), "total_coils": float(f"{wire.total_coils:.4g}"),
        "free_length": _length(wire.free_length), "hand": "left" if wire.hand == "right" else "right", "material": bare["material"],
        "ends": "closed-ground", **height,
    }  # fmt: skip


def _outer(wire: SpringDefinition | None) -> float:
    """Largest outer diameter of a spring (m)."""
    if wire is None:
        raise InputError("a spring known by its card has no guide; give its wire", "guide")
    coil = np.linspace(0.0, wire.total_coils, 257)
    return float(np.max(wire.mean_diameter.value(coil) + wire.wire_diameter.value(coil)))


def _length(value: float) -> str:
    return f"{value * 1e3:.4g} mm"
