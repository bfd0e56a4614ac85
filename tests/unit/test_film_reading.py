"""Unit: frames of videos, folders and arrays; the line, the marker, lost frames, and what does not
change the numbers.
"""

from __future__ import annotations

import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest

import film_parts as made
import valvetrain as vt
from valvetrain.film.cycles import by_marker
from valvetrain.film.frames import open_film
from valvetrain.film.space_time import SightLine, find_line, read_space_time

cv2 = pytest.importorskip("cv2")
SETUP = vt.film.FilmSetup(
    marker=(4, 4),
    marker_radius=2,
    marker_angle=made.MARK_ANGLE,
    line=((6, 10), (6, 239)),
    **made.SCALE,
)
NOISE = np.random.default_rng(3).integers(0, 255, (20, 48, 32)).astype(np.uint8)


def video(path, frames, rate=25.0, coding="FFV1"):
    """A lossless video."""
    out = cv2.VideoWriter(
        str(path),
        cv2.CAP_FFMPEG,
        cv2.VideoWriter_fourcc(*coding),
        rate,
        frames.shape[:0:-1],
        isColor=False,
    )
    for frame in frames:
        out.write(frame)
    out.release()
    return path


def folder(path, frames, numbers=None, suffix="png"):
    path.mkdir()
    for number, frame in zip(numbers or range(len(frames)), frames, strict=True):
        cv2.imwrite(str(path / f"cam1-{number:04d}.{suffix}"), frame)
    return path


def read(film, line=((10, 2), (10, 45)), rate=2000.0, first=0, last=None):
    opened = open_film(film)
    return read_space_time(opened, SightLine(*line), rate, None, 3.0, first, last)


def test_a_video_a_folder_and_an_array_are_the_same_film(tmp_path):
    array = read(NOISE)
    for film in (
        video(tmp_path / "film.avi", NOISE),
        folder(tmp_path / "frames", NOISE),
        folder(tmp_path / "tiff", NOISE, suffix="tiff"),
    ):
        found = read(film)
        assert (
            (found.picture == array.picture).all()
            and (found.time == array.time).all()
            and not found.notes
        )


def test_sixteen_bits_are_kept(tmp_path):
    deep = NOISE.astype(np.uint16) * 257 + 100
    assert read(folder(tmp_path / "deep", deep)).picture == pytest.approx(read(deep).picture)


def test_the_line_averages_what_lies_across_it():
    """On a picture whose grey level is x + 100 y, cubic interpolation is exact, so a slanted line
    gives a straight profile.
    """
    picture = np.arange(32.0)[None, :] + 100 * np.arange(48.0)[:, None]
    profile = SightLine((8.0, 5.0), (20.0, 41.0), 4.0).weights(48, 32) @ picture.ravel()
    share = np.arange(len(profile)) / np.hypot(12.0, 36.0)
    assert len(profile) == 38
    assert profile == pytest.approx(8 + 12 * share + 100 * (5 + 36 * share), rel=1e-12)


def test_the_line_is_found_across_the_coils_of_an_upright_or_lying_spring():
    film, _ = made.turning_film()
    wide = np.full((40, 240, 67), 20, dtype=np.uint8)
    wide[:, :, 22:62] = np.tile(film[:40], 4)
    upright, lying = find_line(open_film(wide)), find_line(open_film(wide.transpose(0, 2, 1)))
    assert (
        22 <= upright.start[0] <= 61
        and upright.start[0] == upright.end[0]
        and upright.end[1] == 239
    )
    assert lying.start == upright.start[::-1] and lying.end == upright.end[::-1]


def test_the_rate_of_a_screen_is_not_taken_for_that_of_the_camera(tmp_path):
    with pytest.raises(vt.InputError, match="plays at 25 frames a second, the rate of a screen"):
        read(video(tmp_path / "film.avi", NOISE), rate=None)
    fast = read(video(tmp_path / "film.mp4", NOISE, 2000.0, "mp4v"), rate=None)
    assert fast.frame_rate == pytest.approx(2000) and "the one in the file" in fast.notes[0]


def test_lost_frames_are_counted_and_leave_the_rest_where_it_was(tmp_path):
    kept = [number for number in range(20) if number not in (7, 8, 13)]
    found = read(folder(tmp_path / "frames", NOISE[kept], [100 + number for number in kept]))
    assert (found.number == kept).all() and "3 frames are lost in 2 gaps" in found.notes[0]
    names = folder(tmp_path / "named", NOISE, [10 * number for number in range(20)])
    assert not read(names).notes, "every tenth number is how some cameras count"


