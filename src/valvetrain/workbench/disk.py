"""What the system says when something cannot be written, as a sentence."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager

from valvetrain.errors import InputError


@contextmanager
def writing(what: str, where: str = "") -> Iterator[None]:
    """Write ``what`` in the block; a full disk, a folder that may not be written and the like
    become an :class:`InputError` at ``where``.

    >>> with writing("this case", "small"):
    ...     raise OSError(28, "No space left on device")
    Traceback (most recent call last):
    valvetrain.errors.InputError: small: this case cannot be written (no space left on device); make
    room there, or choose another folder
    """
    try:
        yield
    except (OSError, sqlite3.Error) as error:
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()
        raise InputError(
            f"{what} cannot be written ({reason}); make room there, or choose another folder", where
        ) from error
