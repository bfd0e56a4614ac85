"""Numbers and names as a reader sees them."""

from __future__ import annotations

import math
import re


def rpm(engine_speed: float) -> float:
    """rad/s as revolutions per minute, rounded to what nobody would call rounding."""
    return round(engine_speed * 30 / math.pi, 6)


def speed_words(engine_speed: float) -> str:
    """An engine speed as text, such as ``5600 rpm``."""
    return f"{rpm(engine_speed):.10g} rpm"


def in_unit(value: float, unit: str) -> float:
    """SI ``value`` in ``unit``; raises :class:`valvetrain.errors.InputError` for an unknown unit."""
    from valvetrain.units import unit_factor

    return value / unit_factor(unit) if unit not in ("", "1") else value


def number(value: float | None, digits: int = 4) -> str:
    """A number with ``digits`` significant digits, a real minus sign, and powers of ten as such; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    size = abs(value)
    if size >= 1e6 or size < 1e-4:
        mantissa, power = f"{value:.{max(digits - 2, 1)}e}".split("e")
        return _scientific(mantissa, int(power))
    decimals = max(0, digits - 1 - math.floor(math.log10(size)))
    text = f"{value:.{min(decimals, 6)}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return text.replace("-", "−")


def unit_words(unit: str) -> str:
    """A unit as printed: ``mm/s^2`` -> ``mm/s²``, ``us`` -> ``µs``."""
    return unit.replace("^2", "²").replace("^3", "³").replace("us", "µs").replace("um", "µm")


def _scientific(mantissa: str, power: int) -> str:
    raised = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa.rstrip('0').rstrip('.')}·10{raised}".replace("-", "−")


def percent(share: float) -> str:
    """A share as a signed percentage with one decimal; what rounds to zero has no sign."""
    text = f"{100 * share:+.1f}"
    return ("0.0" if float(text) == 0 else text.replace("-", "−")) + " %"


def quantity_words(name: str) -> str:
    """A quantity's name in words: ``stage_2_peak_cam_angle`` -> ``Stage II peak, cam angle``."""
    text = name.replace("_", " ")
    for digit, roman in (("1", "I"), ("2", "II"), ("3", "III")):
        text = re.sub(rf"\bstage {digit}\b", f"Stage {roman}", text)
    text = re.sub(r"\bcoil (\d) (\d)\b", r"coils \1–\2", text)
    text = re.sub(r"\bk?hz\b", lambda unit: unit[0].replace("hz", "Hz"), text)
    text = re.sub(r"\s+cam angle$", ", cam angle", text)
    return text[:1].upper() + text[1:]
