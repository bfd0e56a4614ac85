"""How long a request may take and how much memory it may need, as told on the command line."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from valvetrain.errors import InputError

SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
BYTES = {"MB": 1e6, "GB": 1e9, "TB": 1e12}


@dataclass(frozen=True, slots=True)
class Limits:
    """Largest estimated time (s) and memory (bytes) of a request."""

    seconds: float = 600.0
    bytes: float = 2e9


def read_limits(texts: Sequence[str] | None) -> Limits:
    """Bounds from such as ``'2 h'`` and ``'8 GB'``, in one text or several. Raises :class:`InputError` for anything else."""
    limits = Limits()
    for text in (part for whole in texts or () for part in whole.split(",")):
        match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]+)\s*", text)
        if match is None or match[2] not in (*SECONDS, *BYTES) or float(match[1]) == 0:
            raise InputError(f"'{text[:40]}' is no bound; write a time such as '2 h' or a memory such as '8 GB'", "--limit")
        if match[2] in SECONDS:
            limits = Limits(float(match[1]) * SECONDS[match[2]], limits.bytes)
        else:
            limits = Limits(limits.seconds, float(match[1]) * BYTES[match[2]])
    return limits
