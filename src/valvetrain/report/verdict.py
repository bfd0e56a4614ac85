"""The verdict of a result: one sentence for its page, its command, a notebook and Python."""

from __future__ import annotations

import os

from valvetrain import registry
from valvetrain.solution.partial_failures import TRACEBACK_VARIABLE


def verdict_of(result: object) -> str:
    """The sentence of a result, by the function that the registry lists for its class (kind
    ``verdicts``); empty where none is listed or its numbers are missing.
    """
    word = type(result).__name__
    if word not in registry.places("verdicts"):
        return ""
    try:
        sentence: str = registry.find("verdicts", word)(result)
    except Exception:  # a sentence must not cost the numbers it is about
        if os.environ.get(TRACEBACK_VARIABLE):
            raise
        return ""
    return sentence
