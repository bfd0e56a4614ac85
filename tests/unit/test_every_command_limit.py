"""Bounds of the command's options, and folders that are refused before any work."""

from __future__ import annotations

import pytest

from unit.cli_parts import SMALL, call, sentence
from valvetrain.errors import InputError
from valvetrain.runs.cost import read_limits


@pytest.mark.parametrize(
    ("words", "option", "low", "high"),
    [
        (("static", "uniform-spring", "--model", "massless"), "--steps", 2, 10**9),
        (("modes", "uniform-spring", "--model", "massless"), "--count", 1, 10**9),
        (("run", "uniform-spring", "--model", "massless"), "--workers", 1, 256),
    ],
)
def test_a_count_beyond_its_bounds_is_refused(words, option, low, high):
    for number in (low - 1, high + 1):
        assert f"{option}: {number} is outside {low} to {high}" in sentence(
            call(*words, option, str(number))
        )


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

    speed = ("--rpm", "1000:2000:500 rpm") if command == "sweep" else ()
    said = sentence(call(command, "small.toml", "--output", "letters", "--workers", "1", *speed))
    assert "letters" in said and (tmp_path / "letters" / "to-a-friend.txt").read_text() == "kept"
    assert [path.name for path in (tmp_path / "letters").iterdir()] == ["to-a-friend.txt"]
