"""A spring definition that meets a catalogue card by the finite-element rod, with what the card
left free.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.solution.display import Saveable
from valvetrain.spring_card.card import (
    GROUND,
    CatalogueCard,
    Winding,
    changed,
    doubt_of,
    first_winding,
    ground_choices,
    weight,
)
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.spec import spring_model

#: Share of its value to which each load of the card is met, and trials until then.
MET, TRIALS = 2e-4, 12


@dataclass(frozen=True, slots=True)
class CardDeviation:
    """One number of a card and that of the spring; SI, ``requested`` None where the card is silent."""

    quantity: str
    requested: float | None
    found: float


@dataclass(frozen=True)
class SpringFit(Saveable):
    """A spring that meets its card: the ``spring`` as installed, its numbers and the card's, and
    words for what the card left ``free``: material, turns, pitch.

    Made by :func:`spring_from_card`.

    >>> CardDeviation("rate", 40e3, 40.1e3).found
    40100.0
    """

    card: CatalogueCard
    spring: InstalledSpring
    held: tuple[CardDeviation, ...]
    free: tuple[str, ...]

    @property
    def definition(self) -> SpringDefinition:
        """The wire."""
        assert self.spring.wire is not None
        return self.spring.wire

    def __repr__(self) -> str:
        wire = self.definition
        turns = f"{wire.total_coils:.4g} turns, free length {wire.free_length * 1e3:.2f} mm"
        return f"SpringFit '{wire.name}': {turns}; left free: {len(self.free)}"


def spring_from_card(card: CatalogueCard) -> SpringFit:
    """The spring that meets a catalogue card: both loads by the finite-element rod, turns and ends
    by the other values of the card.

    The active turns and the free length are changed until both loads are met to 0.02 %; formulas of
    straight torsion alone miss them by
    some per cent.

    Parameters
    ----------
    card : :class:`CatalogueCard`

    Returns
    -------
    SpringFit whose ``spring`` is at the height of the first load

    Raises
    ------
    InputError : numbers of the card that no spring has together

    Examples
    --------
    >>> import valvetrain as vt
    >>> low, high = vt.spring_card.SpringLoad("46 mm", "350 N"), vt.spring_card.SpringLoad("34 mm", "830 N")
    >>> card = vt.spring_card.CatalogueCard(wire_diameter="4.4 mm", outer_diameter="32 mm", installed_load=low, open_load=high)
    >>> vt.spring_card.spring_from_card(card)
    SpringFit 'spring': 6.383 turns, free length 54.65 mm; left free: 5
    """
    first = first_winding(card)
    if doubt := doubt_of(card):
        warnings.warn(f"spring '{card.name}': {doubt}", UnusualValueWarning, stacklevel=2)
    refusal: InputError | None = None
    for ground in ground_choices(card, first):
        try:
            return _met(card, replace(first, ground=ground))
        except InputError as error:
            refusal = refusal or error
    assert refusal is not None
    raise _closes_early(card, first) or refusal


def _closes_early(card: CatalogueCard, winding: Winding) -> InputError | None:
    """The refusal of turns that are nearly solid at the second load, where coils that close make it."""
    solid = winding.wound(card).solid_height
    left = card.open_load.height - solid
    if left > (card.installed_load.height - card.open_load.height) / 4:
        return None
    side = "below" if left > 0 else "above"
    remedy = "give the solid height, or " if card.solid_height is None else ""
    return InputError(
        f"{winding.total_coils:.3g} turns are solid at {solid * 1e3:.4g} mm, {abs(left) * 1e3:.2g} mm {side} the height of the second load: "
        f"coils close before it, so that both loads cannot be met by {winding.total_coils - 2 * winding.inactive:.3g} active turns; "
        f"{remedy}check turns, heights and wire"
    )


def _met(card: CatalogueCard, winding: Winding) -> SpringFit:
    """The fit from a first winding. Raises :class:`InputError` where no winding meets both loads."""
    for _ in range(TRIALS):
        definition = winding.wound(card)
        low, high = forces_at(definition, (card.installed_load.height, card.open_load.height))
        rate = (high - low) / (card.installed_load.height - card.open_load.height)
        if (
            abs(low - card.installed_load.force) <= MET * card.open_load.force
            and abs(rate / card.rate - 1) <= MET
        ):
            return _fit(card, winding, definition, low, high)
        winding = changed(
            winding, card, rate / card.rate, (card.installed_load.force - low) / card.rate
        )
    raise InputError(
        f"no winding meets both loads of '{card.name}' to {100 * MET:g} %; check heights, loads, wire and diameters"
    )


def forces_at(definition: SpringDefinition, heights: Sequence[float]) -> tuple[float, ...]:
    """Forces (N) of the finite-element rod at falling heights (m). Raises :class:`InputError` for a
    height at which it is solid.
    """
    spring = InstalledSpring(wire=definition, precompression=_compression(definition, heights[0]))
    model = spring_model("finite-element").build(spring)
    away = (
        np.array([_compression(definition, height) for height in heights]) - spring.precompression
    )
    assert isinstance(model, FiniteElementRod)
    return tuple(map(float, model.static_forces(away)))


def _compression(definition: SpringDefinition, height: float) -> float:
    if height <= definition.solid_height:
        raise InputError(
            f"the spring would be solid at {definition.solid_height * 1e3:.4g} mm, above the load given at {height * 1e3:.4g} mm; check "
            "wire, diameters, loads and turns"
        )
    return max(definition.free_length - height, 0.0)


def _fit(
    card: CatalogueCard, winding: Winding, definition: SpringDefinition, low: float, high: float
) -> SpringFit:
    height = card.installed_load.height
    rate = (high - low) / (height - card.open_load.height)
    held = (
        CardDeviation("installed_load", card.installed_load.force, low),
        CardDeviation("open_load", card.open_load.force, high),
        CardDeviation("rate", card.rate, rate),
        CardDeviation("solid_height", card.solid_height, definition.computed_solid_height),
        CardDeviation("mass", card.mass, weight(definition)),
        CardDeviation("free_length", card.free_length, definition.free_length),
        CardDeviation("total_coils", card.total_coils, definition.total_coils),
    )
    spring = InstalledSpring(wire=definition, precompression=definition.free_length - height)
    return SpringFit(card, spring, held, _left_free(card, winding))


def _left_free(card: CatalogueCard, winding: Winding) -> tuple[str, ...]:
    """A word for each choice that the card did not make; the rules on springs have the sentences."""
    weighed = card.total_coils is not None or card.mass is not None
    if not weighed:
        turns = "turns" if card.solid_height is None else "mass"
    elif card.solid_height is None:
        turns = "ground" if winding.ground == GROUND else "early"
    else:
        turns = "solid" if winding.ground == GROUND else ""
    tapers = card.top_outer_diameter is not None and card.taper_from_coil is None
    words = (
        "material" * (card.material is None), turns, "taper" * tapers, "pitch", "damping", "free_length" * (card.free_length is None),
    )  # fmt: skip
    return tuple(filter(None, words))
