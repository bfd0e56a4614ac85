"""The engine alone, no run behind its points: what it costs, what it keeps in memory, what it does
with lost workers and stops.
"""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from valvetrain import InputError
from valvetrain.explore.execution import Execution
from valvetrain.explore.files import FileText
from valvetrain.explore.outputs import Outcome
from valvetrain.explore.study import (
    StudyModel,
    estimate_study,
    read_plan,
    run_plan,
)
from valvetrain.runs.cost import Limits
from valvetrain.runs.workers import Lost
from yardstick import quickest

TEXT = """
case = "gu2021-beehive-blind"
engine_speeds = "6000 rpm"
spring_models = "{model}"
outputs = ["peak_spring_force", "minimum_spring_force"]
points = {{ sampler = "grid", levels = {levels} }}
vary = [
  {{ key = "spring.precompression", low = "6 mm", high = "8 mm" }},
  {{ key = "spring.total_coils", low = 6.5, high = 7.5 }},
]
"""


def plan_of(levels: int, model: str = "massless"):
    return read_plan(FileText(TEXT.format(levels=levels, model=model), "study", Path(), StudyModel))


class Instant:
    """Workers whose points take no time: their outputs are their inputs."""

    def __init__(self, lose=(), stop_after=None) -> None:
        self.jobs, self.lose, self.stop_after, self.points = 0, lose, stop_after, 0

    def __call__(self, function, shared, count):
        self.shared = shared
        return self

    def __enter__(self):
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def stream(self, jobs):
        for place, job in enumerate(jobs):
            self.jobs += 1
            if self.stop_after is not None and self.jobs > self.stop_after:
                raise KeyboardInterrupt
            self.points += len(job)
            found = [
                Outcome(
                    values=dict(zip(self.shared[index].outputs.quantities, values, strict=True))
                )
                for index, values, _ in job
            ]
            yield place, Lost() if self.jobs in self.lose else found


@pytest.fixture
def computed(monkeypatch):
    """The table of a plan by instant workers."""

    def run(plan, workers: Instant, output=None, limit=Limits()):
        monkeypatch.setattr("valvetrain.explore.engine.StandingPool", workers)
        return run_plan(plan, Execution(workers=2, output=output, limit=limit))

    return run


def test_a_point_costs_the_engine_less_than_a_millisecond(computed, tmp_path):
    """Processor time of this process, digest, store and table included, on disk."""
    plan, folders = plan_of(60), iter("abc")
    tables = []

    def anew():
        tables.append(computed(plan, Instant(), tmp_path / next(folders), Limits(1e9, 1e12)))

    taken, table = quickest(anew), tables[0]
    assert taken / len(table) < 1e-3
    assert np.array_equal(table.values, table.inputs)


def test_memory_of_a_point_is_bounded(computed, tmp_path):
    """At most 600 bytes a point, the table of 2 inputs and 2 outputs included: 10 000 points take 6
    MB.
    """
    peaks = {}
    for levels in (3, 12, 36):
        plan = plan_of(levels)
        tracemalloc.start()
        table = computed(plan, Instant(), tmp_path / str(levels), Limits(1e9, 1e12))
        peaks[len(table)] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert (peaks[36**2] - peaks[12**2]) / (36**2 - 12**2) < 600
    assert peaks[36**2] < estimate_study(plan, 2).bytes


def test_points_of_a_lost_worker_keep_their_status_and_are_tried_by_the_next_start(
    computed, tmp_path
):
    plan = plan_of(6)
    table = computed(plan, Instant(lose=(2,)), tmp_path / "points")
    codes = [one.code for one in table.statuses]
    assert (
        codes.count("worker-lost") == 8
        and codes.count("completed") == 28
        and len(table.failures) == 8
    )
    told = {(one.message, one.remedy) for one in table.statuses if one.code == "worker-lost"}
    assert told == {
        (
            "the worker process that ran it was killed, and so was the one that tried it again",
            "take fewer workers if the memory was not enough",
        )
    }
    again = Instant()
    assert computed(plan, again, tmp_path / "points").completed.all() and again.points == 8


def test_points_that_a_list_names_twice_are_computed_once(computed):
    text = TEXT.format(levels=2, model="massless").replace(
        'sampler = "grid", levels = 2', 'sampler = "list"'
    )
    text = text.replace('low = "6 mm", high = "8 mm"', 'values = "6, 7, 6 mm"').replace(
        "low = 6.5, high = 7.5", "values = [7, 7, 7]"
    )
    executor = Instant()
    table = computed(read_plan(FileText(text, "study", Path(), StudyModel)), executor)
    assert len(table) == 3 and executor.points == 2 and np.array_equal(table.values, table.inputs)


def test_the_estimate_grows_with_points_and_models_and_shrinks_with_workers():
    few, many, rods = (
        estimate_study(plan_of(5), 2),
        estimate_study(plan_of(50), 2),
        estimate_study(plan_of(50, "finite-element"), 2),
    )
    assert many.seconds == pytest.approx(100 * few.seconds)
    assert rods.seconds > 5 * many.seconds
    assert estimate_study(plan_of(50), 4).seconds == pytest.approx(many.seconds / 2)


def test_a_request_beyond_its_bound_is_refused_with_its_numbers(computed):
    with pytest.raises(InputError, match=r"beyond the bound of 1 s"):
        computed(plan_of(50), Instant(), limit=Limits(1.0, 1e12))
