"""Unit: what a search requests of a design and in which order, and a limit speed whose runs fail."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.explore.engine import Evaluation
from valvetrain.explore.limit_speed import BELOW, BEYOND, FOUND, limit_of
from valvetrain.explore.measure import REST, RUNS, Measure, measure_designs
from valvetrain.explore.outputs import LimitSearch, Outcome, Outputs, Run, limit_search
from valvetrain.explore.space import Space
from valvetrain.solution.status import COMPLETED, Status

AT_REST = (Run(None, "massless"),)
RUNNING = tuple(Run(speed, "massless") for speed in (400.0, 500.0))
FUNCTION = Evaluation(None, Space({}), Outputs("number", function=print))


class Recording:
    """An engine that records the runs of each batch; number ``number_k`` of a run is 10 k and its speed."""

    def __init__(self, failing: bool = False) -> None:
        self.batches, self.failing = [], failing

    def outcomes(self, jobs):
        self.batches.append([task.run for _, _, task in jobs])
        status = Status("diverged", "did not end")
        return [
            Outcome(status) if self.failing and task.run in AT_REST
            else Outcome(values={name: 10.0 * float(name[-1]) + (task.run[0] or 0.0) for name in task.request.outputs})
            for _, _, task in jobs
        ]  # fmt: skip


@pytest.mark.parametrize("sources", [(REST,), (RUNS,), (RUNS, REST), (RUNS, RUNS, REST)])
@pytest.mark.parametrize("failing", [False, True])
def test_a_design_asks_once_for_what_its_measures_need_and_at_rest_first(sources, failing):
    """A design that fails at rest is not run."""
    runs = {REST: AT_REST, RUNS: RUNNING}
    measures = [Measure(f"number_{k}", runs[one], "a number") for k, one in enumerate(sources)]
    engine = Recording(failing)
    (found,) = measure_designs(engine, FUNCTION, [()], measures)
    fails = failing and REST in sources
    stages = [one for one in (REST, RUNS) if one in sources and not (fails and one == RUNS)]
    assert [one for one in engine.batches if one] == [[*runs[one]] for one in stages]
    assert found.code == ("diverged" if fails else "completed") and bool(found.failure) == fails
    if not fails:
        due = [10.0 * k + (0.0 if one == REST else 500.0) for k, one in enumerate(sources)]
        assert [found.values[one] for one in measures] == due


@pytest.mark.parametrize(
    ("fails", "share", "due"),
    [
        ((), None, (BEYOND, 300.0, np.inf)),
        ((100.0,), None, None),  # the lowest speed: the design has no number
        ((200.0, 150.0, 175.0), None, (FOUND, 125.0, 150.0)),
        ((300.0,), None, (FOUND, 275.0, 300.0)),
        ((), 0.5, (BELOW, 0.0, 100.0)),
        ((), 2.0, (BEYOND, 300.0, np.inf)),
    ],
)
def test_a_run_that_fails_counts_as_beyond_the_bound_but_at_the_lowest_speed(
    fails, share, due, monkeypatch
):
    """Speeds 100, 200 and 300 rad/s, then halves to 25 rad/s; the force is 1 N at all, also of the case."""

    def point(case, values, run, request):
        ended = Status("diverged", "did not end") if run.engine_speed in fails else COMPLETED
        return Outcome(ended, {"peak_spring_force": 1.0})

    monkeypatch.setattr("valvetrain.explore.engine.evaluate", point)
    search = LimitSearch("peak_spring_force", True, 5.0, (100.0, 200.0, 300.0), 25.0, share)
    outputs = Outputs(spring_models="massless", limit_speeds=[search])
    experiment = Evaluation("job-c", Space({}), outputs)
    (task,) = experiment.tasks
    outcome = experiment.evaluate((), task)
    assert outcome.status.completed == (due is not None)
    if due is not None:
        found = limit_of(outcome)
        assert (found.kind, found.low, found.high) == due and outcome.values[
            search.name
        ] == found.value
        assert found.bound == (share or 5.0)


def test_speeds_of_a_limit_rise_however_they_are_told():
    told = {"quantity": "clash_energy", "at_most": "5 mJ", "engine_speeds": "9000, 5000, 7000 rpm"}
    found = limit_search(**told)
    assert np.asarray(found.engine_speeds) == pytest.approx(
        np.array([5000, 7000, 9000]) * np.pi / 30
    )
