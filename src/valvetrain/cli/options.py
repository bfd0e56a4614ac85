"""Options that several commands share, how their text is read, and the case that a command works
on.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.outcome import HELD, at_end
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case


def name_case(case: str, settings: Sequence[str] | None, more: Sequence[str] = ()) -> None:
    """Remember until the command ends how the command line names its case, so that a next step can be copied."""
    from valvetrain.session import call_case

    changes = [part for text in settings or () for part in ("--set", text)]
    call_case([*filter(None, (case,)), *changes, *more])
    at_end(partial(call_case, []))


def matching_cases(begun: str) -> list[str]:
    """Library cases whose names start with ``begun``, for shell completion."""
    from valvetrain.parameters.loading import library_names

    return [name for name in library_names() if name.startswith(begun)]


def take_folder(output: Path | None, resumes: str = "") -> None:
    """Check and lock the folder of ``--output``, or the home of saved runs where it is None, until
    the command ends. ``resumes``: file that identifies an unfinished folder of the same command.

    Raises :class:`InputError` for a folder that cannot be used or that another run writes into.
    """
    from valvetrain.runs.run_folders import ROOT, check_folder, lock_folder

    check_folder(output or ROOT, home=output is None, resumes=resumes)
    if output is not None:
        at_end(lock_folder(output))


#: Formats in which plotly's exporter writes a figure.
FIGURE_FORMATS = ("svg", "png", "pdf")


def read_workers(value: int | None, dask: str = "") -> int:
    """Number of runs at a time: as requested, else the cores this process may use, at most 4. With ``dask`` that of the cluster, which the
    command uses to its end.
    """
    from valvetrain.runs.workers import available_cores

    count = value or min(4, available_cores())
    if not dask:
        return count
    from valvetrain.runs.cluster import on_cluster

    return HELD[-1].enter_context(on_cluster(dask, count))


def choose_case(name: str, settings: Sequence[str] | None = None) -> Case:
    """Load the case ``name`` with ``settings`` (``key.path=value``), in whose units answers are printed.

    A saved run is called by its folder. Raises :class:`InputError`; an error in a value set here is
    placed at its option, not at a line of the file.
    """
    from valvetrain.parameters.loading import load_case
    from valvetrain.parameters.overrides import read_assignment
    from valvetrain.units.reader import follow_case

    changes: dict[str, Any] = {}
    options: dict[str, str] = {}
    for text in settings or ():
        path, value = read_assignment(text, "--set")
        changes[path], options[path] = value, f"--set {path}"
    try:
        case = load_case(_source_of(name), changes)
    except InputError as error:
        raise _placed(error, options) from None
    follow_case(case.text)
    return case


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
