"""Limits: the law behind noisy stations against closed forms: figures, coverage of the bands, the
nose, and what less noise does.
"""

import numpy as np
import pytest

from valvetrain.cam.measured import Measured
from valvetrain.errors import InputError
from valvetrain.lift.figures import lift_figures, pair_figures
from valvetrain.measured.lift_smoothing import smooth_lift

#: l = h (1 - (t / b)^2)^3 about the nose: lift, velocity and acceleration vanish at both ends.
HEIGHT, HALF, NOSE = 9e-3, np.radians(60.0), np.radians(180.0)
STATIONS = np.radians(np.arange(90.0, 271.0))


def law(cam_angle, derivative=0, nose=NOSE):
    x = (np.asarray(cam_angle) - nose) / HALF
    u = np.clip(1 - x * x, 0, None)
    found = (u**3, -6 * x * u**2, u * (30 * x * x - 6), 120 * x - 168 * x**3 - 24 * x + 48 * x**3)[
        derivative
    ]
    if derivative == 3:
        found = 72 * x * u - 48 * x**3  # d/dx of 24 x^2 u - 6 u^2
    return HEIGHT / HALF**derivative * np.where(np.abs(x) < 1, found, 0.0)


def noisy(noise, seed, nose=NOSE):
    return law(STATIONS, nose=nose) + np.random.default_rng(seed).normal(0, noise, len(STATIONS))


def figures(lift, **more):
    return {one.name: one for one in lift_figures(lift, **more)}


def test_figures_of_clean_stations_are_those_of_the_closed_form():
    found = figures(smooth_lift(STATIONS, law(STATIONS), noise=2e-9), heights=(0.2 * 25.4e-3,))
    root5 = np.sqrt(0.2)

    def duration(height):
        return 2 * HALF * np.sqrt(1 - (height / HEIGHT) ** (1 / 3))

    expected = {
        "peak_lift": HEIGHT, "nose_angle": NOSE, "lobe_centre": NOSE, "duration_at_50_thou": duration(1.27e-3),
        "duration_at_1_mm": duration(1e-3), "duration_at_5p08_mm": duration(5.08e-3), "lift_area": HEIGHT * HALF * 32 / 35,
        "opening_at_1_mm": NOSE - duration(1e-3) / 2, "closing_at_1_mm": NOSE + duration(1e-3) / 2,
        "largest_velocity": 6 * HEIGHT / HALF * root5 * 0.64, "least_velocity": 6 * HEIGHT / HALF * root5 * 0.64,
        "nose_acceleration": -6 * HEIGHT / HALF**2, "largest_acceleration": float(law(NOSE + HALF * np.sqrt(0.6), 2)),
        "opening_ramp_velocity": float(-law(NOSE + duration(0.1524e-3) / 2, 1)),
    }  # fmt: skip
    for name, value in expected.items():
        assert found[name].value == pytest.approx(value, rel=5e-4), name
    assert found["largest_jerk"].value == pytest.approx(48 * HEIGHT / HALF**3, rel=0.05)


def flat_start(cam_angle, derivative=0):
    """Rise of 65 degrees by 35 s^4 - 84 s^5 + 70 s^6 - 20 s^7, and back: the first micrometre takes
    three degrees.
    """
    x = (NOSE - np.abs(np.asarray(cam_angle) - NOSE) - NOSE) / np.radians(65) + 1
    s = np.clip(x, 0.0, 1.0)
    rise = 35 * s**4 - 84 * s**5 + 70 * s**6 - 20 * s**7
    found = rise if not derivative else 420 * s**2 - 1680 * s**3 + 2100 * s**4 - 840 * s**5
    return HEIGHT / np.radians(65) ** derivative * found


@pytest.mark.parametrize(
    "count", [180, 360, 720, 3600, pytest.param(20_000, marks=pytest.mark.long)]
)
def test_the_acceleration_depends_little_on_how_many_stations_a_turn_has(count):
    """The fit began three stations before the noise was left, a fifth of a degree where they stand
    close, and cut off the ramp.
    """
    angles = 2 * np.pi * np.arange(count) / count
    lobe = smooth_lift(angles, flat_start(angles) + np.random.default_rng(1).normal(0, 2e-6, count))
    assert np.degrees(lobe.event) == pytest.approx([115.5, 244.5], abs=4)
    assert lobe.noise == pytest.approx(2e-6, rel=0.2) and len(lobe.knots) < 420
    grid = np.linspace(*lobe.event, 1501)[1:-1]
    off, spread = lobe.lift(grid, 2) - flat_start(grid, 2), lobe.spread(grid, 2)
    peak = np.abs(flat_start(grid, 2)).max()
    assert np.sqrt(np.mean(off**2)) < np.sqrt(np.mean(spread**2)) < 0.07 * peak
    assert np.abs(off).max() < 0.12 * peak


@pytest.mark.parametrize("noise", [1e-6, 3e-6, 10e-6])
def test_bands_hold_the_true_law(noise):
    grid = np.linspace(NOSE - 0.97 * HALF, NOSE + 0.97 * HALF, 400)
    covered, found = np.zeros((8, 3)), []
    for seed in range(8):
        lift = smooth_lift(STATIONS, noisy(noise, seed))
        found.append(lift.noise)
        for derivative in range(3):
            apart = np.abs(lift.lift(grid, derivative) - law(grid, derivative))
            covered[seed, derivative] = np.mean(apart < 1.96 * lift.spread(grid, derivative))
    assert np.all(covered.mean(axis=0) > 0.88), covered.mean(axis=0)
    assert np.mean(found) == pytest.approx(noise, rel=0.15)
    # and they tell something: the acceleration is known to a few percent of its peak
    share = {1e-6: 0.05, 3e-6: 0.08, 10e-6: 0.15}[noise]
    assert np.median(lift.spread(grid, 2)) < share * np.abs(law(grid, 2)).max()


