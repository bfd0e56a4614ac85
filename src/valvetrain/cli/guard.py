"""Error handling of the command line: one sentence and an exit code for every error, never a
traceback.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from typer.core import TyperGroup

from valvetrain.cli.outcome import (
    MANNER,
    Manner,
    complain,
    error_object,
    giving_back,
    mend_streams,
    reader_left,
    tell,
    unread,
)
from valvetrain.errors import InputError, MissingExtraError, RunFailedError, UnusualValueWarning
from valvetrain.runs.stopping import exit_code, listening, noted
from valvetrain.solution.status import TRACEBACK_VARIABLE

WRONG_INPUT, FAILED, INTERRUPTED = 2, 1, 130
INTERRUPTED_SENTENCE = "interrupted: nothing more is written; start the command again to repeat it"
#: The sentence on what an interrupted command saved, once it is printed.
_reported: list[str] = []


#: Warnings of unusual values that were shown.
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
        given = sys.argv[1:] if args is None else args
        # before parsing, so that errors of the parser obey it too
        MANNER.set(Manner("--json" in given, "--quiet" in given))
        _reported.clear()
        _warned.clear()
        with listening(), giving_back(), warnings.catch_warnings():
            warnings.showwarning = _show_warning  # type: ignore[assignment]
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
                code = (
                    interrupted()
                    if noted()
                    else _report(error, self._options_of(given), self.commands)
                )
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

    def _options_of(self, args: Sequence[str]) -> dict[str, str]:
        """Argument of the function of the command in ``args`` -> the option that gives it."""
        command = next((self.commands[word] for word in args if word in self.commands), None)
        return {
            str(one.name): next(flag for flag in one.opts if flag.startswith("--"))
            for one in (command.params if command is not None else ())
            if any(flag.startswith("--") for flag in one.opts)
        }


def _by_options(sentence: str, options: Mapping[str, str]) -> str:
    """A sentence on arguments of a function with the options that a user types: names of several
    words, and names alone in brackets.
    """

    def by_flags(text: str, pattern: str) -> str:
        return re.sub(pattern, lambda found: options.get(found[0], found[0]), text)

    def in_brackets(found: re.Match[str]) -> str:
        names = set(re.findall(r"[\w-]+", found[0])) - {"or", "and"}
        return by_flags(found[0], r"\w+") if names <= options.keys() else found[0]

    return re.sub(
        r"\([\w, -]+\)",
        in_brackets,
        by_flags(sentence, r"(?<![\w.'-])[a-z]+(?:_[a-z]+)+(?![\w.'-])"),
    )


def _show_warning(message: Warning | str, category: type[Warning], *rest: Any) -> None:
    """A warning of this package as one line on standard error; each once; those of libraries as ever."""
    if issubclass(category, UnusualValueWarning):
        if str(message) not in _warned:
            _warned.add(str(message))
            tell(f"warning: {message}")
    else:
        sys.stderr.write(warnings.formatwarning(message, category, *rest[:2]))


def interrupted(sentence: str = INTERRUPTED_SENTENCE) -> int:
    """Print once that the command was interrupted and what it saved; the exit code."""
    code = exit_code(noted())
    if not _reported:
        _reported.append(sentence)
        complain(sentence)
        if sentence == INTERRUPTED_SENTENCE:
            _as_json(sentence, "", code)
    return code


def _report(error: Exception, options: Mapping[str, str], commands: Mapping[str, Any]) -> int:
    if isinstance(error, InputError):
        named = error.where.partition(" of a ")[0]
        where = options.get(named, error.where)
        of_an_option = where in options.values()
        return _say(
            _by_options(error.reason, options) if of_an_option else error.reason, WRONG_INPUT, where
        )
    if isinstance(error, MissingExtraError):
        return _say(str(error), WRONG_INPUT)
    if isinstance(error, RunFailedError):
        return _say(str(error), FAILED)
    if hasattr(error, "format_message"):  # the parser's own errors
        return _usage(error, commands)
    if type(error).__name__ == "Abort":
        return interrupted()
    if isinstance(error, BrokenPipeError) and reader_left():
        return 0  # it has read enough
    if os.environ.get(TRACEBACK_VARIABLE):
        raise error
    if isinstance(error, MemoryError):
        return _say(
            "the memory is not enough; choose fewer elements, steps or engine speeds", FAILED
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


def _usage(error: Any, commands: Mapping[str, Any]) -> int:
    message = " ".join(error.format_message().split()).rstrip(".").replace(". Did", "; did")
    context = getattr(error, "ctx", None)
    command = context.command_path if context is not None else "valvetrain"
    message = message[:1].lower() + message[1:]
    word = message.partition("no such command '")[2].rstrip("'").lower()
    named = (
        f"{command} {name}"
        for name, one in commands.items()
        if word and word in (one.help or "").lower()
    )
    remedy = "" if "?" in message else f"; see '{next(named, f'{command} --help')}'"
    return _say(f"{message}{remedy}", WRONG_INPUT)


def _say(sentence: str, code: int, where: str = "") -> int:
    """Print an error on standard error, and under ``--json`` as an object on standard output."""
    message = " ".join(sentence.split())
    placed = where and not message.startswith(where)
    read = _in_units_of_reader(message)
    complain(f"error: {where}: {read}" if placed else f"error: {read}")
    _as_json(message, where, code)
    return code


def _in_units_of_reader(message: str) -> str:
    """A refusal with its numbers in the units requested, but what is quoted from the input as it is."""
    from valvetrain.units.reader import for_reader, reader_text

    parts = re.split(r"('[^']*')", message)
    with for_reader():
        return "".join(one if one.startswith("'") else reader_text(one) for one in parts)


def _as_json(message: str, where: str, code: int) -> None:
    if MANNER.get().json:
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.write(error_object(message, where, code) + "\n")
            sys.stdout.flush()
