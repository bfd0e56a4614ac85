"""Unit: a run against measured cycles, stretch by stretch, with offsets put in by hand.

Which stretches are judged (those that hold three angles at least), what is told of each, and what
is told where there are none.
"""

from __future__ import annotations

import numpy as np
import pytest

from synthetic_spring import bump, run
from valvetrain.compare_test.comparison import (
    ComparisonRequest,
    RunAgainstTest,
    Stage,
    against_cycles,
)
from valvetrain.measured.cycles import MeasuredCycles

ANGLES = 360
DEGREES = np.arange(ANGLES) * 360.0 / ANGLES
#: Model less test (N) before, in and after the lift event.
OFFSETS = {"before": 3.0, "open": -7.0, "after": 11.0}
EDGES = {"before": (0, 120), "open": (120, 240), "after": (240, 360)}


def force(degrees: np.ndarray) -> np.ndarray:
    return 300 + 500 * bump(degrees, 180, 106) + 20 * np.cos(np.radians(3 * degrees))


def judged(*stages: Stage) -> RunAgainstTest:
    """A made-up run against six cycles about its own force less the offsets; the scatter of the
    cycles cancels in their mean.
    """
    mean = force(DEGREES)
    for word, (first, last) in EDGES.items():
        mean[first:last] -= OFFSETS[word]
    turned = np.outer(np.arange(1, 9), np.radians(DEGREES))
    drawn = np.random.default_rng(3).standard_normal((3, 2, 8))
    half = drawn[:, 0] @ np.cos(turned) + drawn[:, 1] @ np.sin(turned)
    cycles = MeasuredCycles(
        "seat_force",
        "N",
        np.radians(DEGREES),
        mean + np.concatenate([half, -half]),
        300.0,
        "made up",
        synthetic=True,
    )
    solution = run(
        {"valve_lift": lambda degrees: 9e-3 * bump(degrees, 180, 106), "seat_force": force}
    )
    return against_cycles(solution, cycles, ComparisonRequest(cycles, level=0.95), stages)


def stage(word: str) -> Stage:
    first, last = EDGES[word]
    return word, np.radians(first - 0.5), np.radians(last - 0.5)


def test_each_stretch_tells_its_own_error_and_extremes() -> None:
    found = judged(("before", 0.0, np.radians(119.5)), stage("open"), stage("after"))
    assert [row.name for row in found.stages] == list(OFFSETS)
    assert [row.bias for row in found.stages] == pytest.approx(list(OFFSETS.values()), abs=1e-9)
    assert [row.rms for row in found.stages] == pytest.approx(
        [abs(one) for one in OFFSETS.values()], abs=1e-9
    )
    names = [event.name for event in found.events if event.dimension == "value"]
    assert names[:6] == [f"{word}, {end}" for word in OFFSETS for end in ("largest", "least")]
    assert not {"largest", "least"} & set(names), (
        "of the whole turn only where there are no stretches"
    )


@pytest.mark.parametrize(
    ("angles", "told"), [(0, False), (1, False), (2, False), (3, True), (4, True), (40, True)]
)
def test_a_stretch_is_judged_from_three_angles_on(angles: int, told: bool) -> None:
    found = judged(("narrow", np.radians(149.5), np.radians(149.5 + angles)), stage("after"))
    assert [row.name for row in found.stages] == (["narrow"] if told else []) + ["after"]
    assert any(event.name.startswith("narrow") for event in found.events) == told


def test_without_stretches_the_whole_turn_has_its_extremes() -> None:
    found = judged()
    assert found.stages == ()
    assert [event.name for event in found.events if event.dimension == "value"][:2] == [
        "largest",
        "least",
    ]
