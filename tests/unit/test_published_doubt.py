"""A published number that its own source contradicts: shown, told as such, and no part of the
largest difference.
"""

from __future__ import annotations

from valvetrain.cli.answers import published_summary
from valvetrain.quantities.compare import compare
from valvetrain.report.run_verdict import published_sentences
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import Quantity

COMPUTED = {
    Quantity("peak_lever_speed", 400.0, "m"): 50.0,
    Quantity("peak_spring_force", 400.0, "m"): 880.0,
}


def rows(doubt: str):
    values = (
        PublishedValue(
            "peak_lever_speed", 10.0, "deg/s", engine_speed=400.0, model="m", doubt=doubt
        ),
        PublishedValue(
            "peak_spring_force", 800.0, "N", engine_speed=400.0, model="m", used_for="the rate"
        ),
    )
    return compare(values, COMPUTED, None)


def test_a_number_that_is_not_in_doubt_counts():
    assert "doubt" not in published_summary(rows(""))
    assert "Furthest: peak lever rotation speed" in published_sentences(rows(""))
