"""Options that several commands share, how their text is read, and the case that a command works
on.
"""

from __future__ import annotations

import inspect
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from valvetrain.cli.outcome import HELD, at_end
from valvetrain.errors import InputError
from valvetrain.runs import request_fields
from valvetrain.runs.request_fields import options_of
from valvetrain.runs.requests import MAX_WORKERS, Sweep

if TYPE_CHECKING:
    from valvetrain.measured.sensor import Sensor
    from valvetrain.parameters.case import Case


def name_case(case: str, settings: Sequence[str] | None, more: Sequence[str] = ()) -> None:
    """Remember until the command ends how the command line names its case, so that a next step can be copied."""
    from valvetrain.session import call_case

    changes = [part for text in settings or () for part in ("--set", text)]
    call_case([*filter(None, (case,)), *changes, *more])
    at_end(partial(call_case, []))


def asks(flag: str, metavar: str | None, label: str) -> Any:
    """An option that takes text, empty by default."""
    return typer.Option(flag, metavar=metavar, help=label, show_default=False)


#: What follows an option -> what is read; else a text.
KINDS = {"N": int, "SHARE": float, "PX": float, "TURNS": float, "": bool}


def asking(
    function: Callable[..., None], asked: Mapping[str, tuple[str, str, str]]
) -> Callable[..., None]:
    """``function`` with an option for each question of ``asked``: its name -> flag, what follows that, and help.

    What follows says what is read: ``QUANTITY=...`` pairs, else as :data:`KINDS`.
    ``function`` takes what was given by name as ``answers``.
    """
    hints = get_type_hints(function, include_extras=True)
    keyword = inspect.Parameter.KEYWORD_ONLY
    first, *others, _ = (
        parameter.replace(kind=keyword, annotation=hints[parameter.name])
        for parameter in inspect.signature(function).parameters.values()
    )
    parameters = [first]
    for name, (flag, follows, label) in asked.items():
        kind = list[str] if "=" in follows else KINDS.get(follows, str)
        option = Annotated[kind | None, asks(flag, follows or None, label)]  # type: ignore[valid-type]
        parameters.append(inspect.Parameter(name, keyword, default=None, annotation=option))
    parameters += others

    def command(**given: Any) -> None:
        answers = {}
        for name, (flag, follows, _) in asked.items():
            if (value := given.pop(name)) is not None:
                answers[name] = read_pairs(value, flag) if "=" in follows else value
        try:
            function(**given, answers=answers)
        except InputError as error:  # a field of a table is named by its option
            name = error.where.partition(" of the ")[0]
            where = asked[name][0] if name in asked else error.where
            raise InputError(error.reason, where) from error

    command.__doc__, command.__name__ = function.__doc__, function.__name__
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return command


def read_pairs(texts: Sequence[str], option: str) -> dict[str, str]:
    """``QUANTITY=VALUE`` of a repeatable option. Raises :class:`InputError` for a text without the
    sign, or a quantity named twice.
    """
    pairs: dict[str, str] = {}
    for text in texts:
        quantity, _, value = (part.strip() for part in text.partition("="))
        name = quantity.replace(" ", "_")
        if not value or not name.isidentifier() or not name.isascii() or len(name) > 60:
            raise InputError(
                f"'{text[:40]}' is no pair; write QUANTITY=..., such as 'spring_force=...'", option
            )
        if name in pairs:
            raise InputError(f"{name} is given twice; give it once", option)
        pairs[name] = value
    return pairs


def matching_cases(begun: str) -> list[str]:
    """Library cases whose names start with ``begun``, for shell completion."""
    from valvetrain.parameters.loading import library_names

    return [name for name in library_names() if name.startswith(begun)]


def typed_option(name: str) -> Any:
    """The option of typer for a field of a request."""
    asked = options_of(Sweep)[name]
    return typer.Option(
        asked.flag, metavar=asked.metavar or None, help=asked.meaning, show_default=False
    )


