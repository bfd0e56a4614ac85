"""Property-based: whatever bytes a film or a frame holds, it is read or refused with one sentence,
within bounded memory.
"""

from __future__ import annotations

import resource
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from unit.cli_parts import call
from valvetrain.errors import InputError
from valvetrain.film.frames import MAX_PIXELS, open_film
from valvetrain.film.motion import coil_motion
from valvetrain.film.setup import FilmSetup
from valvetrain.film.space_time import SightLine, read_space_time
from valvetrain.solution.status import PartialFailures
from valvetrain.views.page import page_of
from valvetrain.views.results import answer_of

cv2 = pytest.importorskip("cv2")
FRAMES = np.random.default_rng(1).integers(0, 255, (20, 24, 32)).astype(np.uint8)
FEW = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
MARKS = st.sampled_from(
    [
        b"RIFF\0\1\0\0AVI LIST",
        b"\0\0\0\x20ftypisom",
        b"\x1aE\xdf\xa3",
        b"OggS",
        b"YUV4MPEG2 W9999 H9999\n",
        b"#EXTM3U\n",
        b"",
    ]
)
HEADS = st.sampled_from(
    [
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
        b"\xff\xd8\xff\xc0\0\x11\x08",
        b"II*\0\x08\0\0\0\2\0",
        b"MM\0*\0\0\0\x08",
        b"BM",
        b"",
    ]
)


def civil(path):
    """Read to its end, or refused with one sentence."""
    try:
        film = open_film(path)
        assert film.rows * film.columns <= MAX_PIXELS
        found = read_space_time(
            film, SightLine((2.0, 2.0), (2.0, 21.0)), 2000.0, (3.0, 3.0), 1.0, 0, None
        )
    except InputError as error:
        assert "\n" not in str(error) and 20 < len(str(error)) < 400
        return
    assert np.isfinite(found.picture).all() and (np.diff(found.number) > 0).all()


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "film.avi"
    out = cv2.VideoWriter(
        str(path), cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*"FFV1"), 25.0, (32, 24), isColor=False
    )
    for frame in FRAMES:
        out.write(frame)
    out.release()
    return path.read_bytes()


@FEW
@given(MARKS, st.binary(max_size=400))
def test_any_bytes_as_a_video(tmp_path, mark, content):
    path = tmp_path / "any.avi"
    path.write_bytes(mark + content)
    civil(path)


@FEW
@given(
    st.integers(0, 10**9),
    st.lists(st.tuples(st.integers(0, 10**9), st.integers(0, 255)), max_size=12),
)
def test_a_damaged_video(tmp_path, sample, end, changes):
    content = bytearray(sample[: end % len(sample) + 1] if end % 3 == 0 else sample)
    for place, value in changes:
        content[place % min(len(content), 600 if place % 2 else len(content))] = value
    path = tmp_path / "damaged.avi"
    path.write_bytes(content)
    civil(path)


@FEW
@given(HEADS, st.binary(max_size=200))
def test_any_bytes_as_a_frame(tmp_path, head, content):
    folder = tmp_path / "frames"
    folder.mkdir(exist_ok=True)
    (folder / "frame-1.png").write_bytes(head + content)
    civil(folder)


def test_a_header_that_claims_a_huge_picture_costs_no_memory(tmp_path, sample):
    """60000 x 60000 in the headers of a video and of a picture, 10 GB unpacked."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    size = struct.pack("<II", 32, 24)
    assert sample.count(size) == 2
    (tmp_path / "huge.avi").write_bytes(sample.replace(size, struct.pack("<II", 60000, 60000)))
    picture = bytearray(cv2.imencode(".png", FRAMES[0])[1].tobytes())
    picture[16:24] = struct.pack(">II", 60000, 60000)
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "frame-1.png").write_bytes(picture)
    for name in ("huge.avi", "frames"):
        with pytest.raises(InputError, match=r"60000 x 60000|damaged|no frame|no video"):
            open_film(tmp_path / name)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("empty.avi", b"", "is empty"),
        ("text.avi", b"time;height\n0;1\n", "no video that can be read"),
        ("list.m3u8", b"#EXTM3U\nhttp://example.org/film.ts\n", "no video that can be read"),
        ("frame.png", cv2.imencode(".png", FRAMES[0])[1].tobytes(), "folder of all frames"),
        ("zero.avi", bytes(5000), "no video that can be read"),
    ],
)
def test_what_is_no_film_is_refused_by_the_command_in_one_sentence(
    tmp_path, monkeypatch, name, content, words
):
    monkeypatch.chdir(tmp_path)
    Path(name).write_bytes(content)
    shown = call("film", name, "--free-decay", "--frame-rate", "2000 1/s")
    assert shown.exit_code == 2 and words in shown.stderr and len(shown.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_missing_and_special_files_are_refused(tmp_path):
    (tmp_path / "none").mkdir()
    for name, words in (
        ("no.avi", "no such file"),
        ("none", "holds no pictures"),
        ("/dev/null", "no regular file"),
        ("a\0b", "no file name"),
    ):
        with pytest.raises(InputError, match=words):
            open_film(tmp_path / name)


@settings(FEW, max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_any_grey_levels_are_followed_or_refused(seed):
    """Bands that come, go and cross, noise, flicker: numbers or one sentence."""
    chance = np.random.default_rng(seed)
    rows, time = np.arange(40.0)[None, :, None], np.arange(40)[:, None, None]
    film = chance.normal(0, chance.uniform(0, 40), (40, 40, 5))
    for _ in range(chance.integers(0, 5)):
        place = chance.uniform(0, 40) + chance.uniform(0, 9) * np.sin(
            chance.uniform(0.01, 2) * time
        )
        film = film + chance.uniform(0, 250) * np.exp(
            -(((rows - place) / chance.uniform(0.3, 4)) ** 2)
        ) * (time % chance.integers(1, 4) == 0)
    how = (
        {"free_decay": True},
        {"marker": (2, 5)},
        {"cam_speed": 200.0},
        {"cam_speed": 300.0, "dwell": (1.0, 4.0)},
    )[seed % 4]
    setup = FilmSetup(
        frame_rate=2000,
        scale=((0, 0), (0, 9), 9e-3),
        line=((2, 0), (2, 39)),
        line_width=3,
        **how,
    )
    try:
        motion = coil_motion(np.clip(film, 0, 255).astype(np.uint8), setup)
    except InputError as error:
        assert "\n" not in str(error) and 20 < len(str(error)) < 400
        return
    gaps = np.diff(motion.places, axis=1)
    assert (gaps[np.isfinite(gaps)] > 0).all() or (gaps[np.isfinite(gaps)] < 0).all()
    gaps = PartialFailures()
    assert page_of(answer_of(motion), gaps) and not gaps.sentences
