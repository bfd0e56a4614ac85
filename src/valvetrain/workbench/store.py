"""The database of a workspace: one SQLite file, a connection for each use, so that threads and
restarts do not matter. Reading it writes nothing, so a full disk or one that may not be written is read.
"""

from __future__ import annotations

import os
import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.runs.run_folders import safe_name
from valvetrain.units.text import clipped

DATABASE = "workbench.sqlite"
_TABLES = """
CREATE TABLE IF NOT EXISTS changes (
    id INTEGER PRIMARY KEY, name TEXT NOT NULL, before TEXT NOT NULL, after TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS jobs (
    id TEXT PRIMARY KEY, case_name TEXT NOT NULL, kind TEXT NOT NULL, request TEXT NOT NULL, state TEXT NOT NULL,
    share REAL NOT NULL DEFAULT 0, text TEXT NOT NULL DEFAULT '', seconds_left REAL, error TEXT NOT NULL DEFAULT '',
    run_id TEXT NOT NULL DEFAULT '', created_at REAL NOT NULL, started_at REAL, ended_at REAL
);
CREATE INDEX IF NOT EXISTS jobs_by_case ON jobs (case_name, created_at);
CREATE INDEX IF NOT EXISTS jobs_by_run ON jobs (run_id);
"""
#: Layout of the tables above; a file of another layout is refused, never guessed at.
_LAYOUT = 2


class Store:
    """The SQLite file of a workspace.

    Parameters
    ----------
    folder : folder of the workspace

    Raises
    ------
    InputError : a file that is no such database, or of another layout
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / DATABASE
        with self.connected() as base:
            base.execute("PRAGMA journal_mode=DELETE")
            (found,) = base.execute("PRAGMA user_version").fetchone()
            if found not in (0, _LAYOUT):
                raise InputError(
                    f"was written by another version (layout {found}); use that version, or another folder",
                    DATABASE,
                )
            base.executescript(_TABLES)
            base.execute(f"PRAGMA user_version={_LAYOUT}")

    @contextmanager
    def connected(self) -> Iterator[sqlite3.Connection]:
        """A connection whose changes are saved when the block ends well, all or none.

        Raises :class:`InputError` for a full disk, a file that may not be written or is damaged.
        """
        try:
            with closing(sqlite3.connect(self.path, timeout=10.0)) as base, base:
                base.row_factory = sqlite3.Row
                yield base
        except sqlite3.Error as error:
            raise InputError(
                f"cannot be used ({error}); free space there and let it be written, or move it away: "
                "the cases and runs next to it stay",
                DATABASE,
            ) from error


#: Longest name of a case or a file (characters).
MAX_LENGTH = 60
_NAME = re.compile(r"[^\W_][\w.+-]*")


def case_name(name: str) -> str:
    """The name of a case as its folder bears it, from what somebody typed or uploaded: ``"My
    spring.toml"`` becomes ``"My-spring"``.

    Raises :class:`InputError` for a name without letters or digits, or a longer one than
    :data:`MAX_LENGTH`.

    >>> case_name("My spring.toml")
    'My-spring'
    """
    stem = name.strip().removesuffix(".toml")
    if not re.search(r"[^\W_]", stem):
        raise InputError(
            "a case needs a name with a letter or a digit; give one such as my-spring", "name"
        )
    if len(stem) > MAX_LENGTH:
        raise InputError(
            f"'{clipped(stem)}' has {len(stem)} characters; use at most {MAX_LENGTH}", "name"
        )
    made = safe_name(stem).lstrip("_+")
    return checked_name(made)


def checked_name(name: str) -> str:
    """``name`` where a file or folder of the workspace may bear it: letters, digits, ``.``, ``+``,
    ``_`` and ``-``, none of them leading.

    Raises :class:`InputError` for anything else: separators, ``..``, hidden files, zero bytes,
    reserved words.

    >>> checked_name("spring-2.toml")
    'spring-2.toml'
    """
    plain = (
        isinstance(name, str)
        and len(name.encode("utf-8", "replace")) <= 200
        and _NAME.fullmatch(name) is not None
    )
    if not plain or ".." in name or name.endswith(".") or name.split(".")[0].upper() in _RESERVED:
        raise InputError(
            f"'{clipped(str(name), 40)}' is no name of a file here; use letters, digits, '-', '_' and '.'",
            "name",
        )
    return name


def inside(root: Path, *parts: str) -> Path:
    """The path ``root/parts...``, each part a :func:`checked_name` and nothing on the way a link.

    Raises :class:`InputError` otherwise, whether or not it exists.
    """
    place = root
    for part in parts:
        place = place / checked_name(part)
        if place.is_symlink():
            raise InputError(
                f"'{clipped(part, 40)}' is a link, and links are not followed; put the file itself there",
                "name",
            )
    if os.path.commonpath((place.resolve(), root.resolve())) != str(root.resolve()):
        raise InputError("this name leads out of the workspace; give another", "name")
    return place


#: Names that some systems reserve for devices.
_RESERVED = {
    "CON",
    "PRN",
    "AUX",
    "NUL",
    *(f"{device}{n}" for device in ("COM", "LPT") for n in range(1, 10)),
}


@contextmanager
def writing(what: str, where: str = "") -> Iterator[None]:
    """Write ``what`` in the block; a full disk, a folder that may not be written and the like
    become an :class:`InputError` at ``where``.

    >>> with writing("this case", "small"):
    ...     raise OSError(28, "No space left on device")
    Traceback (most recent call last):
    valvetrain.errors.InputError: small: this case cannot be written (no space left on device);
    free space there, or choose another folder
    """
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error) or type(error).__name__).lower()
        raise InputError(
            f"{what} cannot be written ({reason}); free space there, or choose another folder",
            where,
        ) from error
