"""Chains that run side by side: answers in the order of the chains, and nothing printed where a map
is cut.
"""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from valvetrain.explore import ensembles as lockstep
from valvetrain.explore.ensembles import Lockstep
from valvetrain.runs.error_bars import RefinementStopped
from valvetrain.runs.stopping import PointsStopped, Stopped, StudyStopped

Array = np.ndarray


def test_questions_of_a_batch_stand_in_the_order_of_the_chains() -> None:
    batches: list[list[float]] = []

    def twice(points: Array) -> Array:
        batches.append([float(x) for x in points[:, 0]])
        return 2.0 * points[:, 0]

    pool = Lockstep(twice, 3)
    found = pool.map(
        lambda item: pool.ask(np.array([item])) + pool.ask(np.array([10.0 * item])),
        [1.0, 2.0, 3.0, 4.0],
    )
    assert found == [22.0, 44.0, 66.0, 88.0]
    assert batches == [[1.0, 2.0, 3.0], [10.0, 20.0, 30.0], [4.0], [40.0]]


@pytest.mark.parametrize("late", [False, True])
def test_a_signal_while_a_chain_starts_leaves_nothing_that_prints_later(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], late: bool
) -> None:
    """The signal comes when the third thread runs already but is not yet known to be alive, as the
    interpreter allows.

    ``late``: that thread comes to its function only after the map was cut.
    """
    started: list[lockstep._Chain] = []
    start_thread, run = threading.Thread.start, lockstep._Chain.run

    def start(chain: lockstep._Chain) -> None:
        started.append(chain)
        start_thread(chain)
        if len(started) == 3:
            chain._started = threading.Event()  # type: ignore[attr-defined]
            time.sleep(0.0 if late else 0.1)
            raise Stopped("SIGINT")

    def begin(chain: lockstep._Chain) -> None:
        time.sleep(0.2 if late and chain.item == 3.0 else 0.0)
        run(chain)

    def loud(item: float) -> float:
        try:
            return pool.ask(np.array([item]))
        except BaseException:
            time.sleep(0.1)
            print("Exception while calling a function")
            raise

    monkeypatch.setattr(lockstep._Chain, "start", start)
    monkeypatch.setattr(lockstep._Chain, "run", begin)
    pool = Lockstep(lambda points: points[:, 0], 3)
    with pytest.raises(Stopped):
        pool.map(loud, [1.0, 2.0, 3.0])
    time.sleep(0.5)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("kind", [PointsStopped, StudyStopped, RefinementStopped])
def test_whatever_was_stopped_holds_what_was_finished_and_says_no_more_than_that_it_stopped(kind):
    done = {2: "two"}
    cut = kind(done)
    assert str(cut) == "stopped" and isinstance(cut, KeyboardInterrupt)
    assert (cut.results if kind is PointsStopped else cut.study) == done
