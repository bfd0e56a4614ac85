"""How long it still takes, on standard error, and what Ctrl-C does in the middle of compiled work."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

from valvetrain.cli.guard import INTERRUPTED, interrupted
from valvetrain.cli.outcome import manner, tell

Report = Callable[[float, str], None]


@contextmanager
def progress_bar(title: str, at_once: bool = True) -> Iterator[Report]:
    """A bar with the time left while the block runs, on a terminal only; yields ``report(share done, what was just done)``.

    Ctrl-C ends the process at once with one sentence: compiled work in other threads would otherwise be waited for. Without ``at_once``
    it is an ordinary KeyboardInterrupt, for work that stops other programs and clears their files away.
    """
    if manner().quiet or not sys.stderr.isatty():
        with _quick_interrupt(lambda: None) if at_once else nullcontext():
            yield lambda done, text: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn

    words, left = TextColumn("{task.description}", markup=False), TextColumn("{task.fields[left]}")
    columns = SpinnerColumn(), words, BarColumn(24), TaskProgressColumn(), left
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(title, total=1.0, left="")
    begun = time.monotonic()

    def report(done: float, text: str) -> None:
        bar.update(task, completed=done, description=f"{title}: {text}", left=time_left(time.monotonic() - begun, done))

    with bar, _quick_interrupt(bar.stop) if at_once else nullcontext():
        yield report


def time_left(elapsed: float, done: float) -> str:
    """Words on the time left after ``elapsed`` seconds with the share ``done``; empty while nothing can be said."""
    if not 0 < done < 1:
        return ""
    seconds = elapsed * (1 - done) / done
    return f"about {seconds:.0f} s left" if seconds < 90 else f"about {seconds / 60:.0f} min left"


@contextmanager
def _quick_interrupt(clean: Callable[[], Any]) -> Iterator[None]:
    """While nothing is being written, Ctrl-C ends the process without waiting for threads."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    parent = os.getpid()

    def stop(*_: Any) -> None:
        if os.getpid() == parent:  # a forked worker holds this handler too until it sets its own
            for worker in multiprocessing.active_children():
                worker.terminate()
            clean()
            interrupted()
        os._exit(INTERRUPTED)

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def busy(title: str) -> Any:
    """A spinner with ``title`` for work of seconds, on a terminal only."""
    if manner().quiet or not sys.stderr.isatty():
        return nullcontext()
    from rich.console import Console

    return Console(stderr=True).status(title)


def announce_compilation(*kinds: str) -> None:
    """One line when the kernels of ``kinds`` (``statics``, ``transient``, ``train``) must be compiled first."""
    from valvetrain.cli.compilation import seconds_to_compile

    seconds = seconds_to_compile(*kinds)
    if seconds:
        tell(f"compiling kernels, once, about {seconds:.0f} s")
