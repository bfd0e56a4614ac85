"""Architecture: identifiers and texts of the package are standard words, none of the old dialect."""

from __future__ import annotations

import dialect
import pytest


def test_no_identifier_is_of_the_dialect():
    found = dict(dialect.counts())
    assert not found, "see the better words in scripts/dialect.py"


def test_no_text_is_of_the_dialect():
    found = list(dialect.in_text())
    assert not found, "see `python scripts/dialect.py --text`"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('"""One line.\n\nThe value is told."""', [(2, "told")]),
        ("# the file beside this one", [(0, "beside")]),
        ("f'{shown} is usual'", [(0, "usual")]),
        (
            '"""What the card tells, for turns of the cam."""',
            [(0, "tells"), (0, "turns of the cam")],
        ),
        ('"told"', []),
        ("# the key ``told`` is saved", []),
        ("# so that it may not blow up", []),
    ],
)
def test_words_of_a_text(text, words):
    assert list(dialect.in_sentences(text)) == words


@pytest.mark.parametrize(
    "name",
    [
        "MOST_RUNS",
        "kept_tables",
        "KeptTables",
        "_Asked",
        "seen_by_sensor",
        "make_ready",
        "Gaps",
        "told",
    ],
)
def test_words_of_the_dialect_are_known(name):
    assert dialect.is_dialect(name)


@pytest.mark.parametrize(
    "name",
    [
        "MAX_RUNS",
        "saved_tables",
        "seen",
        "coil_gaps",
        "keepdims",
        "request",
        "foundation",
        "LARGEST",
        "already",
    ],
)
def test_plain_words_are_not_of_the_dialect(name):
    assert not dialect.is_dialect(name)
