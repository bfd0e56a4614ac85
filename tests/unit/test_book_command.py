"""The validation book's command on rows that are made up: which rows are met, and what makes it fail."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from validation import explained
from validation.row import Row

MET = Row(
    "rates", "rate of a wire", "en13906-1", "4 mm wire", 41000.0, 41010.0, "N/m", 20.0, "rounding"
)
MISSED = replace(
    MET,
    topic="sources",
    name="a|b",
    unit="1",
    computed=41100.0,
    kind="prediction",
    band=(41050.0, 41200.0),
    explanation="another pitch",
)
FAILS = replace(MISSED, name="worse", source="", computed=41300.0)
BARE = replace(MET, name="lost", computed=math.nan)


@pytest.mark.parametrize(
    ("row", "status"),
    [
        (MET, "met"),
        (replace(MET, computed=40980.0), "met"),
        (replace(MET, computed=40979.0), "FAILS"),
        (MISSED, "miss (explained)"),
        (replace(MISSED, computed=41050.0), "miss (explained)"),
        (replace(MISSED, computed=41200.0), "miss (explained)"),
        (replace(MISSED, computed=41049.0), "FAILS"),
        (FAILS, "FAILS"),
        (BARE, "FAILS"),
        (replace(MISSED, explanation=""), "FAILS"),
        (replace(MISSED, band=None), "FAILS"),
        (replace(MET, tolerance=math.inf), "FAILS"),
        (replace(MISSED, computed=41020.0), "met"),
    ],
)
def test_a_row_is_met_missed_or_fails(row, status):
    assert row.status == status and (
        math.isnan(row.computed) or row.difference == row.computed - row.expected
    )


#: Bands that are wider than the rule, about numbers that follow the sampling or a difference of two
#: forces: half the width over the middle.
WIDER = {
    "stage 1 force range, 4200 rpm (solid finite elements)": 0.056, "node 2 contact displacement, 4200 rpm (solid finite elements)": 0.153,
    "coil 1 2 bounce duration, 5600 rpm (solid finite elements)": 0.345,
    "coil 1 2 bounce duration, 8000 rpm (solid finite elements)": 0.095,
    "performance lift difference displacement, 4000 rpm (as printed)": 0.154,
}  # fmt: skip
SHARES = (
    ("acceleration", 0.08),
    ("velocity", 0.04),
    ("displacement", 0.05),
    ("printed", 0.03),
    ("force", 0.02),
    ("", 0.02),
)


@pytest.mark.parametrize(
    ("name", "band"),
    [(name, band) for rows in explained.BANDS.values() for name, band in rows.items()],
)
def test_the_band_of_an_explained_miss_is_as_narrow_as_its_file_says(name, band):
    """2 % of a force, 4 % of a velocity, 5 % of a displacement, 8 % of an acceleration, 1.5 degrees
    of an angle, 3 % of the trains.
    """
    half, middle = (band[1] - band[0]) / 2, abs(band[0] + band[1]) / 2
    if "cam angle" in name:
        assert half == pytest.approx(1.5, abs=0.02)
        return
    share = WIDER.get(name) or next(share for word, share in SHARES if word in name)
    assert 0.95 * share * middle <= half <= 1.2 * share * middle
    found = explained.explained_miss(name)
    assert found is not None and found.band == band and found.why
    assert explained.explained_miss(f"{name} ") is None
