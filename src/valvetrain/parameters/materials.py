"""Materials known by name. Moduli at room temperature; EN 13906-1 gives those of the standard wires."""

from __future__ import annotations

from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.material import OTEVA_90_SC, Material

_ALL = (
    OTEVA_90_SC,
    Material("OTEVA 91 SC", 206e9, 79.5e9, 7850.0),
    Material("EN 10270-1 SH", 206e9, 81.5e9, 7850.0),
    Material("EN 10270-2 VDC", 206e9, 79.5e9, 7850.0),
    Material("EN 10270-2 VDCrV", 206e9, 79.5e9, 7850.0),
    Material("EN 10270-2 VDSiCr", 206e9, 79.5e9, 7850.0),
    Material("EN 10270-3 1.4310", 185e9, 70.0e9, 7900.0),
    Material("EN 10270-3 1.4568", 195e9, 73.0e9, 7800.0),
    Material("AISI 4340", 205e9, 80.0e9, 7850.0),
)
MATERIALS: dict[str, Material] = {material.name: material for material in _ALL}


def material_by_name(name: str) -> Material:
    """The library material ``name``, capitals and spaces ignored. Raises :class:`InputError` naming the nearest ones."""
    found = {_key(known): material for known, material in MATERIALS.items()}.get(_key(name))
    if found is None:
        raise InputError(f"material '{name[:40]}' is not in the library; {nearest(name, tuple(MATERIALS))}")
    return found


def _key(name: str) -> str:
    return "".join(char for char in name.casefold() if char.isalnum())
