"""The three streams of the process where they are closed, where their reader has left, and where they cannot show a name."""

from __future__ import annotations

import contextlib
import os
import select
import sys

_STREAMS = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))


def mend_streams() -> None:
    """Put the null device where a standard stream is closed (``>&-``): else the next file that is opened takes its number, and whatever
    prints writes into it. Names that a stream cannot show are written with backslashes."""
    for number in range(len(_STREAMS)):
        with contextlib.suppress(OSError):
            try:
                os.fstat(number)
            except OSError:
                os.open(os.devnull, os.O_RDWR)  # the least free number, which is this one
    for name, mode in _STREAMS:
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


def reader_left() -> bool:
    """Whether nobody reads standard output any more (``| head -1``); then nothing goes there from now on, at exit either."""
    try:
        place = sys.stdout.fileno()
        if hasattr(select, "poll"):  # elsewhere it is taken for granted: this is asked after an error of a pipe
            watch = select.poll()
            watch.register(place, select.POLLOUT)
            if not any(what & (select.POLLERR | select.POLLHUP) for _, what in watch.poll(0)):
                return False
        os.dup2(os.open(os.devnull, os.O_WRONLY), place)
    except (OSError, ValueError):
        return False
    return True


def unread() -> bool:
    """As :func:`reader_left`, also where rich has seen it first and put the null device in the place of standard output."""
    try:
        return os.path.samestat(os.fstat(sys.stdout.fileno()), os.stat(os.devnull)) or reader_left()
    except (OSError, ValueError):
        return False
