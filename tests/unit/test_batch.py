"""Repeated runs give the same results for any number of workers."""

from __future__ import annotations

import math

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate, sweep
from valvetrain.runs.stopping import PointsStopped, StudyStopped
from valvetrain.runs.workers import available_cores, map_points

RPM = math.pi / 30


def square(value: float) -> float:
    return value * value


def scaled(factor: float, value: float) -> float:
    return factor * value * value


def test_results_keep_their_order_and_progress_counts_up():
    seen = []
    for workers in (1, 2, None):
        assert vt.map(
            square, range(7), workers, lambda done, total: seen.append((done, total))
        ) == tuple(n * n for n in range(7))
    for processes in (False, True):
        for workers in (1, 2, None):
            found = map_points(
                scaled,
                3.0,
                range(7),
                workers,
                processes,
                lambda done, total: seen.append((done, total)),
            )
            assert found == tuple(3.0 * n * n for n in range(7))
    assert seen == [(n, 7) for n in range(1, 8)] * 9
    assert vt.map(square, (), 4) == map_points(scaled, 3.0, (), 4) == ()
    assert available_cores() >= 1


def test_no_worker_is_refused():
    with pytest.raises(InputError, match="workers must be 1 or more"):
        vt.map(square, (1,), 0)
    with pytest.raises(InputError, match="workers must be 1 or more"):
        map_points(scaled, 3.0, (1,), 0)
    with pytest.raises(InputError, match="0 is outside 1 to 256"):
        simulate(load_case("job-t"), workers=0)


def same_bits(one, two) -> None:
    """Every channel, number, event and status of two studies, to the bit."""
    assert [run.label for run in one.solutions] == [run.label for run in two.solutions]
    for first, second in zip(one.solutions, two.solutions, strict=True):
        assert first.channels.identical(second.channels)
        assert first.events == second.events and first.status == second.status
        assert set(first.quantities) == set(second.quantities)
        for name, value in first.quantities.items():
            assert np.array_equal(value, second.quantities[name], equal_nan=True), name
    assert one.still == two.still
    for first, second in zip(one.rest, two.rest, strict=True):
        assert np.array_equal(first.curve.force, second.curve.force)


def test_a_sweep_is_the_same_to_the_bit_for_any_number_of_workers():
    case = load_case("tdi-pushrod", {"train.cycles": 2})
    speeds = [speed * RPM for speed in (3000, 5000, 7600)]
    one, three = (
        sweep(case, speeds, spring_sets=["stock"], workers=workers, critical_speeds=False)
        for workers in (1, 3)
    )
    same_bits(one, three)
    assert len({run.quantities["peak_retainer_force"] for run in one.solutions}) == 3


def test_runs_of_a_spring_and_of_a_train_are_the_same_to_the_bit_for_any_number_of_workers():
    spring, train = load_case("job-c"), load_case("tdi-pushrod", {"train.cycles": 2})
    for case, speeds, models in (
        (spring, [2000 * RPM, 5000 * RPM], ["multi-mass", "modal-varied", "wave-rod-clash"]),
        (train, [3000 * RPM], ["multi-mass", "massless"]),
    ):
        one, three = (
            simulate(case, engine_speeds=speeds, models=models, workers=workers)
            for workers in (1, 3)
        )
        same_bits(one, three)


def test_a_sweep_needs_a_speed():
    with pytest.raises(InputError, match="holds no speed"):
        sweep(load_case("tdi-pushrod"), [])


def test_a_sweep_survives_one_bad_speed_and_names_it(monkeypatch):
    from valvetrain.integrate.train_leapfrog import TrainLeapfrog

    real = TrainLeapfrog.run_to_orbit

    def picky(self, system, cam_speed, *rest):
        if cam_speed > 200:
            raise InputError("the spring finds no equilibrium")
        return real(self, system, cam_speed, *rest)

    monkeypatch.setattr(TrainLeapfrog, "run_to_orbit", picky)
    case = load_case("tdi-pushrod")
    found = sweep(case, [300.0, 500.0], spring_sets=("stock",), models=("massless",), workers=1)
    (sentence,) = found.failures
    assert "massless at 4774.65 rpm" in sentence and "no equilibrium" in sentence
    velocity = found.series(found.labels[0], "seating_velocity").values
    assert np.isfinite(velocity[0]) and np.isnan(velocity[1])


def test_a_sweep_stopped_between_its_speeds_keeps_them_and_shows_its_progress(monkeypatch):
    def stop(*given):
        raise PointsStopped({})

    monkeypatch.setattr("valvetrain.runs.run.run_between", stop)
    shares: list[float] = []
    with pytest.raises(StudyStopped) as stopped:
        sweep(
            "tdi-pushrod", "2000, 3000 rpm", "massless", spring_sets="stock", workers=1,
            compute="error_bars", progress=lambda share, text: shares.append(share),
        )  # fmt: skip
    assert [run.status.code for run in stopped.value.study.solutions] == ["completed"] * 2
    assert (
        shares == sorted(shares) and 0.2 < shares[-1] < 0.3
    )  # the search and the error bars follow
