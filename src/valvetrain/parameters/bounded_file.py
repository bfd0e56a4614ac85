"""Reading a file that somebody named: no more of it than a bound, and nothing but a regular file,
for a pipe or a device may never end.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from valvetrain.errors import InputError

#: Larger files hold neither a case nor a lift table (bytes).
MAX_BYTES = 5_000_000
#: Set to anything, a case may name files next to it only: for cases of strangers (``valvetrain
#: serve``).
SIDE_FILES_VARIABLE = "VALVETRAIN_BESIDE"
_KINDS = {
    stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device", stat.S_IFSOCK: "a socket",
}  # fmt: skip


def named_file(folder: Path, name: str) -> Path:
    """The file that a case in ``folder`` names.

    Raises :class:`InputError` for one elsewhere than next to the case, or a link, where
    :data:`SIDE_FILES_VARIABLE` is set.

    >>> named_file(Path("cases"), "lift.csv").name
    'lift.csv'
    """
    path = folder / name
    if os.environ.get(SIDE_FILES_VARIABLE) and (
        Path(name).name != name or "\\" in name or path.is_symlink()
    ):
        raise InputError(
            "names a file elsewhere than next to the case; put it there and name it plainly, as in 'lift.csv'"
        )
    return path


def bounded_bytes(path: Path, what: str, most: int = MAX_BYTES) -> bytes:
    """Bytes of the regular file ``path``, at most ``most`` of them; ``what`` it should hold, such
    as "lift table", appears in messages.

    Raises :class:`InputError` ("is a pipe; ...") for anything else and for a larger file,
    :class:`OSError` where it cannot be read.
    """
    kind = stat.S_IFMT(path.stat().st_mode)
    if kind != stat.S_IFREG:
        remedy = (
            "give the file in it"
            if kind == stat.S_IFDIR
            else f"save the {what} to a file and give that"
        )
        raise InputError(f"is {_KINDS.get(kind, 'no file')}; {remedy}")
    with path.open("rb") as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        raise InputError(
            f"is larger than {most / 1e6:.3g} MB, so it is no {what}; give another file"
        )
    return content


def file_head(path: Path, noun: str, length: int = 4096) -> tuple[str, bytes, int]:
    """Name as messages show it, first ``length`` bytes, and size of a regular file that holds a ``noun``.

    Raises :class:`InputError` for a missing, empty or special file (a device, a pipe).
    """
    name = path.name[:80] or str(path)[:80]
    try:
        state = path.stat()
        if not stat.S_ISREG(state.st_mode):
            raise InputError(f"'{name}' is no regular file; give the {noun} as a file")
        with path.open("rb") as stream:
            head = stream.read(length)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", "") or "the name is no file name"
        raise InputError(
            f"{noun} '{name}' cannot be read: {reason.lower()}; check the name and the folder"
        ) from error
    if not head.strip():
        raise InputError(f"'{name}' is empty; export the {noun} again")
    return name, head, state.st_size
