"""Unit: the one sentence of each tool's result, with failures, one and several; those of real runs
stand in the tests of the commands.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from unit.test_every_film_table import PEAKS, film, lines, model
from unit.test_every_rig_table import LAID, result
from valvetrain.explore.optimum_summary import optimum_verdict
from valvetrain.film.verdict import film_verdict
from valvetrain.rig.gauge_page import sensor_verdict
from valvetrain.rig.verdict import rig_verdict
from valvetrain.scan.compare import ComparedNumber
from valvetrain.scan.verdict import scan_comparison_verdict
from valvetrain.spring_card.fit import CardDeviation
from valvetrain.spring_card.verdict import card_verdict


def scan(*shares: float, failures: tuple[str, ...] = ()) -> SimpleNamespace:
    """A design compared with a scan whose quantities are off by ``shares``."""
    names = ("preload", "installed_rate", "solid_height", "free_length", "coil_bind_lift")
    numbers = [
        ComparedNumber(name, "", None, 100.0, 100.0 * (1 + share))
        for name, share in zip(names, shares, strict=False)
    ]
    peak = ComparedNumber("peak_spring_force", "chain", 200 * np.pi, 800.0, 700.0)
    return SimpleNamespace(
        numbers=(*numbers, *([peak] if len(shares) > 4 else ())), failures=failures
    )


@pytest.mark.parametrize(
    ("found", "sentence"),
    [
        (scan(0.006, -0.002), "As drawn within 0.6 %."),
        (scan(0.001, 0.03), "1 of 2 quantities are as drawn within 0.1 %, but not installed rate (+3.0 %)."),
        (scan(0.05), "Not as drawn: preload (+5.0 %)."),
        (
            scan(0.03, 0.04, 0.05, 0.001, 0.0),
            "2 of 6 quantities are as drawn within 0.1 %, but not peak spring force below 10 kHz at 6000 rpm (−12.5 %), solid height (+5.0 %), "
            "installed rate (+4.0 %) and 1 more.",
        ),
        (scan(failures=("design: lost",)), "1 run did not complete; scan and design have nothing that can be compared."),
    ],
)  # fmt: skip
def test_a_scan_is_as_drawn_or_says_what_is_not(found, sentence):
    assert scan_comparison_verdict(found) == sentence


@pytest.mark.parametrize(
    ("motion", "beside", "sentence"),
    [
        (
            film(peaks=PEAKS, surge=lines((500.0, 0.01))), None,
            "At 1000 rpm of the cam, coil 2 of 3 moves most, 5 mm; surge at 500 Hz, damping ratio 0.01.",
        ),
        (
            film(), model(model="chain"),
            "beehive by chain is within 0.71 % of every moving coil; coil 2 is the furthest off, 0.035 mm (root mean square).",
        ),
        (
            film(), model(model="chain", peaks=np.array([0.0, 4.9e-3, 0.0])),
            "beehive by chain moves one coil; it is within 0.71 % of its peak of the film.",
        ),
        (film(), model(model="chain", peaks=np.zeros(3)), "No coil moves in beehive by chain."),
        (film(phase=None, surge=None), None, "Free decay of 3 coils."),
        (film(phase=None, surge=None, coils=1), None, "Free decay of 1 coil."),
    ],
)  # fmt: skip
def test_a_film_says_how_near_the_model_is_to_every_moving_coil(motion, beside, sentence):
    assert film_verdict(motion, beside) == sentence


def test_a_recording_says_its_cycles_its_largest_values_and_where_its_mark_is():
    said = (
        "3 of 4 cycles retained at 1010 rpm of the cam: valve lift at most 9 mm (± 0.2 from cycle to cycle), "
        "strain at most 160 µm/m (± 20 from cycle to cycle)"
    )
    assert rig_verdict(result()) == f"{said}."
    synthetic = rig_verdict(result(alignment=LAID, synthetic=True))
    assert synthetic.startswith(f"Synthetic recording: {said}; its mark is at ")


@pytest.mark.parametrize(
    ("found", "left", "sentence"),
    [
        (350.1, ("a",), "6.2 turns of 52 mm free length meet all 2 numbers of the card within 0.1 %; the card left 1 point open."),
        (
            368.0, ("a", "b"),
            "6.2 turns of 52 mm free length miss force at the first height by +5.1 % of the card, the other number is met within 1 %; "
            "the card left 2 points open.",
        ),
    ],
)  # fmt: skip
def test_a_card_is_met_or_the_sentence_says_what_is_missed(found, left, sentence):
    held = (
        CardDeviation("installed_load", 350.0, found),
        CardDeviation("rate", 40e3, 40e3),
        CardDeviation("mass", None, 0.07),
    )
    wire = SimpleNamespace(total_coils=6.2, free_length=52e-3)
    fit = SimpleNamespace(definition=wire, held=held, free=left)
    assert card_verdict(fit) == sentence


def test_a_search_that_found_nothing_says_what_comes_nearest():
    trial = SimpleNamespace(number=5, penalties=[0.0, 0.12], floating=None)
    found = SimpleNamespace(
        best=None, finished=False, trials=range(9), missed_by_least=(trial, "preload at least 40 N")
    )
    assert optimum_verdict(found) == (
        "Stopped after 8 trials: No trial meets every bound. Trial 5 comes nearest; it misses 'preload at least 40 N' by 12 % of the bound: "
        "loosen that bound, or widen the ranges."
    )


def gauge(at: float, largest: float, recorded: float) -> SimpleNamespace:
    """A spike of 970 N in the middle of 100 ms; ``largest`` is recorded at ``at`` (s), ``recorded`` about it."""
    time = np.linspace(0.0, 0.1, 201)
    values, seen = np.full(201, 200.0), np.full(201, 200.0)
    values[100], seen[100] = 970.0, recorded
    seen[round(at / 0.0005)] = largest
    return SimpleNamespace(
        channel="seat_force", unit="N", label="chain", engine_speed=200 * np.pi, true_peak=970.0, recorded_peak=largest,
        share=(largest / 970 - 0.001, largest / 970 + 0.001), time=time, values=values,
        recorded=SimpleNamespace(time=time, values=seen, peak=largest),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("one", "sentence"),
    [
        (
            gauge(0.05, 614.0, 614.0),
            "The gauge records at least 63 % of each peak; least of the seat force, chain, 6000 rpm: 614 of 970 N.",
        ),
        (
            gauge(0.02, 614.0, 300.0),
            "The gauge records at least 63 % of each peak; least of the seat force, chain, 6000 rpm: 614 of 970 N, "
            "and that at another angle: about the true peak it records 300 N.",
        ),
        (
            gauge(0.05, 970.0, 970.0),
            "The gauge records every peak within 0.5 %; least of the seat force, chain, 6000 rpm: 970 of 970 N.",
        ),
    ],
)
def test_a_gauge_says_of_which_channel_it_records_least(one, sentence):
    """The largest value that it records may belong to another, wider peak than the true one."""
    assert sensor_verdict(one) == sentence
