"""Size of a picture from the first bytes of its file, so that none is unpacked before its size is known."""

from __future__ import annotations

import struct


def picture_size(content: bytes) -> tuple[int, int] | None:
    """Rows and columns that a PNG, JPEG, TIFF or BMP claims to have; None for anything else."""
    readers = ((b"\x89PNG\r\n\x1a\n", _png), (b"\xff\xd8", _jpeg), (b"II*\0", _tiff), (b"MM\0*", _tiff), (b"BM", _bmp))
    for mark, read in readers:
        if content.startswith(mark):
            try:
                return read(content)
            except (struct.error, IndexError):
                return None
    return None


def _png(content: bytes) -> tuple[int, int]:
    columns, rows = struct.unpack(">II", content[16:24])
    return rows, columns


def _bmp(content: bytes) -> tuple[int, int]:
    columns, rows = struct.unpack("<ii", content[18:26])
    return abs(rows), abs(columns)


def _jpeg(content: bytes) -> tuple[int, int] | None:
    """The first frame header among the segments."""
    place = 2
    while place + 9 < len(content):
        if content[place] != 0xFF:
            return None
        kind = content[place + 1]
        if kind == 0xFF:
            place += 1
            continue
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            rows, columns = struct.unpack(">HH", content[place + 5 : place + 9])
            return rows, columns
        place += 2 + int(struct.unpack(">H", content[place + 2 : place + 4])[0])
    return None


def _tiff(content: bytes) -> tuple[int, int] | None:
    """Width and length in the first directory."""
    order = "<" if content[:2] == b"II" else ">"
    (place,) = struct.unpack(order + "I", content[4:8])
    (count,) = struct.unpack(order + "H", content[place : place + 2])
    found: dict[int, int] = {}
    for start in range(place + 2, place + 2 + 12 * min(count, 200), 12):
        tag, kind = struct.unpack(order + "HH", content[start : start + 4])
        form = {3: "H", 4: "I"}.get(kind)
        if tag in (256, 257) and form:
            (found[tag],) = struct.unpack(order + form, content[start + 8 : start + 8 + (2 if form == "H" else 4)])
    return (found[257], found[256]) if len(found) == 2 else None
