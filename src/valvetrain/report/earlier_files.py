"""Removes what an earlier run of the same kind left in a folder of results, and nothing else."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path

from valvetrain.solution.atomic import write_text

#: The list of what was written, with the digest of every file, kept in the folder itself.
LIST = ".valvetrain-files.json"


def remove_earlier(folder: Path, kind: str, written: Iterable[Path]) -> tuple[Path, ...]:
    """Remove files listed by the last run of this ``kind`` that this run did not write, then list
    what it wrote; the files removed.

    A file goes only if it is on the list and still holds, byte by byte, what was written: a file of
    the user's, or one changed since,
    stays. A folder without a list loses nothing.
    """
    base = folder.resolve()
    now = {path.resolve().relative_to(base).as_posix(): path for path in written}
    lists = _read(folder / LIST)
    removed = []
    for name, digest in lists.get(kind, {}).items():
        if (
            name not in now
            and not any(name in other for key, other in lists.items() if key != kind)
            and _is_ours(base, name, digest)
        ):
            (base / name).unlink()
            removed.append(folder / name)
    lists[kind] = {name: _digest(path) for name, path in now.items()}
    write_text(folder / LIST, json.dumps(lists, indent=1) + "\n")
    return tuple(removed)


def _is_ours(base: Path, name: str, digest: str) -> bool:
    path = base / name
    return (
        path.resolve() == path
        and path.is_relative_to(base)
        and path.is_file()
        and _digest(path) == digest
    )


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _read(path: Path) -> dict[str, dict[str, str]]:
    """The lists by kind; a file that is no such list counts as none."""
    try:
        lists = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(lists, dict):
        return {}
    return {
        kind: {str(name): str(digest) for name, digest in files.items()}
        for kind, files in lists.items()
        if isinstance(files, dict)
    }
