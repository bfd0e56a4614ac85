"""Films for slides: frames, peaks, sizes, and sentences where something is missing or asked for
wrongly.
"""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from synthetic_study import own_study, rod_run
from unit.cli_parts import SMALL, call, sentence
from valvetrain.cli import animate
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.report.motion import film
from valvetrain.report.motion.film import FilmRequest, film_frames, write_film
from valvetrain.report.motion.scene import Limits, moving_picture
from valvetrain.runs import saved_runs as run_store

TINY = FilmRequest(1.0, 320)


@pytest.fixture(scope="module")
def variant():
    base = own_study((rod_run(),))
    study = replace(
        base, record=replace(base.record, text=load_case("gu2021-beehive-blind").record().text)
    )
    return moving_picture(study, Limits(frames=200)).variants[0]


def test_frames_stand_at_even_angles_and_hold_the_peak_of_the_force(variant):
    frames = film_frames(variant, 25)
    force = variant.forces[0]
    peak = variant.cam_angle[
        np.argmin(np.abs(variant.cam_angle - force.cam_angle[np.argmax(force.values)]))
    ]
    angles = np.degrees(variant.cam_angle[frames])
    assert np.degrees(peak) in angles
    even = np.abs(angles - np.arange(25) * 14.4)
    assert np.sort(even)[:-1].max() <= 2.0 and even.max() <= 7.2 + 1e-9


def test_a_gif_holds_every_frame_and_its_cursor_stands_at_the_angle(variant, tmp_path):
    image = pytest.importorskip("PIL.Image")
    made = write_film(variant, tmp_path / "spring.gif", TINY)
    with image.open(made.path) as gif:
        assert (gif.n_frames, gif.size, gif.info["loop"]) == (
            25,
            (320, 180),
            0,
        ) and made.pictures == 25
        assert made.size == made.path.stat().st_size < 1_000_000
        found = []
        for place in range(25):
            gif.seek(place)
            assert gif.info["duration"] == 40
            dark = 255 - np.asarray(gif.convert("L")).astype(float)
            # The lowest tenth of the plot holds grid lines, which are faint, and the cursor.
            found.append(int(np.argmax(dark[118:128, 180:].sum(axis=0))) + 180)
    left, right = 0.59 * 320, 0.97 * 320
    wanted = left + (right - left) * variant.cam_angle[film_frames(variant, 25)] / (2 * np.pi)
    np.testing.assert_allclose(found[1:], wanted[1:], atol=1.5)
    # One second for the 21.4 ms of a cam turn at 5600 rpm of the crank.
    assert made.slowness == pytest.approx(5600 / 120)


def test_an_mp4_holds_every_frame(variant, tmp_path):
    cv2 = pytest.importorskip("cv2")
    made = write_film(variant, tmp_path / "spring.mp4", TINY)
    video = cv2.VideoCapture(str(made.path))
    seen = 0
    while video.read()[0]:
        seen += 1
    assert (seen, video.get(cv2.CAP_PROP_FRAME_WIDTH), video.get(cv2.CAP_PROP_FRAME_HEIGHT)) == (
        25,
        320,
        180,
    )
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(25)


@pytest.mark.parametrize(
    ("name", "request_", "told"),
    [
        ("spring.avi", TINY, "ends in .gif or .mp4"),
        ("spring.gif", FilmRequest(60.0), "choose 1 to 20 s"),
        ("spring.gif", FilmRequest(2.0, 9000), "choose 320 to 1920"),
        (
            "spring.gif",
            FilmRequest(1.0, 320, "heat"),
            "no colour 'heat'; use stress, contact, gap, velocity",
        ),
    ],
)
def test_wrong_films_are_refused(variant, tmp_path, name, request_, told):
    with pytest.raises(InputError, match=told):
        write_film(variant, tmp_path / name, request_)
    assert not list(tmp_path.iterdir())


def test_a_colour_that_this_run_does_not_show_is_refused(variant, tmp_path):
    bare = replace(
        variant,
        springs=tuple(replace(one, colourings=one.colourings[:1]) for one in variant.springs),
    )
    with pytest.raises(InputError, match="no colour 'gap'; it has stress"):
        write_film(bare, tmp_path / "spring.gif", FilmRequest(1.0, 320, "gap"))


