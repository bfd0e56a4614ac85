"""Result files end in a checksum of all that stands before it, so that damage can be told from a difference."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from valvetrain.errors import InputError

_MARK, _HEX = b"# blake2b ", 32
_LINE = re.compile(rb"# blake2b [0-9a-f]{32}\n\Z")
#: What a cut leaves of the line, from the length on at which chance no longer makes it.
_CUT = re.compile(rb"# bl(a|ak|ake|ake2|ake2b|ake2b [0-9a-f]{0,32})?\Z")


def digest(content: bytes) -> str:
    """Checksum of some bytes, 32 hexadecimal digits."""
    return hashlib.blake2b(content, digest_size=_HEX // 2).hexdigest()


def closing_line(content: bytes) -> bytes:
    """The line that ends a result file whose other bytes are ``content``; NetCDF and CSV readers skip it."""
    return _MARK + digest(content).encode() + b"\n"


def close_file(path: Path) -> None:
    """Append the closing line to a file that is complete but for it."""
    line = closing_line(path.read_bytes())
    with path.open("ab") as stream:
        stream.write(line)


def checked_content(path: Path) -> tuple[bytes, bool]:
    """Bytes of a result file without its closing line, and whether it had one.

    Raises :class:`InputError` where there is no such file, or where its bytes are not those that were written. A file without the line
    passes: what it holds tells whether it should have one (:func:`valvetrain.solution.metadata.unpack`).
    """
    try:
        if not path.is_file():
            raise InputError("no such file; check the path", str(path))
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "bad path"
        raise InputError(f"cannot be read ({reason}); check the path and its permissions", str(path)) from error
    length = len(_MARK) + _HEX + 1
    if not _LINE.search(content[-length:]):
        if _CUT.search(content[-length:]):
            raise InputError("was cut short: its closing line is not whole; write it again, or fetch it again", str(path))
        return content, False
    body = content[:-length]
    if closing_line(body) != content[-length:]:
        raise InputError("is damaged: its bytes are not those that were written (checksum); write it again, or fetch it again", str(path))
    return body, True
