"""A part of an answer that fails is left out and named; it never costs the other parts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import ParamSpec, TypeVar

from valvetrain.errors import InputError

P = ParamSpec("P")
Part = TypeVar("Part")
#: Set to anything to see where an unexpected error comes from.
TRACEBACK_VARIABLE = "VALVETRAIN_TRACEBACK"


class PartialFailures:
    """Collects a sentence per part that failed.

    >>> gaps = PartialFailures()
    >>> gaps.part("share of closed coils", {}, lambda: {"share": 1 / 0})
    {}
    >>> gaps.sentences
    ('share of closed coils: ZeroDivisionError: division by zero',)
    """

    def __init__(self, known: Iterable[str] = ()) -> None:
        self._sentences = list(known)

    @property
    def sentences(self) -> tuple[str, ...]:
        """What failed, and why."""
        return tuple(dict.fromkeys(self._sentences))

    def add(self, sentence: str) -> None:
        """Name a gap."""
        self._sentences.append(sentence)

    def part(
        self, name: str, instead: Part, build: Callable[P, Part], /, *args: P.args, **more: P.kwargs
    ) -> Part:
        """What ``build(*args)`` gives; where it fails, ``instead``, and the gap is named."""
        try:
            return build(*args, **more)
        except Exception as error:  # whatever it is, the other parts of the answer are there
            if os.environ.get(TRACEBACK_VARIABLE):
                raise
            self.add(f"{name}: {reason(error)}")
            return instead


def reason(error: BaseException) -> str:
    """What happened in one line; an unexpected error with its kind."""
    words = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return "the memory was not enough"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return words if isinstance(error, InputError) else f"{type(error).__name__}: {words}"
