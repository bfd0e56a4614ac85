"""Numbers, curves and materials as text, in the units in which they are usually given."""

from __future__ import annotations

import math

from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear, Table
from valvetrain.parameters.material import Material
from valvetrain.units.reader import reader_factor, reader_unit
from valvetrain.units.text import to_unit

#: Size below which a number, in any unit that is shown, is rounding alone.
ROUNDING = 1e-12


def value_text(item: Curve | Material) -> str:
    """A length over the coils, or a material, in the units in which they are usually given."""
    if isinstance(item, Material):
        shown = (
            ("E", item.youngs_modulus, "GPa"),
            ("G", item.shear_modulus, "GPa"),
            ("density", item.density, "kg/m^3"),
        )
        parts = (
            f"{name} {number(to_unit(value, unit))} {unit_text(unit)}"
            for name, value, unit in shown
        )
        return f"{item.name}: {', '.join(parts)}"
    if isinstance(item, Constant):
        return f"{number(to_unit(item.level, 'mm'))} mm"
    if isinstance(item, (PiecewiseLinear, Table)):
        pairs = (
            f"{number(to_unit(value, 'mm'))} at {coil:g}"
            for coil, value in zip(item.coils, item.values, strict=True)
        )
        return f"{', '.join(pairs)} (mm at coil number)"
    return type(item).__name__.replace("_", " ")


def number(value: float | None, digits: int = 4) -> str:
    """A number with ``digits`` significant digits, a real minus sign, and powers of ten as such; a
    dash for None, 0 for what rounding of sums leaves (below :data:`ROUNDING`).
    """
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    size = abs(value)
    if size < ROUNDING:
        return "0"
    if size >= 1e6 or size < 1e-4:
        mantissa, power = f"{value:.{max(digits - 2, 1)}e}".split("e")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return f"{mantissa.rstrip('0').rstrip('.')}·10{raised}".replace("-", "−")
    decimals = max(0, digits - 1 - math.floor(math.log10(size)))
    text = f"{value:.{min(decimals, 6)}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return text.replace("-", "−")


def share_text(share: float) -> str:
    """A share in per cent with two digits.

    >>> share_text(0.264), share_text(1e-5)
    ('26 %', '0.001 %')
    """
    return f"{number(100 * share, 2)} %"


def percent(share: float) -> str:
    """A share as a signed percentage with one decimal; what rounds to zero has no sign.

    >>> percent(0.035), percent(-0.0713), percent(-0.0002)
    ('+3.5 %', '−7.1 %', '0.0 %')
    """
    text = f"{100 * share:+.1f}"
    return ("0.0" if float(text) == 0 else text.replace("-", "−")) + " %"


def unit_text(unit: str) -> str:
    """A unit as printed: ``mm/s^2`` -> ``mm/s²``, ``us`` -> ``µs``, ``um`` -> ``µm``."""
    return unit.replace("^2", "²").replace("^3", "³").replace("us", "µs").replace("um", "µm")


def amount(value: float, unit: str, digits: int = 4) -> str:
    """A number in a metric ``unit`` as text in the unit of the reader: ``112.4 N``.

    >>> amount(0.5, "mm")
    '0.5 mm'
    """
    return f"{number(value * reader_factor(unit), digits)} {unit_text(reader_unit(unit))}".strip()


def rpm(engine_speed: float) -> float:
    """rad/s as revolutions per minute, rounded to 1e-6."""
    return round(engine_speed * 30 / math.pi, 6)
