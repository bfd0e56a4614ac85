"""A dual spring known by its total loads, parted into outer and inner by the wires of both."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Literal

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.card import INACTIVE, SpringCard
from valvetrain.parameters.schema_types import guarded, problem, validate_as

#: Loads of one are parted where both together agree with wires and coils within these factors.
LOW, HIGH = 0.7, 1.4
#: Total loads that are off the rates of both wires by more than this share need another measurement.
FAR = 0.1
#: Active turns of a spring whose rate is what the other one leaves.
MIN_TURNS, MAX_TURNS = 2.0, 14.0
NAMES = ("outer", "inner")
#: Keys by which the total loads are given, in the first table.
LOADS = ("preload", "open_load", "open_lift", "open_height", "rate")


@dataclass(frozen=True, slots=True)
class Parted:
    """``rates`` (N/m), ``preloads`` (N), ``active_coils`` and ``free_lengths`` (m) of outer and inner,
    with what the rates and the preloads were found by.
    """

    rates: tuple[float, float]
    preloads: tuple[float, float]
    active_coils: tuple[float, float]
    free_lengths: tuple[float, float]
    rates_by: str
    preloads_by: str

    @property
    def fields(self) -> dict[str, float | str]:
        """The same by names: ``rates_by``, ``outer_rate``."""
        numbers = {"rate": self.rates, "preload": self.preloads, "free_length": self.free_lengths}
        named = {
            f"{name}_{key}": values[place]
            for key, values in numbers.items()
            for place, name in enumerate(NAMES)
        }
        return {"rates_by": self.rates_by, "preloads_by": self.preloads_by, **named}


def part(rate: float, preload: float, outer: SpringCard, inner: SpringCard) -> Parted:
    """The loads of a dual spring, parted.

    Rates are in the ratio of G d^4 / (8 D^3 n) and add up to the total; where the turns of one are
    not known, it has what the other leaves. Preloads follow from free lengths, of which one is
    enough; without any both springs are taken as compressed alike, so that loads are as rates.

    Parameters
    ----------
    rate : of both together, N/m
    preload : of both together at the installed heights, N
    outer, inner : wire_diameter, mean_diameter and installed_height of each; active_coils and free_length where they are known

    Raises
    ------
    InputError : turns of neither are known; wires and coils, or free lengths, contradict the loads

    Examples
    --------
    >>> coils = {"loads_of": "pair", "installed_height": 0.045, "material": "EN 10270-2 VDSiCr"}
    >>> outer = SpringCard(wire_diameter=4.8e-3, mean_diameter=31.0e-3, active_coils=4.5, **coils)
    >>> inner = SpringCard(wire_diameter=3.3e-3, mean_diameter=22.8e-3, active_coils=5.0, **coils)
    >>> found = part(60e3, 600.0, outer, inner)
    >>> [round(one) for one in found.rates], [round(one) for one in found.preloads]
    ([39857, 20143], [399, 201])
    """
    rates, how = _rates(rate, outer, inner)
    coils = (outer.rate_of_one_coil / rates[0], inner.rate_of_one_coil / rates[1])
    preloads, why = _preloads(preload, rates, outer, inner)
    lengths = (
        (outer.installed_height or 0.0) + preloads[0] / rates[0],
        (inner.installed_height or 0.0) + preloads[1] / rates[1],
    )
    return Parted(rates, preloads, coils, lengths, how, why)


def _rates(rate: float, outer: SpringCard, inner: SpringCard) -> tuple[tuple[float, float], str]:
    """Rates of both, and by what they were found."""
    formula = "G d^4 / (8 D^3 n)"
    own = [None if one.active_coils is None else one.rate_of_one_coil / one.active_coils for one in (outer, inner)]  # fmt: skip
    first, second = own
    if first is not None and second is not None:
        factor = rate / (first + second)
        if not LOW < factor < HIGH:
            raise InputError(
                f"wires and coils of both make a rate of {(first + second) / 1e3:.3g} N/mm, but the total loads make {rate / 1e3:.3g} N/mm; "
                "check wires, diameters, turns and loads"
            )
        made = f", times {factor:.3g} to meet the total" if abs(factor - 1) > 0.005 else ""
        if abs(factor - 1) > FAR:
            made += f" (they make {(first + second) / 1e3:.3g} of {rate / 1e3:.3g} N/mm: measure wires, diameters and turns again)"
        return (first * factor, second * factor), f"the rates {formula} of both{made}"
    if first is None and second is None:
        raise InputError(
            "total loads are parted by the rates of both springs, and the turns of neither are known; count those of one and give "
            "active_coils, total_coils or its solid_height"
        )
    known: Literal[0, 1] = 0 if first is not None else 1
    mine = first if first is not None else second
    assert mine is not None
    left = rate - mine
    other = (inner, outer)[known]
    turns = other.rate_of_one_coil / left if left > 0 else 0.0
    if not MIN_TURNS <= turns <= MAX_TURNS:
        leaves = f"leaves {left / 1e3:.3g} N/mm to the {NAMES[1 - known]} one" + (
            f", which takes {turns:.3g} active turns" if left > 0 else ""
        )
        raise InputError(
            f"wire and coils of the {NAMES[known]} spring make {mine / 1e3:.3g} N/mm of the total of {rate / 1e3:.3g} N/mm, which {leaves}; "
            "check wires, diameters and turns"
        )
    rates = (mine, left) if known == 0 else (left, mine)
    return (
        rates,
        f"the rate {formula} of the {NAMES[known]}, the {NAMES[1 - known]} having the rest",
    )


def _preloads(
    preload: float, rates: tuple[float, float], outer: SpringCard, inner: SpringCard
) -> tuple[tuple[float, float], str]:
    """Preloads of both, and by what they were found."""
    own = [
        None
        if one.free_length is None
        else rate * (one.free_length - (one.installed_height or 0.0))
        for one, rate in zip((outer, inner), rates, strict=True)
    ]
    first, second = own
    if first is None and second is None:
        share = rates[0] / (rates[0] + rates[1])
        return (preload * share, preload * (1 - share)), (
            "preloads as rates, both being compressed alike where no free length is given"
        )
    if first is not None and second is not None:
        factor = preload / (first + second) if min(first, second) > 0 else 0.0
        if not LOW < factor < HIGH:
            raise InputError(
                f"the free lengths make {first:.4g} N and {second:.4g} N as installed, but preload is {preload:.4g} N in all; check them"
            )
        return (first * factor, second * factor), "preloads by both free lengths"
    mine = first if first is not None else second
    assert mine is not None
    name = NAMES[0 if first is not None else 1]
    if not 0 < mine < preload:
        raise InputError(
            f"the free length of the {name} spring makes {mine:.4g} N as installed, but preload is {preload:.4g} N in all; check it"
        )
    pair = (mine, preload - mine) if first is not None else (preload - mine, mine)
    return pair, f"preloads by the free length of the {name}"


def read_pair(entries: list[dict[str, Any]]) -> tuple[SpringCard, SpringCard]:
    """Both cards of a file (``loads_of = "pair"``), each with its own loads; raises a located problem."""
    outer, inner = (
        validate_as(SpringCard, {"loads_of": "pair", **entry}, (place,))
        for place, entry in enumerate(entries)
    )
    for key in LOADS:
        if key in entries[1]:
            raise problem(
                f"loads_of = 'pair' says that the loads of the first spring are those of both; leave {key} out here",
                (1, key),
            )
    if not (outer.preload or 0.0) > 0:
        raise problem("the total preload of the pair is missing; add it", (0, "preload"))
    if outer.installed_height is None:
        raise problem("total loads are parted at installed_height; add it", (0, "installed_height"))
    height = outer.installed_height
    rate, lift = guarded(outer.rate_and_lift, height, path=(0,))
    guarded(outer.refuse_open_solid, lift, height, path=(0,))
    halves = [guarded(_half, one, height, path=(n,)) for n, one in enumerate((outer, inner))]
    found = guarded(part, rate, outer.preload, *halves)
    cards = []
    for place, half in enumerate(halves):
        loads = {"preload": found.preloads[place], "rate": found.rates[place], "open_lift": lift}
        turns = half.active_coils or found.active_coils[place]
        split = {} if place else found.fields
        cards.append(guarded(half.parted, split, path=(place,), active_coils=turns, **loads))
    if doubt := doubtful_pair(found.rates, found.active_coils):
        warnings.warn(f"dual spring: {doubt}", UnusualValueWarning, stacklevel=2)
    return cards[0], cards[1]


def _half(card: SpringCard, height: float) -> SpringCard:
    """One spring of a pair with mean diameter and turns; ``height`` (m): installed, where it has none of its own."""
    if card.mass is not None:
        raise problem(
            "the mass follows from both wires; change total_coils or wire_diameter, and leave mass out",
            ("mass",),
        )
    if card.preload_height is not None:
        raise problem(
            "loads of a pair are those at installed_height; leave preload_height out",
            ("preload_height",),
        )
    if card.wire_diameter is None:
        raise problem(
            "total loads are parted by both wires; give wire_diameter", ("wire_diameter",)
        )
    mean = card.mean_of("give mean_diameter or outer_diameter, one of them")
    active, total = card.active_coils, card.total_coils
    if active is None and total is None and card.solid_height is not None:
        total = card.solid_height / card.wire_diameter
    if active is None and total is not None:
        if total <= INACTIVE:
            raise problem(
                f"there are {total:.3g} turns in all, of which two are at rest; check turns, solid_height and wire_diameter",
                ("wire_diameter",),
            )
        active = total - INACTIVE
    installed = card.installed_height or height
    return card.replace(
        mean_diameter=mean, outer_diameter=None, active_coils=active, installed_height=installed
    )


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
