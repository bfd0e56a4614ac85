"""Files are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from valvetrain.errors import InputError


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary name beside ``path``; it becomes ``path`` when the block ends well, else it is removed.

    Interruption (Ctrl-C) counts as a bad end. Raises :class:`InputError` when the folder cannot be written.
    """
    target = Path(path)
    _refuse_what_is_no_file(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
    except OSError as error:
        raise InputError(f"folder '{target.parent}' cannot be written ({error.strerror}); choose another") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        os.chmod(temporary, _usual_mode())
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def check_target(path: str | os.PathLike[str], where: str = "") -> None:
    """Refuse, with an :class:`InputError` placed at ``where``, a name under which no file can be written: before the work, not after."""
    target = Path(path)
    _refuse_what_is_no_file(target, where)
    parent = next(place for place in target.absolute().parents if os.path.lexists(place))
    try:
        os.rmdir(tempfile.mkdtemp(prefix=".valvetrain.", dir=parent))
    except OSError as error:
        raise InputError(f"folder '{str(parent)[:120]}' may not be written to ({error.strerror}); choose another", where) from None


def write_text(path: str | os.PathLike[str], text: str) -> Path:
    """Write ``text`` (UTF-8, unix line ends) to ``path`` whole or not at all."""
    return write_bytes(path, text.encode("utf-8", "replace"))  # a name of a file may hold bytes that are no text


def write_bytes(path: str | os.PathLike[str], content: bytes) -> Path:
    """Write ``content`` to ``path`` whole or not at all."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)
    return Path(path)


def _refuse_what_is_no_file(target: Path, where: str = "") -> None:
    """A file takes the place of a file, never that of a device, a pipe or a folder."""
    if os.path.exists(target) and not os.path.isfile(target):
        what = "a folder" if os.path.isdir(target) else "a device or a pipe"
        raise InputError(f"'{str(target)[:120]}' is {what}; give the name of a file", where)


def _usual_mode() -> int:
    """The mode a plain ``open`` would give; mkstemp makes files private to their owner."""
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
