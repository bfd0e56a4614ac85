"""What the moving picture draws is what the solution holds: nodes, colours, forces, lift, to the
rounding that pack.py states.
"""

from __future__ import annotations

import base64
from dataclasses import replace

import numpy as np
import pytest

import valvetrain as vt
from spring_shapes import cylindrical
from synthetic_study import own_study, rod_run
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.study import Study
from valvetrain.views.motion.project import motion_data
from valvetrain.views.motion.scene import choose_frames, moving_picture
from valvetrain.views.motion.springs import largest_between, slope_stress

WIRE = load_case("gu2021-beehive-blind").springs[0].wire


def numbers(text: str, kind: str = "<f4") -> np.ndarray:
    """What motion.js reads out of one array."""
    return np.frombuffer(base64.b64decode(text), kind).astype(float)


@pytest.fixture(scope="module")
def study() -> Study:
    """A made-up run on the wire of the beehive, seven turns as the made-up channels have."""
    base = own_study((rod_run(),))
    return replace(
        base, record=replace(base.record, text=load_case("gu2021-beehive-blind").record().text)
    )


@pytest.fixture(scope="module")
def cycle(study):
    return reported_cycle(study.solutions[0])


@pytest.fixture(scope="module")
def drawn(study):
    """The picture as a page holds it."""
    return motion_data(moving_picture(study))["variants"][0]


def test_nodes_stand_where_the_solution_says(drawn, cycle):
    spring = drawn["springs"][0]
    rest, move = (
        numbers(spring["rest"]),
        numbers(spring["move"]["d"], "<i2").reshape(-1, 15) * spring["move"]["scale"],
    )
    np.testing.assert_allclose(numbers(spring["coil"]), np.arange(0, 7.25, 0.5))
    # Half a step of int16, and single precision of heights below 50 mm.
    allowed = spring["move"]["scale"] / 2 + 4e-6
    assert allowed < 2e-4
    np.testing.assert_allclose(rest + move, 1e3 * cycle.channel("axial_position"), atol=allowed)
    np.testing.assert_allclose(
        numbers(spring["radius"]),
        500 * WIRE.mean_diameter.value(np.arange(0, 7.25, 0.5)),
        rtol=1e-6,
    )


def test_the_helix_is_that_of_the_wire(drawn):
    """motion.js draws x = r cos, z = -hand r sin about the upright axis: the centreline of the
    wire, its z axis turned upright.
    """
    spring = drawn["springs"][0]
    coil, radius = numbers(spring["coil"]), numbers(spring["radius"])
    x, z = radius * np.cos(2 * np.pi * coil), -spring["sign"] * radius * np.sin(2 * np.pi * coil)
    line = 1e3 * WIRE.centreline(coil)
    np.testing.assert_allclose(np.column_stack([x, -z]), line[:, :2], atol=1e-4)


@pytest.mark.parametrize(
    ("key", "channel", "factor"),
    [("stress", "inner_fibre_shear_stress", 1e-6), ("velocity", "axial_velocity", 1.0)],
)
def test_a_colour_is_the_channel(drawn, cycle, key, channel, factor):
    one = next(one for one in drawn["springs"][0]["colours"] if one["key"] == key)
    step = (one["high"] - one["low"]) / 255
    shown = one["low"] + step * numbers(one["d"], "u1").reshape(-1, 15)
    np.testing.assert_allclose(shown, factor * cycle.channel(channel), atol=step / 2 * 1.001)


def test_contact_is_the_larger_of_both_neighbours_per_length_of_wire(drawn, cycle):
    """Pair forces (N) of the channel, half a turn apart, over the wire of half a turn; a node sees
    the pair below and the one above.
    """
    one = next(one for one in drawn["springs"][0]["colours"] if one["key"] == "contact")
    step = (one["high"] - one["low"]) / 255
    shown = one["low"] + step * numbers(one["d"], "u1").reshape(-1, 15)
    upper, force = np.arange(1.0, 7.25, 0.5), cycle.channel("coil_contact_force")
    length = 1e3 * 0.5 * WIRE.line_speed(upper)
    by_pair = {coil: force[:, k] / length[k] for k, coil in enumerate(upper)}
    for node, coil in enumerate(np.arange(0, 7.25, 0.5)):
        wanted = np.maximum(by_pair.get(coil, 0.0), by_pair.get(coil + 1.0, 0.0))
        np.testing.assert_allclose(shown[:, node], wanted, atol=step / 2 * 1.001)
    assert one["unit"] == "N/mm" and one["high"] == pytest.approx(
        np.max([values.max() for values in by_pair.values()])
    )


