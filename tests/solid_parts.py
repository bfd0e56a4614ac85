"""Springs for the tests of solids; bars of bricks are those of the validation book."""

from __future__ import annotations

from validation.bars import STEEL

from valvetrain.parameters.curves import Constant
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END


def helix(
    mean_diameter: float = 22e-3, coils: float = 5.0, pitch: float = 7e-3
) -> SpringDefinition:
    """A uniform spring of 3.8 mm wire with clamped end sections."""
    return SpringDefinition(
        wire_diameter=Constant(3.8e-3),
        mean_diameter=Constant(mean_diameter),
        pitch=Constant(pitch),
        total_coils=coils,
        material=STEEL,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
    )
