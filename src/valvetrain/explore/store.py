"""The store of finished points: an append-only file of JSON lines, each with a checksum of its own.

A killed process leaves at most one line that is not whole; it and what is behind it are computed
again. Studies, searches and identifications store their points in the same way.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
from dataclasses import astuple
from functools import cache
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError
from valvetrain.explore.outputs import Outcome
from valvetrain.solution.atomic import append_whole, check_target, digest, lock, remove_abandoned
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.status import COMPLETED, Status

#: Name of the file in the folder of the points.
FILE = "points.jsonl"
#: Ends of a point that a second trial may change: they are not written.
NOT_WRITTEN = ("worker-lost", "interrupted")
#: Characters of the checksum in front of a line.
_CHECKSUM = 16
#: Status, names and values of a point: as small as the many points of a study need it.
_Point = tuple[Status, tuple[str, ...], tuple[float, ...]]


class Store:
    """Finished points by their keys, digests of all that a point depends on, in a file of ``folder``
    (None: in memory only). Use it as a context.

    ``before``: points that were in the file; ``computed``: those that came since. Raises
    :class:`InputError` for a folder in which another process works.

    >>> with Store(None) as store:
    ...     store.add(b"first", Outcome(values={"peak_spring_force": 510.0}))
    ...     store.outcome(b"first").values
    {'peak_spring_force': 510.0}
    """

    def __init__(self, folder: Path | None) -> None:
        self.computed = 0
        self._names: dict[tuple[str, ...], tuple[str, ...]] = {}
        self._points: dict[bytes, _Point] = {}
        self._handle = -1
        if folder is not None:
            self._open(folder)
        self.before = len(self._points)

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __len__(self) -> int:
        return self.before + self.computed

    def __contains__(self, key: bytes) -> bool:
        return key in self._points

    def outcome(self, key: bytes) -> Outcome:
        """The outcome of a stored point."""
        status, names, values = self._points[key]
        return Outcome(status, dict(zip(names, values, strict=True)))

    def add(self, key: bytes, outcome: Outcome) -> None:
        """Store a finished point; it survives a kill of this process after the return."""
        status, names, values = self._remember(key, outcome)
        self.computed += 1
        if self._handle >= 0 and status.code not in NOT_WRITTEN:
            record = [key.hex(), dict(zip(names, values, strict=True)), astuple(status)]
            append_whole(self._handle, _line(json.dumps(record, separators=(",", ":")).encode()))

    def close(self) -> None:
        """Bring the file to the disk and give it free for the next process."""
        if self._handle >= 0:
            try:
                os.fsync(self._handle)
            finally:
                os.close(self._handle)
                self._handle = -1

    def _remember(self, key: bytes, outcome: Outcome) -> _Point:
        names = tuple(outcome.values)
        status = COMPLETED if outcome.status == COMPLETED else outcome.status
        values = tuple(map(float, outcome.values.values()))
        self._points[key] = status, self._names.setdefault(names, names), values
        return self._points[key]

    def _open(self, folder: Path) -> None:
        path = folder / FILE
        check_target(path, "output")
        folder.mkdir(parents=True, exist_ok=True)
        remove_abandoned(folder)
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            if not lock(self._handle):
                raise InputError(
                    "another process works on the points there; wait for it, or choose another folder",
                    str(folder)[:120],
                )
            end = 0
            with path.open("rb") as file:
                for line in file:
                    record = _content(line)
                    if record is None:
                        break
                    key, values, status = record
                    self._remember(bytes.fromhex(key), Outcome(Status(*status), values))
                    end += len(line)
            os.ftruncate(self._handle, end)
        except BaseException:
            os.close(self._handle)
            self._handle = -1
            raise


def _line(body: bytes) -> bytes:
    return digest(body)[:_CHECKSUM].encode() + b" " + body + b"\n"


def _content(line: bytes) -> Any:
    """The record of a line; None where its bytes are not those that were written, or another version
    wrote it in another form.
    """
    body = line[_CHECKSUM + 1 : -1]
    if line != _line(body):
        return None
    record = json.loads(body)
    return record if isinstance(record, list) and len(record) == 3 else None


@cache
def versions_digest() -> str:
    """A digest of all that may compute: the source text of the package, versions of Python and of the libraries, kind of machine."""
    origin = collect_provenance("", "")
    combined = hashlib.blake2b(digest_size=16)
    for text in (
        origin.package_version,
        origin.python_version,
        *map(str, sorted(origin.dependencies.items())),
        platform.machine(),
    ):
        combined.update(text.encode() + b"\0")
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        combined.update(path.read_bytes() + b"\0")
    return combined.hexdigest()
