"""Numbers and parts of sentences."""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.report.text import number

#: What is said of a stress by EN 13906-1 of a force beyond solid.
#: Least number that is written with noughts in place of a power of ten.
TINY = 1e-6
#: Status -> what the run did.
ENDED = {
    "not-converged": "did not settle", "diverged": "diverged", "out-of-range": "left the range of its tables",
    "coil-bind": "reached coil bind", "solid": "ran solid", "buckled": "buckled", "refused": "was refused",
    "interrupted": "was interrupted", "worker-lost": "lost its process",
}  # fmt: skip


def figure(value: float, digits: int = 3) -> str:
    """A number as a sentence gives it: three digits, whole ones never rounded away, small ones without powers
    of ten.

    >>> figure(7.283e-5), figure(0.01234), figure(12345.6)
    ('0.000073', '0.0123', '12346')
    """
    if TINY <= abs(value) < 1e-4:
        return f"{value:.6f}".rstrip("0").replace("-", "−")
    return number(float(round(value)), 12) if abs(value) >= 10**digits else number(value, digits)


def joined(parts: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {last} {parts[-1]}"


def sentence(parts: Sequence[str], condition: str = "") -> str:
    """Parts behind each other, as a sentence under a ``condition``; empty without any."""
    text = "; ".join(part for part in parts if part)
    text = f"{condition}, {text}" if condition and text else text
    return f"{text[:1].upper()}{text[1:]}." if text else ""
