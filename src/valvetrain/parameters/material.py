"""Elastic material of a wire or a part."""

from __future__ import annotations

import math
from dataclasses import InitVar
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.schema_types import (
    FOLLOWS,
    Density,
    Modulus,
    Name,
    Table,
    guarded,
    problem,
    quantity,
    table,
)

PoissonRatio = Annotated[float, quantity("ratio", low=-1.0, high=0.5)]


@table("the material")
class Material(Table):
    """Isotropic elastic material: moduli in Pa, density in kg/m3; each given in SI or with its unit.

    What is left out is that of the library's material of this ``name``; the shear modulus also
    follows from Young's modulus and ``poisson_ratio``. Raises :class:`InputError` for values that are
    not positive, slips of units or moduli that no isotropic solid has.

    >>> Material("a steel", "206 GPa", "79.6 GPa", "7850 kg/m^3").density
    7850.0
    """

    name: Name = ""
    youngs_modulus: Modulus = Field(default=FOLLOWS)
    shear_modulus: Modulus = Field(default=FOLLOWS)
    density: Density = Field(default=FOLLOWS)
    ratio: InitVar[PoissonRatio | None] = Field(default=None, alias="poisson_ratio")

    def __post_init__(self, ratio: float | None) -> None:
        values: dict[str, Any] = {
            "youngs_modulus": self.youngs_modulus, "shear_modulus": self.shear_modulus, "density": self.density,
        }  # fmt: skip
        young, shear = self.youngs_modulus, self.shear_modulus
        if ratio is not None and young is not None:
            by_ratio = young / (2 * (1 + ratio)) if ratio > -1 else math.inf
            if shear is None:
                values["shear_modulus"] = by_ratio
            elif abs(shear / by_ratio - 1) > 0.005:
                raise problem(
                    f"shear_modulus {shear / 1e9:g} GPa contradicts youngs_modulus and poisson_ratio, "
                    f"which make {by_ratio / 1e9:.4g} GPa; drop one"
                )
        name = self.name or "unnamed"
        if None in values.values():
            if not self.name:
                raise problem(
                    "a material needs youngs_modulus, shear_modulus (or poisson_ratio) and density, or a name from the library"
                )
            of_library = guarded(material_by_name, self.name)
            name = name if any(values.values()) else of_library.name
            values = {key: value or getattr(of_library, key) for key, value in values.items()}
        for key, value in {**values, "name": name}.items():
            object.__setattr__(self, key, value)
        if not -1.0 < self.poisson_ratio < 0.5:
            raise problem(
                f"material '{self.name}' has E / (2 G) - 1 = {self.poisson_ratio:.3f}, outside -1 to 0.5; check Young's and shear modulus"
            )

    @property
    def poisson_ratio(self) -> float:
        """Poisson ratio nu = E / (2 G) - 1 of the isotropic solid."""
        return self.youngs_modulus / (2 * self.shear_modulus) - 1


#: A material in a file: a table, or the name of one of the library alone.
MaterialField = Annotated[
    Material, BeforeValidator(lambda raw: {"name": raw} if isinstance(raw, str) else raw)
]


OTEVA_90_SC = Material("OTEVA 90 SC", 206e9, 79.6e9, 7850.0)


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
#: Names of the trade for these wires, as wire merchants list them (metalleschmidt.de, diamondwire.com).
TRADE_NAMES = {
    **dict.fromkeys(("chrome silicon", "CrSi", "SiCr", "SAE 9254", "ASTM A877", "OTEVA 70"), "EN 10270-2 VDSiCr"),
    **dict.fromkeys(("chrome vanadium", "CrV", "ASTM A232"), "EN 10270-2 VDCrV"),
    "carbon valve": "EN 10270-2 VDC", "ASTM A230": "EN 10270-2 VDC",
    **dict.fromkeys(("music wire", "piano wire", "ASTM A228"), "EN 10270-1 SH"),
    "AISI 302": "EN 10270-3 1.4310", "17-7 PH": "EN 10270-3 1.4568",
}  # fmt: skip


def material_by_name(name: str) -> Material:
    """The library material ``name``, capitals, spaces and the number of its standard ignored; names of the trade too. Raises
    :class:`InputError` naming the nearest ones.

    >>> material_by_name("VDSiCr").name, material_by_name("chrome-silicon").name
    ('EN 10270-2 VDSiCr', 'EN 10270-2 VDSiCr')
    """
    word = _key(name)
    names = {known: known for known in MATERIALS} | TRADE_NAMES
    found = {_key(known): MATERIALS[full] for known, full in names.items()}.get(word)
    ends = [one for known, one in MATERIALS.items() if _key(known.split()[-1]) == word]
    if found is None and len(ends) == 1:
        found = ends[0]
    if found is None:
        begun = tuple(known for known in names if _key(known).startswith(word))
        raise InputError(
            f"material '{name[:40]}' is not in the library; {nearest(name, begun or tuple(names))}"
        )
    return found


def _key(name: str) -> str:
    return "".join(char for char in name.casefold() if char.isalnum())


#: Wire -> (largest diameter in mm, least tensile strength in MPa), rising: EN 10270-2:2011 as in the data
#: sheet of Penthor 864, and the maker's data sheet of OTEVA 91 SC (docs/limits.md).
_STRENGTHS: dict[str, tuple[tuple[float, float], ...]] = {
    "EN 10270-2 VDSiCr": ((1.3, 2080.0), (1.6, 2060.0), (2.0, 2010.0), (2.5, 1960.0), (3.5, 1910.0), (4.5, 1860.0), (5.6, 1810.0), (6.5, 1760.0)),
    "OTEVA 91 SC": ((2.5, 2180.0), (3.2, 2130.0), (4.0, 2080.0), (5.0, 2030.0), (6.0, 1980.0), (7.0, 1910.0), (10.0, 1860.0)),
}  # fmt: skip
#: Uncorrected shear that cold coiled springs are permitted with their coils closed, over tensile
#: strength (EN 13906-1:2013, 10.1.1).
PERMITTED_SHEAR = 0.56
#: Surface -> least and largest corrected shear (Pa) of the cycles that springs of carbon and alloy steel
#: below 10 mm bore without end, whatever their strength: 20 to 90 and 20 to 135 kpsi (zimmerli1957).
FATIGUE_RANGES = {"not peened": (137.9e6, 620.5e6), "shot-peened": (137.9e6, 930.8e6)}


def tensile_strength(material: Material, wire_diameter: float) -> float | None:
    """Least tensile strength (Pa) of a wire of the library by its diameter (m); None where unknown.

    >>> tensile_strength(material_by_name("EN 10270-2 VDSiCr"), 4.0e-3)
    1860000000.0
    """
    if MATERIALS.get(material.name) != material:
        return None
    rows = _STRENGTHS.get(material.name, ())
    strength = next((one for most, one in rows if wire_diameter * 1e3 <= most * (1 + 1e-9)), None)
    return None if strength is None else strength * 1e6
