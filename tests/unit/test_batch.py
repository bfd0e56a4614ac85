"""Repeated runs give the same results for any number of workers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.studies.batch import available_cores, map_cases
from valvetrain.studies.sweep import run_sweep


def square(value: float) -> float:
    return value * value


def test_results_keep_their_order_and_progress_counts_up():
    seen = []
    for workers in (1, 2, None):
        assert map_cases(square, range(7), workers, lambda done, total: seen.append((done, total))) == tuple(n * n for n in range(7))
    assert seen == [(n, 7) for n in range(1, 8)] * 3
    assert map_cases(square, (), 4) == ()
    assert available_cores() >= 1


def test_no_worker_is_refused():
    with pytest.raises(InputError, match="workers must be 1 or more"):
        map_cases(square, (1,), 0)


def test_a_sweep_is_the_same_to_the_bit_for_any_number_of_workers():
    case = load_case("tdi-pushrod")
    speeds = [speed * math.pi / 30 for speed in (3000, 5000, 7600)]
    one, two = (run_sweep(case, speeds, spring_sets=("stock",), workers=workers, cycles=12) for workers in (1, 2))
    for name, values in one.series[0].columns.items():
        assert np.array_equal(values, two.series[0].columns[name], equal_nan=True), name
    assert np.array_equal(one.series[0].orders, two.series[0].orders)


def test_a_sweep_needs_a_speed():
    with pytest.raises(InputError, match="at least one engine speed"):
        run_sweep(load_case("tdi-pushrod"), [])


def test_a_sweep_survives_one_bad_speed_and_names_it(monkeypatch):
    from valvetrain.errors import InputError as Refused
    from valvetrain.studies import sweep

    real = sweep.run_job

    def picky(job):
        if job.engine_speed > 400:
            raise Refused("the spring finds no equilibrium")
        return real(job)

    monkeypatch.setattr(sweep, "run_job", picky)
    case = load_case("tdi-pushrod")
    found = run_sweep(case, [300.0, 500.0], spring_sets=("stock",), spring_models=("massless",), workers=1)
    (sentence,) = found.failures
    assert "stock, massless at 4775 rpm" in sentence and "no equilibrium" in sentence
    series = found.series[0]
    assert np.isfinite(series.columns["seating_velocity"][0]) and np.isnan(series.columns["seating_velocity"][1])
