"""A spring turned slowly: limits between ways of recording one run, contracts on cost and size.

The spring is one of a textbook kind (wire 4 mm, mean diameter 28 mm, seven coils), in no library case.
"""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.cosserat import transient
from valvetrain.integrate import leapfrog
from valvetrain.parameters.templates import template_text
from valvetrain.quantities.signal import prominences
from valvetrain.runs.cost import RunRequest, request_cost

SPRING = {
    "wire_diameter": "4 mm", "mean_diameter": "28 mm", "total_coils": 7.0, "material": "EN 10270-2 VDSiCr",
    "pitch": {"formula": "closed-ends", "pitch": "8.5 mm", "ramp": 0.3}, "ends": {"kind": "closed-ground"},
    "installed_height": "38 mm", "options": {"finite-element": {"elements_per_coil": 8}},
}  # fmt: skip
LIFT = {
    "kind": "polynomial", "exponents": "3-4-5", "maximum_lift": "8 mm", "opening_start": "110 deg",
    "opening_end": "180 deg", "closing_start": "180 deg", "closing_end": "250 deg",
}  # fmt: skip


@pytest.fixture(scope="module")
def case():
    return vt.Case(spring=vt.Spring(**SPRING), lift_law=LIFT)


def template():
    return vt.Case(template_text("spring"))


def headline(case, model, engine_speed="1500 rpm"):
    run = case.run(engine_speed, models=model)
    assert run.status.code in ("completed", "not-converged")
    return run, dict(run.quantities)


def test_blocks_of_steps_and_every_other_force_give_the_same_numbers(case, monkeypatch):
    """A revolution in a block a sample, every fifth force stored: what does not depend on single steps
    agrees to 1e-3.
    """
    whole, expected = headline(case, "multi-mass")
    monkeypatch.setattr(leapfrog, "MAX_FINE", 2**11)
    run, found = headline(case, "multi-mass")
    assert run.channels.sizes["subsample"] < 4 < whole.channels.sizes["subsample"]
    assert run.statistics["steps_per_cycle_count"] >= whole.statistics["steps_per_cycle_count"]
    for name in ("peak_spring_force", "minimum_spring_force", "seat_force_at_rest"):
        if name in expected:
            assert found[name] == pytest.approx(expected[name], rel=1e-3), name
    force, same = (float(one["seat_force"].max()) for one in (whole, run))
    assert same == pytest.approx(force, rel=1e-3)


def test_blocks_of_steps_of_the_rod_are_bit_identical(case, monkeypatch):
    whole, expected = headline(case, "finite-element", "2500 rpm")
    monkeypatch.setattr(transient, "BLOCK", 3000)
    run, found = headline(case, "finite-element", "2500 rpm")
    assert found == expected
    for name in ("seat_force", "coil_contact_force", "work_done", "energy_dissipated"):
        assert np.array_equal(run.channels[name], whole.channels[name])


def test_a_peak_costs_no_scan_of_the_whole_trace():
    """Two hundred thousand samples with forty thousand ripples: each once scanned whole, a minute."""
    place = np.arange(200_000)
    trace = np.sin(1e-4 * place) + 1e-3 * np.sin(1.3 * place)
    peaks = np.flatnonzero((trace[1:-1] > trace[:-2]) & (trace[1:-1] > trace[2:])) + 1
    begun = time.process_time()
    rises = prominences(trace, peaks)
    assert time.process_time() - begun < 3 and len(peaks) > 40_000
    assert rises.max() == pytest.approx(np.ptp(trace), rel=0.1) and np.median(rises) < 3e-3


@pytest.mark.parametrize(
    ("model", "engine_speed", "seconds", "megabytes"),
    [
        ("multi-mass", 4000, 0.36, 0), ("multi-mass", 200, 1.7, 270), ("multi-mass", 100, 2.7, 320), ("multi-mass", 50, 3.3, 325),
        ("finite-element", 200, 3.3, 190), ("finite-element", 100, 5.8, 195), ("finite-element", 50, 12.6, 215),
        ("multi-mass", 10, 9.9, 350), ("finite-element", 50, 24.3, 200), ("wave-rod", 50, 1.2, 190), ("wave-rod", 10, 4.0, 270),
        ("wave-rod-clash", 100, 2.0, 170),
    ],
)  # fmt: skip
def test_estimates_hold_within_a_factor_of_two(model, engine_speed, seconds, megabytes):
    """Processor time (s) and growth of memory (MB) as measured with the template of a spring; of the rod
    on a fast and on a busy machine.
    """
    case = template()
    cost = request_cost(
        RunRequest("run", case.parameters, (engine_speed * math.pi / 30,), (model,), (), 1)
    )
    assert seconds / 2 < cost.seconds < 2 * seconds
    assert not megabytes or megabytes / 2 < cost.bytes / 1e6 < 2 * megabytes


def test_cost_grows_as_one_over_the_speed_and_memory_does_not():
    case = template()
    costs = [
        request_cost(RunRequest("run", case.parameters, (speed,), (model,), (), 1))
        for model in ("multi-mass", "finite-element", "wave-rod-clash")
        for speed in (2.0, 0.5)
    ]
    for slow, slower in zip(costs[::2], costs[1::2], strict=True):
        assert slower.seconds < 4 * slow.seconds and slower.bytes < 600e6
