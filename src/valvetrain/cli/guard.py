"""Error handling of the command line: one sentence and an exit code for every error, never a
traceback.
"""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

from typer.core import TyperGroup

from valvetrain.cli.options import giving_back
from valvetrain.cli.outcome import (
    complain,
    error_object,
    manner,
    mend_streams,
    reader_left,
    set_manner,
    unread,
)
from valvetrain.errors import InputError, MissingExtraError, RunFailedError, UnusualValueWarning
from valvetrain.runs.stopping import exit_code, listening, noted
from valvetrain.solution.partial_failures import TRACEBACK_VARIABLE

WRONG_INPUT, FAILED, INTERRUPTED = 2, 1, 130
INTERRUPTED_SENTENCE = "interrupted: nothing more is written; start the command again to repeat it"
#: Arguments of functions, which errors name, -> options of commands.
OPTION_OF = {
    "spring_models": "--spring", "spring_set": "--spring-set", "workers": "--workers", "engine_speeds": "--engine-speed",
    "tolerance": "--tolerance", "reference": "--reference", "resolution": "--resolution", "float_lift": "--float-lift",
    "bounce_height": "--bounce-height", "first_engine_speed": "--from", "duration": "--duration", "draws": "--draws",
    "output": "--output", "dask": "--dask",
}  # fmt: skip
#: The sentence on what an interrupted command saved, once it is printed.
_reported: list[str] = []


def warning_line(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    line: str | None = None,
) -> str:
    """An unusual value as a sentence, each once; others as Python shows them."""
    if issubclass(category, UnusualValueWarning):
        text = "" if str(message) in _warned else f"warning: {message}\n"
        _warned.add(str(message))
        return text
    return _shown_by_python(message, category, filename, lineno, line)


_shown_by_python = warnings.formatwarning
_warned: set[str] = set()


class GuardedGroup(TyperGroup):
    """A command group whose errors are sentences on standard error with the exit codes of
    ``docs/reliability.md``.
    """

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Parse, run, and leave by ``SystemExit`` with the exit code (or hand it back when not
        standalone).
        """
        mend_streams()
        warnings.formatwarning = warning_line
        set_manner(sys.argv[1:] if args is None else list(args))
        _reported.clear()
        with listening(), giving_back():
            try:
                result = super().main(
                    args, prog_name, complete_var, False, windows_expand_args, **extra
                )
                code = result if isinstance(result, int) else 0
                if (
                    code == INTERRUPTED
                ):  # the parser turns every signal into this code without a word
                    code = interrupted()
            except Exception as error:
                code = interrupted() if noted() else _report(error)
            except KeyboardInterrupt:
                code = interrupted()
            except (
                SystemExit
            ) as error:  # rich and the parser end the process where nothing reads what they print
                code = (
                    0
                    if isinstance(error.__context__, BrokenPipeError) and unread()
                    else error.code
                    if isinstance(error.code, int)
                    else FAILED
                )
            stopped = noted()
        if not standalone_mode:
            return code
        if stopped:  # threads may still compute what is no longer needed
            with contextlib.suppress(OSError, ValueError):
                sys.stdout.flush()
            os._exit(code)
        sys.exit(code)


def interrupted(sentence: str = INTERRUPTED_SENTENCE) -> int:
    """Print once that the command was interrupted and what it saved; the exit code."""
    code = exit_code(noted())
    if not _reported:
        _reported.append(sentence)
        complain(sentence)
        if sentence == INTERRUPTED_SENTENCE:
            _as_json(sentence, "", code)
    return code


def _report(error: Exception) -> int:
    if isinstance(error, InputError):
        return _say(error.reason, WRONG_INPUT, OPTION_OF.get(error.where, error.where))
    if isinstance(error, MissingExtraError):
        return _say(str(error), WRONG_INPUT)
    if isinstance(error, RunFailedError):
        return _say(str(error), FAILED)
    if hasattr(error, "format_message"):  # the parser's own errors
        return _usage(error)
    if type(error).__name__ == "Abort":
        return interrupted()
    if isinstance(error, BrokenPipeError) and reader_left():
        return 0  # it has read what it wanted
    if os.environ.get(TRACEBACK_VARIABLE):
        raise error
    if isinstance(error, MemoryError):
        return _say(
            "the memory is not enough; ask for fewer elements, steps or engine speeds", FAILED
        )
    if isinstance(error, OSError):
        return _say(
            f"{error.strerror or error} ({error.filename or 'no file'}); check the disk and the permissions",
            FAILED,
        )
    return _say(
        f"fault in valvetrain ({type(error).__name__}: {error}); report it with what {TRACEBACK_VARIABLE}=1 prints before",
        FAILED,
    )


def _usage(error: Any) -> int:
    message = " ".join(error.format_message().split()).rstrip(".").replace(". Did", "; did")
    context = getattr(error, "ctx", None)
    command = context.command_path if context is not None else "valvetrain"
    message = message[:1].lower() + message[1:]
    remedy = "" if "?" in message else f"; see '{command} --help'"
    return _say(f"{message}{remedy}", WRONG_INPUT)


def _say(sentence: str, code: int, where: str = "") -> int:
    """Print an error on standard error, and under ``--json`` as an object on standard output."""
    message = " ".join(sentence.split())
    complain(f"error: {where}: {message}" if where else f"error: {message}")
    _as_json(message, where, code)
    return code


def _as_json(message: str, where: str, code: int) -> None:
    if manner().json:
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.write(error_object(message, where, code) + "\n")
            sys.stdout.flush()
