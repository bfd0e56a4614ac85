"""Words of a case file: names, lines and texts that may stand in files, pages, decks and terminals as they are."""

from __future__ import annotations

import unicodedata
from typing import Annotated

from pydantic import AfterValidator

from valvetrain.parameters.schema_types import problem
from valvetrain.units.text import clipped

#: Longest name (a file is called by it), line and text (characters).
LONGEST_NAME, LONGEST_LINE, LONGEST_TEXT = 80, 1000, 50_000
_CONTROL = {"Cc": "a control character", "Cs": "half a character", "Zl": "a line break", "Zp": "a paragraph break"}
#: Characters that turn the direction of what is written after them, so that a reader sees another text.
_TURNS = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def words_problem(text: str, most: int, spared: str = "") -> str:
    """Why ``text`` may not stand in files, pages and terminals, empty when it may: longer than ``most`` or with control characters other
    than those in ``spared``."""
    if len(text) > most:
        return f"'{clipped(text)}' has {len(text)} characters; use at most {most}"
    if text.isprintable():
        return ""
    for char in text:
        kind = "a sign that turns the direction of writing" if char in _TURNS else _CONTROL.get(unicodedata.category(char))
        if kind is not None and char not in spared:
            return f"'{clipped(text)}' holds {kind} (U+{ord(char):04X}); remove it"
    return ""


def words(most: int, spared: str = "", separators: str = "") -> AfterValidator:
    """Refuses text that is too long, holds control characters other than ``spared``, or any of ``separators``."""

    def read(text: str) -> str:
        if reason := words_problem(text, most, spared):
            raise problem(reason)
        for sign in separators:
            if sign in text:
                raise problem(f"'{clipped(text)}' holds '{sign}', which parts folders; leave it out")
        return text

    return AfterValidator(read)


#: A name within a case; the name of a case, by which files are found; one line; a text of several lines.
Name = Annotated[str, words(LONGEST_NAME)]
CaseName = Annotated[str, words(LONGEST_NAME, separators="/\\")]
Line = Annotated[str, words(LONGEST_LINE)]
Prose = Annotated[str, words(LONGEST_TEXT, spared="\n\r\t")]
