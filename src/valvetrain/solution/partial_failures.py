"""Partial failures: a part of a result that fails is left out and reported; the other parts are
there.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import ParamSpec, TypeVar

from valvetrain.errors import InputError

P = ParamSpec("P")
Part = TypeVar("Part")
#: Environment variable that lets unexpected errors pass with their traceback.
TRACEBACK_VARIABLE = "VALVETRAIN_TRACEBACK"


class PartialFailures:
    """Collects a sentence per part that failed.

    >>> failures = PartialFailures()
    >>> failures.part("share of closed coils", {}, lambda: {"share": 1 / 0})
    {}
    >>> failures.sentences
    ('share of closed coils: ZeroDivisionError: division by zero',)
    """

    def __init__(self, known: Iterable[str] = ()) -> None:
        self._sentences = list(known)

    @property
    def sentences(self) -> tuple[str, ...]:
        """What failed, and why."""
        return tuple(dict.fromkeys(self._sentences))

    def add(self, sentence: str) -> None:
        """Add the sentence of a failure."""
        self._sentences.append(sentence)

    def part(
        self, name: str, instead: Part, build: Callable[P, Part], /, *args: P.args, **more: P.kwargs
    ) -> Part:
        """The result of ``build(*args)``; where it fails, ``instead``, and the failure is added."""
        try:
            return build(*args, **more)
        except Exception as error:  # whatever it is, the other parts of the result are there
            if os.environ.get(TRACEBACK_VARIABLE):
                raise
            self.add(f"{name}: {reason(error)}")
            return instead


def reason(error: BaseException) -> str:
    """What happened in one line; an unexpected error with its kind."""
    message = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return "the memory was not enough"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return message if isinstance(error, InputError) else f"{type(error).__name__}: {message}"
