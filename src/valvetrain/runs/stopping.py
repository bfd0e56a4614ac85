"""Long calls: their progress at a prompt or in a notebook, and their stop by a signal, at once and with the finished runs.

The interpreter drops a KeyboardInterrupt within a callback of a compiler or a destructor, so every
request is also noted, and :func:`check_stop` is called while waiting.
"""

from __future__ import annotations

import inspect
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from valvetrain import registry
from valvetrain.session import interactive, on_main_thread

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


P = ParamSpec("P")
Result = TypeVar("Result")
#: Titles of the calls whose progress is shown: one at a time, the outermost.
_SHOWN: list[str] = []


def shows_progress(
    title: str, counted: bool = False
) -> Callable[[Callable[P, Result]], Callable[P, Result]]:
    """Decorator: the argument ``progress`` of a function, where it is None, is a bar in an
    interactive session.

    Parameters
    ----------
    title : what the call does, in a word
    counted : its ``progress`` is called with a count and a total, not with a share and a text
    """

    def decorate(function: Callable[P, Result]) -> Callable[P, Result]:
        signature = inspect.signature(function)
        run: Any = function  # whose arguments are bound again

        @wraps(function)
        def call(*arguments: P.args, **options: P.kwargs) -> Result:
            if _SHOWN or not (interactive() and on_main_thread()):
                return function(*arguments, **options)
            given = signature.bind(*arguments, **options)
            if given.arguments.get("progress") is not None:
                return function(*arguments, **options)
            case = getattr(next(iter(given.arguments.values()), None), "case", None)
            kernels = ("train",) if getattr(case, "train", None) else ("statics",)
            _SHOWN.append(title)
            try:
                with registry.find("displays", "progress")(title, kernels) as report:
                    if report is not None:
                        given.arguments["progress"] = (
                            (lambda done, total: report(done / max(total, 1), f"{done} of {total}"))
                            if counted
                            else report
                        )
                    result: Result = run(*given.args, **given.kwargs)
                    return result
            finally:
                _SHOWN.clear()

        return call

    return decorate
