"""Bounds of the command's options, and folders that are refused before any work."""

from __future__ import annotations

import pytest

from unit.cli_parts import SMALL, call, sentence
from valvetrain.cli.options import read_count, read_workers
from valvetrain.errors import InputError
from valvetrain.runs.cost import read_limits


@pytest.mark.parametrize(
    ("words", "option", "low", "high"),
    [
        (("static", "uniform-spring", "--spring", "massless"), "--steps", 2, 10**9),
        (("modes", "uniform-spring", "--spring", "massless"), "--count", 1, 10**9),
        (("run", "uniform-spring", "--spring", "massless"), "--workers", 1, 256),
    ],
)
def test_a_count_beyond_its_bounds_is_refused(words, option, low, high):
    for number in (low - 1, high + 1):
        assert f"{option}: {number} is outside {low} to {high}" in sentence(
            call(*words, option, str(number))
        )


def test_bounds_belong_to_what_they_bound():
    assert [read_count(number, 2, 4, "--count") for number in (2, 4)] == [2, 4]
    assert (read_workers(1), read_workers(256)) == (1, 256) and 1 <= read_workers(None) <= 4
    for number in (1, 5):
        with pytest.raises(InputError, match=f"{number} is outside 2 to 4"):
            read_count(number, 2, 4, "--count")


def test_the_machine_decides_how_many_runs_go_at_a_time(monkeypatch):
    import os

    for cores, expected in ((1, 1), (3, 3), (64, 4)):
        monkeypatch.setattr(
            os, "sched_getaffinity", lambda process, cores=cores: set(range(cores)), raising=False
        )
        assert read_workers(None) == expected


@pytest.mark.parametrize(
    ("text", "seconds", "size"),
    [
        ("7 s", 7, 2e9),
        ("7 min", 420, 2e9),
        ("7 h", 25200, 2e9),
        ("7 d", 604800, 2e9),
        ("7 MB", 600, 7e6),
        ("1.5 GB", 600, 1.5e9),
        ("7TB", 600, 7e12),
        (" 2 h , 8 GB ", 7200, 8e9),
    ],
)
def test_a_bound_is_a_time_or_a_memory(text, seconds, size):
    limits = read_limits([text])
    assert (limits.seconds, limits.bytes) == pytest.approx((seconds, size))
    assert (
        read_limits([text, "3 s"]).seconds,
        read_limits(None).seconds,
        read_limits(None).bytes,
    ) == (3, 600, 2e9)


@pytest.mark.parametrize("text", ["0 h", "-1 h", "1", "h", "1 m", "1 hours", "1e3 s", "1 h 2", ""])
def test_what_is_no_bound_is_refused(text):
    with pytest.raises(InputError, match="is no bound"):
        read_limits([text])


@pytest.mark.parametrize("command", ["run", "compare", "sweep", "refine"])
def test_a_folder_with_other_files_is_refused_before_any_work(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "to-a-friend.txt").write_text("kept")

    speed = ("--engine-speed", "1000:2000:500 rpm") if command == "sweep" else ()
    said = sentence(call(command, "small.toml", "--output", "letters", "--workers", "1", *speed))
    assert "letters" in said and (tmp_path / "letters" / "to-a-friend.txt").read_text() == "kept"
    assert [path.name for path in (tmp_path / "letters").iterdir()] == ["to-a-friend.txt"]
