"""Errors that a user can mend. Each message is one sentence: what, where, what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

#: Longest sentence and longest place (characters): what a stranger wrote is echoed, never in full.
MAX_SENTENCE_LENGTH, MAX_LOCATION_LENGTH = 700, 300


class ValvetrainError(Exception):
    """Base of every error this package raises on purpose.

    >>> issubclass(InputError, ValvetrainError)
    True
    """


class InputError(ValvetrainError):
    """The input cannot be used; the message says what is wrong, where, and the remedy.

    Parameters: ``message`` is the sentence, ``where`` the place in the input (file and key path).

    >>> print(InputError("a wire of 3.8 m is no spring wire; give its unit", "spring.wire_diameter"))
    spring.wire_diameter: a wire of 3.8 m is no spring wire; give its unit
    """

    def __init__(self, message: str, where: str = "") -> None:
        message, where = (
            _readable(message, MAX_SENTENCE_LENGTH),
            _readable(where, MAX_LOCATION_LENGTH),
        )
        super().__init__(f"{where}: {message}" if where else message)
        self.where = where
        self.reason = message


class UnusualValueWarning(UserWarning):
    """A value that hardly any valvetrain has; it is taken as written, and likely its unit is another.

    >>> issubclass(UnusualValueWarning, UserWarning)
    True
    """


class UnknownNameError(InputError, KeyError):
    """A name that a mapping of results does not have; the message names the nearest that it has.

    >>> print(UnknownNameError("peak_forse", ["peak_force", "preload"]))
    there is no 'peak_forse'; did you mean peak_force?
    """

    def __init__(self, name: object, choices: Iterable[str], where: str = "") -> None:
        names = list(dict.fromkeys(choices))
        near = difflib.get_close_matches(str(name)[:60], names, n=3, cutoff=0.5)
        shown = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
        remedy = f"did you mean {' or '.join(near)}?" if near else f"there are {shown or 'none'}"
        super().__init__(f"there is no '{str(name)[:60]}'; {remedy}", where)

    __str__ = Exception.__str__

    def __reduce__(self) -> tuple[object, ...]:
        return InputError, (self.reason, self.where)


class FrozenMapping(dict[str, Any]):
    """A mapping that does not change: it can be hashed, and sent to another process."""

    def _refuse(self, *_: object, **__: object) -> Any:
        raise TypeError("this mapping does not change; make another of it")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (dict(self),)


class NamedNumbers(FrozenMapping):
    """Numbers by name; a name that is not there is answered with the nearest.

    >>> NamedNumbers(preload=280.0)["prelaod"]
    Traceback (most recent call last):
    ...
    valvetrain.errors.UnknownNameError: there is no 'prelaod'; did you mean preload?
    """

    def __missing__(self, name: str) -> float:
        raise UnknownNameError(name, self)


class MissingExtraError(ValvetrainError):
    """An optional part is not installed; the message holds the command that installs it."""


class RunFailedError(ValvetrainError):
    """A run ended before its end and the caller requested an exception instead of a status."""


def _readable(text: str, most: int) -> str:
    """``text`` as one printable line of at most ``most`` characters, its middle left out where it
    is longer.
    """
    if not text.isprintable():
        text = "".join(
            char if char.isprintable() else " " if char in "\n\r\t\xa0" else "?" for char in text
        )
    return text if len(text) <= most else f"{text[: most // 2]} ... {text[-most // 2 + 5 :]}"
