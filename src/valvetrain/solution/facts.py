"""What a result rests on beside its numbers: facts of its case and of its runs, as records that findings read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from valvetrain.solution.status import Detail

#: Code -> its fields: SI numbers, names and words.
FIELDS: dict[str, tuple[str, ...]] = {
    "assumed-wire": (),
    "default-contacts": ("places", "restitution"),
    "no-damping": ("spring",),
    "no-friction": ("place",),
    "assumed-ramp": ("velocity",),
    "split-loads": (
        "rates_by", "preloads_by", "outer_rate", "inner_rate", "outer_preload", "inner_preload", "outer_free_length", "inner_free_length",
    ),
    "not-the-default": ("model", "reason"),
    "chain-of-wire": ("spring", "surge_frequency", "force_error", "second_frequency_error", "better"),
    "buckles": ("spring", "compression", "open_compression"),
    "unknown-solid-height": ("spring",),
    "other-solid-height": ("spring", "stated", "computed"),
    "card-alone": ("spring",),
    "ends-pull": ("label", "engine_speed"),
    "ends-bonded": ("label", "engine_speed"),
    "follows-a-train": ("label", "engine_speed", "driver", "repeats", "force_difference"),
    "spike": ("engine_speed", "raw_force", "force_below_5_khz"),
    "above-solid": ("spring", "solid_force", "label", "engine_speed", "force", "stress"),
    "above-strength": ("label", "engine_speed", "stress"),
    "between-speeds": ("label", "engine_speeds"),
    "worse-between": ("label", "quantity", "engine_speed", "value", "next_engine_speed", "next_value"),
    "calibration-spread": ("quantity", "engine_speed", "low", "high"),
    "too-hard": ("label", "engine_speed", "peak_share", "minimum_share"),
    "run-up": ("first_engine_speed", "last_engine_speed", "duration"),
}  # fmt: skip


class Fact(NamedTuple):
    """A ``code`` of :data:`FIELDS` with its ``fields``: SI numbers, names and words; NaN for an unknown number.

    >>> Fact("card-alone", {"spring": "outer"}).fields["spring"]
    'outer'
    """

    code: str
    fields: Mapping[str, Detail] = {}


def with_code(facts: Iterable[Fact], code: str) -> tuple[Fact, ...]:
    """The facts of one code, such as ``assumed-ramp``."""
    return tuple(one for one in facts if one.code == code)


def distinct(facts: Iterable[Fact]) -> tuple[Fact, ...]:
    """The facts, each once, in their order."""
    found: list[Fact] = []
    for one in facts:
        if one not in found:
            found.append(one)
    return tuple(found)
