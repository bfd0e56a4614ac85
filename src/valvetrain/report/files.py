"""Names of files that no two results share, whatever their labels hold."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import EndCoil
from valvetrain.parameters.toml_text import toml_text

#: Bytes of a name's stem, so that endings and the name of a temporary file next to it fit into the
#: 255 that file systems take.
MAX_LENGTH = 120


@dataclass
class FreeNames:
    """Free file names: labels that differ only in signs, case or accents written otherwise still
    get files of their own.

    >>> names = FreeNames()
    >>> names.free("x 1"), names.free("x/1"), names.free("X-1")
    ('x-1', 'x-1-2', 'X-1-3')
    """

    taken: set[str] = field(default_factory=set)

    def free(self, label: str) -> str:
        """A name of letters, digits, points and dashes that was not given before."""
        composed = unicodedata.normalize("NFC", label)
        plain = (
            "-".join(
                "".join(
                    char if char.isalnum() or char in ".+" else " " for char in composed
                ).split()
            ).strip(".-")
            or "run"
        )
        tries = (
            (plain, "") if number == 1 else (plain, f"-{number}")
            for number in range(1, len(self.taken) + 2)
        )
        name = next(
            one for label, ending in tries if _key(one := _short(label, ending)) not in self.taken
        )
        self.taken.add(_key(name))
        return name


def _key(name: str) -> str:
    """What two names share that some file system takes for one."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())


def _short(label: str, ending: str) -> str:
    """The words with the ending, cut to :data:`MAX_LENGTH` bytes; of long ones the end stays, where
    speed and number stand.
    """
    content = label.encode()
    room = MAX_LENGTH - len(ending)
    if len(content) > room:
        half = room // 2
        label = (
            content[:half].decode(errors="ignore")
            + "~"
            + content[half + 1 - room :].decode(errors="ignore")
        )
    return label + ending


def spring_text(name: str, spring: InstalledSpring, source: str) -> str:
    """A case that holds nothing but the spring; its block can be put into any case file. Raises
    :class:`InputError` for a card.
    """
    wire = spring.wire
    if wire is None:
        raise InputError(
            f"spring '{spring.name}' is known by its card only, so it has no wire to write"
        )
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
    return {
        "kind": end.kind,
        "inactive_coils": end.inactive_coils,
        "ground_coils": end.ground_coils,
    }


def _curve(curve: Curve) -> str | dict[str, Any]:
    if isinstance(curve, Constant):
        return f"{curve.level!r} m"
    assert isinstance(curve, PiecewiseLinear)
    coils, values = np.asarray(curve.coils, dtype=float), np.asarray(curve.values, dtype=float)
    return {"coils": coils.tolist(), "values": [f"{value!r} m" for value in values.tolist()]}
