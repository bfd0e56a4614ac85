"""Two cards of a dual spring whose loads are those of both together (``loads_of = "pair"``)."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any, Literal

from pydantic import Field, PrivateAttr

from valvetrain.errors import UnusualValueWarning
from valvetrain.parameters.dual_spring import Half, part
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_installed import CardBlock
from valvetrain.parameters.schema_spring import DEFAULT_MATERIAL, TotalCoils
from valvetrain.parameters.schema_types import (
    Force,
    PositiveLength,
    guarded,
    placed,
    problem,
    validate_as,
)

#: Of a closed and ground spring: turns that do not move, and those of its solid height.
INACTIVE = 2.0
#: Keys by which the total loads are given, in the first table.
LOADS = ("preload", "open_load", "open_lift", "open_height", "rate")


class PairedCard(CardBlock):
    """One spring of a pair; the first has the loads of both."""

    preload: Force = Field(default=0.0, description="of both springs together, in the first table")
    loads_of: Literal["pair"] = Field(
        default="pair", description="the loads are those of both springs"
    )
    total_coils: TotalCoils | None = Field(
        default=None, description="in place of active_coils, two of them at rest"
    )
    free_length: PositiveLength | None = Field(
        default=None, description="parts the preload; without any both are compressed alike"
    )
    _split: dict[str, float | str] = PrivateAttr(default_factory=dict)

    def installed(self, name: str, group: str = "") -> InstalledSpring:
        """The installed spring, with how its loads were found."""
        built = super().installed(name, group)
        assert built.card is not None
        return replace(built, card=replace(built.card, split=self._split))

    def refuse_free_length(self) -> None:
        """A free length of a pair splits its preload in addition to the loads; nothing is refused."""

    def _from_free(self, preload_height: float | None) -> float | None:
        return None

    def half(self, height: float) -> Half:
        """What the parting needs to know of it; ``height``: installed, where it has none of its own."""
        if self.mass is not None:
            raise problem(
                "the mass follows from both wires; change total_coils or wire_diameter, and leave mass out",
                ("mass",),
            )
        if self.preload_height is not None:
            raise problem(
                "loads of a pair are those at installed_height; leave preload_height out",
                ("preload_height",),
            )
        if self.wire_diameter is None:
            raise problem(
                "total loads are parted by both wires; give wire_diameter", ("wire_diameter",)
            )
        return Half(
            self.wire_diameter,
            self.mean_of(self.wire_diameter, "give mean_diameter or outer_diameter, one of them"),
            (self.material or DEFAULT_MATERIAL).shear_modulus,
            self.installed_height or height,
            self._turns(self.wire_diameter),
            self.free_length,
        )

    def _turns(self, wire: float) -> float | None:
        """Active turns, as given or by all turns or the solid height; None where nothing gives them."""
        if self.active_coils is not None:
            return self.active_coils
        total = self.total_coils
        if total is None and self.solid_height is not None:
            total = self.solid_height / wire
        if total is not None and total <= INACTIVE:
            raise problem(
                f"there are {total:.3g} turns in all, of which two are at rest; check turns, solid_height and wire_diameter",
                ("wire_diameter",),
            )
        return None if total is None else total - INACTIVE


def read_pair(entries: list[Any]) -> tuple[PairedCard, PairedCard]:
    """Both cards, each with its own loads; raises a located problem."""
    outer, inner = (validate_as(PairedCard, entry, (place,)) for place, entry in enumerate(entries))
    for key in LOADS:
        if key in inner.model_fields_set:
            raise problem(
                f"loads_of = 'pair' says that the loads of the first spring are those of both; leave {key} out here",
                (1, key),
            )
    if "preload" not in outer.model_fields_set or outer.preload <= 0:
        raise problem("the total preload of the pair is missing; add it", (0, "preload"))
    if outer.installed_height is None:
        raise problem("total loads are parted at installed_height; add it", (0, "installed_height"))
    height = outer.installed_height
    rate, lift = placed(0, outer._rate, height)
    placed(0, outer.refuse_open_solid, lift, height)
    halves = [placed(place, one.half, height) for place, one in enumerate((outer, inner))]
    found = guarded(part, rate, outer.preload, *halves)
    parted = []
    for place, one in enumerate((outer, inner)):
        own = {"preload": found.preloads[place], "rate": found.rates[place], "open_lift": lift}
        own |= {"active_coils": halves[place].active_coils or found.active_coils[place]}
        own |= {"installed_height": halves[place].installed_height}
        parted.append(one.model_copy(update={**own, "open_load": None, "open_height": None}))
    parted[0]._split = found.fields
    if doubt := doubtful_pair(found.rates, found.active_coils):
        warnings.warn(f"dual spring: {doubt}", UnusualValueWarning, stacklevel=2)
    return parted[0], parted[1]


def doubtful_pair(rates: tuple[float, float], turns: tuple[float, float]) -> str:
    """Why ``rates`` (N/m) and active ``turns`` of outer and inner are hardly those of a dual spring; empty where
    the outer one is the stiffer, as those of catalogues are.

    >>> doubtful_pair((38e3, 27e3), (4.2, 2.8))
    ''
    """
    if rates[1] <= rates[0]:
        return ""
    return (
        f"the inner spring would be the stiffer one ({rates[1] / 1e3:.3g} against {rates[0] / 1e3:.3g} N/mm, {turns[1]:.3g} active turns); those of "
        "catalogues are the softer: measure both wires, and count the turns of both"
    )
