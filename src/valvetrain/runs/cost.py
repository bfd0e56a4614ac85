"""Time and memory that a request may take, and the refusal of one beyond them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from valvetrain.errors import InputError

SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
BYTES = {"MB": 1e6, "GB": 1e9, "TB": 1e12}
#: What to reduce in a run, in curves and modes, and in a refinement.
FEWER, FEWER_AT_REST, FEWER_REFINED = (
    "speeds, cycles or unknowns",
    "steps, modes or unknowns",
    "speeds, variants or unknowns",
)


@dataclass(frozen=True, slots=True)
class Cost:
    """Estimated wall time (s) and memory (bytes)."""

    seconds: float = 0.0
    bytes: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        return Cost(self.seconds + other.seconds, self.bytes + other.bytes)


@dataclass(frozen=True, slots=True)
class Limits:
    """Largest estimated time (s) and memory (bytes) of a request."""

    seconds: float = 600.0
    bytes: float = 2e9


def read_limits(texts: Sequence[str] | None, where: str = "--limit") -> Limits:
    """Limits from texts such as ``'2 h'`` and ``'8 GB'``. Raises :class:`InputError` for anything
    else.
    """
    limits = Limits()
    for text in (part for whole in texts or () for part in whole.split(",")):
        match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]+)\s*", text)
        if match is None or match[2] not in (*SECONDS, *BYTES) or float(match[1]) == 0:
            raise InputError(
                f"'{text[:40]}' is no bound; write a time such as '2 h' or a memory such as '8 GB'",
                where,
            )
        if match[2] in SECONDS:
            limits = Limits(float(match[1]) * SECONDS[match[2]], limits.bytes)
        else:
            limits = Limits(limits.seconds, float(match[1]) * BYTES[match[2]])
    return limits


def limits_of(limit: str) -> Limits:
    """Limits from ``"2 h, 8 GB"``, empty for the defaults. Raises :class:`InputError` for anything
    else.
    """
    if not isinstance(limit, str):
        raise InputError(
            f"'{str(limit)[:40]}' is no bound; write a time and a memory such as '2 h, 8 GB'",
            "limit",
        )
    return read_limits((limit,) if limit else (), "limit")


def cost_text(cost: Cost) -> str:
    """The cost in suitable units."""
    return f"about {duration_text(cost.seconds)} and {memory_text(cost.bytes)}"


def refuse_cost(cost: Cost, limits: Limits, option: str = "--limit ", fewer: str = FEWER) -> None:
    """Raise :class:`InputError` for a cost that is too large, with what to request ``fewer`` of, and the ``option`` that
    raises the limit.
    """
    over = []
    if cost.seconds > limits.seconds:
        over.append((_rounded_up(cost.seconds, SECONDS), duration_text(limits.seconds)))
    if cost.bytes > limits.bytes:
        over.append((_rounded_up(cost.bytes, BYTES), memory_text(limits.bytes)))
    if over:
        bounds = " and ".join(bound for _, bound in over)
        raised = ", ".join(value for value, _ in over)
        remedy = f"choose fewer {fewer}, or raise the bound with {option}'{raised}'"
        raise InputError(
            f"this request will take {cost_text(cost)}, beyond the bound of {bounds}; {remedy}"
        )


def duration_text(seconds: float) -> str:
    """A time in a suitable unit."""
    for unit, size in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{max(1.0, seconds):.0f} s"


def memory_text(size: float) -> str:
    """A memory size in a suitable unit."""
    unit, scale = next((one for one in (("TB", 1e12), ("GB", 1e9)) if size >= one[1]), ("MB", 1e6))
    return f"{size / scale:.3g} {unit}" if unit != "MB" else f"{max(1.0, size / scale):.0f} MB"


def _rounded_up(value: float, units: Mapping[str, float]) -> str:
    """``value`` as the next whole number of the largest unit that leaves at least one."""
    unit = [name for name, size in units.items() if value >= size or size == min(units.values())][
        -1
    ]
    return f"{math.ceil(1.05 * value / units[unit])} {unit}"
