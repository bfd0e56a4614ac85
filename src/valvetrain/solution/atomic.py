"""Atomic files: written whole or not at all; half-written files of killed processes are recognised
by their lock and removed.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from valvetrain.errors import InputError

try:
    import fcntl
except ImportError:  # no such locks here: half-written files stay
    fcntl = None  # type: ignore[assignment]

SUFFIX = ".valvetrain.part"
_OURS = re.compile(r"\..*\.[a-z0-9_]{8}" + re.escape(SUFFIX))
#: Bytes of the target's name that the temporary one repeats: names may be 255 bytes long.
_REPEATED = 200


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary file next to ``path``; it becomes ``path`` when the block ends without an error,
    else it is removed.

    Interruption (Ctrl-C) counts as an error. What killed processes left in the folder is removed at
    its first use. Raises :class:`InputError` when the folder cannot be written.
    """
    target = Path(path)
    _refuse_what_is_no_file(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _sweep_once(target.parent.absolute())
        handle, temporary = _locked_file(target)
    except OSError as error:
        raise InputError(
            f"folder '{target.parent}' cannot be written ({error.strerror}); choose another"
        ) from error
    try:
        yield temporary
        os.umask(mask := os.umask(0))
        os.chmod(temporary, 0o666 & ~mask)  # mkstemp makes files private to their owner
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    finally:
        os.close(handle)


def check_target(path: str | os.PathLike[str], where: str = "") -> None:
    """Refuse, with an :class:`InputError` at ``where``, a name under which no file can be written."""
    target = Path(path)
    _refuse_what_is_no_file(target, where)
    parent = next(path for path in target.absolute().parents if os.path.lexists(path))
    try:
        os.rmdir(tempfile.mkdtemp(prefix=".valvetrain.", dir=parent))
    except OSError as error:
        raise InputError(
            f"folder '{str(parent)[:120]}' may not be written to ({error.strerror}); choose another",
            where,
        ) from None


def write_text(path: str | os.PathLike[str], text: str) -> Path:
    """Write ``text`` (UTF-8, unix line ends) to ``path`` whole or not at all."""
    # The name of a file in it may hold bytes that are no text.
    return write_bytes(path, text.encode("utf-8", "replace"))


def write_bytes(path: str | os.PathLike[str], content: bytes | memoryview) -> Path:
    """Write ``content`` to ``path`` whole or not at all."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)
    return Path(path)


def append_whole(handle: int, content: bytes) -> None:
    """Add ``content`` to the open file ``handle``, whole or not at all. Raises :class:`OSError`
    when there is no space.
    """
    before = os.fstat(handle).st_size
    if os.write(handle, content) < len(content):
        os.ftruncate(handle, before)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _refuse_what_is_no_file(target: Path, where: str = "") -> None:
    """A file takes the place of a file, never that of a device, a pipe or a folder."""
    if os.path.exists(target) and not os.path.isfile(target):
        what = "a folder" if os.path.isdir(target) else "a device or a pipe"
        raise InputError(f"'{str(target)[:120]}' is {what}; give the name of a file", where)


def remove_abandoned(folder: Path) -> tuple[Path, ...]:
    """Remove half-written files of killed processes from ``folder``; those of living ones are
    locked and stay.
    """
    removed = []
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            if _OURS.fullmatch(path.name) and is_abandoned(path):
                with suppress(OSError):
                    path.unlink()
                    removed.append(path)
    return tuple(removed)


def is_abandoned(path: Path) -> bool:
    """Whether no process holds the lock of a file that its writer locks as long as it lives."""
    if fcntl is None:
        return False
    try:
        with path.open("rb") as stream:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def is_living(path: Path) -> bool:
    """Whether a living process holds the lock of a file; never where there are no such locks."""
    return fcntl is not None and not is_abandoned(path)


def lock(handle: int) -> bool:
    """Lock an open file for as long as this process lives or has it open; False where another
    process has it.

    True without a lock where there are no such locks.
    """
    if fcntl is None:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def _locked_file(target: Path) -> tuple[int, Path]:
    """A new temporary file next to ``target``, locked; another one where a process removed it
    before it was locked.
    """
    prefix = "." + os.fsdecode(os.fsencode(target.name)[:_REPEATED]) + "."
    while True:
        handle, name = tempfile.mkstemp(prefix=prefix, suffix=SUFFIX, dir=target.parent)
        lock(handle)
        if os.path.exists(name):
            return handle, Path(name)
        os.close(handle)


_sweep_once = cache(remove_abandoned)


_MARK, _HEX = b"# blake2b ", 32
_LINE = re.compile(rb"# blake2b [0-9a-f]{32}\n\Z")
#: What a cut leaves of the line, from the length on at which chance no longer makes it.
_CUT = re.compile(rb"# bl(a|ak|ake|ake2|ake2b|ake2b [0-9a-f]{0,32})?\Z")


def digest(content: bytes) -> str:
    """Checksum of some bytes, 32 hexadecimal digits."""
    return hashlib.blake2b(content, digest_size=_HEX // 2).hexdigest()


def closing_line(content: bytes) -> bytes:
    """The line that ends a result file whose other bytes are ``content``; NetCDF readers skip
    it.
    """
    return _MARK + digest(content).encode() + b"\n"


def checked_content(path: Path) -> tuple[bytes, bool]:
    """Bytes of a result file without its closing line, and whether it had one.

    Raises :class:`InputError` where there is no such file, or where its bytes are not those that
    were written. A file without the line passes.
    """
    try:
        if not path.is_file():
            raise InputError("no such file; check the path", str(path))
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "bad path"
        raise InputError(
            f"cannot be read ({reason}); check the path and its permissions", str(path)
        ) from error
    length = len(_MARK) + _HEX + 1
    if not _LINE.search(content[-length:]):
        if _CUT.search(content[-length:]):
            raise InputError(
                "was cut short: its closing line is not whole; write it again, or fetch it again",
                str(path),
            )
        return content, False
    body = content[:-length]
    if closing_line(body) != content[-length:]:
        raise InputError(
            "is damaged: its bytes are not those that were written (checksum); write it again, or fetch it again",
            str(path),
        )
    return body, True
