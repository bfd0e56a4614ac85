"""Unit: the command ``film``: its files, its answer, its page, and what it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import film_parts as made
import valvetrain as vt
from unit.cli_parts import call as invoke
from unit.cli_parts import typed
from valvetrain.film.command import _lift
from valvetrain.film.surge import alias_of, fit_surge
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text

cv2 = pytest.importorskip("cv2")
FILM = typed(
    "film film.avi --frame-rate '2000 1/s' --line '6, 10, 6, 239' --scale '4, 0, 4, 120, 20 mm'"
)
CAM = typed(
    "--marker '4, 4' --marker-radius 2 --marker-angle '63.0253575 deg' --cam-speed '1623.4 rpm'"
)


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    """The command run once on a video of the turning film."""
    home = tmp_path_factory.mktemp("film")
    film, _ = made.turning_film()
    out = cv2.VideoWriter(
        str(home / "film.avi"),
        cv2.CAP_FFMPEG,
        cv2.VideoWriter_fourcc(*"FFV1"),
        25.0,
        film.shape[:0:-1],
        isColor=False,
    )
    for frame in film:
        out.write(frame)
    out.release()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        return home, invoke(*FILM, *CAM, "--output", "out", "--json", "--synthetic")


def test_the_answer_is_that_of_the_function(answer):
    home, shown = answer
    assert shown.exit_code == 0, shown.output
    data, motion = json.loads(shown.stdout), made.turning_motion()
    assert [one["mean"] for one in data["peaks"]] == pytest.approx(
        [one.mean for one in motion.peaks], rel=1e-12
    )
    lines = [one["frequency"]["value"] for one in data["surge_lines"]]
    assert lines == pytest.approx([one.natural_frequency for one in motion.surge.lines], rel=1e-9)
    assert (
        data["cam_speed"]["value"] == pytest.approx(made.CAM_SPEED, rel=1e-3)
        and data["cam_speed"]["by"] == "marker"
    )
    assert data["synthetic"] is True and "verdict" not in data
    assert data["findings"][0]["code"] == "Y231" and "Y211" not in {
        one["code"] for one in data["findings"]
    }
    kept = json.loads((home / "out" / "run.json").read_text())
    assert kept["peaks"] == data["peaks"] and (home / "out" / "inputs" / "case.toml").is_file()


def test_a_table_of_lifts_tells_the_phase(answer, monkeypatch):
    """Its angles are counted from the nose, so the lobe lies on both sides of zero."""
    home, _ = answer
    monkeypatch.chdir(home)
    nose = made.OPEN / 2
    angles = np.radians(np.arange(-75.0, 75.5, 1.0))
    rows = zip(
        np.degrees(angles),
        1e3 * np.where(np.abs(angles) < nose, made.lift(np.abs(angles + nose)), 0.0),
        strict=True,
    )
    Path("lobe.csv").write_text(
        "\n".join(
            [
                "cam angle [deg],valve lift [mm]",
                *(f"{angle:.3f},{lift:.5f}" for angle, lift in rows),
            ]
        )
        + "\n"
    )
    shown = invoke(*FILM, "--lift", "lobe.csv", "--output", "by-lift", "--json")
    assert shown.exit_code == 0, shown.output
    data = json.loads(shown.stdout)
    assert data["cam_speed"]["by"] == "lift" and data["cam_speed"]["value"] == pytest.approx(
        made.CAM_SPEED, rel=1e-3
    )
    cycles = vt.measured.read_cycles("by-lift/displacement-coil-6.csv")
    top = np.degrees(cycles.cam_angle[np.argsort(cycles.values[0])[-30:]])
    assert abs(np.mean((top + 180) % 360 - 180)) < 2.0


def test_the_files_hold_a_column_a_turn(answer):
    home, _ = answer
    found, cycles = (
        vt.measured.read_cycles(home / "out" / "displacement-coil-6.csv"),
        made.turning_motion().cycles[5],
    )
    assert found.values == pytest.approx(
        cycles.values, abs=1e-9, nan_ok=True
    ) and found.values.shape == (3, 360)
    assert (
        found.quantity == "coil_6_displacement"
        and found.cam_speed == pytest.approx(cycles.cam_speed)
        and found.synthetic
    )
    rows = [
        line
        for line in (home / "out" / "displacement-coil-6.csv").read_text().splitlines()
        if not line.startswith("#")
    ]
    assert rows[0] == "cam angle [deg],cycle 1 [m],cycle 2 [m],cycle 3 [m]" and len(rows) == 361
    motion = made.turning_motion()
    peaks = list(csv.reader((home / "out" / "peaks.csv").open()))
    assert [float(row[1]) for row in peaks[1:]] == pytest.approx(
        [1e3 * one.mean for one in motion.peaks], rel=1e-6
    )
    tracks = list(csv.reader((home / "out" / "tracks.csv").open()))
    assert len(tracks) == 301 and len(tracks[0]) == 2 + 3 * 6


def test_aliases_are_where_sampling_folds_them():
    """Sampled sines of known frequency: the fit finds the line where the alias is said to be."""
    time = np.arange(200) / 2000
    for frequency in (300.0, 1130.0, 1900.0, 2350.0):
        swing = np.exp(-20 * time) * np.sin(2 * np.pi * frequency * time)
        line = fit_surge(1e-3 * swing[:, None] + 0, [np.arange(200)], 2000.0).lines[0]
        assert line.natural_frequency == pytest.approx(alias_of(frequency, 2000.0), abs=0.5)
        assert line.decay_rate == pytest.approx(20.0, rel=0.01)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ((), "the cam angle is not known"),
        (("--cam-speed", "1000 Hz"), "rotational speed"),
        (("--free-decay", "--case", "vaz-ohc"), "has no cam"),
        (("--cam-speed", "1000 rpm", "--model", "multi-mass"), "name it with --case"),
        (("--cam-speed", "1000 rpm", "--case", "vaz-ohc", "--model", "cheese"), "cheese"),
        (("--cam-speed", "1000 rpm", "--line", "0, 0, 0"), "4 numbers of pixels"),
        (("--cam-speed", "1000 rpm", "--line", "0, 0, 5, 5"), "at least 12 px"),
        (("--cam-speed", "1000 rpm", "--line", "0, 0, 0, 900"), "outside the picture"),
        (("--cam-speed", "1000 rpm", "--scale", "1, 1, 1, 1, 5 mm"), "same or their distance"),
        (("--cam-speed", "1000 rpm", "--scale", "12 mm"), "4 numbers of pixels"),
        (("--marker", "900, 4"), "outside the picture"),
        (("--cam-speed", "1000 rpm", "--coils", "30"), "no frame shows more than 6"),
        (("--cam-speed", "1000 rpm", "--seat", "left"), "--seat: 'left' is not available"),
        (("--cam-speed", "1000 rpm", "--dwell", "30 deg"), "no window"),
        (("--cam-speed", "1000 rpm", "--first-frame", "9", "--last-frame", "3"), "count from 0"),
        (("--cam-speed", "1000 rpm", "--first-frame", "290"), "only 10 can be read"),
        (("--first-angle", "3 deg", "--lift", "none.csv"), "cannot be read"),
    ],
)
def test_wrong_requests_are_refused_in_one_sentence(answer, monkeypatch, more, words):
    home, _ = answer
    monkeypatch.chdir(home)
    before = sorted(Path().iterdir())
    given = [one for one in FILM if "--scale" not in more or one not in FILM[-2:]]
    given = [one for one in given if "--line" not in more or one not in FILM[4:6]]
    shown = invoke(*given, *more)
    assert shown.exit_code == 2 and words in " ".join(shown.stderr.split()), shown.stderr
    assert len(shown.stderr.splitlines()) == 1 and sorted(Path().iterdir()) == before


def test_a_film_is_laid_on_the_lift_of_the_valve_and_not_of_the_tappet():
    """A rocker of 1.6 and its lash: 14.35 mm of valve lift (docs/how-to/13) behind 8.97 mm of the cam."""
    case = parse_case(template_text("pushrod"))
    lift = _lift(None, case)
    assert float(np.max(lift(np.radians(np.arange(360.0))))) == pytest.approx(14.35e-3, abs=5e-6)
