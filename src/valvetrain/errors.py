"""Errors that a user can mend. Each message is one sentence: what, where, what to do."""

from __future__ import annotations

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


class MissingExtraError(ValvetrainError):
    """An optional part is not installed; the message holds the command that installs it."""


class RunFailedError(ValvetrainError):
    """A run ended before its end and the caller asked for an exception instead of a status."""


def _readable(text: str, most: int) -> str:
    """``text`` as one printable line of at most ``most`` characters, its middle left out where it
    is longer.
    """
    if not text.isprintable():
        text = "".join(
            char if char.isprintable() else " " if char in "\n\r\t\xa0" else "?" for char in text
        )
    return text if len(text) <= most else f"{text[: most // 2]} ... {text[-most // 2 + 5 :]}"
