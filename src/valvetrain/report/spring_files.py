"""A spring as the block of a case file."""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import EndCoil
from valvetrain.parameters.toml_text import toml_text


def spring_text(name: str, spring: InstalledSpring, source: str) -> str:
    """A case that holds nothing but the spring; its block can be put into any case file. Raises :class:`InputError` for a card."""
    wire = spring.wire
    if wire is None:
        raise InputError(f"spring '{spring.name}' is known by its card only, so it has no wire to write")
    material = wire.material
    block: dict[str, Any] = {
        "name": wire.name, "wire_diameter": _curve(wire.wire_diameter), "mean_diameter": _curve(wire.mean_diameter),
        "total_coils": wire.total_coils, "pitch": _curve(wire.pitch), "lower_end": _end(wire.lower_end), "upper_end": _end(wire.upper_end),
        "material": {
            "name": material.name, "youngs_modulus": f"{material.youngs_modulus / 1e9!r} GPa",
            "shear_modulus": f"{material.shear_modulus / 1e9!r} GPa", "density": f"{material.density!r} kg/m^3",
        },
        "precompression": f"{spring.precompression!r} m", "seats": spring.seats,
    }  # fmt: skip
    if wire.hand != "right":
        block["hand"] = wire.hand
    return toml_text({"name": name, "title": f"{wire.name}, {source}", "spring": block})


def _end(end: EndCoil) -> dict[str, Any]:
    return {"kind": end.kind, "inactive_coils": end.inactive_coils, "ground_coils": end.ground_coils}


def _curve(curve: Curve) -> str | dict[str, Any]:
    if isinstance(curve, Constant):
        return f"{curve.level!r} m"
    assert isinstance(curve, PiecewiseLinear)
    coils, values = np.asarray(curve.coils, dtype=float), np.asarray(curve.values, dtype=float)
    return {"coils": coils.tolist(), "values": [f"{value!r} m" for value in values.tolist()]}
