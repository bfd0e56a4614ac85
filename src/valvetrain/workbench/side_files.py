"""Files next to a case, such as tables of lifts: listed, put there and taken away, none of
them larger or more than a bound.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_toml
from valvetrain.solution.atomic import write_bytes, write_text
from valvetrain.units.text import clipped
from valvetrain.workbench.edits import named_files
from valvetrain.workbench.store import inside, writing

CASE_FILE = "case.toml"
#: Bounds of the files of one case: number, and bytes together.
MAX_FILES, MAX_FILE_BYTES = 20, 20_000_000
#: Names of what a job writes next to the case that it was given.
_OF_JOBS = ("answer.json", "complaints.txt", "lock")


@dataclass(frozen=True, slots=True)
class StoredFile:
    """A file of a case or a run that a visitor put there.

    Parameters
    ----------
    path : where it is
    size : bytes
    changed : time at which it was written (ns since the epoch)
    is_named : the case names it, so it cannot be removed
    """

    path: Path
    size: int
    changed: int
    is_named: bool = False

    @property
    def name(self) -> str:
        """Its name."""
        return self.path.name


def stored_files(folder: Path, named: Collection[str] = ()) -> tuple[StoredFile, ...]:
    """The files in a ``folder``, by name: no links, nothing hidden or half written, and no case; those
    ``named`` by one say so.
    """
    files = []
    with suppress(OSError):  # the folder, or one of them, was removed meanwhile
        for path in sorted(folder.iterdir()) if not folder.is_symlink() else ():
            if path.name == CASE_FILE or path.name.startswith("."):
                continue
            if path.is_file() and not path.is_symlink():
                with suppress(OSError):
                    status = path.stat()
                    files.append(
                        StoredFile(path, status.st_size, status.st_mtime_ns, path.name in named)
                    )
    return tuple(files)


def names_in(text: str) -> frozenset[str]:
    """Names of the files that a case names; none of a text that is no TOML."""
    try:
        return frozenset(named_files(parse_toml(text, "case")))
    except InputError:
        return frozenset()


def found_file(folder: Path, name: str) -> Path:
    """The file of that name next to the case in ``folder``. Raises :class:`InputError` where there
    is none.
    """
    path = inside(folder, name)
    if name == CASE_FILE or not path.is_file():
        raise InputError(
            f"there is no file '{clipped(name, 60)}' next to this case; it may have been removed",
            "file",
        )
    return path


def check_bounds(
    files: Mapping[str, bytes | int], where: str, new: Collection[str] | None = None
) -> None:
    """Refuse, with an :class:`InputError`, more files than a case may have, and names that a
    case or a job has for its own.

    ``files``: contents, or numbers of bytes, by name; ``new``: those that are put there, whose
    names are judged; all where left out.
    """
    for name in files if new is None else new:
        if name.lower().endswith(".toml"):
            raise InputError(
                f"'{clipped(name, 60)}' is no file that a case names; a case file is opened on the start page",
                where,
            )
        if name.lower() in _OF_JOBS:
            raise InputError(
                f"'{name}' is a name that a run has for its own; give the file another", where
            )
    size = sum(one if isinstance(one, int) else len(one) for one in files.values())
    if len(files) > MAX_FILES or size > MAX_FILE_BYTES:
        raise InputError(
            f"a case has at most {MAX_FILES} files of {MAX_FILE_BYTES / 1e6:.0f} MB; leave this one out",
            where,
        )


def not_sent(text: str, sent: Mapping[str, bytes]) -> str:
    """The sentence on files that a case names and that were not sent with it; empty where all were."""
    missing = sorted(names_in(text) - set(sent))
    if not missing:
        return ""
    missing_names = " and ".join(f"'{clipped(name, 60)}'" for name in missing[:3])
    what = "which was" if len(missing) == 1 else "which were"
    return f"names {missing_names}, {what} not sent with it; choose the case and the files it names together, then send them at once"


#: What the name of a passing folder begins with.
_PASSING = ".new-"


@contextmanager
def passing_folder(root: Path, files: Mapping[str, bytes]) -> Iterator[Path]:
    """A folder with ``files`` in a passing one below ``root``, where a case that names them is read before it is there."""
    with (
        writing("what was sent", "name"),
        tempfile.TemporaryDirectory(prefix=_PASSING, dir=root, ignore_cleanup_errors=True) as name,
    ):
        made = Path(name) / "case"
        made.mkdir()
        for side, content in files.items():
            write_bytes(inside(made, side), content)
        yield made


def new_folder(root: Path, name: str, text: str, files: Mapping[str, bytes], read: Callable[[Path], object]) -> None:  # fmt: skip
    """Make the folder ``name`` of a case below ``root`` with its ``text`` and ``files``, whole or
    not at all; ``read`` refuses what is no case.

    Raises :class:`InputError` for a name that is taken, and where it cannot be written.
    """
    folder = inside(root, name)
    with passing_folder(root, files) as made:
        read(made)
        write_text(made / CASE_FILE, text)
        if folder.exists():
            raise InputError(f"there is a case '{name}' already; choose another name", "name")
        made.rename(folder)


def remove_passing(root: Path) -> None:
    """Remove what a server that was killed left of them."""
    for left in root.glob(f"{_PASSING}*"):
        if not left.is_symlink():
            shutil.rmtree(left, ignore_errors=True)
