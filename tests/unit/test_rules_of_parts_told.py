"""Unit: where a card's taper begins."""

from __future__ import annotations

import pytest

from valvetrain.errors import InputError
from valvetrain.spring_card.card import CatalogueCard, SpringLoad


def card(top: float | None = None, taper: float | None = None) -> CatalogueCard:
    """Wire of 4 mm, 32 mm outside (m)."""
    return CatalogueCard(
        outer_diameter=32e-3,
        wire_diameter=4e-3,
        installed_load=SpringLoad(46e-3, 350.0),
        open_load=SpringLoad(34e-3, 830.0),
        top_outer_diameter=top,
        taper_from_coil=taper,
    )


@pytest.mark.parametrize(
    ("top", "taper", "coils", "diameters"),
    [
        (None, None, (0, 3, 8), (28, 28, 28)),
        (26, None, (0, 4, 6, 8), (28, 28, 25, 22)),
        (26, 5.0, (0, 5, 6.5, 8), (28, 28, 25, 22)),
        (26, 0.0, (0, 4, 8), (28, 25, 22)),
    ],
)
def test_a_beehive_of_a_card_tapers_from_half_way_unless_told(top, taper, coils, diameters):
    """Eight turns; mean diameters in mm at coils."""
    curve = card(None if top is None else 1e-3 * top, taper).mean_diameter(8.0)
    assert [1e3 * float(curve.value(coil)) for coil in coils] == pytest.approx(diameters)


@pytest.mark.parametrize("taper", [-0.5, 8.0, 9.0])
def test_a_taper_begins_below_the_top(taper):
    with pytest.raises(InputError, match="taper"):
        card(26e-3, taper).mean_diameter(8.0)
