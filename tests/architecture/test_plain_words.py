"""Texts speak the words of the field: what a user, or a reader of the code, meets holds none of the
words listed here.

Read are the documents, the README, case files and templates, and all strings and comments of the
package.
"""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from architecture.layout import PACKAGE, ROOT

#: What is not said -> what the field says.
INSTEAD = {
    r"march(?:es|ed|ing)?": "time integration, to integrate",
    r"(?:rid(?:e|es|ing)|rode)": "prescribed motion; to move with, to touch",
    r"held (?:coils?|ends?|turns?|wire|vertices|unknowns)": "inactive coils, fixed ends",
    r"ends held": "ends fixed",
    r"spring '?\S* ?binds": "reaches coil bind",
    r"(?:at|through|by) the doors?": "at the interface",
    r"the house": "the architecture",
    r"(?:its|the|their|own|these) rooms?(?! temperature)": "its package",
    r"lets? go": "loses contact",
    r"(?:blots|streaks) are": "what the figure shows",
    r"hangs? on": "depends on",
    r"no source tells": "is not published",
    r"is what it looks for": "what it finds",
    r"goes on where it was (?:cut|stopped)": "an interrupted search is resumed",
    r"slips? of the pen": "a mistake",
    r"what the (?:scan|table|card|data) tells?": "what it gives",
    r"the exit code tells": "the exit code says how it ended",
}  # fmt: skip
FORBIDDEN = {words: re.compile(rf"\b(?:{words})\b", re.I) for words in INSTEAD}
PAGES = [
    *ROOT.glob("*.md"),
    *(ROOT / "docs").rglob("*.md"),
    *PACKAGE.rglob("*.toml"),
    *PACKAGE.rglob("*.j2"),
]


def findings(place: str, text: str) -> list[str]:
    """``place: words; say ...`` of each forbidden word in a text."""
    found = (
        (words, match) for words, pattern in FORBIDDEN.items() for match in pattern.finditer(text)
    )
    return [f"{place}: '{match[0]}'; say {INSTEAD[words]}" for words, match in found]


def spoken(path: Path) -> Iterator[tuple[int, str]]:
    """Line and text of every string and comment of a Python file."""
    with io.StringIO(path.read_text(encoding="utf-8")) as lines:
        for token in tokenize.generate_tokens(lines.readline):
            if (
                token.type in (tokenize.STRING, tokenize.COMMENT)
                or tokenize.tok_name[token.type] == "FSTRING_MIDDLE"
            ):
                yield token.start[0], token.string


@pytest.mark.parametrize(
    "text",
    [
        "the time march",
        "mass that rides on the retainer",
        "both ends held",
        "units are read at the door",
        "The house: rooms",
        "loads its room on first use",
        "let the train go or lets go",
        "Goes on where it was cut.",
    ],
)
def test_the_rule_catches_what_it_should(text):
    assert findings("here", text)


@pytest.mark.parametrize(
    "text",
    [
        "coil bind",
        "at room temperature",
        "an indoor bench",
        "held constant beyond the knots",
        "override",
    ],
)
def test_the_rule_spares_what_is_fine(text):
    assert not findings("here", text)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_pages_and_case_files_speak_plainly(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    assert not [
        found
        for number, line in enumerate(lines, 1)
        for found in findings(f"{path.relative_to(ROOT)}:{number}", line)
    ]


def test_strings_and_comments_of_the_package_speak_plainly():
    paths = sorted(PACKAGE.rglob("*.py"))
    assert not [
        one
        for path in paths
        for line, text in spoken(path)
        for one in findings(f"{path.relative_to(ROOT)}:{line}", text)
    ]