CaseArgument = Annotated[
    str,
    typer.Argument(
        metavar="CASE",
        help="Name of a library case (see 'valvetrain cases') or path of a case file.",
        autocompletion=matching_cases,
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY.PATH=VALUE",
        show_default=False,
        help="Change a value of the case, written as in its file: 'spring.wire_diameter=4.1 mm'. Nothing after '=' removes it. Repeatable.",
    ),
]
ElementsOption = Annotated[
    int | None,
    typer.Option(
        "--elements-per-coil", metavar="N", help="Finite elements per coil.", show_default=False
    ),
]
JsonOption = Annotated[
    bool,
    typer.Option("--json", help="Print one JSON object on standard output and nothing else there."),
]
QuietOption = Annotated[
    bool, typer.Option("--quiet", help="Print errors only; the exit code says how it ended.")
]
UnitsOption = Annotated[
    str,
    typer.Option(
        "--units",
        metavar="SYSTEM",
        envvar="VALVETRAIN_UNITS",
        show_envvar=False,
        help="Units of the answer and the page: si or imperial (in, lbf, lbf/in, ksi). Files and --json stay SI.",
    ),
]
SpeedOption = Annotated[str | None, typed_option("engine_speeds")]


def take_units(system: str) -> None:
    """Print the answer of this command in a ``system`` of units. Raises :class:`InputError` for an
    unknown one.
    """
    from valvetrain.units.reader import request_units

    request_units(system)
    at_end(lambda: request_units("si"))


def read_folder(text: str) -> Path:
    """The folder of that name, as :func:`valvetrain.runs.request_fields.read_path` reads it."""
    from valvetrain.runs.request_fields import read_path

    return read_path(text, "--output")


def take_folder(output: Path | None, resumes: str = "") -> None:
    """Check and lock the folder of ``--output``, or the home of saved runs where it is None, until
    the command ends. ``resumes``: file that identifies an unfinished folder of the same command.

    Raises :class:`InputError` for a folder that cannot be used or that another run writes into.
    """
    from valvetrain.runs.run_folders import ROOT, check_folder, lock_folder

    check_folder(output or ROOT, home=output is None, resumes=resumes)
    if output is not None:
        at_end(lock_folder(output))


OutputOption = Annotated[
    Path | None,
    typer.Option(
        "--output",
        metavar="FOLDER",
        parser=read_folder,
        help="Folder of the results (default: a new one, runs/CASE/DATE-TIME-DIGEST).",
    ),
]
WorkersOption = Annotated[int | None, typed_option("workers")]
SpringOption = Annotated[list[str] | None, typed_option("models")]
SpringSetOption = Annotated[list[str] | None, typed_option("spring_sets")]
#: Formats in which plotly's exporter writes a figure.
FIGURE_FORMATS = ("svg", "png", "pdf")
OpenOption = Annotated[bool, typer.Option("--open", help="Open the report page in a browser.")]
LimitOption = Annotated[list[str] | None, typed_option("limit")]
ImplausibleOption = Annotated[bool, typed_option("implausible")]


def read_engine_speeds(text: str | None, where: str = "--rpm") -> tuple[float, ...] | None:
    """Crank speeds (rad/s) as :func:`valvetrain.units.si_speeds` reads them; None for None."""
    from valvetrain.units import si_speeds

    return None if text is None else si_speeds(text, "engine_speed", where)


def read_amounts(texts: Sequence[str] | None, dimension: str, where: str) -> tuple[float, ...]:
    """SI values of a repeatable option, each text one amount or several (``'32 mm'``, ``'200, 400
    N'``), in order.
    """
    return request_fields.read_amounts(dimension, list(texts or ()), where)


def read_workers(value: int | None, dask: str = "") -> int:
    """Number of runs at a time: as requested, else the cores this process may use, at most 4. With ``dask`` that of the cluster, which the
    command uses to its end.
    """
    from valvetrain.runs.workers import available_cores

    count = min(4, available_cores())
    if value is not None:
        count = request_fields.read_count(1, MAX_WORKERS, value, "--workers")
    if not dask:
        return count
    from valvetrain.runs.cluster import on_cluster

    return HELD[-1].enter_context(on_cluster(dask, count))


def read_names(texts: Sequence[str] | None) -> tuple[str, ...]:
    """Names of a repeatable option whose values may be lists with commas, in order, each once."""
    return request_fields.read_names(texts or (), "")


def read_models(texts: Sequence[str] | None) -> tuple[str, ...]:
    """Names of spring models. Raises :class:`InputError` with the nearest name for an unknown one."""
    return request_fields.read_models(texts or (), "--model")


