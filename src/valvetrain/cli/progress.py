"""How long it still takes, on standard error."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

from valvetrain.cli.outcome import manner, tell

Report = Callable[[float, str], None]


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """A bar with the time left while the block runs, on a terminal only; yields ``report(share done, what was just done)``."""
    if manner().quiet or not sys.stderr.isatty():
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

    with bar:
        yield report


def time_left(elapsed: float, done: float) -> str:
    """Words on the time left after ``elapsed`` seconds with the share ``done``; empty while nothing can be said."""
    if not 0 < done < 1:
        return ""
    seconds = elapsed * (1 - done) / done
    return f"about {seconds:.0f} s left" if seconds < 90 else f"about {seconds / 60:.0f} min left"


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
