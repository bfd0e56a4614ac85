"""Names of files that no two results share, whatever their labels hold."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass, field

#: Bytes of a name's stem, so that endings and the name of a temporary file beside it fit into the 255 that file systems take.
LONGEST = 120


@dataclass
class FreeNames:
    """Free file names: labels that differ only in signs, case or accents written otherwise still get files of their own.

    >>> names = FreeNames()
    >>> names.free("x 1"), names.free("x/1"), names.free("X-1")
    ('x-1', 'x-1-2', 'X-1-3')
    """

    taken: set[str] = field(default_factory=set)

    def free(self, words: str) -> str:
        """A name of letters, digits, points and dashes that was not given before."""
        composed = unicodedata.normalize("NFC", words)
        plain = "-".join("".join(char if char.isalnum() or char in ".+" else " " for char in composed).split()).strip(".-") or "run"
        tries = ((plain, "") if number == 1 else (plain, f"-{number}") for number in range(1, len(self.taken) + 2))
        name = next(one for words, ending in tries if _key(one := _short(words, ending)) not in self.taken)
        self.taken.add(_key(name))
        return name


def _key(name: str) -> str:
    """What two names share that some file system takes for one."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())


def _short(words: str, ending: str) -> str:
    """The words with the ending, cut to :data:`LONGEST` bytes; of long ones the end stays, where speed and number stand."""
    content = words.encode()
    room = LONGEST - len(ending)
    if len(content) > room:
        half = room // 2
        words = content[:half].decode(errors="ignore") + "~" + content[half + 1 - room :].decode(errors="ignore")
    return words + ending
