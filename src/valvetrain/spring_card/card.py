"""A spring as a catalogue gives it, and the wires that its numbers leave possible."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.card_doubts import doubtful_turns
from valvetrain.parameters.curves import (
    RAMP,
    Constant,
    Curve,
    PiecewiseLinear,
    pitch_with_closed_turns,
)
from valvetrain.parameters.material import MATERIALS, Material
from valvetrain.parameters.schema_types import Mass, Table, problem, quantity, table
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import TEXTBOOK_TURNS, EndCoil
from valvetrain.units import Given, keep_si

#: Wire of a card that names no material.
DEFAULT_MATERIAL = MATERIALS["EN 10270-2 VDSiCr"]
#: Inactive turns at either end where the card does not give how many turns there are, ground turns
#: where no solid height is given.
INACTIVE, GROUND = TEXTBOOK_TURNS["closed-ground"]
#: Inactive turns at one end that a closed end can have, and ground turns that a solid height may
#: require.
POSSIBLE_INACTIVE, POSSIBLE_GROUND = (RAMP / 2, 3.0), (0.2, 1.0)


@dataclass(frozen=True, slots=True)
class SpringLoad:
    """``force`` (N) of a spring at a ``height`` (m) between its seats; SI, text with a unit or pint
    quantities.

    >>> SpringLoad("1.25 in", "350 lbf").height
    0.03175
    """

    height: float
    force: float

    if TYPE_CHECKING:  # accepted types are wider than the stored one

        def __init__(self, height: Given, force: Given) -> None: ...

    def __post_init__(self) -> None:
        keep_si(self, "a load of a spring", height="spring_length", force="force")
        if not (self.height > 0 and self.force >= 0):
            raise InputError(
                f"a load of {self.force:g} N at {self.height * 1e3:g} mm is none of a valve spring; correct the load"
            )


CardLength = Annotated[float, quantity("length", low=1e-6, high=1e3)]


@table("the card")
class CatalogueCard(Table):
    """A spring with closed and ground ends by its catalogue card.

    Parameters
    ----------
    wire_diameter, outer_diameter : of the round wire and of the coils, lengths
    installed_load, open_load : :class:`SpringLoad` at two heights, the higher one first
    top_outer_diameter : of a beehive, its narrow end, a length; the coils taper from
        ``taper_from_coil`` on, half of them where not given
    solid_height, mass, free_length, total_coils : where the card gives them
    material : of the wire; EN 10270-2 VDSiCr where the card names none
    name : word for the spring

    Raises
    ------
    InputError : numbers that contradict each other or can only be slips of units

    Examples
    --------
    >>> low, high = SpringLoad("46 mm", "350 N"), SpringLoad("34 mm", "830 N")
    >>> round(CatalogueCard(wire_diameter="4.2 mm", outer_diameter="32 mm", installed_load=low, open_load=high).rate)
    40000
    """

    wire_diameter: CardLength
    outer_diameter: CardLength
    installed_load: SpringLoad
    open_load: SpringLoad
    top_outer_diameter: CardLength | None = None
    taper_from_coil: Annotated[float, quantity("ratio", low=0.0, high=1e3)] | None = None
    solid_height: CardLength | None = None
    mass: Mass | None = None
    free_length: CardLength | None = None
    total_coils: Annotated[float, quantity("ratio", low=1e-6, high=1e3)] | None = None
    material: Material | None = None
    name: str = "spring"

    def __post_init__(self) -> None:
        low, high = self.installed_load, self.open_load
        if not (low.height > high.height and high.force > low.force):
            raise problem(
                "the second load of a card is the larger one, at the smaller height; exchange or correct them"
            )
        if self.solid_height is not None and self.solid_height >= high.height:
            raise problem("the solid height is above that of the second load; correct one of them")
        if self.free_length is not None and self.free_length <= low.height:
            raise problem(
                "the free length is no longer than the height of the first load; correct one of them"
            )
        for key in ("outer_diameter", "top_outer_diameter"):
            if (coil := getattr(self, key)) is not None and coil < 3 * self.wire_diameter:
                raise problem(
                    f"{key} is less than three wires, an index below 2; check both and their units"
                )

    @property
    def rate(self) -> float:
        """Secant rate (N/m) between the two loads."""
        return (self.open_load.force - self.installed_load.force) / (
            self.installed_load.height - self.open_load.height
        )

    @property
    def length(self) -> float:
        """Free length (m) that both loads make with a straight curve."""
        return self.installed_load.height + self.installed_load.force / self.rate

    @property
    def wire(self) -> Material:
        """Material of the wire, the default one where the card names none."""
        return self.material or DEFAULT_MATERIAL

    def mean_diameter(self, total_coils: float) -> Curve:
        """Mean coil diameter (m) over the coil number."""
        full = self.outer_diameter - self.wire_diameter
        if self.top_outer_diameter is None:
            return Constant(full)
        taper = total_coils / 2 if self.taper_from_coil is None else self.taper_from_coil
        if not 0 <= taper < total_coils:
            raise InputError(
                f"taper_from_coil is {taper:g} of {total_coils:.3g} turns; the taper begins below the top",
                "taper_from_coil",
            )
        knots, levels = (
            (0.0, taper, total_coils),
            (full, full, self.top_outer_diameter - self.wire_diameter),
        )
        return PiecewiseLinear(knots[taper == 0 :], levels[taper == 0 :])


@dataclass(frozen=True, slots=True)
class Winding:
    """What a card leaves to be found: all turns, inactive and ground turns at either end, and the
    free length (m).
    """

    total_coils: float
    inactive: float
    ground: float
    free_length: float

    def wound(self, card: CatalogueCard) -> SpringDefinition:
        """The spring, its pitch constant between the closed ends. Raises :class:`InputError` for
        one that cannot be wound.
        """
        wire, closed = card.wire_diameter, self.inactive - RAMP / 2
        end = EndCoil("closed-ground", self.inactive, self.ground)

        def law(pitch: float) -> PiecewiseLinear:
            return pitch_with_closed_turns(self.total_coils, wire, pitch, closed, closed, RAMP)

        def length(pitch: float) -> float:
            return (
                float(
                    np.diff(
                        law(pitch).integral(np.array([self.ground, self.total_coils - self.ground]))
                    )[0]
                )
                + wire
            )

        solid, slope = length(wire), (length(2 * wire) - length(wire)) / wire
        pitch = wire + (self.free_length - solid) / slope
        if pitch <= wire:
            raise InputError(
                f"{self.total_coils:.3g} turns of {wire * 1e3:.4g} mm wire are solid at {solid * 1e3:.4g} mm, but the loads make a "
                f"free length of {self.free_length * 1e3:.4g} mm; check heights, loads and wire"
            )
        diameter = card.mean_diameter(self.total_coils)
        return SpringDefinition(
            Constant(wire),
            diameter,
            law(pitch),
            total_coils=self.total_coils,
            material=card.wire,
            lower_end=end,
            upper_end=end,
            name=card.name,
            solid_height=card.solid_height,
        )


def first_winding(card: CatalogueCard) -> Winding:
    """Turns and free length by the formulas of the trade: the rate by torsion of the wire (EN
    13906-1), the turns by what is given.

    All turns are those given, else those of the mass, else of the solid height, else the active ones
    and one inactive turn at either end.
    Raises :class:`InputError` where they leave no closed ends to the active ones.
    """
    length = card.length
    total = _given_turns(card)
    if total is None:
        active = _active_turns(card, None)
        total = active + 2 * INACTIVE
        return Winding(total, INACTIVE, GROUND, length)
    _refuse_high_stack(card, total)
    inactive = (total - _active_turns(card, total)) / 2
    return Winding(
        total, check_inactive(card, total, inactive), ground_turns(card, total, inactive), length
    )


def _source_of_turns(card: CatalogueCard) -> str:
    return (
        "total_coils"
        if card.total_coils is not None
        else "mass"
        if card.mass is not None
        else "solid_height"
    )


def _refuse_high_stack(card: CatalogueCard, total: float) -> None:
    least = (total + 1 - 2 * POSSIBLE_GROUND[1]) * card.wire_diameter
    if card.top_outer_diameter is None and least > card.open_load.height:
        solid = (
            ""
            if card.solid_height is None
            else f" and the card has a solid height of {card.solid_height * 1e3:.4g} mm"
        )
        raise InputError(
            f"{_source_of_turns(card)} makes {total:.3g} turns, solid at {least * 1e3:.4g} mm or more, but the second load is given at "
            f"{card.open_load.height * 1e3:.4g} mm{solid}; check wire, diameters and {_source_of_turns(card)}",
            _source_of_turns(card),
        )


def check_inactive(card: CatalogueCard, total: float, inactive: float) -> float:
    """``inactive``; raises :class:`InputError` where no closed end has this many turns."""
    if POSSIBLE_INACTIVE[0] <= inactive <= POSSIBLE_INACTIVE[1]:
        return inactive
    source = _source_of_turns(card)
    raise InputError(
        f"{source} makes {total:.3g} turns and the loads {total - 2 * inactive:.3g} active ones, which leaves {inactive:.2g} inactive turns "
        f"at either end; a closed end has {POSSIBLE_INACTIVE[0]:g} to {POSSIBLE_INACTIVE[1]:g}: check wire, loads and {source}",
        source,
    )


def ground_turns(card: CatalogueCard, total: float, inactive: float) -> float:
    """Ground turns at either end by the solid height, where the turns are known otherwise; the
    textbook's where it does not fit.
    """
    if card.solid_height is None or (card.total_coils is None and card.mass is None):
        return GROUND
    ground = (total + 1 - card.solid_height / card.wire_diameter) / 2
    return ground if POSSIBLE_GROUND[0] <= ground <= min(POSSIBLE_GROUND[1], inactive) else GROUND


def ground_choices(card: CatalogueCard, winding: Winding) -> tuple[float, ...]:
    """Ground turns to try: those of the winding, then more where the card leaves the solid height
    open.
    """
    if card.solid_height is not None or card.total_coils is None:
        return (winding.ground,)
    more = (0.75, POSSIBLE_GROUND[1])
    return (winding.ground, *(one for one in more if one <= winding.inactive))


def doubt_of(card: CatalogueCard) -> str:
    """Why the loads are hardly those of one spring with this wire; empty where nothing is odd."""
    if card.top_outer_diameter is not None:
        return ""
    active = _active_turns(card, None)
    known = card.total_coils is not None or card.mass is not None
    turns = _given_turns(card) if known else None
    return doubtful_turns(active, card.wire_diameter, card.solid_height, turns)


def ground_off(turns: float) -> float:
    """Turns of whole wire that are ground away at one end: closed wire rises by its diameter per
    turn over the plane of the wheel.
    """
    depth = np.linspace(0.0, min(turns, 1.0), 201)
    lost = (np.arccos(1 - 2 * depth) - (1 - 2 * depth) * 2 * np.sqrt(depth * (1 - depth))) / np.pi
    return float(np.trapezoid(lost, depth))


def weight(spring: SpringDefinition) -> float:
    """Mass (kg) on the scales: of the wire less what is ground away at both ends."""
    mass = spring.mass
    for end, tip in ((spring.lower_end, 0.0), (spring.upper_end, spring.total_coils)):
        wire, turn = float(spring.wire_diameter.value(tip)), float(spring.line_speed(tip))
        mass -= spring.material.density * np.pi / 4 * wire**2 * turn * ground_off(end.ground_coils)
    return mass


def _given_turns(card: CatalogueCard) -> float | None:
    if card.total_coils is not None:
        return card.total_coils
    if card.mass is not None:
        return turns_of_mass(card, card.mass)
    return (
        None
        if card.solid_height is None
        else card.solid_height / card.wire_diameter + 2 * GROUND - 1
    )


def turns_of_mass(card: CatalogueCard, mass: float) -> float:
    """All turns of a spring of that mass (kg), what is ground away put back; fixed point in the
    slowly varying turns of a taper.
    """
    per_length = card.wire.density * np.pi / 4 * card.wire_diameter**2
    total = 8.0
    for _ in range(30):
        coil = np.linspace(0.0, total, 401)
        turn = float(
            np.hypot(np.pi * np.mean(card.mean_diameter(total).value(coil)), card.length / total)
        )
        total = float(np.clip(mass / (per_length * turn) + 2 * ground_off(GROUND), 1.0, 100.0))
    return total


def _active_turns(card: CatalogueCard, total: float | None) -> float:
    """Active turns that make the rate, 1/k = integral of 8 D^3 / (G d^4) du over the middle of the
    wire; Wahl's mean of a taper.
    """
    give = card.wire.shear_modulus * card.wire_diameter**4 / (8 * card.rate)
    if card.top_outer_diameter is None:
        return give / (card.outer_diameter - card.wire_diameter) ** 3
    turns = 6.0 if total is None else total
    for _ in range(60):
        whole = turns + 2 * INACTIVE if total is None else total
        coil = (
            np.linspace((whole - turns) / 2, (whole + turns) / 2, 401)
            if turns < whole
            else np.linspace(0.0, whole, 401)
        )
        turns = give / float(np.mean(card.mean_diameter(whole).value(coil) ** 3))
    return turns


def changed(winding: Winding, card: CatalogueCard, stretch: float, length: float) -> Winding:
    """The winding with its active turns times ``stretch`` and its free length longer by ``length``
    (m).
    """
    active = (winding.total_coils - 2 * winding.inactive) * stretch
    if _given_turns(card) is None:
        return replace(
            winding,
            total_coils=active + 2 * winding.inactive,
            free_length=winding.free_length + length,
        )
    inactive = check_inactive(card, winding.total_coils, (winding.total_coils - active) / 2)
    fitted = card.solid_height is not None
    ground = ground_turns(card, winding.total_coils, inactive) if fitted else winding.ground
    return replace(
        winding, inactive=inactive, ground=ground, free_length=winding.free_length + length
    )