def test_forces_and_lift_are_the_channels(drawn, cycle):
    by_words = {one["words"]: one for one in drawn["forces"]}
    for words, channel in (
        ("spring on retainer", "retainer_force"),
        ("spring on seat", "seat_force"),
    ):
        np.testing.assert_allclose(
            numbers(by_words[words]["values"]), cycle.channel(channel), rtol=1e-6
        )
        np.testing.assert_allclose(
            numbers(by_words[words]["angle"]), np.degrees(cycle.cam_angle), atol=1e-4
        )
    np.testing.assert_allclose(
        numbers(drawn["lift"]), 1e3 * cycle.channel("valve_lift"), rtol=1e-6, atol=1e-9
    )
    retainer = numbers(drawn["springs"][0]["retainer"])
    np.testing.assert_allclose(
        retainer[0] - retainer,
        1e3 * (cycle.channel("valve_lift") - cycle.channel("valve_lift")[0]),
        atol=1e-5,
    )


@pytest.mark.parametrize("most", [100, 250, 500])
def test_frames_keep_the_peak_of_the_force_and_every_clash(study, cycle, most):
    picture = moving_picture(study, most)
    sample = picture.variants[0].sample
    assert len(sample) <= max(most, 120) + 40
    assert (
        int(np.argmax(cycle.channel("seat_force"))) in sample
        and int(np.argmin(cycle.channel("seat_force"))) in sample
    )
    for event in study.solutions[0].events:
        peak = event.details["peak_cam_angle"] % (2 * np.pi)
        assert np.min(np.abs(cycle.cam_angle[sample] - peak)) <= np.radians(0.25) + 1e-9
    assert np.max(np.diff(np.degrees(cycle.cam_angle[sample]))) <= 0.5 + 2 * 360 / (0.8 * most)


def test_a_spike_between_frames_is_seen_in_the_next():
    values = np.zeros((100, 2))
    values[41, 1] = 7.0
    sample = choose_frames(np.linspace(0, 2 * np.pi, 100, endpoint=False), 20)
    assert 41 not in sample
    shown = largest_between(values, sample)
    assert (
        shown[:, 1].max() == 7.0
        and sample[np.argmax(shown[:, 1])] > 41
        and shown[:, 0].max() == 0.0
    )


def test_a_case_that_cannot_be_built_again_is_left_out():
    assert moving_picture(replace(own_study(), record=replace(own_study().record, text=""))) is None


def test_stress_by_the_slope_of_the_coils_is_that_of_the_textbook():
    """A uniform spring that moves slowly: k 8 F D / (pi d**3) with F the rate times the
    compression, everywhere on the active wire.
    """
    wire = cylindrical("4 mm", "24 mm", "8 mm", total_coils=6)
    coil = np.linspace(0, 6, 61)
    first, last = wire.free_coils
    rate = wire.material.shear_modulus * 4e-3**4 / (8 * 24e-3**3 * (last - first))
    lift = np.array([0.0, 2e-3, 7e-3])
    moved = -lift[:, None] * np.clip((coil - first) / (last - first), 0.0, 1.0)
    found = slope_stress(wire, coil, moved, 250.0)
    active = (coil > first + 0.2) & (coil < last - 0.2)
    k = (6 + 0.5) / (6 - 0.75)
    wanted = 1e-6 * k * 8 * (250.0 + rate * lift) * 24e-3 / (np.pi * 4e-3**3)
    np.testing.assert_allclose(
        found.values[:, active], np.repeat(wanted[:, None], np.sum(active), axis=1), rtol=1e-9
    )
    assert np.all(found.values[:, (coil < first) | (coil > last)] == 0.0)


def test_a_run_that_cannot_be_drawn_is_named_and_the_others_are(study):
    strange = replace(
        rod_run(), provenance=replace(rod_run().provenance, label="lost", model="no-such-model")
    )
    picture = moving_picture(replace(study, solutions=(study.solutions[0], strange)))
    assert [one.label for one in picture.variants] == ["finite-element"]
    assert (
        picture.notes[0].startswith("lost at 5600 rpm could not be drawn: ")
        and "no-such-model" in picture.notes[0]
    )
    with pytest.raises(vt.InputError, match="no-such-model"):
        moving_picture(replace(study, solutions=(strange,)))
