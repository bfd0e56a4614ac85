"""What a request is estimated to take, by hand, and the sentence that refuses one beyond its bounds."""

from __future__ import annotations

import pytest

from valvetrain.errors import InputError
from valvetrain.studies.cost import COPIES, REDUCED, RUN, Cost, Limits, estimate, memory_words, refuse_cost, time_words


@pytest.mark.parametrize(
    ("more", "seconds", "size"),
    [
        ({}, 4 * RUN + 6.0, 4 * 172800 + COPIES * 172800),
        ({"refinement": 3.0}, 4 * RUN + 54.0, 4 * 172800 + COPIES * 172800),
        ({"own_time": 1.5}, 4 * RUN + 9.0, 4 * 172800 + COPIES * 172800),
        ({"workers": 3}, (4 * RUN + 6.0) / 3, 4 * 172800 + COPIES * 172800 * 3),
        ({"workers": 9}, (4 * RUN + 6.0) / 4, 4 * 172800 + COPIES * 172800 * 4),
        ({"workers": 0}, 4 * RUN + 6.0, 4 * 172800 + COPIES * 172800),
        ({"samples": 100.0, "channels": 5.0}, 4 * RUN + 6.0, 4 * 4000 + COPIES * 4000),
        ({"whole": False}, 4 * RUN + 6.0, 4 * REDUCED + COPIES * 172800),
    ],
)
def test_an_estimate_is_runs_time_and_records(more, seconds, size):
    found = estimate(runs=4, simulated_time=2.0, processor_time=3.0, **more)
    assert (found.seconds, found.bytes) == (pytest.approx(seconds), pytest.approx(size))


def test_costs_add_and_nothing_costs_nothing():
    assert Cost(1.0, 2.0) + Cost(0.5, 4.0) == Cost(1.5, 6.0) and Cost() == Cost(0.0, 0.0)


@pytest.mark.parametrize(
    ("seconds", "told"),
    [(0.2, "1 s"), (59.0, "59 s"), (89.0, "89 s"), (90.0, "1.5 min"), (5399.0, "90 min"), (5400.0, "1.5 h"), (129600.0, "1.5 d"),
     (129000.0, "35.8 h")],
)  # fmt: skip
def test_a_time_as_people_say_it(seconds, told):
    assert time_words(seconds) == told


@pytest.mark.parametrize(("size", "told"), [(1.0, "1 MB"), (999e6, "999 MB"), (1e9, "1 GB"), (2.34567e9, "2.35 GB")])
def test_a_memory_as_people_say_it(size, told):
    assert memory_words(size) == told


@pytest.mark.parametrize(
    ("cost", "limits", "words"),
    [
        (Cost(700.0, 1e6), Limits(), "about 11.7 min and 1 MB, beyond the bound of 10 min; .* with --limit '13 min'$"),
        (Cost(7000.0, 3e9), Limits(), "beyond the bound of 10 min and 2 GB; .* '3 h, 4 GB'$"),
        (Cost(1.0, 2.5e12), Limits(), "beyond the bound of 2 GB; .* '3 TB'$"),
        (Cost(0.5, 0.0), Limits(0.1, 1.0), "beyond the bound of 1 s; .* '1 s'$"),
        (Cost(100000.0, 0.0), Limits(), "'2 d'$"),
    ],
)
def test_a_request_beyond_its_bounds_names_those_that_would_do(cost, limits, words):
    with pytest.raises(InputError, match=words):
        refuse_cost(cost, limits)
    assert refuse_cost(cost, Limits(1e9, 1e15)) == f"about {time_words(cost.seconds)} and {memory_words(cost.bytes)}"


def test_a_request_at_its_bounds_passes():
    assert refuse_cost(Cost(600.0, 2e9), Limits()) == "about 10 min and 2 GB"
    with pytest.raises(InputError, match="limit='11 min'"):
        refuse_cost(Cost(601.0, 2e9), Limits(), "limit=")
