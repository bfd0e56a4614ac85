"""The watch over all that tests make: what it tells apart, what it lets pass, and that a thing
which is not kept is named.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import made_watch
from made_watch import alike, note, told
from system_parts import under_ci

sys.path.insert(0, str(Path(__file__).parents[1] / "golden"))
from keep_made import joined

THING = {
    "force": np.linspace(300.0, 800.0, 720),
    "unit": "N",
    "words": "peak 812.3 N at 140 deg",
    "count": 3,
}


@pytest.mark.parametrize(
    "change",
    [
        {"force": THING["force"] * (1 + 3e-6)},
        {"force": -THING["force"]},
        {"force": THING["force"][::-1]},
        {"force": np.append(THING["force"], 800.0)},
        {"force": np.where(np.arange(720) == 7, np.nan, THING["force"])},
        {"words": "peak 812.4 N at 140 deg"},
        {"count": 4},
    ],
)
def test_other_numbers_are_told_apart(change):
    (digest, sums), (other, moved) = told(THING), told(THING | change)
    assert digest != other or not alike(sums, moved)


@pytest.mark.parametrize(
    "change", [{"unit": "mm"}, {"words": "least 812.3 N at 140 deg"}, {"count": True}]
)
def test_other_words_are_told_apart(change):
    assert told(THING)[0] != told(THING | change)[0]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (THING, THING | {"force": THING["force"] * (1 + 1e-12)}),
        (THING, THING | {"created_at": "2026-11-23T10:00:00"}),
        ("results in runs/a/b.csv", "results in somewhere/else/c.csv"),
        ("done in 3.4 s", "done in 12 s"),
    ],
)
def test_rounding_times_and_places_are_not(first, second):
    (digest, sums), (other, moved) = told(first), told(second)
    assert digest == other and alike(sums, moved)


@pytest.fixture
def watching(monkeypatch):
    """The watch of a file of tests of which one thing is kept."""
    digest, sums = told(THING)
    left = {"tests/unit/test_x.py": {"unsure": {"loose"}, "words_alone": {f"rough|{digest}"}}}
    monkeypatch.delenv(made_watch.FOLDER, raising=False)
    monkeypatch.setattr(
        made_watch, "kept", lambda: ({"thing": {digest: [sums]}, "rough": {digest: []}}, left)
    )
    monkeypatch.setattr(made_watch, "unknown", [])
    monkeypatch.setitem(made_watch.now, "file", "tests/unit/test_x.py")
    return made_watch.unknown


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("thing", {}, []),
        ("thing", {"count": 4}, ["thing: other numbers"]),
        ("thing", {"unit": "mm"}, ["thing: other words"]),
        ("new", {}, ["new: other words"]),
        ("loose", {"unit": "mm"}, []),
        ("rough", {"count": 4}, []),
        ("rough", {"unit": "mm"}, ["rough: other words"]),
    ],
)
def test_what_is_not_kept_is_named(watching, name, change, said):
    note(name, THING | change)
    assert watching == said


def test_a_file_of_which_nothing_is_kept_is_free(watching, monkeypatch):
    monkeypatch.setitem(made_watch.now, "file", "tests/unit/test_y.py")
    note("thing", {"anything": 1})
    assert not watching


def test_runs_are_joined_to_what_they_have_in_common():
    """Of three runs: one name alike, one whose numbers differ, one whose words differ."""
    first = {
        "f|same": {"d": [[1.0, 5.0, 6.0]]},
        "f|numbers": {"d": [[1.0, 5.0, 6.0]]},
        "f|words": {"d": [[1.0, 5.0, 6.0]]},
    }
    second = {
        "f|same": {"d": [[1.0, 5.0, 6.0 + 1e-7]]},
        "f|numbers": {"d": [[1.0, 5.1, 6.0]]},
        "f|words": {"e": [[1.0, 5.0, 6.0]]},
    }
    kept = joined([first, second, first])["f"]
    assert kept == {
        "unsure": ["words"],
        "words_alone": ["numbers|d"],
        "made": {"same": {"d": [[1.0, 5.0, 6.0]]}, "numbers": {"d": []}},
    }
    many = {"f|many": {"d": [[1.0, float(n), 0.0] for n in range(made_watch.MOST)]}}
    assert joined([many, many])["f"]["words_alone"] == ["many|d"], (
        "what goes beyond is not kept, so no run can be held to it"
    )


@pytest.mark.skipif(
    not under_ci() or sys.version_info[:2] != (3, 11),
    reason="only continuous integration has to compare; it has Python 3.11",
)
def test_what_is_kept_is_compared_where_it_counts():
    assert made_watch.are_same(), (
        "keep all anew with the pinned versions: python tests/golden/keep_made.py"
    )
    pool, left = made_watch.kept()
    assert len(left) > 200 and len(pool) > 1000
