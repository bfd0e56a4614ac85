"""Units at the interface: text such as "4.0 mm", quantities and plain SI numbers to SI floats and
back; inside all is SI.
"""

from valvetrain.units.arguments import as_names, known_arguments
from valvetrain.units.dimensions import DIMENSIONS, Dimension
from valvetrain.units.inputs import (
    MAX_SPEEDS,
    PLAUSIBLE,
    Given,
    Window,
    believed,
    doubt,
    keep_si,
    si,
    si_array,
    si_each,
    si_speeds,
    warn_unusual,
)
from valvetrain.units.text import (
    PlainInteger,
    PlainNumber,
    dimension_of,
    dimension_powers,
    format_quantity,
    numbers_of,
    parse_quantities,
    parse_quantity,
    plain_value,
    to_unit,
    unit_factor,
)

__all__ = [
    "DIMENSIONS", "Dimension", "Given", "MAX_SPEEDS", "PLAUSIBLE", "PlainInteger", "PlainNumber", "Window", "as_names", "believed",
    "dimension_of", "dimension_powers", "doubt", "format_quantity", "keep_si", "numbers_of", "parse_quantities", "parse_quantity", "plain_value",
    "known_arguments", "si", "si_array", "si_each", "si_speeds", "to_unit", "unit_factor", "warn_unusual",
]  # fmt: skip
