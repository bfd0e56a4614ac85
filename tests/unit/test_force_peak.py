"""The peak of a force below a cut-off: that of scipy's filter, and no property of samples, steps, phase
or contact constants.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles, RunOptions
from valvetrain.integrate.run import run
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.evaluate import evaluate
from valvetrain.runs.api import simulate
from valvetrain.runs.differences import result_differences
from valvetrain.runs.prepared import prepare
from valvetrain.runs.saved_runs import DEFINITIONS, FORCE, SavedRun
from valvetrain.solution.force_peak import filtered_cycle, force_peak
from valvetrain.system.build import build

PERIOD, STEP = 15e-3, 1e-7
TIME = STEP * np.arange(round(PERIOD / STEP))
PEAKS = ("peak_spring_force", "peak_retainer_force")


def spiked(width: float, impulse: float, place: float = 0.3) -> np.ndarray:
    """A half-sine of that width (s) and impulse (N s) on one slow wave (N)."""
    since = (TIME - place * PERIOD) / width
    spike = np.where((since > 0) & (since < 1), np.sin(np.pi * since), 0.0)
    return 300 + 200 * np.cos(2 * np.pi * TIME / PERIOD) + impulse * np.pi / (2 * width) * spike


def peak(values: np.ndarray, cutoff: float = 10e3, averaged: int = 1):
    means = values.reshape(-1, averaged).mean(axis=1)
    place = float(np.argmax(values)) / len(values)
    return force_peak(means, averaged * STEP, cutoff, float(values.max()), place, averaged)


@pytest.mark.parametrize("cutoff", [3e3, 10e3, 30e3])
@pytest.mark.parametrize("width", [8e-6, 80e-6])
def test_the_peak_is_that_of_the_zero_phase_filter_of_scipy(width, cutoff):
    values = spiked(width, 0.03, 0.02)
    sections = butter(4, cutoff, fs=1 / STEP, output="sos")
    expected = sosfiltfilt(sections, np.tile(values, 3))[len(TIME) : 2 * len(TIME)].max()
    assert expected > 501  # the spike makes it, not the wave under it
    for averaged, within in ((1, 2e-4), (10, 2e-4), (40, 2e-3)):  # of 8 us, bins of 4 fold a little
        assert peak(values, cutoff, averaged).below == pytest.approx(expected, rel=within)


def test_a_spike_far_shorter_than_the_filter_has_its_width_for_its_duration():
    """Impulse over height of a half-sine: 2 / pi of its width."""
    for width in (1e-6, 2e-6):
        found = peak(spiked(width, 2e-4, 0.01)).duration
        assert found == pytest.approx(2 / np.pi * width, rel=0.05)
    assert np.isnan(peak(spiked(3e-3, 0.03)).duration)  # no spike: the filter takes nothing away


@pytest.mark.parametrize("place", [0.0, 1e-4, 0.25, 0.5, 0.9999])
def test_the_phase_of_the_cycle_moves_nothing_and_its_ends_add_nothing(place):
    values = spiked(40e-6, 0.03)
    expected, found = peak(values), peak(np.roll(values, round(place * len(values))))
    assert found.below == pytest.approx(expected.below, rel=1e-5)
    assert found.duration == pytest.approx(expected.duration, rel=1e-3)
    assert (found.place - expected.place - place + 0.5) % 1.0 == pytest.approx(0.5, abs=1e-3)


def test_a_wave_at_the_cut_off_is_halved_and_bins_do_not_weaken_what_is_below():
    for averaged, cutoff in ((1, 10e3), (40, 10e3), (40, 50e3)):
        wave = np.cos(2 * np.pi * cutoff * TIME).reshape(-1, averaged).mean(axis=1)
        found = filtered_cycle(wave, averaged * STEP, cutoff, averaged)
        assert found.max() == pytest.approx(0.5, rel=2e-3)


def chain_at(stiffness: float, word: str = "multi-mass") -> dict[str, float]:
    case = load_case("job-c")
    (spring,) = case.springs
    contact = replace(spring.contact, stiffness=stiffness * spring.contact.stiffness)
    made = simulate(
        case.replace(springs=(replace(spring, contact=contact),)), models=(word,), workers=1
    )
    return dict(made.solutions[-1].quantities)


@pytest.mark.slow
def test_contact_constants_decide_the_raw_peak_and_not_the_peak_below_10_khz():
    soft, own, hard = (chain_at(factor) for factor in (0.25, 1.0, 4.0))
    for other in (soft, hard):
        raw = abs(other["raw_peak_spring_force"] / own["raw_peak_spring_force"] - 1)
        assert raw > 0.15
        assert other["peak_spring_force"] == pytest.approx(own["peak_spring_force"], rel=0.03)
    assert 1e-6 < hard["raw_peak_spring_force_duration"] < 2e-5
    assert "below_10_khz_peak_spring_force" not in own


@pytest.mark.slow
def test_contact_constants_leave_the_peak_of_the_beehive():
    case = load_case("gu2021-beehive")
    found = []
    for factor in (0.25, 1.0, 4.0):
        (spring,) = case.springs
        contact = replace(spring.contact, stiffness=factor * spring.contact.stiffness)
        changed = case.replace(springs=(replace(spring, contact=contact),))
        speeds = [8000 * np.pi / 30]
        made = simulate(changed, engine_speeds=speeds, models=("finite-element",))
        found.append(made.solutions[0].quantities["peak_spring_force"])
    assert found[1] == pytest.approx(988, rel=0.01)
    assert [found[0], found[2]] == pytest.approx([found[1]] * 2, rel=0.02)


@pytest.mark.parametrize("word", ["massless", "modal-uniform", "wave-rod", "multi-mass"])
def test_peaks_of_a_train_depend_neither_on_its_samples_nor_on_its_step(word):
    problem = build(load_case("vaz-ohc"), spring_models=(word,))
    ready = prepare(problem, problem.members[0], {}, "")
    speed, most = problem.engine_speeds[-1] / 2, 5760
    step = runner(ready.system, speed, TrainOptions(most), rest=ready.rest).time_step

    def peaks(samples: int, parts: int) -> list[float]:
        options = RunOptions(samples, step / parts * (1 + 1e-9), "ends", ready.rest)
        found = evaluate(run(ready.system, speed, Cycles(2), options), ready.frame).quantities
        both = [found[f"raw_{name}"] for name in PEAKS]
        assert [found[name] for name in PEAKS] == pytest.approx(both, rel=2e-3)  # nothing clashes
        return [found[name] for name in PEAKS]

    expected = peaks(1440, 1)
    for samples, parts in ((720, 1), (5760, 1), (1440, 2)):
        assert peaks(samples, parts) == pytest.approx(expected, rel=1e-3)


def test_the_cut_off_of_a_case_counts_and_is_in_its_run():
    narrow = load_case("job-c", {"operation.force_bandwidth": "3 kHz"})
    runs = [
        simulate(one, models=("multi-mass",), workers=1).solutions[-1]
        for one in (load_case("job-c"), narrow)
    ]
    assert [one.provenance.options["force_bandwidth"] for one in runs] == [10e3, 3e3]
    wide, slow = (one.quantities for one in runs)
    assert slow["peak_spring_force"] < 0.95 * wide["peak_spring_force"]
    assert slow["raw_peak_spring_force"] == wide["raw_peak_spring_force"]


def saved(force: float, cut_off: float | None) -> SavedRun:
    answer = {"quantities": {"peak_spring_force": {"value": force, "unit": "N"}}}
    below = {"below": {"value": cut_off, "unit": "Hz"}}
    return SavedRun(Path(), answer | ({} if cut_off is None else {DEFINITIONS: {FORCE: below}}))


def test_two_definitions_of_the_peak_are_not_compared():
    assert len(result_differences(saved(900.0, 10e3), saved(950.0, 10e3))) == 1
    for other in (saved(900.0, 5e3), saved(900.0, None)):
        with pytest.raises(InputError, match="force_bandwidth"):
            result_differences(saved(900.0, 10e3), other)
