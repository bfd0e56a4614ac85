"""What a form of recordings answers: whether a content is its own, and what it holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.measurements.recording import Recording

#: Bytes of the beginning of a file by which its form is found.
HEAD = 4096
_EXTRA = "install the extra 'measure' (pip install 'valvetrain[measure]')"


@dataclass(frozen=True, slots=True)
class RigFormat:
    """A form of recordings.

    ``words``: what it is called. ``recognise(head, name)`` looks at the first bytes alone (the name is for messages). ``read(path, name,
    wanted)`` gives the channels called as in ``wanted``, all where it is empty. ``apart``: whether it is read in a process of its own,
    since the library behind it is not made for damaged bytes.
    """

    words: str
    recognise: Callable[[bytes, str], bool]
    read: Callable[[Path, str, tuple[str, ...]], Recording]
    apart: bool = True


def missing_library(name: str, form: str, library: str) -> InputError:
    """The refusal of a file whose library is not installed."""
    return InputError(f"'{name[:80]}' is {form}, which needs {library}; {_EXTRA}")


def says_synthetic(*words: object) -> bool:
    """Whether any of a file's descriptions says that it was computed."""
    return any("synthetic" in str(word).lower() for word in words)


def plain_word(value: object) -> str:
    """A word of a file as text of one line."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return " ".join("".join(char if char.isprintable() else " " for char in text).split())[:120]
