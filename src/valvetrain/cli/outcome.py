"""Outcome of a command: one JSON object or tables for people, and what went wrong."""

from __future__ import annotations

import contextlib
import json
import math
import os
import select
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from valvetrain.errors import InputError
from valvetrain.solution.status import TRACEBACK_VARIABLE, reason

_STREAMS = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))


def mend_streams() -> None:
    """Open the null device in place of closed standard streams (``>&-``), whose number the next
    opened file would take. Characters that a stream cannot encode are written with backslashes.
    """
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
    """Whether the reader of standard output has left (``| head -1``); then nothing more is written
    to it.
    """
    try:
        place = sys.stdout.fileno()
        if hasattr(
            select, "poll"
        ):  # elsewhere it is taken for granted: this is called after an error of a pipe
            watch = select.poll()
            watch.register(place, select.POLLOUT)
            if not any(what & (select.POLLERR | select.POLLHUP) for _, what in watch.poll(0)):
                return False
        _discard(place)
    except (OSError, ValueError):
        return False
    return True


def _discard(place: int) -> None:
    """Send what is written to the file descriptor ``place`` to the null device."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), place)


def unread() -> bool:
    """As :func:`reader_left`, also where rich has already replaced standard output by the null
    device.
    """
    try:
        return os.path.samestat(os.fstat(sys.stdout.fileno()), os.stat(os.devnull)) or reader_left()
    except (OSError, ValueError):
        return False


#: Width of tables where the output is no terminal.
PLAIN_WIDTH = 100


@dataclass(frozen=True, slots=True)
class Manner:
    """Output requested on the command line: one JSON object on standard output, or nothing but
    errors.
    """

    json: bool = False
    quiet: bool = False


_DEFAULT = Manner()
#: The output requested on the command line.
MANNER: ContextVar[Manner] = ContextVar("manner", default=_DEFAULT)


@dataclass(frozen=True)
class Outcome:
    """``data``: the object of ``--json``. ``show`` prints the same for people. ``failures``: a sentence per run that did not complete."""

    data: Mapping[str, Any]
    show: Callable[[Console], None]
    failures: tuple[str, ...] = ()


def deliver(outcome: Outcome) -> None:
    """Print an outcome on standard output, failures on standard error; exit code 1 where a run
    failed.
    """
    failures = outcome.failures
    try:
        if MANNER.get().json:
            sys.stdout.write(to_json(outcome.data) + "\n")
        elif not MANNER.get().quiet:
            failures = (*failures, *_show(outcome))
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read it has left; the exit code still reports the result
        if not reader_left():
            raise
    except OSError as error:
        if not error.filename:
            error.filename = "standard output"
            # what is still buffered would fail once more at the end, which changes the exit code
            with contextlib.suppress(OSError, ValueError):
                _discard(sys.stdout.fileno())
        raise
    for sentence in failures:
        complain(f"failed: {sentence}")
    if failures:
        raise typer.Exit(1)


def _show(outcome: Outcome) -> tuple[str, ...]:
    """Print for people; what could not be printed, since results are saved whatever printing does."""
    from valvetrain.units.reader import for_reader

    try:
        width = None if sys.stdout.isatty() else PLAIN_WIDTH
        console = _Plain(file=sys.stdout, width=width, highlight=False, markup=False, emoji=False)
        with for_reader():
            outcome.show(console)
    except (OSError, InputError, typer.Exit):
        raise
    except Exception as error:
        if os.environ.get(TRACEBACK_VARIABLE):
            raise
        return (f"answer in the terminal: {reason(error)}",)
    return ()


class _Plain(Console):
    """A console that prints control sequences of foreign text as text and reports a reader that
    left.
    """

    def on_broken_pipe(self) -> None:
        """Replace rich's handling of a broken pipe, which would end the process with code 1."""
        raise BrokenPipeError

    def print(self, *objects: Any, crop: bool = False, **manner: Any) -> None:
        """Print lines that do not wrap, such as commands to copy, as long as they are; see the base class."""
        super().print(*objects, crop=crop, **manner)

    def render_str(self, text: str, **manner: Any) -> Text:
        """Text with control sequences escaped; see the base class."""
        return super().render_str(
            "".join(char if char.isprintable() or char in "\n\xa0" else "?" for char in text),
            **manner,
        )


def tell(sentence: str) -> None:
    """Print one line on standard error, whatever the sentence contains; nothing under ``--quiet``."""
    if not MANNER.get().quiet:
        complain(sentence)


def complain(sentence: str) -> None:
    """Print one error line on standard error, under ``--quiet`` too."""
    clean = "".join(char if char.isprintable() else "?" for char in sentence)
    sys.stderr.write(clean + "\n")
    sys.stderr.flush()


def error_object(message: str, where: str, code: int) -> str:
    """The JSON object of an error; ``code`` is the exit code."""
    return to_json({"error": {"message": message, "where": where, "code": code}})


def to_json(data: Mapping[str, Any]) -> str:
    """One JSON object; numbers that are not finite become null."""
    return json.dumps(plain(data), indent=2, allow_nan=False)


def plain(item: Any) -> Any:
    """``item`` as JSON values: numbers that are not finite are null, arrays lists, anything else
    text.
    """
    if isinstance(item, Mapping):
        return {str(key): plain(value) for key, value in item.items()}
    if isinstance(item, (list, tuple)):
        return [plain(value) for value in item]
    if hasattr(item, "tolist"):
        return plain(item.tolist())
    if isinstance(item, float):
        return item if math.isfinite(item) else None
    if item is None or isinstance(item, (bool, int, str)):
        return item
    return str(item)


def plain_table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """A table without frames."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), show_header=any(headers))
    for header in headers:
        table.add_column(header, overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


#: Estimates above this are printed (s).
WORTH_SAYING = 20.0


#: What the commands that run release at their ends.
HELD: list[ExitStack] = []


@contextmanager
def giving_back() -> Iterator[None]:
    """Call at the end of the block every release that :func:`at_end` received in it."""
    with ExitStack() as held:
        HELD.append(held)
        try:
            yield
        finally:
            HELD.remove(held)


def at_end(release: Callable[[], None]) -> None:
    """Call ``release`` when the command ends."""
    HELD[-1].callback(release)
