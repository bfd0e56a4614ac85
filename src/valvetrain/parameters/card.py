"""A spring that is known by its catalogue card: loads, heights and what its mass follows from."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from copy import copy
from dataclasses import field
from typing import Any, Literal

import numpy as np
from pydantic import Field

from valvetrain.errors import UnusualValueWarning
from valvetrain.parameters.card_doubts import doubtful_surge, doubtful_turns
from valvetrain.parameters.material import MATERIALS, Material, MaterialField
from valvetrain.parameters.schema_types import (
    FOLLOWS,
    SUCH_AS,
    Force,
    Mass,
    Name,
    PositiveLength,
    Stiffness,
    Table,
    as_given,
    problem,
    table,
)
from valvetrain.parameters.spring import TotalCoils

#: A card of fewer active turns is a slip of units, and a chain of its mass could not be damped.
MIN_TURNS = 0.3
#: Turns of a closed and ground spring that do not move, both ends together.
INACTIVE = 2.0
#: Of a card that names no material.
DEFAULT_MATERIAL = MATERIALS["EN 10270-2 VDSiCr"]


@table("the card")
class SpringCard(Table):
    """A spring known only by its catalogue card: ``rate`` (N/m), ``preload`` at the seat (N), the
    rest where known (kg, m, N).

    Rate, load and lift follow from two loads, their heights or a free length; the mass from wire and coils. Of a pair
    (``loads_of``) they follow from both cards (:mod:`valvetrain.parameters.dual_spring`); ``split`` then says how.
    ``doubt``: why the turns that give the rate are hardly those of one spring.

    >>> card = SpringCard(preload="250 N", open_load="600 N", open_height="30 mm", installed_height="40 mm")
    >>> round(card.rate), round(card.open_lift, 6)
    (35000, 0.01)
    """

    rate: Stiffness = Field(default=FOLLOWS)
    preload: Force = Field(default=FOLLOWS)
    mass: Mass | None = Field(
        default=None, description="that vibrates; without it from wire and coils"
    )
    installed_height: PositiveLength | None = Field(
        default=None, description="without it preload_height"
    )
    open_load: Force | None = None
    open_lift: PositiveLength | None = None
    solid_height: PositiveLength | None = Field(default=None, description="at coil bind")
    name: Name = Field(default=FOLLOWS)
    preload_height: PositiveLength | None = as_given(
        default=None, description="at which preload is given; without it installed_height"
    )
    open_height: PositiveLength | None = as_given(
        default=None, description="at which open_load is given, in place of open_lift"
    )
    free_length: PositiveLength | None = as_given(
        default=None,
        description="in place of rate: preload over the way to its height; parts the preload of a pair",
    )
    wire_diameter: PositiveLength | None = as_given(default=None, description="for the mass")
    mean_diameter: PositiveLength | None = as_given(default=None, description="for the mass")
    outer_diameter: PositiveLength | None = as_given(
        default=None, description="for the mass, in place of mean_diameter"
    )
    active_coils: TotalCoils | None = as_given(
        default=None, description="for the mass; without them as many as give the rate"
    )
    material: MaterialField | None = as_given(
        default=None, description="for the mass; without it EN 10270-2 VDSiCr"
    )
    loads_of: Literal["pair"] | None = as_given(
        default=None, description="loads are those of both springs"
    )
    total_coils: TotalCoils | None = as_given(
        default=None, description="of a pair, in place of active_coils, two of them at rest"
    )
    split: Mapping[str, float | str] = field(default_factory=dict, compare=False, init=False)
    doubt: str = field(default="", compare=False, init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", self.name or "spring card")
        if self.loads_of is None:
            self._derive()

    def replace(self, **changes: Any) -> SpringCard:
        """A copy with the named fields changed; nothing follows from them."""
        changed = copy(self)
        changed.__dict__.update(changes)
        return changed

    def parted(self, split: Mapping[str, float | str], **loads: float | None) -> SpringCard:
        """The card of one spring of a pair with ``loads`` of its own, which were found as ``split`` says."""
        single = self.replace(
            split=split, loads_of=None, free_length=None, open_load=None, open_height=None, **loads
        )
        single._derive()
        return single

    @property
    def surge_frequency(self) -> float | None:
        """First surge frequency (Hz), both ends fixed: 0.5 sqrt(rate / mass); None without a mass."""
        return None if self.mass is None else 0.5 * math.sqrt(self.rate / self.mass)

    @property
    def steel(self) -> Material:
        """Material of the wire, as given or the usual one."""
        return self.material or DEFAULT_MATERIAL

    @property
    def rate_of_one_coil(self) -> float:
        """Rate (N/m) of one active turn of the wire with the mean diameter, G d^4 / (8 D^3)."""
        wire, mean = self.wire_diameter or math.nan, self.mean_diameter or math.nan
        return self.steel.shear_modulus * wire**4 / (8 * mean**3)

    @property
    def wound_heights(self) -> tuple[float, float] | None:
        """Solid heights (m) of (n - 1) and of n wires on each other, between which that of n turns with closed ends is; None
        where the card has not both wire and turns.
        """
        turns = self.total_coils or (self.active_coils and self.active_coils + INACTIVE)
        if not turns or self.wire_diameter is None:
            return None
        return (turns - 1) * self.wire_diameter, turns * self.wire_diameter

    def _derive(self) -> None:
        """Loads as installed, from those that are given; refuses a rate that contradicts the loads."""
        if self.preload is None:
            raise problem(f"'preload' is missing; add it{SUCH_AS['preload']}", ("preload",))
        if self.preload < 0:
            raise problem("a preload is a compressive force, zero or more", ("preload",))
        preload_height, installed = self._heights()
        rate, lift = self.rate_and_lift(preload_height)
        preload = self.preload + (
            rate * (preload_height - installed)
            if preload_height is not None and installed is not None
            else 0.0
        )
        if preload < 0:
            raise problem(
                "the spring would be loose at this installed_height; install it lower",
                ("installed_height",),
            )
        if lift is not None and preload_height is not None and installed is not None:
            lift -= preload_height - installed
        load = None if lift is None else preload + rate * lift
        if (
            self.solid_height is not None
            and installed is not None
            and self.solid_height >= installed
        ):
            raise problem(
                "solid_height is not below installed_height; check both", ("solid_height",)
            )
        self.refuse_open_solid(lift, installed)
        values = {
            "rate": rate,
            "preload": preload,
            "installed_height": installed,
            "open_load": load
            if self.open_load is None or preload_height != installed
            else self.open_load,
            "open_lift": lift,
            "mass": self._mass(rate),
        }
        given = ("preload_height", "open_height", "free_length")  # they held for the loads as given
        self.__dict__.update(values | dict.fromkeys(given))

    def refuse_open_solid(self, open_lift: float | None, installed: float | None) -> None:
        """Refuse an open load at a height where the coils are closed already."""
        if open_lift is None or installed is None or self.solid_height is None:
            return
        if (height := installed - open_lift) < self.solid_height * (1 - 1e-9):
            key = "open_lift" if self.open_height is None else "open_height"
            made = "" if self.open_height is not None else " (by open_lift)"
            raise problem(
                f"the open load is given at {height * 1e3:.4g} mm{made}, but the spring is solid at {self.solid_height * 1e3:.4g} mm "
                f"(solid_height), where it cannot be pressed further; check both heights",
                (key,),
            )

    def _heights(self) -> tuple[float | None, float | None]:
        """Heights (m) at which the preload is stated and at which the spring is installed."""
        preload_height, installed = self.preload_height, self.installed_height
        return (installed if preload_height is None else preload_height), (
            preload_height if installed is None else installed
        )

    def rate_and_lift(self, preload_height: float | None) -> tuple[float, float | None]:
        """Rate (N/m) and the lift (m) from the preload to the open load, where it is specified."""
        load, lift = self.open_load, self._lift(preload_height)
        by_loads = None if load is None or lift is None else (load - self.preload) / lift
        if by_loads is not None and by_loads <= 0:
            raise problem(
                "open_load does not exceed preload, so the rate would not be positive; check both",
                ("open_load",),
            )
        if self.rate is not None:
            if self.free_length is not None and self.loads_of is None:
                raise problem(
                    "free_length gives the rate, which rate gives too; leave one of them out",
                    ("free_length",),
                )
            if by_loads is not None and abs(by_loads / self.rate - 1) > 0.02:
                raise problem(
                    f"rate {self.rate / 1e3:g} N/mm contradicts the loads, which make {by_loads / 1e3:.4g} N/mm; correct one of them",
                    ("rate",),
                )
            return self.rate, lift
        by_free = self._from_free(preload_height)
        if by_loads is None and by_free is None:
            raise problem(
                "the rate is missing; give rate, or open_load and open_lift or open_height, or free_length"
            )
        if by_loads is not None and by_free is not None and abs(by_free / by_loads - 1) > 0.05:
            warnings.warn(
                f"the loads of a spring make {by_loads / 1e3:.4g} N/mm, its free length and preload {by_free / 1e3:.4g} N/mm: "
                "it is progressive, or a number is wrong; the rate of the loads is taken",
                UnusualValueWarning,
                stacklevel=2,
            )
        return by_loads or by_free or 0.0, lift

    def _lift(self, preload_height: float | None) -> float | None:
        """Lift (m) from the preload to the open load, as given or by the heights of both."""
        if self.open_height is None:
            return self.open_lift
        if self.open_lift is not None:
            raise problem(
                "open_lift and open_height are both given and may contradict; give one",
                ("open_height",),
            )
        if preload_height is None:
            raise problem(
                "open_height needs the height of the preload; add installed_height",
                ("open_height",),
            )
        if self.open_height >= preload_height:
            raise problem(
                f"open_height is not below that of the preload ({preload_height * 1e3:.4g} mm); check both",
                ("open_height",),
            )
        return preload_height - self.open_height

    def _from_free(self, preload_height: float | None) -> float | None:
        """Rate (N/m) of the preload and the free length, as service manuals give them; None without one."""
        if self.free_length is None or self.loads_of is not None:
            return None
        if preload_height is None:
            raise problem(
                "free_length needs the height of the preload; add installed_height",
                ("free_length",),
            )
        if self.free_length <= preload_height or self.preload == 0:
            raise problem(
                f"free_length is not above the height of a preload ({preload_height * 1e3:.4g} mm); check both",
                ("free_length",),
            )
        return self.preload / (self.free_length - preload_height)

    def mean_of(self, needed: str) -> float:
        """Mean coil diameter (m); refuses two diameters or none, by the sentence ``needed``,
        and coils that are too narrow.
        """
        mean, outer, wire = self.mean_diameter, self.outer_diameter, self.wire_diameter or 0.0
        if (mean is None) == (outer is None):
            raise problem(needed, ("mean_diameter",))
        mean = mean if mean is not None else (outer or 0.0) - wire
        if mean <= 2 * wire:
            raise problem(
                "the coils are too narrow for this wire (index below 2); check diameters and units",
                ("wire_diameter",),
            )
        return mean

    def _mass(self, rate: float) -> float | None:
        """Mass (kg) that vibrates: as given, or of the active turns, rho pi^2 d^2 D n / 4; None
        where neither is given.
        """
        sizes = [one for one in (self.mean_diameter, self.outer_diameter) if one is not None]
        if self.wire_diameter is None and self.mass is None and (sizes or self.active_coils):
            raise problem(
                "the mass from wire and coils needs wire_diameter; add it, or mass",
                ("wire_diameter",),
            )
        if self.wire_diameter is None or (self.mass is not None and len(sizes) != 1):
            return self.mass
        mean = self.mean_of("the mass from wire and coils needs mean_diameter or outer_diameter; give one of them")  # fmt: skip
        by_rate = self.steel.shear_modulus * self.wire_diameter**4 / (8 * mean**3 * rate)
        if self.mass is None and by_rate < MIN_TURNS:
            raise problem(
                f"rate, wire and coil diameter make {by_rate:.2g} active turns, which no spring has; check wire_diameter, coil diameter, "
                "loads and their units",
                ("wire_diameter",),
            )
        by_wire = self.steel.density * np.pi**2 * self.wire_diameter**2 * mean / 4
        coils, mass = self.active_coils or by_rate, self.mass
        if mass is None and self.active_coils is None:
            doubt = doubtful_turns(by_rate, self.wire_diameter, self.solid_height, None)
            self.__dict__["doubt"] = doubt
        else:
            surge, of_wire = (
                0.5 * math.sqrt(rate / one) for one in (mass or by_wire * coils, by_wire * by_rate)
            )
            turns = self.active_coils if mass is None else None
            self.__dict__["doubt"] = doubtful_surge(surge, of_wire, by_rate, turns)
        if mass is None and not 0.7 < coils / by_rate < 1.4:
            raise problem(
                f"wire and coils make a rate of {rate * by_rate / coils / 1e3:.3g} N/mm, but the card has {rate / 1e3:.3g} N/mm, which "
                f"takes {by_rate:.3g} active coils; correct one of them, or give mass",
                ("wire_diameter",),
            )
        return float(by_wire * coils) if mass is None else mass
