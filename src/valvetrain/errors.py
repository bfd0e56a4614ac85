"""Errors that a user can mend. Each message is one sentence: what, where, what to do."""

from __future__ import annotations


class ValvetrainError(Exception):
    """Base of every error this package raises on purpose."""


class InputError(ValvetrainError):
    """The input cannot be used; the message says what is wrong, where, and the remedy.

    Parameters: ``message`` is the sentence, ``where`` the place in the input (file and key path).
    """

    def __init__(self, message: str, where: str = "") -> None:
        super().__init__(f"{where}: {message}" if where else message)
        self.where = where
        self.reason = message


class MissingExtraError(ValvetrainError):
    """An optional part is not installed; the message holds the command that installs it."""


class RunFailedError(ValvetrainError):
    """A run ended before its end and the caller asked for an exception instead of a status."""
