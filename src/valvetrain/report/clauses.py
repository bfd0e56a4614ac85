"""Numbers and parts of sentences."""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import shown
from valvetrain.units.reader import reader_factor, reader_unit

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


def amount_text(value: float, unit: str, digits: int = 3) -> str:
    """A number in a metric ``unit`` with the unit of the reader, rounded as :func:`figure` does."""
    return f"{figure(value * reader_factor(unit), digits)} {unit_text(reader_unit(unit))}".strip()


def quantity_text(name: str, value: float, digits: int = 3, whole: bool = False) -> str:
    """An SI value with the unit of its tables; below a tenth of a millimetre in µm, unless it is
    shown next to ``whole`` ones.
    """
    found, unit = shown(name, value)
    number_shown = float(found)
    if unit == "mm" and not whole and 0 < abs(number_shown) < 0.1:
        number_shown, unit = 1e3 * number_shown, "um"
    return f"{figure(number_shown, digits)} {unit_text(unit)}".strip()


def joined(parts: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {last} {parts[-1]}"


def sentence(parts: Sequence[str], condition: str = "") -> str:
    """Parts behind each other, as a sentence under a ``condition``; empty without any."""
    text = "; ".join(part for part in parts if part)
    text = f"{condition}, {text}" if condition and text else text
    return f"{text[:1].upper()}{text[1:]}." if text else ""
