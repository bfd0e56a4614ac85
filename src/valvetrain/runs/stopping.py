"""Stopping a study by a signal: at once, with its finished runs, and without losing the request.

The interpreter drops a KeyboardInterrupt within a callback of a compiler or a destructor, so every
request is also noted, and :func:`check_stop` is called while waiting.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from valvetrain.solution.study import Study

#: Time (s) between two checks while waiting.
POLL_INTERVAL = 0.1
#: Names of the signals that stop a command.
_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
_noted: list[int] = []


class Stopped(KeyboardInterrupt):
    """A signal requested to stop."""


class PointsStopped(Stopped):
    """Independent runs were stopped; ``results`` holds the finished ones by index."""

    def __init__(self, results: Mapping[int, Any]) -> None:
        super().__init__("stopped")
        self.results = dict(results)


class StudyStopped(Stopped):
    """A study was stopped; its unfinished runs have the status ``interrupted``."""

    def __init__(self, study: Study) -> None:
        super().__init__("stopped")
        self.study = study


def noted() -> int:
    """The signal that requested to stop, 0 for none."""
    return _noted[0] if _noted else 0


def check_stop() -> None:
    """Raise :class:`Stopped` where a signal has requested it."""
    if _noted:
        raise Stopped(signal.Signals(_noted[0]).name)


def exit_code(number: int) -> int:
    """Exit code of a process that signal ``number`` stopped, by the convention of shells; 130, that
    of Ctrl-C, for 0.
    """
    return 128 + (number or signal.SIGINT)


@contextmanager
def listening() -> Iterator[None]:
    """While the block runs, SIGINT, SIGTERM and SIGHUP are noted and raise :class:`Stopped`; a
    second one ends the process.

    Only the main thread can listen; elsewhere, and for signals that the caller's parent had
    ignored, nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    owner = os.getpid()

    def stop(number: int, _: Any) -> None:
        if os.getpid() != owner:  # a forked worker holds this handler until it sets its own
            os._exit(exit_code(number))
        _noted.append(number)
        if len(_noted) > 1:
            os._exit(exit_code(_noted[0]))
        raise Stopped(signal.Signals(number).name)

    before: dict[int, Any] = {}
    for name in _SIGNALS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
            before[number] = signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _noted.clear()
