"""The live chain: its curves are those of a run, bit for bit; the newest question wins; a rod can
be ended.

Evidence: ``simulate`` (which records every channel) against the worker's shorter record; Hooke's
law for a massless spring.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY, parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.workbench import live, live_worker
from valvetrain.workbench.live import LiveChain
from valvetrain.workbench.live_result import LiveResult
from valvetrain.workbench.live_worker import LiveCase
from valvetrain.workbench.pages.orders import models_for
from workbench_parts import SMALL, lives, wait_for
from yardstick import quickest


def test_a_curve_is_that_of_a_run_of_the_changed_case():
    found = LiveCase(SMALL, Path(), "multi-mass").answer({"spring.mass": "50 g"}, "5000 rpm")
    case = parse_case(SMALL, "case", changes={"spring.mass": "50 g"})
    cycle = reported_cycle(vt.simulate(case, "5000 rpm", models=["multi-mass"]).solutions[0])
    assert found.sentence == "" and found.engine_speed == pytest.approx(5000)
    assert np.array_equal(found.force_N, np.round(cycle.channel("retainer_force"), 4))
    assert found.angle_deg[0] == 0 and list(found.angle_deg) == sorted(found.angle_deg)
    assert found.quantities["largest force"][0] == pytest.approx(max(found.force_N), abs=1e-4)


def test_a_massless_spring_is_hookes_law():
    found = LiveCase(SMALL, Path(), "massless").answer({"spring.rate": "40 N/mm"}, "")
    lift = vt.simulate(parse_case(SMALL), models=["massless"]).solutions[0]
    assert found.engine_speed == pytest.approx(4000)
    expected = 250 + 40e3 * reported_cycle(lift).channel("valve_lift")
    assert np.allclose(found.force_N, expected, atol=1e-3)


def test_the_float_speed_of_rigid_parts_is_that_of_a_run():
    """Limit between ways in: rigid theory counts a share of the spring's mass, whatever model runs."""
    changes = {"train.valve.mass": "48 g"}
    found = LiveCase(template_text("direct"), Path(), "").answer(changes, "5000 rpm")
    case = vt.Case(parse_case(template_text("direct"), "case", changes=changes))
    (still,) = case.compare("5000 rpm").still.values()
    live_rpm = found.quantities["contact-loss speed, rigid parts"][0]
    assert live_rpm == pytest.approx(still["rigid_contact_loss_engine_speed"] * 30 / np.pi)


@pytest.mark.parametrize(
    ("changes", "speed", "words"),
    [
        ({"spring.mass": "50 mm"}, "", "is a length"),
        ({"spring.mas": "1 g"}, "", "did you mean"),
        ({}, "4000 kg", "is a mass"),
        ({"operation.engine_speeds": ""}, "", "names no engine speed"),
        ({"a\0": "1"}, "", "unknown"),
        ({"spring.solid_height": "30 mm"}, "", "coil bind"),
    ],
)
def test_a_refusal_is_a_sentence_and_the_next_curve_comes(changes, speed, words):
    case = LiveCase(SMALL, Path(), "multi-mass")
    assert words in case.answer(changes, speed).sentence
    assert case.answer({}, "").sentence == ""


def test_a_chain_curve_of_the_beehive_takes_less_than_a_tenth_of_a_second():
    """Processor time of reading, building and integrating at its highest speed, the best of sixty."""
    text = (LIBRARY / "gu2021-beehive-blind.toml").read_text("utf-8")
    case = LiveCase(text, LIBRARY, live_worker.CHAIN)
    case.answer({}, "")
    heights = iter(f"{6.5 + place / 120} mm" for place in range(60))
    said = []

    def one():
        said.append(case.answer({"spring.precompression": next(heights)}, "").sentence)

    assert quickest(one, 60, 0.1) < 0.1 and not any(said)