#: Words of --sensor -> how they are read.
SENSOR_KEYS: dict[str, Callable[[str], Any]] = {
    "bandwidth": str, "order": int, "filter": str, "zero_phase": {"yes": True, "no": False}.__getitem__, "natural_frequency": str,
    "damping_ratio": float,
}  # fmt: skip


def read_sensor(bandwidth: str | None, sentence: str | None) -> Sensor:
    """The gauge of ``--bandwidth`` and ``--sensor 'KEY=VALUE, ...'``. Raises :class:`InputError` for other words."""
    from valvetrain.measured.sensor import Sensor

    given: dict[str, Any] = {}
    for part in (sentence or "").split(","):
        if not part.strip():
            continue
        key, sign, value = (one.strip() for one in part.partition("="))
        key = key.replace("-", "_").replace(" ", "_")
        if key not in SENSOR_KEYS or not sign or not value:
            raise InputError(
                f"'{part.strip()[:40]}' is no property of a gauge; use KEY=VALUE with {', '.join(SENSOR_KEYS)}",
                "--sensor",
            )
        try:
            given[key] = SENSOR_KEYS[key](value)
        except (ValueError, KeyError) as error:
            kind = "yes or no" if key == "zero_phase" else "a number"
            raise InputError(
                f"{key} is {kind}, not '{value[:20]}'; correct it", "--sensor"
            ) from error
    if bandwidth is not None:
        if "bandwidth" in given:
            raise InputError("bandwidth is given twice; give it once", "--sensor")
        given["bandwidth"] = bandwidth
    return Sensor(**given)


#: What ``--elements-per-coil`` sets in the table of every spring.
ELEMENTS = "options.finite-element.elements_per_coil"


def choose_case(
    name: str,
    settings: Sequence[str] | None = None,
    elements_per_coil: int | None = None,
) -> Case:
    """Load the case ``name`` with ``settings`` (``key.path=value``) and the mesh of ``--elements-per-coil``.

    A saved run is called by its folder. Raises :class:`InputError`; an error in a value set here is
    placed at its option, not at a line of the file.
    """
    from valvetrain.parameters.loading import load_case
    from valvetrain.parameters.overrides import read_assignment

    changes: dict[str, Any] = {}
    options: dict[str, str] = {}
    for text in settings or ():
        path, value = read_assignment(text, "--set")
        changes[path], options[path] = value, f"--set {path}"
    source = _source_of(name)
    try:
        paths = () if elements_per_coil is None else _spring_paths(load_case(source).text)
        for path in (f"{one}.{ELEMENTS}" for one in paths):
            changes[path], options[path] = elements_per_coil, "--elements-per-coil"
        return load_case(source, changes)
    except InputError as error:
        raise _placed(error, options) from None


def _spring_paths(text: str) -> list[str]:
    """Key paths of every spring of a case file."""
    tree = tomllib.loads(text)
    places = {"spring": tree.get("spring", {})} if "train" not in tree else {}
    places |= {
        f"train.springs.{name}": springs
        for name, springs in tree.get("train", {}).get("springs", {}).items()
    }
    paths = []
    for path, springs in places.items():
        paths += (
            [f"{path}.{place}" for place in range(len(springs))]
            if isinstance(springs, list)
            else [path]
        )
    return paths


def folder_of(name: str) -> Path:
    """Folder of the files that a case names."""
    from valvetrain.parameters.loading import LIBRARY, library_names

    return LIBRARY if name in library_names() else Path(_source_of(name)).parent


def _source_of(name: str) -> str | Path:
    """What is loaded for the ``name`` of a case: the file of a saved run where it is its folder."""
    from valvetrain.parameters.loading import library_names
    from valvetrain.runs.saved_runs import run_of_path

    saved = None if not name.strip() or name in library_names() else run_of_path(Path(name))
    return name if saved is None else saved.case_file


def _placed(error: InputError, options: dict[str, str]) -> InputError:
    key = error.where.rpartition(", ")[2]
    for path, option in options.items():
        if key == path or key.startswith(f"{path}."):
            return InputError(error.reason, option)
    if options and key and any(path.startswith(f"{key}.") for path in options):
        return InputError(error.reason, f"{key} with {', '.join(dict.fromkeys(options.values()))}")
    return error
