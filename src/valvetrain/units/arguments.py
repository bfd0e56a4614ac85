"""Arguments of public functions that are names: one or several, and names that they had before."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Sequence
from typing import ParamSpec, TypeVar

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def as_names(given: Sequence[str] | str) -> tuple[str, ...]:
    """Names, of which a single one may stand for itself; empty text is none.

    >>> as_names("massless"), as_names(["massless", "multi-mass"]), as_names("")
    (('massless',), ('massless', 'multi-mass'), ())
    """
    return tuple(dict.fromkeys([given] if isinstance(given, str) and given else given))


def renamed(
    **earlier: str,
) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """Decorator of a function whose arguments had ``earlier`` names (earlier -> present): they are
    taken, with a :class:`DeprecationWarning`.
    """

    def decorate(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        @functools.wraps(function)
        def call(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
            for old, new in earlier.items():
                if old in kwargs:
                    owner = function.__qualname__.removesuffix(".__init__")
                    if new in kwargs:
                        raise TypeError(
                            f"{owner}() takes {new} or {old}, which is its earlier name"
                        )
                    message = f"the argument {old} of {owner} is named {new} now"
                    warnings.warn(message, DeprecationWarning, stacklevel=2)
                    kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return call

    return decorate
