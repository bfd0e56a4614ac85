"""Limits: films drawn from known motions give these motions back: places, damping, frequencies,
peaks, phase, drift, order of the coils.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import film_parts as made
import valvetrain as vt
from valvetrain.film.frames import open_film
from valvetrain.film.space_time import SightLine, read_space_time
from valvetrain.film.tracks import track

LINE = SightLine((4.0, 0.0), (4.0, 239.0))


def tracked(film, line=LINE, coils=None):
    return track(read_space_time(open_film(film), line, made.RATE, None, 3.0, 0, None), coils)


@pytest.fixture(scope="module")
def decay():
    heights = made.drawn.decaying(made.REST, 0.9 * made.SHARE, (1.1, 0.4), made.SURGE, made.DAMPING)
    film, truth = made.drawn.draw(made.SCENE, heights, 160)
    return vt.film.coil_motion(
        film, vt.film.FilmSetup(free_decay=True, seat="end", line=((4, 0), (4, 239)), **made.SCALE)
    ), truth


def test_places_are_true_to_a_tenth_of_a_pixel_and_their_deviations_tell_it(decay):
    motion, truth = decay
    off = made.errors(motion.places[:, ::-1], truth)
    assert np.sqrt(np.mean(off**2)) < 0.03 and np.abs(off).max() < 0.15
    assert 0.6 < np.sqrt(np.mean((off / motion.spread[:, ::-1]) ** 2)) < 1.3


def test_a_free_decay_gives_frequencies_within_their_intervals_and_the_damping(decay):
    """Closed form: two modes of one damping ratio."""
    lines = decay[0].surge.lines
    assert len(lines) == 2
    for order, line in enumerate(lines, start=1):
        assert abs(line.natural_frequency - order * made.SURGE) < 1.96 * line.frequency_spread < 1.0
        assert line.damping_ratio == pytest.approx(made.DAMPING, rel=0.05)
        assert abs(line.damping_ratio - made.DAMPING) < 1.96 * line.damping_spread


def test_a_turning_cam_gives_displacements_peaks_and_speed():
    """Lift, surge, mark and the drift of the camera are closed forms."""
    motion = made.turning_motion()
    assert motion.phase.cam_speed == pytest.approx(
        made.CAM_SPEED, abs=1.96 * motion.phase.spread + 1e-9
    )
    assert (
        np.degrees(
            np.abs(motion.phase.cam_angle - made.CAM_SPEED * motion.time - made.FIRST_ANGLE)
        ).max()
        < 0.6
    )
    time = np.arange(0.0, 0.2, 2e-5)
    least = made.REST - made.turning(time).min(axis=0)
    for peak, true in zip(motion.peaks, least, strict=True):
        assert 1e3 * peak.mean == pytest.approx(true, abs=0.03) and peak.cycles == 3
    assert np.ptp(motion.drift) == pytest.approx(
        1.2 * np.ptp(np.sin(2.2 * np.linspace(0, 1, 300))), abs=0.1
    )
    assert any("camera drifted by 1." in note for note in motion.notes)


def test_damping_in_the_dwell_of_a_turning_cam_is_within_five_per_cent():
    motion = made.turning_motion()
    strongest = max(motion.surge.lines, key=lambda line: line.amplitude)
    assert abs(strongest.natural_frequency - made.SURGE) < 1.96 * strongest.frequency_spread < 2.0
    assert strongest.damping_ratio == pytest.approx(made.DAMPING, rel=0.05)
    first, last = np.degrees(motion.dwell)
    assert np.degrees(made.OPEN) - 3 < first < np.degrees(made.OPEN) + 40 and 320 < last < 363


def test_the_lift_tells_the_phase_and_the_scale_without_a_marker():
    film, _ = made.turning_film()
    setup = vt.film.FilmSetup(frame_rate=made.RATE, line=((6, 10), (6, 239)))
    motion = vt.film.coil_motion(film, setup, valve_lift=made.lift)
    assert motion.phase.cam_speed == pytest.approx(made.CAM_SPEED, rel=1e-3)
    off = motion.phase.cam_angle - made.CAM_SPEED * motion.time - made.FIRST_ANGLE
    assert np.degrees(np.abs((off + np.pi) % (2 * np.pi) - np.pi)).max() < 0.5
    assert motion.metres_per_pixel == pytest.approx(1e-3 / made.PER_MM, rel=2e-3)


@pytest.mark.parametrize(
    ("blur", "per_mm", "merged"),
    [(0.8, 6.0, 0.0), (2.2, 1.5, 0.1)],
    ids=("glare lines apart", "glare lines run into each other"),
)
def test_coils_that_close_keep_their_identity(blur, per_mm, merged):
    """All coils touch five times; at 1.5 px a mm the glare lines, 5.2 px wide, then lie 5.5 px
    apart and show no dip between them.
    """
    scene = replace(
        made.SCENE,
        blur=blur,
        pixels_per_mm=per_mm,
        rows=round(40 * per_mm),
        seat_row=37 * per_mm,
        columns=7,
    )
    film, truth = made.drawn.draw(scene, made.closing(6, 3.66, 6.5, 0.3), 220)
    found = tracked(film, SightLine((3.0, 0.0), (3.0, scene.rows - 1.0)))
    off = made.errors(found.places, truth)
    apart = np.diff(truth[:, ::-1], axis=1).min()
    assert found.places.shape[1] == 6 and np.isfinite(found.places).mean() > 0.97
    assert np.nanmax(np.abs(off)) < 0.5 * apart, "a coil was taken for its neighbour"
    assert np.sqrt(np.nanmean(off**2)) < (0.1 if not merged else 0.2)
    assert found.merged.any(axis=1).mean() >= merged


@pytest.mark.long
def test_the_vaz_spring_filmed_at_2000_frames_a_second():
    """A run of vaz-ohc by the modal model, filmed; the decay rate of its surge is half its mass
    damping of 50 1/s, as published.
    """
    _, rest, angle, moved, cam_speed = made.drawn.coils_of_case("vaz-ohc", model="modal-uniform")
    film, truth = made.drawn.draw(made.SCENE, made.drawn.driven(rest, angle, moved, cam_speed), 260)
    setup = vt.film.FilmSetup(
        cam_speed=cam_speed,
        first_angle=0.0,
        line=((4, 0), (4, 239)),
        dwell=np.radians((165.0, 355.0)),
        **made.SCALE,
    )
    motion = vt.film.coil_motion(film, setup)
    off = made.errors(motion.places[:, ::-1], truth)
    assert np.sqrt(np.mean(off**2)) < 0.1
    first = motion.surge.lines[0]
    assert (
        abs(first.decay_rate - 25.0)
        < 1.96 * 2 * np.pi * first.natural_frequency * first.damping_spread + 0.05 * 25.0
    )
    by_default = vt.film.film_over_model(
        motion, "vaz-ohc"
    )  # the first variant of the case is a spring without coils
    assert by_default.model == "finite-element" and by_default.apart.max() < 0.5e-3
    model = vt.film.film_over_model(motion, "vaz-ohc", "modal-uniform")
    assert model.turns[0] == pytest.approx(0.6, abs=0.31) and model.turns[2] == pytest.approx(
        2.6, abs=0.05
    )
    assert model.apart.max() < 0.05e-3 and model.shift == 0.0
    assert model.quantities[2] == f"outer_coil_{model.turns[2]:.2f}_displacement".replace(".", "_")
    assert any(
        "mirrored" in note and "above half the frame rate (1000 Hz)" in note for note in model.notes
    )
