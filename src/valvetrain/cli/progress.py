"""Progress and remaining time on standard error, and as JSON lines for a calling program."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from importlib import import_module
from typing import Any

from valvetrain.cli.outcome import manner, tell

Report = Callable[[float, str], None]
#: Names the open file (its number) that receives the progress, ``{"share": 0.25, "text":
#: "multi-mass, 4200 rpm"}`` a line.
PROGRESS_VARIABLE = "VALVETRAIN_PROGRESS"
#: What was announced to come before the first share of the work.
_AHEAD: list[str] = []


def tell_progress(share: float | None, text: str) -> None:
    """One line to the file that :data:`PROGRESS_VARIABLE` names, where it does; ``share`` of the
    work done, None while it is not known.
    """
    number = os.environ.get(PROGRESS_VARIABLE, "")
    if number.isdecimal():
        with suppress(OSError):
            os.write(int(number), (json.dumps({"share": share, "text": text}) + "\n").encode())


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """A bar with the time left while the block runs, on a terminal only; yields ``report(share
    done, what was just done)``.
    """
    tell_progress(0.0, "; ".join([title, *_AHEAD]))
    _AHEAD.clear()
    if manner().quiet or not sys.stderr.isatty():
        yield tell_progress
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn

    label, left = TextColumn("{task.description}", markup=False), TextColumn("{task.fields[left]}")
    columns = SpinnerColumn(), label, BarColumn(24), TaskProgressColumn(), left
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(title, total=1.0, left="")
    begun = time.monotonic()

    def report(done: float, text: str) -> None:
        tell_progress(done, text)
        bar.update(
            task,
            completed=done,
            description=f"{title}: {text}",
            left=time_left(time.monotonic() - begun, done),
        )

    with bar:
        yield report


def time_left(elapsed: float, done: float) -> str:
    """The remaining time as text after ``elapsed`` seconds with the share ``done``; empty while
    unknown.
    """
    if not 0 < done < 1:
        return ""
    seconds = elapsed * (1 - done) / done
    return f"about {seconds:.0f} s left" if seconds < 90 else f"about {seconds / 60:.0f} min left"


def busy(title: str) -> Any:
    """A spinner with ``title`` for work of seconds, on a terminal only."""
    tell_progress(None, title)
    if manner().quiet or not sys.stderr.isatty():
        return nullcontext()
    from rich.console import Console

    return Console(stderr=True).status(title)


def announce_compilation(*kinds: str) -> None:
    """One line when the kernels of ``kinds`` (``statics``, ``transient``, ``train``) must be
    compiled first.
    """

    seconds = seconds_to_compile(*kinds)
    if seconds:
        label = f"compiling kernels, once, about {seconds:.0f} s"
        tell_progress(None, label)
        _AHEAD[:] = [label]
        tell(label)


#: Kind of work -> a kernel that is compiled last in it, and the seconds that all of its kernels
#: take on one core.
KERNELS: Mapping[str, tuple[str, str, float]] = {
    "statics": ("valvetrain.cosserat.energy_kernels", "bend_terms", 4.0),
    "transient": ("valvetrain.cosserat.time_stepping", "integrate_in_time", 12.0),
    "train": ("valvetrain.integrate.train_kernel", "advance_train", 16.0),
}  # fmt: skip


def seconds_to_compile(*kinds: str) -> float:
    """Seconds of compilation that lie ahead for ``kinds`` of :data:`KERNELS`; 0 when all is there."""
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
        # Numba keeps its index private; it checks version and age of the source, which a look at
        # file names would not.
        return bool(kernel._cache._cache_file._load_index())
    except AttributeError:
        return True
    except Exception:  # damaged bytes raise whatever they happen to spell; they are compiled again
        return False
