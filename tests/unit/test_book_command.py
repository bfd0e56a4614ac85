"""The validation book's command on rows that are made up: which rows are met, and what makes it fail."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from validation import __main__ as book
from validation import explained
from validation.row import BookCase, Row

MET = Row(
    "rates", "rate of a wire", "en13906-1", "4 mm wire", 41000.0, 41010.0, "N/m", 20.0, "rounding"
)
MISSED = replace(
    MET,
    topic="sources",
    name="a|b",
    unit="1",
    computed=41100.0,
    kind="prediction",
    band=(41050.0, 41200.0),
    explanation="another pitch",
)
FAILS = replace(MISSED, name="worse", source="", computed=41300.0)
BARE = replace(MET, name="lost", computed=math.nan)


@pytest.mark.parametrize(
    ("row", "status"),
    [
        (MET, "met"),
        (replace(MET, computed=40980.0), "met"),
        (replace(MET, computed=40979.0), "FAILS"),
        (MISSED, "miss (explained)"),
        (replace(MISSED, computed=41050.0), "miss (explained)"),
        (replace(MISSED, computed=41200.0), "miss (explained)"),
        (replace(MISSED, computed=41049.0), "FAILS"),
        (FAILS, "FAILS"),
        (BARE, "FAILS"),
        (replace(MISSED, explanation=""), "FAILS"),
        (replace(MISSED, band=None), "FAILS"),
        (replace(MET, tolerance=math.inf), "FAILS"),
        (replace(MISSED, computed=41020.0), "met"),
    ],
)
def test_a_row_is_met_missed_or_fails(row, status):
    assert row.status == status and (
        math.isnan(row.computed) or row.difference == row.computed - row.expected
    )


def test_the_command_tells_each_case_and_each_row_that_fails(monkeypatch, capsys, tmp_path):
    cases = (
        BookCase("rates_of_wires", lambda: [MET, BARE]),
        BookCase("long", lambda: [MISSED, FAILS], slow=True),
    )
    monkeypatch.setattr(book, "book", lambda: cases)
    assert book.main(["--page", str(tmp_path / "page.md")]) == 1
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("rates_of_wires: 2 rows, 1 fail, ") and told[0].endswith(" s")
    assert told[1].startswith("long: 2 rows, 1 fail, ")
    assert float(told[0].split(", ")[2].split()[0]) < 5
    assert told[2:] == [
        "FAILS: rates, lost: expected 41000, computed nan N/m, tolerance 20",
        "FAILS: sources, worse: expected 41000, computed 41300 1, tolerance 20, band of the explained miss 41050 to 41200",
        "4 rows, 2 fail",
    ]
    assert (tmp_path / "page.md").read_text(encoding="utf-8") == book.page(
        [MET, BARE, MISSED, FAILS]
    )
    monkeypatch.setattr(book, "book", lambda: (BookCase("good", lambda: [MET]), cases[1]))
    assert book.main(["--quick"]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == ["1 rows, 0 fail"]
    assert [row.name for row in book.run_book()] == ["rate of a wire", "a|b", "worse"]


def test_one_chapter_is_run_with_those_that_share_its_tables(monkeypatch):
    """``--only laws --page`` left the rows of followers out of the tables of both."""
    cases = {one.rows.__module__.rpartition(".")[2] for one in book.book()}
    assert set(book.TABLES) | set(book.TABLES.values()) <= cases
    for only in ("laws", "followers"):
        chosen = []
        monkeypatch.setattr(book, "book", lambda chosen=chosen: tuple(recorded(chosen)))
        book.run_book(only=only)
        assert set(chosen) == {"laws", "followers"}


def recorded(chosen: list[str]):
    """A case of every chapter that writes down its chapter when it is run."""
    for chapter in book.CHAPTERS:

        def rows(chapter: str = chapter) -> list[Row]:
            chosen.append(chapter)
            return []

        rows.__module__ = f"validation.{chapter}"
        yield BookCase(chapter, rows)


#: Bands that are wider than the rule, about numbers that follow the sampling or a difference of two
#: forces: half the width over the middle.
WIDER = {
    "stage 1 force range, 4200 rpm (solid finite elements)": 0.056, "node 2 contact displacement, 4200 rpm (solid finite elements)": 0.153,
    "coil 1 2 bounce duration, 5600 rpm (solid finite elements)": 0.345,
    "coil 1 2 bounce duration, 8000 rpm (solid finite elements)": 0.095,
    "performance lift difference displacement, 4000 rpm (as printed)": 0.154,
}  # fmt: skip
SHARES = (
    ("acceleration", 0.08),
    ("velocity", 0.04),
    ("displacement", 0.05),
    ("printed", 0.03),
    ("force", 0.02),
    ("", 0.02),
)


@pytest.mark.parametrize(
    ("name", "band"),
    [(name, band) for rows in explained.BANDS.values() for name, band in rows.items()],
)
def test_the_band_of_an_explained_miss_is_as_narrow_as_its_file_says(name, band):
    """2 % of a force, 4 % of a velocity, 5 % of a displacement, 8 % of an acceleration, 1.5 degrees
    of an angle, 3 % of the trains.
    """
    half, middle = (band[1] - band[0]) / 2, abs(band[0] + band[1]) / 2
    if "cam angle" in name:
        assert half == pytest.approx(1.5, abs=0.02)
        return
    share = WIDER.get(name) or next(share for word, share in SHARES if word in name)
    assert 0.95 * share * middle <= half <= 1.2 * share * middle
    found = explained.explained_miss(name)
    assert found is not None and found.band == band and found.why
    assert explained.explained_miss(f"{name} ") is None
