"""Folders that pass: of files that were sent, and of a case that is being made."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.solution.atomic import write_bytes, write_text
from valvetrain.workbench.disk import writing
from valvetrain.workbench.names import inside
from valvetrain.workbench.side_files import CASE_FILE

#: What their names begin with.
_SENT, _NEW = "upload-", ".new-"


@contextmanager
def beside(passing: Path, files: Mapping[str, bytes]) -> Iterator[Path]:
    """A passing folder below ``passing`` with ``files``, where a case that names them is read for the first time."""
    with writing("what was sent", "upload"):
        held = tempfile.TemporaryDirectory(prefix=_SENT, dir=passing, ignore_cleanup_errors=True)
    with held as name:
        with writing("what was sent", "upload"):
            for side, content in files.items():
                inside(Path(name), side).write_bytes(content)
        yield Path(name)


def new_folder(root: Path, name: str, text: str, files: Mapping[str, bytes]) -> None:
    """Make the folder ``name`` of a case below ``root`` with its ``text`` and ``files``, whole or not at all.

    Raises :class:`InputError` for a name that is taken, and where it cannot be written.
    """
    folder = inside(root, name)
    with writing(f"the case '{name}'", "name"), tempfile.TemporaryDirectory(prefix=_NEW, dir=root, ignore_cleanup_errors=True) as passing:
        made = Path(passing) / name
        made.mkdir()
        for side, content in files.items():
            write_bytes(inside(made, side), content)
        write_text(made / CASE_FILE, text)
        if folder.exists():
            raise InputError(f"there is a case '{name}' already; choose another name", "name")
        made.rename(folder)


def remove_passing(cases: Path, jobs: Path) -> None:
    """Remove what a server that was killed left of them among the cases and below the jobs."""
    for left in (*cases.glob(f"{_NEW}*"), *jobs.glob(f"{_SENT}*")):
        if not left.is_symlink():
            shutil.rmtree(left, ignore_errors=True)