def test_the_nose_moves_no_further_than_said():
    """Noise of 3 micrometres moved the largest of the raw stations by degrees; here it moves by
    what its spread says.
    """
    apart, said = [], []
    for seed in range(12):
        found = figures(smooth_lift(STATIONS, noisy(3e-6, seed)))["nose_angle"]
        apart.append(found.value - NOSE)
        said.append(found.spread)
    assert np.degrees(np.std(apart)) < 0.2
    assert np.std(apart) == pytest.approx(np.mean(said), rel=0.6)
    assert np.mean(np.abs(apart) < 1.96 * np.array(said)) > 0.8


def test_less_noise_means_narrower_bands_and_no_noise_the_law():
    spreads = [
        np.median(smooth_lift(STATIONS, noisy(noise, 1)).spread(STATIONS[35:-35], 2))
        for noise in (1e-5, 1e-6, 1e-7)
    ]
    assert spreads[0] > 1.5 * spreads[1] > 2.2 * spreads[2]
    exact = smooth_lift(STATIONS, law(STATIONS))
    np.testing.assert_allclose(exact.lift(STATIONS), law(STATIONS), atol=5e-8)


def test_draws_are_the_spread():
    lift = smooth_lift(STATIONS, noisy(3e-6, 2))
    drawn = np.array([lift.evaluated(row, STATIONS[40:-40], 2) for row in lift.draws(400, 5)])
    np.testing.assert_allclose(drawn.std(axis=0), lift.spread(STATIONS[40:-40], 2), rtol=0.2)
    np.testing.assert_array_equal(lift.draws(3, 5), lift.draws(400, 5)[:3])


def test_a_band_is_kept_and_said_to_be_too_tight():
    lifts = noisy(5e-6, 3)
    loose, tight = smooth_lift(STATIONS, lifts, band=1e-4), smooth_lift(STATIONS, lifts, band=4e-6)
    assert not loose.widened and tight.widened
    assert np.abs(tight.residuals).max() <= 4e-6 < np.abs(loose.residuals).max()


def test_the_base_circle_is_taken_off():
    lift = smooth_lift(STATIONS, noisy(2e-6, 4) + 0.123e-3)
    assert lift.base == pytest.approx(0.123e-3, abs=1e-6)
    assert figures(lift)["peak_lift"].value == pytest.approx(HEIGHT, abs=3e-6)


def test_separation_and_overlap():
    """Exhaust centred 110 cam deg before the intake: overlap in crank degrees by the closed form."""
    exhaust_nose = NOSE - np.radians(110.0)
    stations = np.radians(np.arange(0.0, 160.0))
    exhaust = smooth_lift(stations, law(stations, nose=exhaust_nose), noise=2e-9)
    intake = smooth_lift(STATIONS, law(STATIONS), noise=2e-9)
    found = {one.name: one.value for one in pair_figures(intake, exhaust)}
    assert np.degrees(found["lobe_separation"]) == pytest.approx(110.0, abs=1e-3)
    half = HALF * np.sqrt(1 - (1e-3 / HEIGHT) ** (1 / 3))
    assert found["overlap_at_1_mm"] == pytest.approx(2 * (2 * half - np.radians(110.0)), abs=1e-5)


def test_as_a_law_it_rests_exactly_and_is_smooth():
    measured = Measured(cam_angles=tuple(STATIONS), lifts=tuple(noisy(3e-6, 6)))
    first, last = measured.smoothed.event
    outside = np.concatenate(
        [np.linspace(0, first - 1e-6, 50), np.linspace(last + 1e-6, 2 * np.pi - 1e-6, 50)]
    )
    assert np.all(measured.lift(outside) == 0.0) and np.all(measured.lift(outside, 2) == 0.0)
    for edge in (first, last):
        jump = np.diff(measured.lift(np.array([edge - 1e-9, edge + 1e-9]), 2))
        assert np.abs(jump)[0] < 1e-3 * np.abs(law(NOSE, 2))
    smoothed = measured.smoothed.lift(STATIONS)
    np.testing.assert_allclose(measured.lift(STATIONS), smoothed, atol=1e-15)
    other = Measured(cam_angles=tuple(STATIONS), lifts=tuple(noisy(3e-6, 6)), draw=2)
    apart = np.abs(other.lift(STATIONS, 2) - measured.lift(STATIONS, 2))
    assert 0 < np.median(apart) < 4 * np.median(measured.smoothed.spread(STATIONS[35:-35], 2))


@pytest.mark.parametrize(
    ("angles", "lifts", "words"),
    [
        (STATIONS, np.zeros(len(STATIONS)), "no lift above its base circle"),
        (STATIONS[60:], law(STATIONS[60:]), "begin and end on the base circle"),
        (STATIONS[:5], law(STATIONS[:5]), "fewer than eight stations"),
    ],
)
def test_what_is_no_lobe_is_refused(angles, lifts, words):
    with pytest.raises(InputError, match=words):
        smooth_lift(angles, lifts)


def test_noise_that_is_no_noise_is_refused():
    for value in (0.0, -1e-6, 2e-3):
        with pytest.raises(InputError, match="noise is a length above zero"):
            smooth_lift(STATIONS, law(STATIONS), noise=value)
