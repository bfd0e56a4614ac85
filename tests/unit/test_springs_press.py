"""Springs press or are loose: no spring model pulls on the retainer or lifts the cylinder head,
unless its ends are held.
"""

from dataclasses import replace

import numpy as np
import pytest

from spring_parts import drive, raised_cosine
from spring_shapes import cylindrical
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.case_changes import changed_case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.spec import spring_model
from valvetrain.springs.wave_rod import WaveRod

CARD = InstalledSpring(card=SpringCard(rate=30e3, preload=60.0, mass=0.05))
WIRE = InstalledSpring(wire=cylindrical("4 mm", "24 mm", "7 mm", 6), precompression=1e-3)
MODELS = ["massless", "multi-mass", "wave-rod", "modal-uniform", "modal-varied"]


def kicked(model, frequency=250.0, lift=8e-3):
    """Both end forces while the retainer goes down and up far quicker than the spring follows, and
    some time after.
    """
    step = min(1e-5, 0.8 * model.stable_time_step())
    model = model.with_time_step(step)
    displacement, velocity = raised_cosine(lift, 1 / frequency, step)
    rest = np.zeros(len(displacement))
    state = model.initial_state(0.0)
    forces = drive(
        model, state, np.concatenate((displacement, rest)), np.concatenate((velocity, rest)), step
    )
    return forces, state, model


@pytest.mark.parametrize("word", MODELS)
def test_a_spring_of_a_card_presses_or_is_loose(word):
    tied, free = (spring_model(word).build(replace(CARD, tied=held)) for held in (True, False))
    pulled, pressed = kicked(tied)[0], kicked(free)[0]
    assert np.min(pressed) >= -1e-9
    if word != "massless":
        assert np.min(pulled) < -30.0
        assert np.max(pressed) == pytest.approx(np.max(pulled), rel=0.5)
    below = -CARD.precompression - 1e-3
    assert free.force(free.initial_state(below), below).retainer == pytest.approx(0.0, abs=1e-9)
    assert tied.force(tied.initial_state(below), below).retainer == pytest.approx(-30.0, rel=0.02)


@pytest.mark.parametrize(
    "word", ["massless", "multi-mass", "wave-rod", "wave-rod-clash", "modal-uniform"]
)
def test_a_spring_of_wire_on_planes_presses_and_one_between_clamps_pulls(word):
    free, held = (
        spring_model(word).build(replace(WIRE, seats=seats)) for seats in ("planes", "clamps")
    )
    assert np.min(kicked(free)[0]) >= -1e-9
    if word != "massless":
        assert np.min(kicked(held)[0]) < 0


@pytest.mark.parametrize(("seats", "pulls"), [("planes", False), ("clamps", True)])
def test_a_retainer_that_leaves_a_rod_is_pulled_by_clamps_alone(seats, pulls):
    wire = replace(WIRE.with_options("finite-element", elements_per_coil=6), seats=seats)
    rod = spring_model("finite-element").build(wire)
    force = rod.force(rod.initial_state(0.0), -2e-3).retainer
    assert (force < -1e3) if pulls else force == 0.0


@pytest.mark.parametrize("word", ["multi-mass", "wave-rod"])
def test_a_loose_end_keeps_momentum_and_energy(word):
    """With an end open only the other force moves the masses; undamped, no energy is made or lost
    over opening and closing.
    """
    model = spring_model(word).build(CARD)
    assert isinstance(model, MultiMassSpring | WaveRod) and not model.pulls
    forces, state, used = kicked(model)
    assert np.sum(forces[:, 0] < 1e-9) > 20
    n, step = used.unknowns, min(1e-5, 0.8 * model.stable_time_step())
    masses = used.layout.masses if isinstance(used, MultiMassSpring) else np.full(n, used.cell_mass)
    totals, momentum, impulse = [], [masses @ state[n : 2 * n]], []
    for _ in range(400):
        retainer, seat = used.kernel(used.parameters(), used.integers(), state, 0.0, 0.0, step)
        impulse.append((retainer - seat) * step)
        momentum.append(masses @ state[n : 2 * n])
        totals.append(used.energy(state, 0.0, 0.0, step).total)
    assert np.diff(momentum) == pytest.approx(np.array(impulse), abs=1e-9)
    assert np.ptp(totals) < 2e-3 * np.max(totals) + 2e-3


def test_no_spring_of_a_train_pulls_beyond_its_speed():
    """The stock spring of the diesel surges past its preload at 9000 rpm; it pulled with 110 N
    before.
    """
    study = simulate(
        load_case("tdi-pushrod"),
        engine_speeds=(9000 * np.pi / 30,),
        spring_sets=["stock"],
        models=MODELS[1:4],
    )
    for solution in study.solutions:
        assert (
            np.min(solution.channel("retainer_force")) >= -1e-9
            and np.min(solution.channel("seat_force")) >= -1e-9
        )


def test_a_source_that_leaves_the_preload_out_keeps_its_formula():
    bare = CARD.without_preload()
    assert bare.pulls and bare.card.preload == 0 and not CARD.pulls
    model = spring_model("massless").build(bare)
    assert model.force(model.initial_state(-1e-5), -1e-5).retainer == pytest.approx(-30e3 * 1e-5)


BINDING = {
    "train.springs.stock.0.card.installed_height": "40 mm",
    "train.springs.stock.0.card.solid_height": "31.5 mm",
}


@pytest.mark.parametrize(
    "word", ["massless", "multi-mass", "wave-rod", "modal-uniform", "finite-element"]
)
def test_a_run_that_passes_coil_bind_says_so(word):
    """8 mm of lift and 8.5 mm to coil bind: the valve that floats at 9000 rpm passes it, the one
    that is led at 4000 does not.
    """
    case = load_case("tdi-pushrod")
    tight = changed_case(case, BINDING)
    speeds = (4000 * np.pi / 30, 10000 * np.pi / 30)
    led, floating = simulate(
        tight, engine_speeds=speeds, spring_sets=["stock"], models=[word], workers=1
    ).solutions
    assert led.status.code != "coil-bind" and led.quantities["coil_bind_clearance"] > 0
    assert floating.quantities["coil_bind_clearance"] == 0
    assert floating.quantities["peak_valve_lift"] == pytest.approx(8.5e-3, rel=1e-12)
    assert (
        floating.status.code == "coil-bind"
        and not floating.status.completed
        and floating.status.where == "stock"
    )
    assert "solid at 8.5 mm of lift" in floating.status.message
    assert np.all(floating.channel("valve_lift") < 8.5e-3)
    assert floating.time[-1] < floating.status.time
    assert all(event.time <= floating.status.time for event in floating.events)
    assert len(floating.cycle["valve_lift"]) == len(floating.time) < len(led.time)
    assert 0 < floating.quantities["float_excess_lift"] < 8.5e-3
    largest = np.max(floating.channel("seat_force"))
    assert floating.quantities["raw_peak_spring_force"] == pytest.approx(largest, rel=1e-3)
    assert 0.7 * largest < floating.quantities["peak_spring_force"] <= 1.001 * largest
    assert not any("peak_valve_lift" in name for name in floating.statistics)


def test_a_spring_whose_card_does_not_tell_its_solid_height_is_not_judged():
    (solution,) = simulate(
        load_case("tdi-pushrod"),
        engine_speeds=(10000 * np.pi / 30,),
        spring_sets=["stock"],
        workers=1,
    ).solutions
    assert solution.status.code != "coil-bind" and "coil_bind_clearance" not in solution.quantities
