"""Bytes of a file that somebody brings: bounded, from regular files alone, as text where it is text."""

from __future__ import annotations

import codecs
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import bounded_bytes

#: Byte marks at the beginning of a text -> its coding; the longer one first.
_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


def read_content(path: Path, most_bytes: int, noun: str) -> bytes:
    """Content of a regular file of at most ``most_bytes``; ``noun`` says what was looked for.

    Raises :class:`InputError` for a missing, empty, larger or special file (a device, a pipe).
    """
    shown = path.name[:80] or str(path)[:80]
    try:
        content = bounded_bytes(path, noun, most_bytes)
    except InputError as error:
        raise InputError(f"{noun} '{shown}' {error.reason}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", "") or "the name is no file name"
        raise InputError(f"{noun} '{shown}' cannot be read: {reason.lower()}; check the name and the folder") from error
    if not content.strip():
        raise InputError(f"'{shown}' is empty; export the {noun} again")
    return content


def text_of(content: bytes, name: str) -> str:
    """The text in ``content``: UTF-8 or 16 by its mark, else UTF-8, else Windows' western coding. Raises :class:`InputError` for bytes."""
    for mark, coding in _MARKS:
        if content.startswith(mark):
            return _decoded(content, coding, name)
    if b"\0" in content:
        raise InputError(f"'{name[:80]}' is no text; export the table as text (CSV) or as a workbook (XLSX)")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return _decoded(content, "cp1252", name)


def _decoded(content: bytes, coding: str, name: str) -> str:
    try:
        return content.decode(coding)
    except UnicodeDecodeError as error:
        raise InputError(f"'{name[:80]}' is no text; export the table as text (CSV) or as a workbook (XLSX)") from error
