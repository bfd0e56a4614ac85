"""Unit: where a card's taper begins, how far about a spike it is looked for, which files are told
as not sent.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.compare_test.events import MEETING, _around
from valvetrain.errors import InputError
from valvetrain.spring_card.card import CatalogueCard, SpringLoad

DEG = np.pi / 180


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


@pytest.mark.parametrize(
    ("angle", "others", "reach"),
    [
        (100, [100], MEETING / DEG),
        (100, [100, 100 + 1.6 * MEETING / DEG], MEETING / DEG),
        (100, [40, 100, 106], 6),
        (100, [96, 100, 106], 4),
        (358, [4, 358], 6),
        (1, [1, 355, 200], 6),
    ],
)
def test_a_spike_is_looked_for_half_way_to_its_nearest_neighbour(angle, others, reach):
    """Cam angles every half degree; neighbours may lie beyond the end of the turn."""
    grid = np.arange(0.25, 360.0, 0.5)
    found = _around(grid * DEG, angle * DEG, [other * DEG for other in others])
    away = np.abs((grid - angle + 180) % 360 - 180)
    assert found.tolist() == np.flatnonzero(away <= 0.5 * reach).tolist()