def test_of_questions_that_wait_the_last_is_answered_and_nothing_lives_on(monkeypatch):
    results: dict[int, LiveResult] = {}
    with LiveChain(SMALL, spring_model="massless") as chain:
        first = chain.curve()
        assert len(first.force_N) == len(first.angle_deg) == 720
        assert first.engine_speed == pytest.approx(4000)
        assert chain.curve({"spring.rate": "1 kg"}).sentence
        with chain._chain._turn:  # the worker is busy
            threads = []
            for place in range(4):
                asked = {"spring.rate": f"{30 + place} N/mm"}
                threads.append(
                    threading.Thread(
                        target=lambda place=place, asked=asked: results.update(
                            {place: chain.curve(asked)}
                        )
                    )
                )
                threads[-1].start()
                wait_for(lambda place=place: chain._chain._last == place + 3)
        for thread in threads:
            thread.join()
        assert [results[place].skipped for place in range(4)] == [True, True, True, False]
        assert max(results[3].force_N) == pytest.approx(250 + 33 * 9, abs=1e-3)
        chain._chain._longest = 0.0
        assert "took longer than 0 s" in chain.curve({"operation.cycles": "10000"}).sentence
        chain._chain._longest = 120.0
        assert max(chain.curve().force_N) == pytest.approx(250 + 32 * 9, abs=1e-3), (
            "the worker that was ended is replaced"
        )
        process = chain._chain._process
        assert process is not None
    wait_for(lambda: not lives(process.pid))
    assert chain.curve().skipped, "it is closed"


def test_a_train_of_cards_has_the_numbers_of_its_run():
    """Contract: one headline number, whether a slider, the first run of the page or Python asks."""
    text = (LIBRARY.parents[1] / "templates" / "pushrod.toml").read_text("utf-8")
    answer = LiveCase(text, LIBRARY, "").answer({}, "6000 rpm")
    run = vt.Case(text).run("6000 rpm")
    force = reported_cycle(run).channel("retainer_force")
    assert answer.model == run.model == "modal-uniform"
    assert answer.quantities["largest force"][0] == pytest.approx(force.max(), rel=1e-3)
    (first,) = (one for one in models_for(parse_case(text)) if one["chosen"])
    assert first["value"] == run.model


def test_a_rod_is_ended_by_cancel(monkeypatch):
    monkeypatch.setattr(
        live, "ROD", "multi-mass"
    )  # a quick stand-in whose run is made long by its speed
    with LiveChain(SMALL) as chain:
        found: list[LiveResult] = []
        thread = threading.Thread(
            target=lambda: found.append(chain.rod({"operation.cycles": "10000"}, "100 rpm"))
        )
        thread.start()
        wait_for(lambda: chain._rod._busy and chain._rod._process is not None)
        number = chain._rod._process.pid
        chain.cancel()
        thread.join(20)
        assert found and found[0].skipped and not lives(number)


def test_a_worker_ends_with_a_server_that_is_killed():
    code = (
        "import time; from valvetrain.workbench.live import LiveChain; from workbench_parts import SMALL; "
        "one = LiveChain(SMALL, spring_model='massless'); print(one._chain._process.pid, flush=True); time.sleep(120)"
    )
    path = os.pathsep.join(str(Path(__file__).parents[1] / name) for name in ("", "../src"))
    server = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": path},
    )
    assert server.stdout is not None
    number = int(server.stdout.readline())
    assert lives(number)
    server.kill()
    server.communicate()
    wait_for(lambda: not lives(number))


def test_sliders_are_bounded(monkeypatch):
    monkeypatch.setattr(live, "MAX_LIVE", 1)
    with LiveChain(SMALL), pytest.raises(InputError, match="1 sliders are in use"):
        LiveChain(SMALL)
    LiveChain(SMALL).close()


def test_the_float_speed_is_where_a_run_begins_to_float():
    """Runs of the simulation 2.5 % on either side of it, between which the motion of this train does
    not repeat; the numbers of control beside a curve are those of a run.
    """
    text = template_text("direct")
    live_case = LiveCase(text, Path(), "massless")
    found = live_case.float_speed({})
    engine_speed, unit = found.quantities["float speed"]
    assert unit == "rpm" and not found.sentence
    speeds = f"{0.975 * engine_speed}, {1.025 * engine_speed} rpm"
    runs = vt.simulate(parse_case(text, "direct"), speeds, models="massless").solutions
    below, above = (run.quantities["float_excess_lift"] for run in runs)
    assert below <= 50e-6 < above
    told = live_case.answer({}, f"{0.975 * engine_speed} rpm").quantities
    for label, name in (
        ("minimum cam contact force while open", "minimum_cam_contact_force"),
        ("minimum spring margin", "minimum_spring_margin_force"),
    ):
        assert told[label][0] == pytest.approx(runs[0].quantities[name], rel=1e-6, abs=1e-9)


def test_a_spring_alone_has_no_float_speed():
    assert "no float speed" in LiveCase(SMALL, Path(), "massless").float_speed({}).sentence
