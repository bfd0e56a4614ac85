"""What a request is estimated to take, by hand, and the sentence that refuses one beyond its
bounds.
"""

from __future__ import annotations

import math
from itertools import product

import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring, SpringCard
from valvetrain.parameters.loading import load_case
from valvetrain.runs.cost import (
    COPIES,
    REDUCED,
    RUN,
    Cost,
    Limits,
    duration_text,
    estimate,
    memory_text,
    refuse_cost,
)
from valvetrain.runs.request_cost import RunRequest, request_cost, unknowns_of
from valvetrain.springs.spec import spring_model


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
    ("cost", "limits", "words"),
    [
        (
            Cost(700.0, 1e6),
            Limits(),
            "about 11.7 min and 1 MB, beyond the bound of 10 min; .* with --limit '13 min'$",
        ),
        (Cost(7000.0, 3e9), Limits(), "beyond the bound of 10 min and 2 GB; .* '3 h, 4 GB'$"),
        (Cost(1.0, 2.5e12), Limits(), "beyond the bound of 2 GB; .* '3 TB'$"),
        (Cost(0.5, 0.0), Limits(0.1, 1.0), "beyond the bound of 1 s; .* '1 s'$"),
        (Cost(100000.0, 0.0), Limits(), "'2 d'$"),
    ],
)
def test_a_request_beyond_its_bounds_names_those_that_would_do(cost, limits, words):
    with pytest.raises(InputError, match=words):
        refuse_cost(cost, limits)
    assert (
        refuse_cost(cost, Limits(1e9, 1e15))
        == f"about {duration_text(cost.seconds)} and {memory_text(cost.bytes)}"
    )


def test_a_request_at_its_bounds_passes():
    assert refuse_cost(Cost(600.0, 2e9), Limits()) == "about 10 min and 2 GB"
    with pytest.raises(InputError, match="limit='11 min'"):
        refuse_cost(Cost(601.0, 2e9), Limits(), "limit=")


CARD = InstalledSpring(card=SpringCard(rate=30e3, preload=250.0, mass=0.04))
WIRE = InstalledSpring(
    wire=vt.parameters.cylindrical("4 mm", "24 mm", "7 mm", 8), precompression=5e-3
)


@pytest.mark.parametrize(
    ("spring", "word", "options", "ratio", "unknowns"),
    [
        (WIRE, "finite-element", {}, 1.0, 24 * 8.0),
        (WIRE, "finite-element", {"elements_per_coil": 72}, 3.0, 72 * 8.0),
        (WIRE, "finite-element", {"elements_per_coil": 12}, 0.5, 12 * 8.0),
        (WIRE, "multi-mass", {}, 1.0, 12 * 8.0),
        (WIRE, "multi-mass", {"masses_per_coil": 30}, 2.5, 30 * 8.0),
        (CARD, "multi-mass", {}, 5 / 96, 5.0),
        (CARD, "multi-mass", {"elements": 2}, 5 / 96, 5.0),
        (CARD, "multi-mass", {"elements": 48}, 0.5, 48.0),
        (CARD, "multi-mass", {"elements": 192}, 2.0, 192.0),
        (WIRE, "modal-uniform", {}, 1.0, 40.0),
        (WIRE, "modal-uniform", {"modes": 80}, 2.0, 80.0),
        (WIRE, "massless", {}, 1.0, 1.0),
    ],
)
def test_unknowns_are_those_of_the_finest_option_and_a_card_is_a_chain_of_five(
    spring, word, options, ratio, unknowns
):
    """Over the 24 elements a coil, 12 masses a coil and 5 modes of the defaults; a chain of a card
    over the 96 masses of eight coils.
    """
    found = unknowns_of(
        spring_model(word), spring.with_options(word, **options) if options else spring
    )
    assert found == (pytest.approx(ratio), pytest.approx(unknowns))


#: Bytes of one record of 33 channels of 720 numbers, and of a run that is kept without its
#: channels.
RECORD, WITHOUT = 8 * 720 * 33, 40_000


@pytest.mark.parametrize(
    ("workers", "whole", "springs"), [*product((1, 2, 5), (True, False), (1, 2))]
)
def test_a_spring_alone_costs_its_rest_its_runs_and_every_step_of_its_forces(
    workers, whole, springs
):
    """Cam turns of 0.02 and 0.04 s, two cycles of each, in steps of 2 µs: 10 000 and 20 000 a turn,
    128 bytes while run and 16 kept.
    """
    case = load_case("job-c")
    case = case.replace(springs=case.springs * springs)
    found = request_cost(
        RunRequest("run", case, (200 * math.pi, 100 * math.pi), ("massless",), (), workers), whole
    )
    side = min(workers, 2)
    refinement, channels = math.sqrt(springs), 30 + 3 * springs
    record = RECORD * channels / 33
    assert found.seconds == pytest.approx(
        0.3 * springs + (2 * 0.03 + 0.12 * 0.05 * refinement**2) / side, rel=1e-9
    )
    steps = (128 * 20_000 * side + (16 * 30_000 if whole else 0)) * refinement
    assert found.bytes == pytest.approx(
        steps + 2 * (record if whole else WITHOUT) + 2 * record * side, rel=1e-9
    )
