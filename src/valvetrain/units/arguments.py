"""Arguments of public functions: names, one or several; and the refusal of an unknown argument."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from inspect import Parameter, signature
from typing import ParamSpec, TypeVar

from valvetrain.errors import InputError, UnknownNameError

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def as_names(given: Sequence[str] | str | None) -> tuple[str, ...]:
    """Names, of which a single one may be given without a list; empty text is none. Raises
    :class:`InputError` for what is no name.

    >>> as_names("massless"), as_names(["massless", "multi-mass"]), as_names("")
    (('massless',), ('massless', 'multi-mass'), ())
    """
    if not given:
        return ()
    names = [given] if isinstance(given, str) else given
    if not isinstance(names, Iterable) or not all(isinstance(name, str) for name in names):
        raise InputError(f"'{str(given)[:40]}' is no name; give one as text, or a list of them")
    return tuple(dict.fromkeys(names))


def known_arguments(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Decorator of a function that refuses an argument it does not have by :class:`UnknownNameError`,
    which names the nearest.
    """
    every = signature(function).parameters.values()
    anything = any(one.kind is Parameter.VAR_KEYWORD for one in every)
    known = () if anything else tuple(one.name for one in every if one.name != "self")

    @functools.wraps(function)
    def call(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
        for name in kwargs if known else ():
            if name not in known:
                raise UnknownNameError(name, known, f"argument of {function.__name__}")
        return function(*args, **kwargs)

    return call
