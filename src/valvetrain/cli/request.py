"""Commands made from requests: each field of a request and of its command line is an option, and the model alone reads
its text.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer

from valvetrain.cli.options import (
    FIGURE_FORMATS,
    choose_case,
    folder_of,
    matching_cases,
    name_case,
    read_workers,
    take_folder,
)
from valvetrain.cli.outcome import at_end
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import (
    Fields,
    Option,
    flagged,
    option,
    options_of,
    read_choice,
    read_path,
    read_switch,
    read_text,
)
from valvetrain.runs.requests import Clustered, ParallelRequest

RequestOf = TypeVar("RequestOf", bound=Fields)
LineOf = TypeVar("LineOf", bound="CommandLine")
FieldsOf = TypeVar("FieldsOf", bound=Fields)


@dataclass(frozen=True, kw_only=True)
class QuietLine(Fields):
    """The command line of every command."""

    quiet: bool = option(
        read_switch,
        "Print errors only; the exit code says how it ended.",
        "--quiet",
        default=False,
    )


@dataclass(frozen=True, kw_only=True)
class AnswerLine(QuietLine):
    """The command line of a command that prints an answer."""

    json: bool = option(
        read_switch,
        "Print one JSON object on standard output and nothing else there.",
        "--json",
        default=False,
    )


@dataclass(frozen=True, kw_only=True)
class CommandLine(AnswerLine):
    """What a command line says besides its request: units and form of the answer."""

    units: str = option(
        read_text,
        "Units of the answer and the page: si or imperial (in, lbf, lbf/in, ksi); default: as the case is written. Files and --json stay SI.",
        "--units",
        "SYSTEM",
        default="",
    )
    open_page: bool = option(
        read_switch, "Open the report page in a browser.", "--open", default=False
    )

    def request(self, model: type[RequestOf], given: Mapping[str, Any]) -> tuple[RequestOf, Path]:
        """The request that was typed, and the folder of its case file, which most commands need."""
        return model.read(given, flags=True), Path()


@dataclass(frozen=True, kw_only=True)
class FolderLine(CommandLine):
    """The command line of a request whose result is saved in a folder."""

    output: Path | None = option(
        read_path,
        "Folder of the results (default: a new one, runs/CASE/DATE-TIME-DIGEST).",
        "--output",
        "FOLDER",
    )

    def request(self, model: type[RequestOf], given: Mapping[str, Any]) -> tuple[RequestOf, Path]:
        """As that of the base class, with the folder locked."""
        request, folder = super().request(model, given)
        take_folder(self.output)
        return request, folder


@dataclass(frozen=True, kw_only=True)
class SavedLine(FolderLine):
    """The command line of a request of a case, with changes of it, whose result is saved in a folder."""

    settings: tuple[str, ...] = option(
        lambda given, _: tuple(given),
        "Change a value of the case, written as in its file: 'spring.wire_diameter=4.1 mm'. Nothing after '=' removes it. Repeatable.",
        "--set",
        "KEY.PATH=VALUE",
        default=(),
        repeatable=True,
    )

    def request(self, model: type[RequestOf], given: Mapping[str, Any]) -> tuple[RequestOf, Path]:
        """As that of the base class, of the case with its changes."""
        name, sets = given["case"], given.get("spring_sets") or ()
        if name is None:
            if self.settings:
                raise InputError("values are changed of a case; name it with --case", "--set")
            return super().request(model, given)
        name_case(name, self.settings, [part for one in sets for part in ("--spring-set", one)])
        case = choose_case(name, self.settings)
        request = model.read({**given, "case": case}, flags=True)
        take_folder(self.output)
        return request, folder_of(name)


@dataclass(frozen=True, kw_only=True)
class DaskLine(Clustered, SavedLine):
    """The command line of a request that a cluster can compute."""


@dataclass(frozen=True, kw_only=True)
class StudyLine(SavedLine):
    """The command line of a study, with its page and figures."""

    report: bool = option(
        read_switch, "Write the report page.", "--report/--no-report", default=True
    )
    figures: str = option(
        partial(read_choice, FIGURE_FORMATS),
        "Write every figure as a file of this format too.",
        "--figures",
        "|".join(FIGURE_FORMATS),
        default="",
    )


@dataclass(frozen=True, kw_only=True)
class MotionLine(StudyLine, DaskLine):
    """The command line of a study in motion."""


def command_of(
    model: type[RequestOf],
    line: type[LineOf],
    execute: Callable[[RequestOf, LineOf, Path], None],
    **always: Any,
) -> Callable[[typer.Typer], None]:
    """The function that adds the command of a request. ``execute`` takes the request, the command line and the folder of
    the case file.

    ``always``: fields that the command sets itself, which are then no options.
    """

    def command(**given: Any) -> None:
        from valvetrain.units.reader import request_units

        typed = line.read({name: given.pop(name) for name in options_of(line)}, flags=True)
        request_units(typed.units)
        at_end(lambda: request_units(""))
        request, folder = typed.request(model, {**given, **always})
        if isinstance(request, ParallelRequest):
            workers = read_workers(request.workers, getattr(typed, "dask", ""))
            request = replace(request, workers=workers)
        with flagged({name: one for name, one in options_of(model).items() if one.flag}):
            execute(request, typed, folder)

    return partial(_add, model.command, execute, (model, line), command, always)


def command_without_case(
    name: str, line: type[FieldsOf], execute: Callable[[FieldsOf], None]
) -> Callable[[typer.Typer], None]:
    """The function that adds the command ``name``, which is about no case: ``execute`` takes its command line."""

    def command(**given: Any) -> None:
        execute(line.read(given, flags=True))

    return partial(_add, name, execute, (line,), command, ())


def _add(
    name: str,
    execute: Callable[..., None],
    models: tuple[type[Fields], ...],
    command: Callable[..., None],
    always: Container[str],
    app: typer.Typer,
) -> None:
    """Add a command with the options of all fields of ``models`` but those of ``always``."""
    every = {name: one for model in models for name, one in options_of(model).items()}
    parameters = [
        _parameter(name, one)
        for name, one in every.items()
        if name not in always and (one.flag or one.metavar)
    ]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__doc__ = execute.__doc__
    app.command(name)(command)


def _parameter(name: str, asked: Option) -> inspect.Parameter:
    """The parameter of typer for an option; its text is read later."""
    keyword = inspect.Parameter.KEYWORD_ONLY
    if not asked.flag:
        word = asked.metavar.strip("[]")
        info: Any = typer.Argument(
            metavar=word,
            help=asked.meaning,
            autocompletion=matching_cases if word == "CASE" else None,
            show_default=False,
        )
        if word == asked.metavar:
            return inspect.Parameter(name, keyword, annotation=Annotated[str, info])
        return inspect.Parameter(
            name, keyword, annotation=Annotated[str | None, info], default=None
        )
    info = typer.Option(
        *asked.flag.split(),
        metavar=asked.metavar or None,
        help=asked.meaning + (f" (default: {asked.default})" if asked.default else ""),
        show_default=False,
        envvar="VALVETRAIN_UNITS" if name == "units" else None,
        show_envvar=False,
    )
    if not asked.metavar:
        default = "/" in asked.flag
        return inspect.Parameter(name, keyword, annotation=Annotated[bool, info], default=default)
    kind: Any = list[str] if asked.repeatable else str
    return inspect.Parameter(name, keyword, annotation=Annotated[kind | None, info], default=None)