@pytest.mark.parametrize(
    ("missing", "name", "told"),
    [("PIL", "a.gif", "pip install pillow"), ("cv2", "a.mp4", r"valvetrain\[film\]")],
)
def test_a_missing_package_is_named(monkeypatch, missing, name, told, tmp_path):
    known = film.find_spec
    monkeypatch.setattr(film, "find_spec", lambda word: None if word == missing else known(word))
    monkeypatch.setitem(__import__("sys").modules, "cv2" if missing == "cv2" else "none-such", None)
    with pytest.raises(InputError, match=told):
        film.check_ending(tmp_path / name)


def test_the_command_draws_a_case_and_a_kept_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    case = tmp_path / "small.toml"
    case.write_text(SMALL, encoding="utf-8")
    first = call(
        "animate",
        str(case),
        "--output",
        "a.gif",
        "--spring",
        "multi-mass",
        "--duration",
        "1 s",
        "--width",
        "320",
        "--json",
    )
    assert first.exit_code == 0, first.output
    told = json.loads(first.stdout)
    assert (
        told["pictures"] == 25
        and told["run"] == "multi-mass"
        and told["slowness"] == pytest.approx(9000 / 120)
    )
    assert (
        call(
            "run",
            str(case),
            "--output",
            "kept",
            "--spring",
            "multi-mass,massless",
            "--no-report",
            "--quiet",
        ).exit_code
        == 0
    )
    again = call(
        "animate",
        "kept",
        "--output",
        "b.gif",
        "--spring",
        "multi-mass",
        "--duration",
        "1 s",
        "--width",
        "320",
        "--quiet",
    )
    assert again.exit_code == 0, again.output
    # The same run, read from its file: the same picture but for the installed shape, which the kept
    # run does not hold.
    assert abs((tmp_path / "a.gif").stat().st_size - (tmp_path / "b.gif").stat().st_size) < 20_000


@pytest.mark.parametrize(
    ("place", "more", "way"),
    [
        ("job-t", (), "computed"),
        ("job-t", ("--set", "spring.precompression=6 mm"), "computed"),
        ("kept", (), "read"),
        ("kept", ("--spring", "massless"), "read"),
        ("kept", ("--set", "spring.precompression=6 mm"), "computed"),
    ],
)
def test_a_kept_run_is_drawn_from_its_file_unless_a_value_is_changed(
    place, more, way, tmp_path, monkeypatch
):
    def stopped(word):
        def stop(first, *more):
            raise InputError(f"{word} from {first if word == 'read' else first.name}")

        return stop

    kept = SimpleNamespace(folder=tmp_path, case_file="job-t")
    monkeypatch.setattr(
        run_store, "run_of_path", lambda path: kept if path.name == "kept" else None
    )
    monkeypatch.setattr(animate, "_computed", stopped("computed"))
    monkeypatch.setattr(animate, "_of_saved_run", stopped("read"))
    found = call("animate", place, "--output", str(tmp_path / "a.gif"), *more)
    assert (
        found.exit_code == 2
        and f"{way} from {tmp_path if way == 'read' else 'job-t'}" in sentence(found)
    )


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--output", "a.avi"), "ends in .gif or .mp4"),
        ((), "give --output FILE.gif"),
        (("--output", "none/a.gif"), "a folder that does not exist"),
        (
            ("--output", "a.gif", "--engine-speed", "3000, 4000 rpm"),
            "one engine speed, and 2 are given",
        ),
        (("--output", "a.gif", "--spring", "massless,multi-mass"), "one spring model"),
        (("--output", "a.gif", "--duration", "3"), "unit"),
    ],
)
def test_the_command_refuses_with_a_sentence(words, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = call("animate", "job-t", *words)
    assert found.exit_code == 2 and told in sentence(found)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--duration", "0.9 s"), "--duration"),
        (("--duration", "21 s"), "--duration"),
        (("--width", "319"), "--width"),
        (("--width", "1921"), "--width"),
        (("--output", "a.avi"), "ends in"),
        (("--engine-speed", "3000, 4000 rpm"), "2 are given"),
        (("--spring", "massless,multi-mass"), "one spring model"),
        (("--duration", "3"), "unit"),
    ],
)
def test_the_command_refuses_before_it_computes(words, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "valvetrain.cli.animate._computed", lambda *_: pytest.fail("it computed first")
    )
    found = call(
        "animate", "job-t", *(("--output", "a.gif") if "--output" not in words else ()), *words
    )
    assert found.exit_code == 2 and told in sentence(found)
