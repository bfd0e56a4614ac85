"""Limits: recordings made from a known motion; what comes out is that motion, within the band that
is stated.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.rig.alignment import align_lift
from valvetrain.rig.channels import RigAnswers
from valvetrain.rig.cutting import LowPass
from valvetrain.rig.cycles import cycles_in
from valvetrain.rig.reader import Recording, RigChannel
from valvetrain.rig.shaft import decode_counts, number_teeth

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from sample_rig import Rig, columns, record

TURN = 2 * np.pi


def lift(angle):
    """Valve lift (m): 9 mm, unlike on either side."""
    at = np.asarray(angle) % TURN
    return 9e-3 * np.clip(1 - ((at - np.pi - 0.08 * np.cos(at)) / 1.05) ** 2, 0, None) ** 3


def force(angle):
    """Spring force (N): preload, rate and a surge."""
    return 250 + 40e3 * lift(angle) + 30 * np.sin(20 * np.asarray(angle)) * lift(angle) / 9e-3


def recording(rig, step=None):
    """The recording without a file between."""
    records = record(rig, lift, force)
    channels = tuple(
        RigChannel(name, unit, values, step=step or 1 / rig.sampling_rate)
        for name, unit, values in columns(records)
    )
    return Recording("samples", channels, synthetic=True)


WHEEL = RigAnswers(
    angle_of="crank",
    pulses="Crank wheel",
    index="Cam pulse",
    teeth=60,
    missing=1,
    zero={"spring_force": "250 N"},
)
ENCODER = RigAnswers(angle_of="crank", encoder="Crank angle", zero={"spring_force": "250 N"})


@pytest.fixture(scope="module")
def recorded():
    return recording(Rig(slipped=3))


@pytest.fixture(scope="module")
def short():
    return recording(Rig(cycles=5))


@pytest.mark.parametrize("answers", [WHEEL, ENCODER], ids=["wheel", "encoder"])
def test_the_known_mean_lies_within_the_stated_band(recorded, answers):
    found = cycles_in(recorded, "known", answers, lift)
    assert (
        found.synthetic
        and [place for place, _ in found.outliers] == [3]
        and len(found.retained) == 11
    )
    for channel, true in zip(found.channels, (force, lift), strict=True):
        away = np.abs(channel.cycles.mean - true(channel.cycles.cam_angle))
        assert 0.93 < np.mean(away <= channel.spread) <= 1.0
        assert away.max() < 2.5 * np.median(channel.spread)
    assert np.degrees(abs(found.offset)) < 0.01 and np.degrees(2 * found.offset_uncertainty) < 0.02


def test_without_noise_what_is_left_is_a_ten_thousandth():
    clean = recording(Rig(force_noise=0.0, lift_noise=0.0, jitter=0.0, force_drift=0.0))
    found = cycles_in(clean, "clean", replace(WHEEL, offset=0.0))
    for channel, true, swing in zip(found.channels, (force, lift), (390.0, 9e-3), strict=True):
        assert (
            np.max(np.abs(channel.cycles.mean - true(channel.cycles.cam_angle))) < 1.5e-3 * swing
        )  # half a sample of a tooth's edge
    smooth = cycles_in(clean, "clean", replace(ENCODER, offset=0.0))
    assert (
        np.max(np.abs(smooth.channels[1].cycles.mean - lift(smooth.grid.cam_angle))) < 2e-4 * 9e-3
    )


def test_one_pulse_a_turn_says_that_speed_within_a_turn_is_unseen(recorded):
    steady = recording(Rig(turn_variation=0.0))
    once = RigAnswers(angle_of="cam", once="Cam pulse")
    found = cycles_in(steady, "once", once, lift)
    assert np.degrees(abs(found.offset)) < 0.1
    assert any("within a revolution is not seen" in note for note in found.notes)
    shaken = cycles_in(recorded, "once", once, lift)
    assert np.degrees(abs(shaken.offset)) > 0.1, "what it cannot see moves the cycle"


def test_speed_follows_the_shaft(recorded):
    rig = Rig()
    found = cycles_in(recorded, "known", WHEEL, lift)
    times = np.linspace(0.05, 0.4, 400)
    step = 1e-6
    from sample_rig import cam_angle_at

    true = (cam_angle_at(rig, times + step) - cam_angle_at(rig, times - step)) / (2 * step)
    assert np.max(np.abs(found.shaft.cam_speed(times) / true - 1)) < 6e-3
    told = np.degrees(np.abs(found.shaft.angle_at(times) - cam_angle_at(rig, times)) % TURN)
    assert np.max(np.minimum(told, 360 - told)) < 0.04


@pytest.mark.parametrize("angles", [360, 720, 2880])
def test_the_grid_of_angles_moves_nothing_that_it_can_hold(short, angles):
    """Below the band the cycles are the same numbers on any grid: halved, doubled, as the band
    needs.
    """
    asked = replace(WHEEL, band="3 kHz", offset=0.0)
    usual, other = (
        cycles_in(short, "grid", replace(asked, angle_count=points)) for points in (1440, angles)
    )
    shared = np.gcd(1440, angles)
    for one, two in zip(usual.channels, other.channels, strict=True):
        np.testing.assert_allclose(
            two.cycles.values[:, :: angles // shared],
            one.cycles.values[:, :: 1440 // shared],
            rtol=0,
            atol=1e-9 * np.ptp(one.cycles.values),
        )


def test_a_tone_above_the_grid_does_not_fold_back():
    """A tone at 12 kHz, grid of 360 angles at 25 Hz (Nyquist 4.5 kHz): it is gone by 80 dB, where
    plain picking folds it to 3 kHz.
    """
    rig = Rig(force_noise=0.0, force_drift=0.0, turn_variation=0.0, drift_of_speed=0.0, jitter=0.0)
    plain = recording(rig)
    times = np.arange(len(plain.channels[0].values)) / rig.sampling_rate
    tone = 0.1 * np.sin(TURN * 12e3 * times)
    with_tone = Recording(
        "tone",
        (replace(plain.channels[0], values=plain.channels[0].values + tone), *plain.channels[1:]),
    )
    asked = replace(ENCODER, angle_count=360, offset=0.0, zero={})
    one, two = (cycles_in(given, "tone", asked) for given in (plain, with_tone))
    folded = np.max(np.abs(two.channels[0].cycles.values - one.channels[0].cycles.values))
    assert folded < 1.5e-4 * 100.0
    assert one.channels[0].band < 0.8 * 4500 * 1.001
    picked = np.interp(two.grid.times, times, 100 * np.sin(TURN * 12e3 * times))
    assert np.max(np.abs(picked)) > 50.0, "the same tone picked without a filter would stay"


def test_a_cut_recording_gives_the_same_cycles(recorded):
    """Cycles do not know what was recorded before and after them, but for the ends of the spline."""
    half = Recording(
        "half",
        tuple(replace(one, values=one.values[: len(one.values) // 2]) for one in recorded.channels),
    )
    whole, part = (
        cycles_in(given, "cut", replace(ENCODER, offset=0.0, zero={}, keep_outliers=True))
        for given in (recorded, half)
    )
    count = len(part.retained) - 1
    for one, two in zip(whole.channels, part.channels, strict=True):
        np.testing.assert_allclose(
            two.cycles.values[:count],
            one.cycles.values[:count],
            atol=2e-3 * np.ptp(one.cycles.values),
        )


def test_the_low_pass_has_the_gain_that_it_states():
    step, times = 1e-5, np.arange(6000) * 1e-5
    by = LowPass(step, 8e3, 10e3)
    at = np.linspace(0.02, 0.04, 301)
    for frequency, least, most in (
        (100.0, 0.9998, 1.0002),
        (7.9e3, 0.999, 1.001),
        (9e3, 0.45, 0.55),
        (10.1e3, 0.0, 2e-4),
        (40e3, 0.0, 2e-4),
    ):
        gain = np.max(np.abs(by.at(np.exp(2j * np.pi * frequency * times).real, 0.0, at)))
        wave = by.at(np.sin(2 * np.pi * frequency * times), 0.0, at)
        assert least - 1e-3 <= max(gain, np.max(np.abs(wave))) <= most
    slow = np.sin(2 * np.pi * 500 * times + 0.3)
    np.testing.assert_allclose(
        by.at(slow, 0.0, at), np.sin(2 * np.pi * 500 * at + 0.3), atol=2e-4
    )  # no phase
    assert np.isnan(by.at(slow, 0.0, np.array([0.0, times[-1]]))).all()


def test_lift_alignment_is_right_within_its_uncertainty():
    """Over 60 seeds the stated standard uncertainty is that of the found offsets."""
    grid = np.linspace(0, TURN, 720, endpoint=False)
    away = []
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(0, 20e-6, 720)
        found = align_lift(grid, 1.02 * lift(grid + 1.3) + 15e-6 + noise, lift)
        away.append((found.offset - 1.3) / found.uncertainty)
        assert found.gain == pytest.approx(1.02, abs=0.003) and found.base == pytest.approx(
            15e-6, abs=8e-6
        )
    assert 0.5 < np.std(away) < 1.3


def test_flanks_that_disagree_widen_the_uncertainty():
    grid = np.linspace(0, TURN, 720, endpoint=False)
    late = lift(grid - 0.02 * (np.sin(grid) < 0))  # the closing flank comes late
    found = align_lift(grid, late, lift)
    assert abs(found.opening - found.closing) == pytest.approx(0.02, rel=0.1)
    assert found.uncertainty == pytest.approx(0.01, rel=0.1)


def test_strain_by_calibration_is_the_force():
    plain = recording(Rig())
    bridge = replace(
        plain.channels[0], name="Bridge", unit="um/m", values=plain.channels[0].values * 1e3 / 2.5
    )
    made = Recording("bridge", (bridge, *plain.channels[1:]))
    asked = replace(WHEEL, channels={"spring_force": "Bridge", "valve_lift": "Valve lift"})
    with pytest.raises(
        InputError, match=r"does not say the calibration of spring_force \('Bridge' is in um/m\)"
    ):
        cycles_in(made, "bridge", asked, lift)
    found = cycles_in(made, "bridge", replace(asked, calibration={"spring_force": "2.5 N"}), lift)
    mean = found.channels[0].cycles.mean
    assert np.max(np.abs(mean - force(found.grid.cam_angle))) < 8.0


def test_drift_is_taken_off_in_the_dwell(recorded):
    found = cycles_in(recorded, "known", WHEEL, lift)
    taken = found.channels[0].taken_off
    rig = Rig()
    middle = (found.grid.cut_times[1:] + found.grid.cut_times[:-1]) / 2
    true = rig.force_offset + rig.force_drift * middle / ((rig.cycles + 0.4) * TURN / rig.cam_speed)
    assert len(taken) >= len(true) - 3, "dwells of the slipped cycle tell no zero"
    assert np.all(np.diff(taken) > 1.0) and true[0] - 2 < taken[0] < taken[-1] < true[-1] + 2


def wheel(teeth, missing, seed=1, speed=25.0, turns=30.3):
    """Times of the edges of a crank wheel, the mark at zero."""
    tooth = np.arange(int(turns * teeth))
    there = tooth % teeth < teeth - missing
    times = (tooth[there] + 0.3 * teeth) / teeth / (2 * speed)
    return times + np.random.default_rng(seed).normal(0, 1e-6, len(times))


@pytest.mark.parametrize(("teeth", "missing"), [(60, 2), (36, 1), (60, 0), (2, 0)])
def test_wheels_are_counted(teeth, missing):
    found = number_teeth(wheel(teeth, missing), teeth, missing, "wheel")
    assert not found.notes
    assert found.numbers[-1] == next(
        place for place in range(int(30.3 * teeth) - 1, 0, -1) if place % teeth < teeth - missing
    )
    if missing:
        assert set(np.diff(found.marks)) == {teeth} and found.marks[0] == teeth


def test_lost_and_false_pulses_are_told():
    times = wheel(60, 2)
    lost = number_teeth(np.delete(times, [400, 777]), 60, 2, "wheel")
    assert (
        "2 pulses of 'wheel' were lost" in lost.notes[0]
        and lost.numbers[-1] == number_teeth(times, 60, 2, "wheel").numbers[-1]
    )
    false = number_teeth(
        np.sort(np.append(times, [times[500] + 5e-5, times[900] + 7e-5])), 60, 2, "wheel"
    )
    assert (
        "2 pulses of 'wheel' follow too soon" in false.notes[0]
        and false.numbers[-1] == lost.numbers[-1]
    )


@pytest.mark.parametrize(
    ("teeth", "missing", "words"),
    [
        (58, 2, "does not come back after 58 teeth"),
        (60, 0, "say teeth 60 and missing 2"),
        (60, 5, "no gap of 5 missing teeth"),
    ],
)
def test_a_wheel_that_is_not_as_told_is_refused(teeth, missing, words):
    with pytest.raises(InputError, match=words):
        number_teeth(wheel(60, 2), teeth, missing, "wheel")


def test_gaps_and_uneven_times_leave_out_what_was_not_measured(recorded):
    rig = Rig()
    times = np.arange(len(recorded.channels[0].values)) / rig.sampling_rate
    keep = (times < 0.20) | (times > 0.21)
    gapped = tuple(
        replace(one, values=one.values[keep], times=times[keep], step=0.0)
        for one in recorded.channels[:2]
    )
    found = cycles_in(
        Recording("gaps", (*gapped, *recorded.channels[2:])),
        "gaps",
        replace(ENCODER, offset=0.0),
        lift,
    )
    assert any("with 1 gaps that are left open" in note for note in found.notes)
    named = {place: why for place, why in found.outliers}
    hit = [
        place
        for place in range(found.grid.cycles)
        if found.grid.cut_times[place] < 0.21 and found.grid.cut_times[place + 1] > 0.20
    ]
    assert hit and all("was not measured as a whole" in named[place] for place in hit)
    assert np.isfinite(found.channels[0].cycles.values).all()


def test_a_falling_encoder_is_turned_round(recorded):
    angle = recorded.channels[4]
    falling = Recording(
        "falling", (*recorded.channels[:4], replace(angle, values=720.0 - angle.values))
    )
    found = cycles_in(falling, "falling", ENCODER, lift)
    assert (
        any("its sign is changed" in note for note in found.notes)
        and np.degrees(abs(found.offset)) < 0.03
    )


@pytest.mark.parametrize(("per_sample", "step"), [(0.9, 0.0), (0.05, 1.0), (0.37, 0.1), (0.2, 0.5)])
def test_counts_are_told_from_a_smooth_angle(per_sample, step):
    """Even speed: a smooth angle (step 0) is left as it is; counts of 1, 0.1 and 0.5 degrees are
    put back to the angle they stand for.
    """
    true = np.radians(per_sample) * np.arange(4000) + 0.001
    shown = np.floor(true / np.radians(step) + 1e-9) * np.radians(step) if step else true
    times, angles, found = decode_counts(shown, np.arange(4000.0))
    assert np.degrees(found) == pytest.approx(step, abs=1e-4)
    away = np.degrees(angles - (np.radians(per_sample) * times + 0.001))
    assert (
        abs(np.mean(away))
        < 0.03 * max(step, 1e-9) + 0.5 * per_sample * (step > per_sample) * 0.1 + 1e-9
    )
