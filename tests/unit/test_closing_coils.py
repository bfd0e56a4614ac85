"""Unit: how active turns and gaps that close one after the other become a spring, counted by hand."""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.spring_card.tester import PitchLaw

WIRE = 4e-3


def law(total: float | None = 9.0, closes: str = "lower", stations: int = 3) -> PitchLaw:
    low, high = (
        vt.spring_card.SpringLoad("46 mm", "350 N"),
        vt.spring_card.SpringLoad("34 mm", "830 N"),
    )
    card = vt.spring_card.CatalogueCard(
        wire_diameter=WIRE, outer_diameter="32 mm", installed_load=low, open_load=high
    )
    return PitchLaw(card, total, 0.75, closes, stations)


@pytest.mark.parametrize(
    ("total", "active", "expected"),
    [
        (None, 6.0, (8.0, 1.0)),
        (None, 4.5, (6.5, 1.0)),
        (9.0, 6.0, (9.0, 1.5)),
        (7.5, 5.0, (7.5, 1.25)),
        (8.0, 7.0, (8.0, 0.5)),
    ],
)
def test_turns_that_are_not_active_lie_in_halves_at_both_ends(total, active, expected):
    """One at either end where the number of all turns is not known."""
    assert law(total).winding(active) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("closes", "stations", "steps", "expected"),
    [
        ("lower", 3, (1, 2, 3), (1, 3, 6)),
        ("upper", 3, (1, 2, 3), (6, 3, 1)),
        ("both", 5, (1, 2, 3), (1, 3, 6, 3, 1)),
        ("both", 4, (1, 2), (1, 3, 3, 1)),
        ("both", 1, (2,), (2,)),
        ("lower", 1, (2,), (2,)),
    ],
)
def test_gaps_grow_by_their_steps_away_from_the_end_that_closes_first(
    closes, stations, steps, expected
):
    made = law(closes=closes, stations=stations)
    assert made.steps == len(steps) and made.gaps(np.array(steps, dtype=float)).tolist() == list(
        expected
    )


@pytest.mark.parametrize(
    ("total", "active", "places"), [(9.0, 6.0, (1.75, 4.5, 7.25)), (None, 4.0, (1.25, 3.0, 4.75))]
)
def test_stations_lie_evenly_between_the_ramps_of_both_ends(total, active, places):
    """Half a turn of ramp about the end of the inactive turns, so that the first station lies a
    quarter of a turn inside.
    """
    made, total_coils = law(total), total or active + 2
    assert made.places(active) == pytest.approx(places)
    spring = made.definition(np.array([active, 1e-3, 1e-3, 2e-3]))
    inactive = (total_coils - active) / 2
    assert (
        spring.total_coils,
        spring.lower_end.inactive_coils,
        spring.upper_end.inactive_coils,
    ) == (total_coils, inactive, inactive)
    assert spring.lower_end.kind == "closed-ground" and spring.lower_end.ground_coils == 0.75
    assert spring.pitch.value(np.array(places)) == pytest.approx(
        [WIRE + 1e-3, WIRE + 2e-3, WIRE + 4e-3]
    )
    closed = np.array([0.0, inactive - 0.25, total_coils - inactive + 0.25, total_coils])
    assert spring.pitch.value(closed) == pytest.approx([WIRE] * 4)
