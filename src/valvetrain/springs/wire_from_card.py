"""A wire for a spring given by its card only, so that a finite-element spring can take its
place.
"""

from __future__ import annotations

import math

from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END

ACTIVE_COILS = 5.0
CLEARANCE = 0.15
"""Gap left between coils at full lift, as a share of the wire diameter."""


def wire_from_card(card: SpringCard, valve_lift: float) -> tuple[SpringDefinition, float]:
    """Cylindrical wire and its precompression (m): clamped at both tips, with the card's rate,
    preload, mass; no clash to ``valve_lift``.

    A card leaves one freedom, taken up by :data:`ACTIVE_COILS` = n: with k = G d^4 / (8 D^3 n) and
    m = rho pi^2 d^2 D n / 4 follows
    d^10 = (8 k n / G) (4 m / (rho pi^2 n))^3. Raises :class:`InputError` for
    a card without mass.
    """
    if card.mass is None:
        raise InputError(
            f"spring '{card.name}' has no mass on its card, which a finite-element spring needs; add its mass"
        )
    material, n = OTEVA_90_SC, ACTIVE_COILS
    first = 8 * card.rate * n / material.shear_modulus
    second = 4 * card.mass / (material.density * math.pi**2 * n)
    wire = (first * second**3) ** 0.1
    mean = second / wire**2
    precompression = card.preload / card.rate
    pitch = (precompression + valve_lift) / n + (1 + CLEARANCE) * wire
    definition = SpringDefinition(
        wire_diameter=Constant(wire),
        mean_diameter=Constant(mean),
        pitch=Constant(pitch),
        total_coils=n,
        material=material,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
        name=card.name,
    )
    return definition, precompression
