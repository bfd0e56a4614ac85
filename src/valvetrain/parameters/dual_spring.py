"""A dual spring known by its total loads, parted into outer and inner by the wires of both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from valvetrain.errors import InputError

#: Loads of one are parted where both together agree with wires and coils within these factors.
LOW, HIGH = 0.7, 1.4
#: Total loads that are off the rates of both wires by more than this share need another measurement.
FAR = 0.1
#: Active turns of a spring whose rate is what the other one leaves.
MIN_TURNS, MAX_TURNS = 2.0, 14.0
NAMES = ("outer", "inner")


@dataclass(frozen=True, slots=True)
class Half:
    """One spring of a pair: ``wire_diameter`` and ``mean_diameter`` (m), ``shear_modulus`` (Pa),
    ``installed_height`` (m), and where they are known ``active_coils`` and ``free_length`` (m).
    """

    wire_diameter: float
    mean_diameter: float
    shear_modulus: float
    installed_height: float
    active_coils: float | None = None
    free_length: float | None = None

    @property
    def rate_of_one_coil(self) -> float:
        """Rate (N/m) of one active turn, G d^4 / (8 D^3)."""
        return self.shear_modulus * self.wire_diameter**4 / (8 * self.mean_diameter**3)


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


def part(rate: float, preload: float, outer: Half, inner: Half) -> Parted:
    """The loads of a dual spring, parted.

    Rates are in the ratio of G d^4 / (8 D^3 n) and add up to the total; where the turns of one are
    not known, it has what the other leaves. Preloads follow from free lengths, of which one is
    enough; without any both springs are taken as compressed alike, so that loads are as rates.

    Parameters
    ----------
    rate : of both together, N/m
    preload : of both together at the installed heights, N
    outer, inner : known values of each

    Raises
    ------
    InputError : turns of neither are known; wires and coils, or free lengths, contradict the loads

    Examples
    --------
    >>> outer, inner = Half(4.8e-3, 31.0e-3, 79.5e9, 0.045, 4.5), Half(3.3e-3, 22.8e-3, 79.5e9, 0.045, 5.0)
    >>> found = part(60e3, 600.0, outer, inner)
    >>> [round(one) for one in found.rates], [round(one) for one in found.preloads]
    ([39857, 20143], [399, 201])
    """
    rates, how = _rates(rate, outer, inner)
    coils = (outer.rate_of_one_coil / rates[0], inner.rate_of_one_coil / rates[1])
    preloads, why = _preloads(preload, rates, outer, inner)
    lengths = (
        outer.installed_height + preloads[0] / rates[0],
        inner.installed_height + preloads[1] / rates[1],
    )
    return Parted(rates, preloads, coils, lengths, how, why)


def _rates(rate: float, outer: Half, inner: Half) -> tuple[tuple[float, float], str]:
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
    preload: float, rates: tuple[float, float], outer: Half, inner: Half
) -> tuple[tuple[float, float], str]:
    """Preloads of both, and by what they were found."""
    own = [
        None if one.free_length is None else rate * (one.free_length - one.installed_height)
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
