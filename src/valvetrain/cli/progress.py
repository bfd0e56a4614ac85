"""Progress and remaining time on standard error, below the cell of a notebook, and as JSON lines for a
calling program.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

from valvetrain.cli.outcome import MANNER, tell
from valvetrain.session import COMPILING, PROGRESS_VARIABLE

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case

Report = Callable[[float, str], None]
#: Seconds of work from which the time left is told without a terminal.
SURE = 5.0
#: What was announced to come before the first share of the work.
_AHEAD: list[str] = []


def tell_progress(share: float | None, text: str) -> None:
    """One line, ``{"share": 0.25, "text": "multi-mass, 4200 rpm"}``, to the file that
    :data:`PROGRESS_VARIABLE` names, where it does; ``share`` of the work done, None while unknown.
    """
    number = os.environ.get(PROGRESS_VARIABLE, "")
    if number.isdecimal():
        with suppress(OSError):
            os.write(int(number), (json.dumps({"share": share, "text": text}) + "\n").encode())


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """A bar with the time left while the block runs; without a terminal one line, where that is more than a minute. Yields
    ``report(share done, what was just done)``.
    """
    tell_progress(0.0, "; ".join([title, *_AHEAD]))
    _AHEAD.clear()
    if MANNER.get().quiet:
        yield tell_progress
        return
    # When the first report came, and at which share: kernels may be compiled before it.
    first: tuple[float, float] | None = None
    said = False
    with _terminal_bar(title) if sys.stderr.isatty() else nullcontext() as draw:

        def report(done: float, text: str) -> None:
            nonlocal first, said
            tell_progress(done, text)
            if draw is not None:
                draw(done, text)
                return
            now = time.monotonic()
            first = first or (now, done)
            elapsed, share = now - first[0], (done - first[1]) / max(1 - first[1], 1e-9)
            if not said and elapsed > SURE and elapsed * (1 - share) > 60 * share > 0:
                said = True
                tell(f"{title}: {time_left(elapsed, share)}")

        yield report


@contextmanager
def session_bar(title: str, kernels: Sequence[str]) -> Iterator[Report | None]:
    """A bar at a Python prompt or below the cell of a notebook while the block runs; None where
    neither is there. ``kernels``: kinds of :data:`KERNELS` that workers may have to compile first.
    """
    from rich.console import Console

    console = Console(stderr=True)
    if not (console.is_jupyter or console.is_terminal):
        yield None
        return
    seconds = seconds_to_compile(*kernels)
    first = COMPILING.format(seconds) if seconds else ""
    # Without a thread that draws: worker processes are forked only where no thread runs.
    with _cell_bar(title) if console.is_jupyter else _terminal_bar(title, False) as draw:
        draw(0.0, first)
        yield draw


@contextmanager
def _cell_bar(title: str) -> Iterator[Report]:
    """A bar below the cell, drawn ten times a second at most; it disappears at the end."""
    display: Any = import_module("IPython.display").display
    begun, drawn = time.monotonic(), -1.0
    handle = display({"text/plain": title}, raw=True, display_id=True)

    def report(done: float, text: str) -> None:
        nonlocal drawn
        now = time.monotonic() - begun
        if now - drawn < 0.1:
            return
        drawn = now
        line = ", ".join(
            filter(None, (f"{title}: {text}" if text else title, time_left(now, done)))
        )
        bar = f'<progress max="1" value="{done:.4f}"></progress> {100 * done:.0f} % {escape(line)}'
        handle.update({"text/html": bar, "text/plain": f"{100 * done:.0f} % {line}"}, raw=True)

    try:
        yield report
    finally:
        handle.update({"text/html": "", "text/plain": ""}, raw=True)


@contextmanager
def _terminal_bar(title: str, animated: bool = True) -> Iterator[Report]:
    """A bar with the time left on standard error."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        SpinnerColumn,
        Task,
        TaskProgressColumn,
        TextColumn,
    )
    from rich.text import Text

    begun = time.monotonic()

    class TimeLeft(ProgressColumn):
        """The time left as it was last estimated; nothing once that time is over."""

        def render(self, task: Task) -> Text:
            at, done = task.fields["reported"]
            waited = time.monotonic() - begun - at
            return Text(time_left(at, done, waited))

    label = TextColumn("{task.description}", markup=False)
    columns = SpinnerColumn(), label, BarColumn(24), TaskProgressColumn(), TimeLeft()
    console = Console(stderr=True)
    bar = Progress(*columns, console=console, transient=True, auto_refresh=animated)
    task = bar.add_task(title, total=1.0, reported=(0.0, 0.0))

    def report(done: float, text: str) -> None:
        bar.update(
            task,
            completed=done,
            refresh=not animated,
            description=f"{title}: {text}" if text else title,
            reported=(time.monotonic() - begun, done),
        )

    with bar:
        yield report


def time_left(elapsed: float, done: float, waited: float = 0.0) -> str:
    """The remaining time as text, ``waited`` seconds after the share ``done`` was reached in ``elapsed`` seconds; empty while
    unknown, and where more has passed than was expected.
    """
    if not 0 < done < 1:
        return ""
    seconds = elapsed * (1 - done) / done - waited
    if seconds < 1:
        return ""
    return f"about {seconds:.0f} s left" if seconds < 90 else f"about {seconds / 60:.0f} min left"


def busy(title: str) -> Any:
    """A spinner with ``title`` for work of seconds, on a terminal only."""
    tell_progress(None, title)
    if MANNER.get().quiet or not sys.stderr.isatty():
        return nullcontext()
    from rich.console import Console

    return Console(stderr=True).status(title)


def announce_compilation(*kinds: str) -> None:
    """One line when the kernels of ``kinds`` (``statics``, ``transient``, ``train``) must be
    compiled first.
    """
    seconds = seconds_to_compile(*kinds)
    if seconds:
        label = COMPILING.format(seconds)
        tell_progress(None, label)
        _AHEAD[:] = [label]
        tell(label)


def announce_runs(case: Case) -> None:
    """As :func:`announce_compilation`, of what the runs of a case need: of a train, or of springs alone."""
    announce_compilation(*(("train",) if case.train is not None else ("statics", "transient")))


#: Kind of work -> a kernel that is compiled last in it, and the seconds that all of its kernels
#: take on one core.
KERNELS: Mapping[str, tuple[str, str, float]] = {
    "statics": ("valvetrain.cosserat.energy_kernels", "bend_terms", 4.0),
    "transient": ("valvetrain.cosserat.time_stepping", "integrate_in_time", 12.0),
    "train": ("valvetrain.integrate.train_kernel", "advance_train", 16.0),
}  # fmt: skip


def seconds_to_compile(*kinds: str) -> float:
    """Seconds of compilation still needed for ``kinds`` of :data:`KERNELS`; 0 when all is there."""
    return sum(
        seconds
        for module, name, seconds in map(KERNELS.__getitem__, kinds)
        if not _compiled(getattr(import_module(module), name))
    )


def _compiled(kernel: Any) -> bool:
    """Whether ``kernel`` is compiled in this process or has a valid entry in its cache; True where
    that cannot be written.
    """
    if getattr(kernel, "signatures", ()):
        return True
    try:
        # The index of Numba is private; it checks version and age of the source, which a look at
        # file names would not.
        return bool(kernel._cache._cache_file._load_index())
    except AttributeError:
        return True
    except Exception:  # damaged bytes raise whatever they happen to spell; they are compiled again
        return False