def test_a_video_that_is_cut_short_says_so(tmp_path):
    whole = video(tmp_path / "film.avi", np.concatenate([NOISE] * 3))
    content = whole.read_bytes()
    (tmp_path / "cut.avi").write_bytes(content[: len(content) // 2])
    found = read(tmp_path / "cut.avi")
    assert len(found.picture) < 60 and len(found.picture) + found.missing == 60


def test_the_mark_tells_the_time_of_a_turn_between_frames():
    """Triangular flashes at known times; one of them hidden."""
    time = np.arange(400) / 2000
    marks = 0.01 + 0.03 * np.arange(6)
    flash = sum(np.clip(1 - np.abs(time - mark) / 2e-3, 0, None) for mark in marks)
    phase = by_marker(time, 30 + 150 * flash, 0.5, None)
    assert phase.cam_speed == pytest.approx(2 * np.pi / 0.03, rel=1e-4)
    assert np.interp(marks[2], time, phase.cam_angle) == pytest.approx(0.5 + 4 * np.pi, abs=0.02)
    hidden = np.where(np.abs(time - marks[3]) < 3e-3, 0.0, flash)
    missed = by_marker(
        time, 180 - 150 * hidden, 0.5, 2 * np.pi / 0.031
    )  # a dark mark, and a speed that is wrong
    assert missed.cam_speed == pytest.approx(2 * np.pi / 0.03, rel=1e-3)
    assert "not seen in 1 turns" in missed.notes[0] and missed.given_speed == 2 * np.pi / 0.031


def test_a_speed_that_changes_is_followed_from_mark_to_mark():
    time = np.arange(1200) / 2000
    angle = 200 * time + 60 * time**2
    phase = by_marker(time, 100.0 * (np.mod(angle + 0.25, 2 * np.pi) < 0.5), 0.0, None)
    inside = (angle > 2 * np.pi) & (angle < angle[-1] - 2 * np.pi)
    off = (phase.cam_angle - angle + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(off)[inside].max() < np.radians(6) and "speed changes" in " ".join(phase.notes)


@pytest.mark.long
def test_numbers_depend_neither_on_the_width_of_the_line_nor_on_the_first_frame():
    film, _ = made.turning_film()
    first = made.turning_motion()
    surge = first.surge.lines[0]
    for change in (
        {"line_width": 3.0},
        {"first_frame": 37},
    ):
        motion = vt.film.coil_motion(film, replace(SETUP, **change))
        line = motion.surge.lines[0]
        assert abs(line.natural_frequency - surge.natural_frequency) < 1.96 * np.hypot(
            line.frequency_spread, surge.frequency_spread
        )
        assert abs(line.damping_ratio - surge.damping_ratio) < 1.96 * np.hypot(
            line.damping_spread, surge.damping_spread
        )
        for one, two in zip(motion.peaks, first.peaks, strict=True):
            assert abs(one.mean - two.mean) < 1.96 * np.hypot(one.spread, two.spread) + 2e-6


def test_frames_that_are_lost_leave_displacements_open(tmp_path):
    film, _ = made.turning_film()
    kept = np.r_[0:120, 127:300]
    motion = vt.film.coil_motion(folder(tmp_path / "frames", film[kept], kept.tolist()), SETUP)
    assert np.isnan(motion.cycles[-1].values).sum() >= 4
    assert "7 frames are lost" in " ".join(motion.notes)
    whole = made.turning_motion()
    assert motion.displacement[:, 2] == pytest.approx(whole.displacement[kept, 2], abs=0.03e-3)


def test_without_opencv_the_extra_is_named(tmp_path, monkeypatch):
    film = folder(tmp_path / "frames", NOISE)
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(vt.InputError, match="extra 'film'"):
        open_film(film)
    shutil.rmtree(film)


def test_a_spring_alone_is_laid_under_the_film_too():
    """job-t is a spring under prescribed motion, whose one spring has a name of its own in the
    case.
    """
    motion = made.turning_motion()
    model = vt.film.film_over_model(motion, "job-t", "multi-mass", first_turn=0.5)
    assert (
        model.spring == "spring"
        and (model.turns == np.arange(6) + 0.5).all()
        and model.displacement.shape == (360, 6)
    )
    with pytest.raises(vt.InputError, match="has no displacement of coils"):
        vt.film.film_over_model(motion, "job-t", "massless")
    with pytest.raises(vt.InputError, match="spring 'inner' is unknown"):
        vt.film.film_over_model(motion, "job-t", "multi-mass", "inner")
